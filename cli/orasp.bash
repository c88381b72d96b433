# Completion of orasp for bash: commands, options, methods, objectives, scenarios, files.
# Installed as bash-completion/completions/orasp; by hand: source <(orasp completion bash)

_orasp() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}
  local commands="solve graph evaluate explain replan compare sample simulate train report paper scenarios completion"
  local methods="auto value-iteration dijkstra bellman-ford orasp-search a-star beam and-or mip exhaustive greedy random q-learning dqn"
  local fleet_methods="mip greedy fleet-search fast"
  local objectives="piece_cost cubesat cubesat_zone custom indexed time travel fuel completion expression sum"
  local changes="--objective --direction --max-subassemblies --max-moved-parts --max-moved-mass --robots --sites"
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
      mapfile -t COMPREPLY < <(compgen -W "$methods $fleet_methods" -- "$current")
      return
      ;;
    --methods)
      before=""
      [[ $current == *,* ]] && before=${current%,*},
      mapfile -t COMPREPLY < <(compgen -P "$before" -W "$methods $fleet_methods" -- "${current##*,}")
      compopt -o nospace
      return
      ;;
    --objective)
      mapfile -t COMPREPLY < <(compgen -W "$objectives makespan fleet_travel" -- "$current"; compgen -f -- "$current")
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
    -o | --output | --dot | --svg | --plan | --policy | --resume | --log | --sample | --write-model)
      mapfile -t COMPREPLY < <(compgen -f -- "$current")
      compopt -o filenames
      return
      ;;
    --seed | --epsilon | --max-sweeps | --initial-value | --max-subassemblies | --max-moved-parts | \
      --max-moved-mass | --robots | --sites | --steps | --time-limit | --memory-limit | --threads | -n | --alternatives | --connection | --step | \
      --done | --removed | --made | --inaccessible | --not-next | --lost-part | --late-part | \
      --checkpoint-every | --episodes | --hidden | --learning-rate | --batch | --replay | --discount | --epsilon-start | \
      --epsilon-end | --epsilon-decay | --target-rate | --gradient-clip | --curriculum | --environments | \
      --updates-per-step | --n-step | --imitation | --title | --sample-count)
      return
      ;;
    --count)
      [[ $command == sample || $command == simulate ]] && return
      ;;
  esac

  case $command in
    solve) options="--method --seed --steps --bound --policy --write-model --sweep-order --epsilon --max-sweeps --initial-value --count --alternatives $changes $limits $output" ;;
    graph) options="--dot --svg $changes $limits $output" ;;
    evaluate) options="$changes $output" ;;
    explain) options="--connection --plan --step $changes $limits $output" ;;
    replan) options="--plan --done --removed --inaccessible --not-next --lost-part --late-part $changes $limits $output" ;;
    compare) options="--methods --seed --steps --csv --markdown $changes $limits $output" ;;
    sample) options="--count --seed --policy --sequences $changes $limits $output" ;;
    simulate) options="--plan --policy --count --seed $changes --time-limit --memory-limit $output" ;;
    train)
      options="--output --resume --log --checkpoint-every --episodes --seed --device --to-the-end --hidden --learning-rate --batch
        --replay --discount --epsilon-start --epsilon-end --epsilon-decay --target-rate --gradient-clip --curriculum --environments
        --updates-per-step --n-step --imitation --no-double-q --no-returns --no-known-reward --no-scaling $changes --time-limit
        --memory-limit --json --quiet"
      ;;
    report) options="--output --svg --title --log --sample --sample-count --seed $changes $limits --quiet" ;;
    paper) options="--output --quick --no-learning --json --quiet" ;;
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
