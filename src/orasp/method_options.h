#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace orasp {

struct Options;

/// The rows of the methods' options. What is known of an option stands in its row alone: its name,
/// what its value is and may be, its help. Its default is that of the member of Options which it
/// sets. The command line reads the rows for its help, its refusals, the completion of the shell
/// and the "options" of a plan; the manual page and the tables of the documentation are written
/// from that help. To add an option is to add a row to one of the tables of method_options.cpp.

/// Which numbers an option takes. Share: from 0 to 1.
enum class Sign { Any, NotNegative, Positive, Share };

/// A flag takes no value: where it is given, its member becomes `given`.
struct FlagOption {
  bool& (*member)(Options&);
  bool given = true;
};
struct WholeOption {
  std::uint64_t& (*member)(Options&);
  std::uint64_t least = 0;
  std::uint64_t greatest = std::numeric_limits<std::uint64_t>::max();
};
/// Whole numbers, separated by commas.
struct WholeListOption {
  std::vector<std::size_t>& (*member)(Options&);
  std::uint64_t least = 0;
  std::uint64_t greatest = std::numeric_limits<std::uint64_t>::max();
};
struct RealOption {
  double& (*member)(Options&);
  Sign sign = Sign::Any;
};
/// One of several words.
struct ChoiceOption {
  std::span<const std::string_view> words;
  /// The place of the chosen word among them.
  std::size_t (*get)(const Options&);
  void (*set)(Options&, std::size_t);
};
/// A file, which the caller reads: what it holds goes into the member that `help` speaks of.
struct FileOption {};

/// One row: an option of a method.
struct OptionSpec {
  /// "sweep-order".
  std::string_view name;
  /// What the help calls the value: "ORDER"; empty for a flag.
  std::string_view unit;
  std::variant<FlagOption, WholeOption, WholeListOption, RealOption, ChoiceOption, FileOption> kind;
  /// A sentence without its full stop; "{}" stands for the words of a choice.
  std::string_view help;
  /// What holds where the option is not given; "{}" stands for the default of the member.
  std::string_view otherwise = "{}";
  /// The title under which the help of `orasp train` shows it; unused elsewhere.
  std::string_view group = {};
};

/// The tables. Each belongs to the methods that name it in the catalogue.
[[nodiscard]] std::span<const OptionSpec> no_options();
[[nodiscard]] std::span<const OptionSpec> symmetry_options();
/// Those of sweeps and symmetry; of bounds and symmetry.
[[nodiscard]] std::span<const OptionSpec> sweep_options();
[[nodiscard]] std::span<const OptionSpec> search_options();
[[nodiscard]] std::span<const OptionSpec> bound_options();
[[nodiscard]] std::span<const OptionSpec> beam_options();
[[nodiscard]] std::span<const OptionSpec> policy_options();
/// How a policy is trained: the options of `orasp train`.
[[nodiscard]] std::span<const OptionSpec> training_options();

/// The help of a row, with the default: "Stop after N sweeps (default: none)."
[[nodiscard]] std::string help_of(const OptionSpec& option);

/// The words that the value may be; empty where it is not a choice.
[[nodiscard]] std::span<const std::string_view> words_of(const OptionSpec& option);

/// Whether the value is a number or a flag, which JSON writes without quotes.
[[nodiscard]] bool is_bare(const OptionSpec& option);

/// The value that `options` holds, as text; empty for a file and for an empty list.
[[nodiscard]] std::string value_of(const OptionSpec& option, const Options& options);

/// Sets the option from the text of its value; a flag takes no text. `label` is what error messages
/// call it: "--sweep-order". A file changes nothing.
/// @throws InputError where the value is not allowed, with a sentence that says what is.
void set_option(const OptionSpec& option, std::string_view label, std::string_view text,
                Options& options);

/// Options by name, with the texts of their values; a flag has none: {{"bound", "parts"}}.
using OptionTexts = std::map<std::string, std::string>;

/// The options of `method` from their texts, the others at their defaults. `mark` stands in front
/// of their names in error messages: "--" on a command line.
///
///     solve(problem, "beam", options_from("beam", {{"bound", "parts"}}));
///
/// @throws InputError for an unknown method, for an option that the method does not have, and for
/// a value that is not allowed.
[[nodiscard]] Options options_from(std::string_view method, const OptionTexts& given,
                                   std::string_view mark = "");

/// The methods that have an option of this name: "orasp-search, a-star, beam and q-learning".
[[nodiscard]] std::string owners_of(std::string_view option);

/// Numbers from their texts. `label` ("--seed") stands in front of error messages.
/// @throws InputError with a sentence that says what was allowed.
[[nodiscard]] std::uint64_t whole_number(
    std::string_view label, std::string_view text, std::uint64_t least,
    std::uint64_t greatest = std::numeric_limits<std::uint64_t>::max());
/// A finite number.
[[nodiscard]] double number(std::string_view label, std::string_view text, Sign sign);

}  // namespace orasp
