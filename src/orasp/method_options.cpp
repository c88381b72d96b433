#include "orasp/method_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/catalogue.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

constexpr std::array<std::string_view, 2> kSweepOrders = {"layers", "textbook"};
constexpr std::array<std::string_view, 3> kSymmetries = {"auto", "on", "off"};
constexpr std::array<std::string_view, 3> kDevices = {"auto", "cpu", "cuda"};
constexpr std::array<std::string_view, 3> kInputsNames = {"auto", "connections", "pieces"};

// The tables. A row is NAME, UNIT, KIND, HELP, OTHERWISE, GROUP; see OptionSpec.

constexpr OptionSpec kSymmetry{
    "symmetry", "USE",
    ChoiceOption{kSymmetries,
                 [](const Options& options) { return static_cast<std::size_t>(options.symmetry); },
                 [](Options& options, std::size_t place) {
                   options.symmetry = static_cast<SymmetryUse>(place);
                 }},
    "Take states that differ by an exchange of equal parts for one: {}",
    "{}: where it is worth while"};

constexpr std::array kSymmetryOptions = {kSymmetry};

constexpr std::array kSweepOptions = {
    OptionSpec{"sweep-order", "ORDER",
               ChoiceOption{kSweepOrders,
                            [](const Options& options) {
                              return static_cast<std::size_t>(options.value_iteration.order);
                            },
                            [](Options& options, std::size_t place) {
                              options.value_iteration.order =
                                  static_cast<ValueIterationOptions::Order>(place);
                            }},
               "Sweep by layers, or textbook as in the paper"},
    OptionSpec{
        "epsilon", "REWARD",
        RealOption{[](Options& options) -> double& { return options.value_iteration.epsilon; },
                   Sign::Positive},
        "Stop when no value changed by this much"},
    OptionSpec{"max-sweeps", "N",
               WholeOption{[](Options& options) -> std::uint64_t& {
                             return options.value_iteration.max_sweeps;
                           },
                           1},
               "Stop after N sweeps", "none"},
    OptionSpec{"initial-value", "REWARD", RealOption{[](Options& options) -> double& {
                 return options.value_iteration.initial_value;
               }},
               "Value of every state to begin with"},
    kSymmetry,
};

constexpr OptionSpec kBound{
    "bound", "BOUND",
    ChoiceOption{
        kBoundNames, [](const Options& options) { return static_cast<std::size_t>(options.bound); },
        [](Options& options, std::size_t place) { options.bound = static_cast<BoundKind>(place); }},
    "The upper bound on what is left: {}", "{}; none is the paper's"};

constexpr std::array kBoundOptions = {kBound};
constexpr std::array kSearchOptions = {kBound, kSymmetry};

constexpr OptionSpec kPolicy{
    "policy", "FILE", FileOption{},
    "Plan with this policy of `orasp train`; auto and beam begin with its plan and take its advice",
    "train one first; auto and beam: none"};
constexpr std::array kPolicyOptions = {kPolicy};
constexpr std::array kBeamOptions = {kBound, kSymmetry, kPolicy};

constexpr std::string_view kTraining = "Training";
constexpr std::string_view kPaper = "As in the paper";
constexpr std::string_view kBeyond = "Beyond the paper";

