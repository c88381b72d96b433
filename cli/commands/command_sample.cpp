#include "cli/commands/command_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/json_output.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "orasp/planners/random_rewards.h"
#include "orasp/planners/reward_statistics.h"

namespace orasp::cli {
namespace {

using Sample = RandomRewards;

/// What a policy earns, and what there is to earn.
struct Yardstick {
  double policy = 0;
  Result best;  ///< of `auto`
};

/// `auto` gets the time limit, 10 s where there is none.
std::optional<Yardstick> yardstick(const Problem& problem, const TransitionSystem& system,
                                   const SampleOptions& options) {
  if (options.policy.empty()) return std::nullopt;
  const PolicyFile file = read_policy(options.policy, problem);
  LimitOptions limits = options.limits;
  if (!limits.time_limit) limits.time_limit = 10;
  const Result followed = follow_policy(system, file.trained.policy, make_budget(limits));
  if (!followed.has_plan()) throw InputError(fmt::format("{} finds no plan", options.policy));
  return Yardstick{followed.reward, solve(problem, "auto", {}, make_budget(limits))};
}

nlohmann::ordered_json as_json(const Problem& problem, const Sample& sample,
                               const RewardFigures& figures,
                               const std::optional<Yardstick>& yardstick,
                               const SampleOptions& options) {
  const auto number = [&](double value) {
    return sample.rewards.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
  };
  nlohmann::ordered_json document = {
      {"n", sample.rewards.size()},
      {"seed", options.seed},
      {"mean", number(figures.mean)},
      {"deviation", number(figures.deviation)},
      {"min", number(figures.least)},
      {"quartiles",
       {number(figures.percentiles[1]), number(figures.percentiles[2]),
        number(figures.percentiles[3])}},
      {"max", number(figures.greatest)},
      {"rewards", sample.rewards}};
  if (yardstick) {
    const Result& best = yardstick->best;
    document["policy_reward"] = yardstick->policy;
    document["best_status"] = status_name(best.status);
    document["best_reward"] =
        best.has_plan() ? nlohmann::ordered_json(best.reward) : nlohmann::ordered_json();
    document["bound"] = best.bound && std::isfinite(*best.bound)
                            ? nlohmann::ordered_json(*best.bound)
                            : nlohmann::ordered_json();
  }
  if (options.sequences) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const auto& sequence : sample.sequences) {
      nlohmann::ordered_json ids = nlohmann::ordered_json::array();
      for (const ConnectionIndex c : sequence) ids.push_back(problem.connection_id(c));
      list.push_back(std::move(ids));
    }
    document["sequences"] = std::move(list);
  }
  return document;
}

/// Bars of '#': how many rewards fall into each of equal ranges from the least to the greatest.
std::string histogram(const std::vector<double>& rewards, const RewardFigures& figures,
                      std::size_t width) {
  const double span = figures.greatest - figures.least;
  if (!(span > 0)) return {};
  const auto bars = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::ceil(std::log2(static_cast<double>(rewards.size())))) + 1, 5,
      20);
  std::vector<std::size_t> counts(bars);
  for (const double reward : rewards) {
    const auto bar =
        static_cast<std::size_t>((reward - figures.least) / span * static_cast<double>(bars));
    ++counts[std::min(bar, bars - 1)];
  }
  std::vector<double> starts;
  for (std::size_t bar = 0; bar < bars; ++bar)
    starts.push_back(figures.least + span * static_cast<double>(bar) / static_cast<double>(bars));
  const std::vector<std::string> labels = aligned_numbers(starts);
  std::size_t label_width = 0;
  for (const std::string& label : labels) label_width = std::max(label_width, label.size());
  const std::size_t most = *std::ranges::max_element(counts);
  const std::size_t room = std::min<std::size_t>(width - label_width - 12, 60);
  std::string text;
  for (std::size_t bar = 0; bar < bars; ++bar) {
    const std::string marks((counts[bar] * room + most - 1) / most, '#');
    text += fmt::format("{:>{}}  {:>6}{}{}\n", labels[bar], label_width, grouped(counts[bar]),
                        marks.empty() ? "" : "  ", marks);
  }
  return text;
}

