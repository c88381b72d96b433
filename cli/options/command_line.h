#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/context.h"
#include "orasp/method_options.h"

namespace orasp::cli {

using Arguments = std::vector<std::string>;

/// A name and what it means, in the two columns of the help; the second is broken into lines.
[[nodiscard]] std::string help_entry(std::string_view name, std::string_view meaning);

/// An argument of a command, as it was declared.
struct DeclaredArgument {
  /// As the usage line shows it: "PROBLEM", "[NAME]".
  std::string usage;
  /// The words that it may be; empty: any.
  std::vector<std::string> words;
};

/// An option of a command, as it was declared.
struct DeclaredOption {
  /// "--json", or all of "-o,--output".
  std::string names;
  /// What the help calls its value; empty: a flag, which takes none.
  std::string unit;
  /// The words that its value may be; empty: any.
  std::vector<std::string> words;
};

/// The arguments and options of one command: they are declared, then `parse` sets their targets.
/// Every value arrives as text and is checked by the functions of orasp/method_options.h, so that
/// all errors read alike. What was declared can be read back, for the completion of the shell. The
/// parser behind it is CLI11, which takes seconds to compile and is therefore known to
/// command_line.cpp alone.
class CommandLine {
 public:
  using Setter = std::function<void(const std::string&)>;

  /// `name` is the command's.
  explicit CommandLine(const std::string& name);
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;
  ~CommandLine();

  /// What the command does, at the head of the help.
  void about(const std::string& text);

  /// `usage` is how the usage line shows the argument: "PROBLEM", or "[NAME]" where it may be
  /// left out.
  void positional(const std::string& usage, std::string& target, const std::string& help);
  void positionals(const std::string& usage, std::vector<std::string>& targets,
                   const std::string& help);

  /// `names` are "--json" or "-o,--output". A flag that is given sets its target.
  void flag(const std::string& names, bool& target, const std::string& help);
  /// A flag that clears its target: "--no-learning".
  void turn_off(const std::string& names, bool& target, const std::string& help);
  /// A flag that calls `set` with an empty text.
  void flag(const std::string& names, const std::string& help, Setter set);
  /// The flag --quiet, which quiet() tells of.
  void quiet_flag(const std::string& help);

  /// An option with a value; `unit` is what the help calls the value.
  void value(const std::string& names, const std::string& unit, const std::string& help,
             Setter set);
  void text(const std::string& names, const std::string& unit, const std::string& help,
            auto& target) {
    value(names, unit, help, [&target](const std::string& given) { target = given; });
  }
  void whole(const std::string& names, const std::string& unit, const std::string& help,
             auto& target, std::uint64_t least,
             std::uint64_t greatest = std::numeric_limits<std::uint64_t>::max()) {
    value(names, unit, help, [=, &target](const std::string& given) {
      target = whole_number(names.substr(names.find("--")), given, least, greatest);
    });
  }
  void real(const std::string& names, const std::string& unit, const std::string& help,
            auto& target, Sign sign) {
    value(names, unit, help,
          [=, &target](const std::string& given) { target = number(names, given, sign); });
  }

  /// An option from its row; a flag calls `set` with an empty text.
  void option(const OptionSpec& row, Setter set);

  /// The words that the option or argument declared last may be, which the completion offers.
  void words(std::vector<std::string> known);
  /// Options that are declared from here on stand under this title in the help.
  void group(const std::string& title);
  void footer(const std::string& text);

  /// @returns false if the words ask for the help, which is then printed. @throws InputError.
  [[nodiscard]] bool parse(const Arguments& arguments);

  /// Whether --quiet was given.
  [[nodiscard]] bool quiet() const { return quiet_; }
  [[nodiscard]] const std::vector<DeclaredArgument>& arguments() const { return arguments_; }
  /// All but --help, in the order of the help.
  [[nodiscard]] const std::vector<DeclaredOption>& options() const { return options_; }

 private:
  class Parser;
  std::unique_ptr<Parser> parser_;
  std::vector<DeclaredArgument> arguments_;
  std::vector<DeclaredOption> options_;
  std::vector<std::string>* last_words_ = nullptr;
  bool quiet_ = false;
};

/// What a command does once its words are read. @returns the exit code. @throws InputError.
using CommandWork = std::function<int(const Context& context)>;

}  // namespace orasp::cli