constexpr std::array kTrainingOptions = {
    OptionSpec{"episodes", "N",
               WholeOption{[](Options& o) -> std::uint64_t& { return o.dqn.episodes; }, 1},
               "Episodes to play in all", "5000, and 20000 from 128 connections on", kTraining},
    OptionSpec{"device", "DEVICE",
               ChoiceOption{kDevices,
                            [](const Options& o) {
                              return static_cast<std::size_t>(
                                  std::ranges::find(kDevices, o.dqn.device) - kDevices.begin());
                            },
                            [](Options& o, std::size_t place) { o.dqn.device = kDevices[place]; }},
               "auto, cpu or cuda", "{}", kTraining},
    OptionSpec{"to-the-end", "",
               FlagOption{[](Options& o) -> bool& { return o.dqn.stop_when_proved; }, false},
               "Play all episodes", "stop when the policy's plan earns the proved bound",
               kTraining},
    OptionSpec{"inputs", "INPUTS",
               ChoiceOption{kInputsNames,
                            [](const Options& o) { return static_cast<std::size_t>(o.dqn.inputs); },
                            [](Options& o, std::size_t place) {
                              o.dqn.inputs = static_cast<NetworkInputs>(place);
                            }},
               "What the network sees: the open connections, as the paper's, or the pieces that a "
               "step leaves; {}",
               "{}, pieces from 128 connections on", kTraining},
    OptionSpec{"hidden", "N,N,...",
               WholeListOption{[](Options& o) -> std::vector<std::size_t>& { return o.dqn.hidden; },
                               1, 65'536},
               "Units of the hidden layers",
               "two of 128, or of the connections if they are more; two of 32 over pieces", kPaper},
    OptionSpec{
        "learning-rate", "RATE",
        RealOption{[](Options& o) -> double& { return o.dqn.learning_rate; }, Sign::Positive},
        "Of AdamW", "{}", kPaper},
    OptionSpec{"batch", "N",
               WholeOption{[](Options& o) -> std::uint64_t& { return o.dqn.batch; }, 1, 1'000'000},
               "Steps in a gradient step", "three times the connections, and 64 over pieces",
               kPaper},
    OptionSpec{
        "replay", "N",
        WholeOption{[](Options& o) -> std::uint64_t& { return o.dqn.replay; }, 1, 100'000'000},
        "Steps remembered", "{}", kPaper},
    OptionSpec{"discount", "SHARE",
               RealOption{[](Options& o) -> double& { return o.dqn.discount; }, Sign::Share},
               "Of the rewards to come", "{}", kPaper},
    OptionSpec{"epsilon-start", "SHARE",
               RealOption{[](Options& o) -> double& { return o.dqn.epsilon_start; }, Sign::Share},
               "Random actions at first", "{}", kPaper},
    OptionSpec{"epsilon-end", "SHARE",
               RealOption{[](Options& o) -> double& { return o.dqn.epsilon_end; }, Sign::Share},
               "Random actions in the end", "{}", kPaper},
    OptionSpec{
        "epsilon-decay", "STEPS",
        RealOption{[](Options& o) -> double& { return o.dqn.epsilon_decay; }, Sign::Positive},
        "Steps in which they fall by 1/e", "{}", kPaper},
    OptionSpec{"target-rate", "SHARE",
               RealOption{[](Options& o) -> double& { return o.dqn.target_rate; }, Sign::Share},
               "What the target network takes over at each gradient step", "{}", kPaper},
    OptionSpec{
        "gradient-clip", "SIZE",
        RealOption{[](Options& o) -> double& { return o.dqn.gradient_clip; }, Sign::Positive},
        "Cut the gradient's components here", "{}", kPaper},
    OptionSpec{"curriculum", "SHARE",
               RealOption{[](Options& o) -> double& { return o.dqn.curriculum; }, Sign::Share},
               "Share of the episodes in which the network takes over ever earlier, having begun "
               "with the last connection",
               "0.5, and 0 over pieces", kPaper},
    OptionSpec{
        "environments", "N",
        WholeOption{[](Options& o) -> std::uint64_t& { return o.dqn.environments; }, 1, 65'536},
        "Episodes side by side that explore, beside one that acts greedily",
        "7, and 31 from 128 connections on that are not over pieces", kBeyond},
    OptionSpec{"updates-per-step", "N",
               WholeOption{[](Options& o) -> std::uint64_t& { return o.dqn.updates_per_step; }, 1,
                           1'000'000},
               "Gradient steps for each step of all episodes", "{}", kBeyond},
    OptionSpec{
        "n-step", "N", WholeOption{[](Options& o) -> std::uint64_t& { return o.dqn.n_step; }},
        "Rewards that a target takes from its episode before the network's estimate, over pieces "
        "only up to the next random step; 0: all",
        "{}", kBeyond},
    OptionSpec{"imitation", "SHARE",
               RealOption{[](Options& o) -> double& { return o.dqn.imitation; }, Sign::Share},
               "Share of each batch that is taken from the best episode", "{}", kBeyond},
    OptionSpec{
        "no-double-q", "", FlagOption{[](Options& o) -> bool& { return o.dqn.double_q; }, false},
        "Let the target network choose the action it values", "the network chooses", kBeyond},
    OptionSpec{"no-returns", "",
               FlagOption{[](Options& o) -> bool& { return o.dqn.returns; }, false},
               "Let a target be below what its episode earned", "never", kBeyond},
    OptionSpec{"no-known-reward", "",
               FlagOption{[](Options& o) -> bool& { return o.dqn.known_reward; }, false},
               "Let the network learn each step's own reward too", "it is added", kBeyond},
    OptionSpec{"no-scaling", "", FlagOption{[](Options& o) -> bool& { return o.dqn.scale; }, false},
               "Learn rewards as they are", "centred and scaled by random episodes", kBeyond},
};

/// The number that the whole of `text` is, or nothing.
template <class Number>
std::optional<Number> parsed(std::string_view text) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end ? std::optional(value) : std::nullopt;
}

std::vector<std::size_t> whole_numbers(std::string_view label, std::string_view text,
                                       const WholeListOption& kind) {
  std::vector<std::size_t> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    numbers.push_back(
        whole_number(label, text.substr(begin, end - begin), kind.least, kind.greatest));
    begin = end + 1;
  }
  return numbers;
}

