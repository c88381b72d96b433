# Completion of orasp for bash: commands, options, methods, objectives, scenarios, files.
# Installed as bash-completion/completions/orasp; by hand: source <(orasp completion bash)

_orasp() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}
  local commands="solve graph evaluate explain compare sample train scenarios completion"
  local methods="auto value-iteration dijkstra bellman-ford orasp-search a-star beam and-or exhaustive greedy random q-learning dqn"
  local objectives="piece_cost cubesat cubesat_zone custom indexed time travel fuel completion expression sum"
  local changes="--objective --direction --max-subassemblies --max-moved-parts --max-moved-mass"
  local limits="--time-limit --memory-limit --threads"
  local output="--json --output --quiet"
  local options scenarios before

  # bash breaks words at ':' and '='; complete what stands after an option's '=' as its value.
  if [[ $current == "=" ]]; then
    current=""
  elif [[ $previous == "=" ]] && ((COMP_CWORD >= 2)); then
    previous=${COMP_WORDS[COMP_CWORD - 2]}
  fi

  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "$commands --help --version" -- "$current")
    return
  fi

  case $previous in
    --method)
      mapfile -t COMPREPLY < <(compgen -W "$methods" -- "$current")
      return
      ;;
    --methods)
      before=""
      [[ $current == *,* ]] && before=${current%,*},
      mapfile -t COMPREPLY < <(compgen -P "$before" -W "$methods" -- "${current##*,}")
      compopt -o nospace
      return
      ;;
    --objective)
      mapfile -t COMPREPLY < <(compgen -W "$objectives" -- "$current"; compgen -f -- "$current")
      return
      ;;
    --direction)
      mapfile -t COMPREPLY < <(compgen -W "disassembly assembly" -- "$current")
      return
      ;;
    --bound)
      mapfile -t COMPREPLY < <(compgen -W "none connections sizes parts best" -- "$current")
      return
      ;;
    --device)
      mapfile -t COMPREPLY < <(compgen -W "auto cpu cuda" -- "$current")
      return
      ;;
    --sweep-order)
      mapfile -t COMPREPLY < <(compgen -W "layers textbook" -- "$current")
      return
      ;;
    -o | --output | --dot | --svg | --plan | --policy | --resume | --log)
      mapfile -t COMPREPLY < <(compgen -f -- "$current")
      compopt -o filenames
      return
      ;;
    --seed | --epsilon | --max-sweeps | --initial-value | --max-subassemblies | --max-moved-parts | \
      --max-moved-mass | --time-limit | --memory-limit | --threads | -n | --alternatives | --connection | --step | \
      --checkpoint-every | --episodes | --hidden | --learning-rate | --batch | --replay | --discount | --epsilon-start | \
      --epsilon-end | --epsilon-decay | --target-rate | --gradient-clip | --curriculum | --environments | \
      --updates-per-step | --n-step | --imitation)
      return
      ;;
    --count)
      [[ $command == sample ]] && return
      ;;
  esac

  case $command in
    solve) options="--method --seed --bound --policy --sweep-order --epsilon --max-sweeps --initial-value --count --alternatives $changes $limits $output" ;;
    graph) options="--dot --svg $changes $limits $output" ;;
    evaluate) options="$changes $output" ;;
    explain) options="--connection --plan --step $changes $limits $output" ;;
    compare) options="--methods --seed --csv --markdown $changes $limits $output" ;;
    sample) options="--count --seed --policy --sequences $changes $limits $output" ;;
    train)
      options="--output --resume --log --checkpoint-every --episodes --seed --device --to-the-end --hidden --learning-rate --batch
        --replay --discount --epsilon-start --epsilon-end --epsilon-decay --target-rate --gradient-clip --curriculum --environments
        --updates-per-step --n-step --imitation --no-double-q --no-returns --no-known-reward --no-scaling $changes --time-limit
        --memory-limit --json --quiet"
      ;;
    scenarios) options=$output ;;
    completion)
      mapfile -t COMPREPLY < <(compgen -W "bash --help" -- "$current")
      return
      ;;
    *) return ;;
  esac
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options --help" -- "$current")
    return
  fi

  # A scenario or a file. The list's first word on each line is a name; a generator's form (chain:N) gives its prefix.
  scenarios=$("${COMP_WORDS[0]}" scenarios 2>/dev/null | while read -r name _; do
    [[ $name == name ]] || printf '%s ' "${name%%:*}$([[ $name == *:* ]] && printf ':')"
  done)
  mapfile -t COMPREPLY < <(compgen -W "$scenarios" -- "$current")
  if [[ $command != scenarios ]]; then
    mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -f -- "$current")
    compopt -o filenames
  fi
  [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *: ]] && compopt -o nospace
}

complete -F _orasp orasp
