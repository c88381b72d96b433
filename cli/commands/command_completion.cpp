#include "cli/commands/command_completion.h"

#include <compare>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "cli/commands/command_table.h"
#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/output/text.h"
#include "orasp/model/error.h"

namespace orasp::cli {

namespace {

/// What the shell offers in the place of an option's value or of an argument.
struct Offer {
  /// "words": one of `words`; "list": several, joined by commas; "file": a file, or one of `words`;
  /// "value": nothing.
  std::string_view kind;
  std::string words;

  friend auto operator<=>(const Offer&, const Offer&) = default;
};

Offer offer_of(const DeclaredOption& option) {
  const bool file = option.unit.find("FILE") != std::string::npos || option.unit == "DIR";
  const bool list = option.unit.find(',') != std::string::npos;
  const std::string_view kind = file                   ? "file"
                                : option.words.empty() ? "value"
                                : list                 ? "list"
                                                       : "words";
  return {kind, fmt::format("{}", fmt::join(option.words, " "))};
}

/// "-o,--output" in two.
std::vector<std::string> names_of(const DeclaredOption& option) {
  return comma_separated(option.names);
}

/// The commands with what each declares.
struct Declared {
  std::string name;
  std::vector<DeclaredArgument> arguments;
  std::vector<DeclaredOption> options;
};

std::vector<Declared> all_declared() {
  std::vector<Declared> all;
  for (const Command& command : commands()) {
    CommandLine line(command.name);
    const CommandWork work = command.declare(line);
    all.push_back({command.name, line.arguments(), line.options()});
  }
  return all;
}

/// The branches of `case "$command $previous"`: one for each offer, with the options that take it.
/// An option that takes the same in every command that has it stands without the command's name.
std::string branches_by_option(const std::vector<Declared>& all) {
  std::map<std::string, std::map<Offer, std::vector<std::string>>> uses;  // by option: commands
  std::map<std::string, std::size_t> owners;
  for (const Declared& command : all) {
    for (const DeclaredOption& option : command.options) {
      for (const std::string& name : names_of(option)) {
        ++owners[name];
        if (!option.unit.empty()) uses[name][offer_of(option)].push_back(command.name);
      }
    }
  }
  std::map<Offer, std::vector<std::string>> patterns;
  for (const auto& [name, offers] : uses) {
    for (const auto& [offer, of] : offers) {
      if (of.size() == owners[name]) {
        patterns[offer].push_back(fmt::format("*\" {}\"", name));
        continue;
      }
      for (const std::string& command : of)
        patterns[offer].push_back(fmt::format("\"{} {}\"", command, name));
    }
  }
  std::string text;
  for (const auto& [offer, of] : patterns) {
    text += fmt::format("    {}) takes={}", fmt::join(of, " | \\\n      "), offer.kind);
    if (!offer.words.empty()) text += fmt::format(" words=\"{}\"", offer.words);
    text += " ;;\n";
  }
  return text;
}

/// The branches of `case $command`: its options, and what its arguments may be.
std::string branches_by_command(const std::vector<Declared>& all) {
  std::string text;
  for (const Declared& command : all) {
    std::vector<std::string> options;
    for (const DeclaredOption& option : command.options) {
      for (const std::string& name : names_of(option)) {
        if (!name.starts_with("--")) continue;
        options.push_back(name);
        break;  // of two long names the help leads with the first
      }
    }
    options.emplace_back("--help");
    std::string arguments;
    std::string words;
    for (const DeclaredArgument& argument : command.arguments) {
      if (!argument.words.empty()) {
        arguments = "words";
        words = fmt::format("{} --help", fmt::join(argument.words, " "));
      } else if (arguments.empty()) {
        arguments = argument.usage == "PROBLEM" ? "problem" : "scenario";
      }
    }
    text += fmt::format("    {}) arguments={} words=\"{}\" options=\"{}\" ;;\n", command.name,
                        arguments, words, fmt::join(options, " "));
  }
  return text;
}

std::string bash_completion() {
  const std::vector<Declared> all = all_declared();
  std::string names;
  for (const Declared& command : all) names += command.name + ' ';
  return R"sh(# Completion of orasp for bash: commands, options and their values, scenarios, files.
# Written by `orasp completion bash`; by hand: source <(orasp completion bash)

_orasp() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
  local command=${COMP_WORDS[1]}
  local takes="" words="" arguments="" options="" scenarios before

  # bash breaks words at ':' and '='; what stands after '=' completes an option's value.
  if [[ $current == "=" ]]; then
    current=""
  elif [[ $previous == "=" ]] && ((COMP_CWORD >= 2)); then
    previous=${COMP_WORDS[COMP_CWORD - 2]}
  fi

  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W ")sh" +
         names + R"sh(--help --version" -- "$current")
    return
  fi

  case "$command $previous" in
)sh" + branches_by_option(all) +
         R"sh(  esac
  case $takes in
    words)
      mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
      return
      ;;
    list)
      before=""
      [[ $current == *,* ]] && before=${current%,*},
      mapfile -t COMPREPLY < <(compgen -P "$before" -W "$words" -- "${current##*,}")
      compopt -o nospace
      return
      ;;
    file)
      mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current"; compgen -f -- "$current")
      [[ -n $words ]] || compopt -o filenames
      return
      ;;
    value) return ;;
  esac

  case $command in
)sh" + branches_by_command(all) +
         R"sh(    *) return ;;
  esac
  if [[ $arguments == words ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
    return
  fi
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")
    return
  fi
  [[ -n $arguments ]] || return

  # A scenario or a file. The first word of each line of the list is a name; the form of a
  # generator (chain:N) gives its prefix.
  scenarios=$("${COMP_WORDS[0]}" scenarios 2>/dev/null | while read -r name _; do
    [[ $name == name ]] || printf '%s ' "${name%%:*}$([[ $name == *:* ]] && printf ':')"
  done)
  mapfile -t COMPREPLY < <(compgen -W "$scenarios" -- "$current")
  if [[ $arguments == problem ]]; then
    mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -f -- "$current")
    compopt -o filenames
  fi
  [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *: ]] && compopt -o nospace
}

complete -F _orasp orasp
)sh";
}

}  // namespace

int run(const CompletionOptions& options, const Context& context) {
  if (options.shell != "bash")
    throw InputError(fmt::format("there is no completion for the shell {}, only for bash",
                                 in_quotes(options.shell)));
  context.print(bash_completion());
  return kSolved;
}

CommandWork completion_command(CommandLine& line) {
  const auto chosen = std::make_shared<CompletionOptions>();
  CompletionOptions& options = *chosen;
  line.about("Prints a script that completes commands, options, methods and scenarios.");
  line.positional("SHELL", options.shell, "bash");
  line.words({"bash"});
  line.footer(
      "\nExamples:\n"
      "  source <(orasp completion bash)\n"
      "  orasp completion bash > /etc/bash_completion.d/orasp\n"
      "\n"
      "Exit codes: 0 printed, 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