/// The names of the methods that have the option.
std::vector<std::string_view> methods_with(std::string_view option) {
  std::vector<std::string_view> methods;
  for (const Planner& planner : planners()) {
    if (std::ranges::find(planner.options(), option, &OptionSpec::name) != planner.options().end())
      methods.push_back(planner.name);
  }
  return methods;
}

std::string with(std::string_view text, const std::string& filling) {
  std::string filled(text);
  if (const std::size_t place = filled.find("{}"); place != std::string::npos)
    filled.replace(place, 2, filling);
  return filled;
}

}  // namespace

std::span<const OptionSpec> no_options() {
  return {};
}
std::span<const OptionSpec> symmetry_options() {
  return kSymmetryOptions;
}
std::span<const OptionSpec> search_options() {
  return kSearchOptions;
}
std::span<const OptionSpec> sweep_options() {
  return kSweepOptions;
}
std::span<const OptionSpec> bound_options() {
  return kBoundOptions;
}
std::span<const OptionSpec> beam_options() {
  return kBeamOptions;
}
std::span<const OptionSpec> policy_options() {
  return kPolicyOptions;
}
std::span<const OptionSpec> training_options() {
  return kTrainingOptions;
}

std::string help_of(const OptionSpec& option) {
  std::string standard = value_of(option, Options());
  if (const std::size_t zero = standard.find("e-0"); zero != std::string::npos)
    standard.erase(zero + 2, 1);  // 1e-09 is how a program writes 1e-9
  return fmt::format("{} (default: {}).", with(option.help, detail::listed(words_of(option))),
                     with(option.otherwise, standard));
}

std::span<const std::string_view> words_of(const OptionSpec& option) {
  const auto* const choice = std::get_if<ChoiceOption>(&option.kind);
  return choice == nullptr ? std::span<const std::string_view>() : choice->words;
}

bool is_bare(const OptionSpec& option) {
  return std::holds_alternative<FlagOption>(option.kind) ||
         std::holds_alternative<WholeOption>(option.kind) ||
         std::holds_alternative<RealOption>(option.kind);
}