std::string yardstick_text(const Yardstick& yardstick, const Sample& sample) {
  const auto beaten = static_cast<std::size_t>(std::ranges::count_if(
      sample.rewards, [&](double reward) { return reward < yardstick.policy; }));
  std::string text =
      fmt::format("\n{:<14}  {}, more than {} of {}\n", "policy", number_text(yardstick.policy),
                  grouped(beaten), counted(sample.rewards.size(), "random sequence"));
  const Result& best = yardstick.best;
  if (best.has_plan())
    text += fmt::format("{:<14}  {}, {}\n", "best plan", number_text(best.reward),
                        best.status == Status::Optimal ? "proved optimal" : "not proved optimal");
  if (best.status != Status::Optimal && best.bound && std::isfinite(*best.bound))
    text += fmt::format("{:<14}  {}\n", "bound", number_text(*best.bound));
  return text;
}

std::string summary(const Problem& problem, const Sample& sample, const RewardFigures& figures,
                    const std::optional<Yardstick>& yardstick, const SampleOptions& options,
                    const Context& context) {
  std::string text = fmt::format("{}: {} of {}, seed {}\n", title(problem, options.problem),
                                 grouped(sample.rewards.size()),
                                 counted(options.count, "random sequence"), options.seed);
  if (!sample.rewards.empty()) {
    const std::vector<double> numbers = {
        figures.mean,           figures.deviation,      figures.least,   figures.percentiles[1],
        figures.percentiles[2], figures.percentiles[3], figures.greatest};
    const std::vector<std::string> texts = aligned_numbers(numbers);
    constexpr std::array<const char*, 7> kNames = {
        "mean", "deviation", "minimum", "lower quartile", "median", "upper quartile", "maximum"};
    std::size_t widest = 0;
    for (const std::string& number : texts) widest = std::max(widest, number.size());
    for (std::size_t i = 0; i < texts.size(); ++i)
      text += fmt::format("{:<14}  {:>{}}\n", kNames[i], texts[i], widest);
    const std::string bars = histogram(sample.rewards, figures, context.width());
    if (!bars.empty()) text += fmt::format("\nrewards from\n{}", bars);
  }
  if (yardstick) text += yardstick_text(*yardstick, sample);
  if (sample.last.status == Status::Infeasible)
    text += "\ninfeasible (proved): no sequence handles every connection\n";
  if (sample.last.stop != Stop::None) text += '\n' + stop_text(sample.last.stop) + '\n';
  for (const std::string& note : sample.last.notes) text += printable(note) + '\n';
  return text;
}

}  // namespace

int run(const SampleOptions& options, const Context& context) {
  const Problem problem =
      load_one_robot_problem(options.problem, options.changes, context, "sample");
  const TransitionSystem system(problem);
  const std::optional<Yardstick> compared = yardstick(problem, system, options);
  Sample sample;
  {
    ProgressLine progress(context, title(problem, options.problem) + ", sample");
    Budget budget = make_budget(options.limits);
    progress.attach_to(budget);
    if (const std::optional<Violation> reason = system.infeasibility()) {
      sample.last.status = Status::Infeasible;
      sample.last.notes = {reason->message};
    } else {
      sample = draw_rewards(system, options.count, options.seed, options.sequences, budget);
    }
  }
  const RewardFigures figures = figures_of(sample.rewards);
  if (options.json) {
    for (const std::string& note : sample.last.notes) context.warn(printable(note));
  }
  print_result(context, options.output, options.json,
               as_json(problem, sample, figures, compared, options),
               [&] { return summary(problem, sample, figures, compared, options, context); });
  if (sample.rewards.size() == options.count) return kSolved;
  return exit_code(sample.last);
}

CommandWork sample_command(CommandLine& line) {
  const auto chosen = std::make_shared<SampleOptions>();
  SampleOptions& options = *chosen;
  line.about(
      "Draws random legal sequences, every legal action of a state as likely as any\n"
      "other, and describes their rewards.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Sample");
  line.whole("-n,--count", "N", "Sequences to draw (default: 100).", options.count, 1);
  add_seed_option(line, options.seed, "the sample");
  line.text("--policy", "FILE",
            "Say too what this policy of `orasp train` earns, and the best plan that auto finds in "
            "the time limit, or 10 s (default: neither).",
            options.policy);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits);
  add_output_options(line, options.json, options.output, "the figures and all rewards");
  line.flag("--sequences", options.sequences,
            "Add the sequences to the JSON (default: rewards alone).");
  line.footer(
      "\nExamples:\n"
      "  orasp sample hubble-free -n 1000\n"
      "  orasp sample jwst -n 100 --seed 7 --json --sequences\n"
      "\n"
      "Exit codes: 0 drawn, 10 proved infeasible, 20 a limit stopped it, 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
