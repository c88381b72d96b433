#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/options/values.h"

namespace orasp::cli {

using Arguments = std::vector<std::string>;

/// A name and what it means, in the two columns of the help; the second is broken into lines.
[[nodiscard]] std::string help_entry(std::string_view name, std::string_view meaning);

/// The arguments and options of one command: they are declared, then `parse` sets their targets.
/// Every value arrives as text and is checked by the functions of values.h, so that all errors
/// read alike. The parser behind it is CLI11, which takes seconds to compile and is therefore
/// known to command_line.cpp alone.
class CommandLine {
 public:
  using Setter = std::function<void(const std::string&)>;

  CommandLine(const std::string& name, const std::string& summary);
  CommandLine(CommandLine&&) noexcept;
  CommandLine& operator=(CommandLine&&) noexcept;
  ~CommandLine();

  /// `usage` is how the usage line shows the argument: "PROBLEM", or "[NAME]" where it may be
  /// left out.
  void positional(const std::string& usage, std::string& target, const std::string& help);
  void positionals(const std::string& usage, std::vector<std::string>& targets,
                   const std::string& help);

  /// `names` are "--json" or "-o,--output"; `unit` is what the help calls the value.
  void flag(const std::string& names, bool& target, const std::string& help);
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

  /// Options that are declared from here on stand under this title in the help.
  void group(const std::string& title);
  void footer(const std::string& text);

  /// @returns false if the words ask for the help, which is then printed. @throws InputError.
  [[nodiscard]] bool parse(const Arguments& arguments);

 private:
  class Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace orasp::cli