std::string value_of(const OptionSpec& option, const Options& options) {
  // The members are handed out for writing; what is read here is a copy.
  Options copy = options;
  struct Reader {
    Options& from;
    std::string operator()(const FlagOption& kind) const {
      return kind.member(from) == kind.given ? "true" : "false";
    }
    std::string operator()(const WholeOption& kind) const {
      return fmt::to_string(kind.member(from));
    }
    std::string operator()(const WholeListOption& kind) const {
      return fmt::format("{}", fmt::join(kind.member(from), ","));
    }
    std::string operator()(const RealOption& kind) const {
      return fmt::to_string(kind.member(from));
    }
    std::string operator()(const ChoiceOption& kind) const {
      const std::size_t place = kind.get(from);
      return place < kind.words.size() ? std::string(kind.words[place]) : std::string();
    }
    std::string operator()(const FileOption&) const { return {}; }
  };
  return std::visit(Reader{copy}, option.kind);
}

void set_option(const OptionSpec& option, std::string_view label, std::string_view text,
                Options& options) {
  struct Writer {
    std::string_view label;
    std::string_view text;
    Options& to;
    void operator()(const FlagOption& kind) const { kind.member(to) = kind.given; }
    void operator()(const WholeOption& kind) const {
      kind.member(to) = whole_number(label, text, kind.least, kind.greatest);
    }
    void operator()(const WholeListOption& kind) const {
      kind.member(to) = whole_numbers(label, text, kind);
    }
    void operator()(const RealOption& kind) const {
      kind.member(to) = number(label, text, kind.sign);
    }
    void operator()(const ChoiceOption& kind) const {
      const auto found = std::ranges::find(kind.words, text);
      if (found == kind.words.end())
        throw InputError(fmt::format("{}: {} is none of {}{}", label, detail::in_quotes(text),
                                     detail::listed(kind.words),
                                     detail::suggestion(text, kind.words)));
      kind.set(to, static_cast<std::size_t>(found - kind.words.begin()));
    }
    void operator()(const FileOption&) const {}
  };
  std::visit(Writer{label, text, options}, option.kind);
}

Options options_from(std::string_view method, const OptionTexts& given, std::string_view mark) {
  const Planner& planner = find_planner(method);
  Options options;
  for (const auto& [name, text] : given) {
    const std::span<const OptionSpec> rows = planner.options();
    const auto row = std::ranges::find(rows, name, &OptionSpec::name);
    const std::string label = std::string(mark) + name;
    if (row == rows.end()) {
      const std::vector<std::string_view> owners = methods_with(name);
      if (owners.empty()) throw InputError(fmt::format("no method has an option {}", label));
      throw InputError(fmt::format("{} belongs to the method{} {}, not to {}", label,
                                   owners.size() > 1 ? "s" : "", detail::listed(owners, "and"),
                                   method));
    }
    set_option(*row, label, text, options);
  }
  return options;
}

std::string owners_of(std::string_view option) {
  return detail::listed(methods_with(option), "and");
}

std::uint64_t whole_number(std::string_view label, std::string_view text, std::uint64_t least,
                           std::uint64_t greatest) {
  const auto value = parsed<std::uint64_t>(text);
  if (value && *value >= least && *value <= greatest) return *value;
  throw InputError(fmt::format("{}: {} is not a whole number from {} to {}", label,
                               detail::in_quotes(text), least, greatest));
}

double number(std::string_view label, std::string_view text, Sign sign) {
  const auto value = parsed<double>(text);
  const bool finite = value && std::isfinite(*value);
  bool allowed = finite;
  const char* wanted = "a number";
  switch (sign) {
    case Sign::Any: break;
    case Sign::NotNegative:
      allowed = finite && *value >= 0;
      wanted = "a number of 0 or more";
      break;
    case Sign::Positive:
      allowed = finite && *value > 0;
      wanted = "a number above 0";
      break;
    case Sign::Share:
      allowed = finite && *value >= 0 && *value <= 1;
      wanted = "a number from 0 to 1";
      break;
  }
  if (allowed) return *value;
  throw InputError(fmt::format("{}: {} is not {}", label, detail::in_quotes(text), wanted));
}

}  // namespace orasp
