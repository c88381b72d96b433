#include "cli/commands/command_train.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"
#include "cli/options/shared_options.h"
#include "cli/output/json_output.h"
#include "cli/output/text.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/graph_policy_file.h"
#include "orasp/io/policy_file.h"
#include "orasp/io/problem_json.h"
#include "orasp/learning/imitation.h"
#include "orasp/model/tolerance.h"

namespace orasp::cli {
namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}
Json number_or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}
std::string reward_text(double value) {
  return std::isfinite(value) ? number_text(value) : std::string("-");
}

/// The training log: a line of JSON after every round, at once in the file.
class Log {
 public:
  Log(const std::string& file, bool go_on) : name_(file) {
    if (file.empty()) return;
    stream_.reset(std::fopen(file.c_str(), go_on ? "ab" : "wb"));
    if (!stream_) fail();
  }
  void write(const TrainingRecord& record) {
    write(Json{{"episodes", record.episodes},
               {"updates", record.updates},
               {"epsilon", record.epsilon},
               {"loss", record.loss},
               {"greedy", number_or_null(record.greedy)},
               {"best_greedy", number_or_null(record.best_greedy)},
               {"best", number_or_null(record.best)},
               {"bound", number_or_null(record.bound)},
               {"seconds", record.seconds}});
  }
  void write(const Json& line) {
    if (!stream_) return;
    const std::string text = line.dump() + '\n';
    if (std::fwrite(text.data(), 1, text.size(), stream_.get()) != text.size() ||
        std::fflush(stream_.get()) != 0)
      fail();
  }

 private:
  struct Close {
    void operator()(std::FILE* stream) const { static_cast<void>(std::fclose(stream)); }
  };
  [[noreturn]] void fail() const {
    throw InputError(
        fmt::format("cannot write {}: {}", name_, std::generic_category().message(errno)));
  }
  std::string name_;
  std::unique_ptr<std::FILE, Close> stream_;
};

/// Tells people how training goes: a line where the policy improved, and one every ten seconds.
class Reporter {
 public:
  explicit Reporter(const Context& context) : context_(context) {}
  void tell(const TrainingRecord& record) {
    const bool improved = record.best_greedy > told_;
    if (!improved && record.seconds < next_) return;
    told_ = record.best_greedy;
    next_ = record.seconds + 10;
    context_.say(
        fmt::format("{:>7} episodes {:>8} updates  greedy {:>10}  best {:>10}  bound {:>10}  {}",
                    grouped(record.episodes), grouped(record.updates), reward_text(record.greedy),
                    reward_text(record.best), record.bound ? reward_text(*record.bound) : "-",
                    seconds_text(record.seconds)));
  }

 private:
  const Context& context_;
  double told_ = -kInfinity;
  double next_ = 0;
};

/// Training takes minutes: that its result cannot be written is said before.
void require_folder(const std::string& file) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  std::error_code ignored;
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
    throw InputError(fmt::format("cannot write {}: there is no folder {}", file, folder.string()));
}

PolicyFile file_of(const Problem& problem, const Training& training) {
  return {.problem_digest = problem_digest(problem),
          .problem_name = problem.name(),
          .trained = training.trained};
}

Json as_json(const Problem& problem, const Training& training, const TrainOptions& options) {
  const Result& result = training.result;
  Json sequence = Json::array();
  for (const ConnectionIndex c : result.sequence) sequence.push_back(problem.connection_id(c));
  Json steps = Json::array();  // where a step takes more than one connection
  for (const PlanStep& step : result.steps) {
    Json& taken = steps.emplace_back(Json::array());
    for (const ConnectionIndex c : step.connections) taken.push_back(problem.connection_id(c));
  }
  Json document = {{"problem", problem.name()},
                   {"problem_digest", problem_digest(problem)},
                   {"seed", options.learning.dqn.seed},
                   {"device", training.device},
                   {"episodes", training.record.episodes},
                   {"updates", training.record.updates},
                   {"policy_reward", number_or_null(training.trained.reward)},
                   {"final_reward", number_or_null(training.record.greedy)},
                   {"status", status_name(result.status)},
                   {"reward", result.has_plan() ? Json(result.reward) : Json()},
                   {"bound", number_or_null(result.bound)},
                   {"sequence", std::move(sequence)},
                   {"notes", result.notes},
                   {"seconds", result.statistics.seconds}};
  if (!steps.empty()) document["steps"] = std::move(steps);
  if (result.stop != Stop::None) document["stopped"] = stop_name(result.stop);
  return document;
}

std::string summary(const Problem& problem, const Training& training, const TrainOptions& options) {
  const Result& result = training.result;
  std::string text = fmt::format("{}: {}\n", title(problem, options.problems.front()),
                                 result.stop == Stop::None ? "trained" : stop_text(result.stop));
  const auto line = [&text](std::string_view name, const std::string& value) {
    text += fmt::format("{:<9} {}\n", name, value);
  };
  if (result.status == Status::Infeasible) {
    line("status", "infeasible (proved: no plan exists)");
    for (const std::string& note : result.notes) text += printable(note) + '\n';
    return text;
  }
  line("episodes", grouped(training.record.episodes));
  line("updates", grouped(training.record.updates));
  line("policy", reward_text(training.trained.reward) + " (the best of the training, kept)");
  line("final", reward_text(training.record.greedy) + " (the network at the end)");
  line("best plan", result.has_plan() ? reward_text(result.reward) : "-");
  if (training.record.bound) {
    const double bound = *training.record.bound;
    const double gap = bound - training.trained.reward;
    std::string meaning;
    if (gap <= kRewardTolerance * std::max(1.0, std::abs(bound))) {
      meaning = " (the policy's plan is optimal, proved)";
    } else if (std::isfinite(gap)) {
      meaning = fmt::format(" ({} more than the policy's plan)", reward_text(gap));
    }
    line("bound", reward_text(bound) + meaning);
  }
  line("time", seconds_text(training.record.seconds));
  if (options.policy.empty()) line("written", "nowhere: -o FILE keeps the policy");
  if (!options.policy.empty() && !training.trained.policy.empty()) line("written", options.policy);
  for (const std::string& note : result.notes) text += printable(note) + '\n';
  return text;
}

Json as_json(const ImitationRecord& record) {
  return {{"epoch", record.epoch},
          {"own", record.own},
          {"problems", record.problems},
          {"held_out_problems", record.held_out_problems},
          {"states", record.states},
          {"held_out_states", record.held_out_states},
          {"loss", record.loss},
          {"held_out_loss", record.held_out_loss},
          {"held_out_right", record.held_out_right},
          {"seconds", record.seconds}};
}

/// `orasp train --problems`.
int run_together(const TrainOptions& options, const Context& context) {
  if (!options.of_q_learning.empty())
    throw InputError(
        fmt::format("{} belongs to deep Q-learning, and --problems learns by imitation",
                    options.of_q_learning));
  std::vector<std::unique_ptr<const Problem>> problems;
  std::vector<std::unique_ptr<const TransitionSystem>> systems;
  std::vector<const TransitionSystem*> plain;
  std::optional<ProblemKind> kind;
  for (const std::string& name : options.problems) {
    problems.push_back(std::make_unique<const Problem>(
        load_one_robot_problem(name, options.changes, context, "train")));
    const ProblemKind mine = kind_of(*problems.back());
    kind = kind ? kind_of_both(*kind, mine) : mine;
    systems.push_back(std::make_unique<const TransitionSystem>(*problems.back()));
    plain.push_back(systems.back().get());
  }
  std::optional<GraphPolicyFile> earlier;
  if (!options.resume.empty()) {
    earlier = read_graph_policy(options.resume);
    kind = kind_of_both(earlier->kind, *kind);
  }
  Log log(options.log, earlier.has_value());
  ImitationOptions imitation;
  imitation.seed = options.learning.dqn.seed;
  const Imitation learned = imitate(
      plain, imitation, make_budget(options.limits),
      [&](const ImitationRecord& record) {
        log.write(as_json(record));
        context.say(fmt::format("{:>4} epochs  loss {:.4f}  held out {:.4f}  right {:.1f} %  {}{}",
                                record.epoch, record.loss, record.held_out_loss,
                                100 * record.held_out_right, seconds_text(record.seconds),
                                record.own ? "  with own states" : ""));
      },
      earlier ? &earlier->policy : nullptr);
  const ImitationRecord& best = learned.best;
  if (best.states == 0) {
    context.warn("nothing was learned: no state of the problems has a choice that was settled");
  } else if (!options.policy.empty()) {
    write_file(
        options.policy,
        graph_policy_bytes({.kind = *kind, .seed = imitation.seed, .policy = learned.policy}));
  }
  Json document = as_json(best);
  document["seed"] = imitation.seed;
  if (learned.stop != Stop::None) document["stopped"] = stop_name(learned.stop);
  print_result(context, "", options.json, document, [&] {
    return fmt::format(
        "{} problems: {}\n{:<9} {} problems, {} states\n{:<9} {} problems, {} states, {:.1f} % of "
        "the choices optimal\n{:<9} {}\n{:<9} {}\n",
        problems.size(), learned.stop == Stop::None ? "trained" : stop_text(learned.stop),
        "learned", best.problems, best.states, "held out", best.held_out_problems,
        best.held_out_states, 100 * best.held_out_right, "time", seconds_text(best.seconds),
        "written",
        options.policy.empty() ? "nowhere: -o FILE keeps the policy"
                               : (best.states == 0 ? "nothing" : options.policy));
  });
  return learned.stop == Stop::None ? kSolved : kStopped;
}

}  // namespace

int run(const TrainOptions& options, const Context& context) {
  if (!options.policy.empty()) require_folder(options.policy);
  if (options.together) return run_together(options, context);
  if (options.problems.size() > 1)
    throw InputError(
        "train learns a policy for one problem; --problems learns one for all of several");
  const Problem problem =
      load_one_robot_problem(options.problems.front(), options.changes, context, "train");
  if (problem.uncertain()) {
    throw InputError(fmt::format(
        "train learns for attempts that always succeed, and an attempt at connection {} may fail "
        "(its success is below 1); `orasp solve` finds the optimal policy",
        in_quotes(problem.connection_id(*problem.first_uncertain()))));
  }
  std::optional<PolicyFile> earlier;
  if (!options.resume.empty()) earlier = read_policy(options.resume, problem);
  DqnOptions dqn = options.learning.dqn;
  if (earlier) {
    dqn.inputs =
        earlier->trained.policy.pieces ? NetworkInputs::Pieces : NetworkInputs::Connections;
    dqn.hidden = earlier->trained.training.hidden;
    dqn.known_reward = earlier->trained.training.known_reward;
  }
  const TransitionSystem system(problem);
  Training training;
  {
    Budget budget = make_budget(options.limits);
    Log log(options.log, earlier.has_value());
    Reporter reporter(context);
    TrainingHooks hooks;
    hooks.save_every = options.checkpoint_every;
    hooks.log = [&](const TrainingRecord& record) {
      log.write(record);
      reporter.tell(record);
    };
    if (!options.policy.empty()) {
      hooks.save = [&](const Training& now) {
        write_file(options.policy, policy_bytes(file_of(problem, now)));
      };
    }
    training = train(system, dqn, budget, hooks, earlier ? &earlier->trained : nullptr);
  }
  if (!training.warning.empty()) context.warn(training.warning);
  if (!options.policy.empty()) {
    if (!training.trained.policy.empty()) {
      write_file(options.policy, policy_bytes(file_of(problem, training)));
    } else {
      context.warn("nothing was learned, so " + options.policy + " is not written");
    }
  }
  print_result(context, "", options.json, as_json(problem, training, options),
               [&] { return summary(problem, training, options); });
  return exit_code(training.result);
}

CommandWork train_command(CommandLine& line) {
  const auto chosen = std::make_shared<TrainOptions>();
  TrainOptions& options = *chosen;
  line.about(
      "Learns a policy by deep Q-learning: a network that says in every state what to do\n"
      "next. `orasp solve --method dqn --policy` plans with it.\n"
      "With --problems: one graph network for many products, which answers for products that\n"
      "it has not seen too. Needs no libtorch.");
  line.positionals("PROBLEM", options.problems, kProblemHelp);
  line.group("Training");
  line.flag("--problems", options.together,
            "Learn one policy for all PROBLEMs and for others of their kind, by imitation of\n"
            "proved plans (default: a policy for one problem, by deep Q-learning).");
  line.text("-o,--output", "FILE",
            "Write the policy to FILE, now and then and at the end (default: none).",
            options.policy);
  line.text("--resume", "FILE",
            "Go on from this policy (default: begin anew). With --problems one of --problems.",
            options.resume);
  line.text("--log", "FILE", "Write a line of JSON after every round of episodes (default: none).",
            options.log);
  line.value("--checkpoint-every", "SECONDS", "Write the policy this often (default: 30).",
             [&options](const std::string& text) {
               options.of_q_learning = "--checkpoint-every";
               options.checkpoint_every = number("--checkpoint-every", text, Sign::Positive);
             });
  add_seed_option(line, options.learning.dqn.seed,
                  "the network's first weights and the random actions");
  for (const OptionSpec& row : training_options()) {
    line.group(std::string(row.group));
    line.option(row, [&options, &row](const std::string& text) {
      options.of_q_learning = "--" + std::string(row.name);
      set_option(row, "--" + std::string(row.name), text, options.learning);
    });
  }
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits, "", false);
  line.group("Output");
  line.flag("--json", options.json, "Print the outcome as JSON (default: text for people).");
  line.quiet_flag("No progress and no warnings on standard error (default: both).");
  line.footer(
      "\nExamples:\n"
      "  orasp train hubble-upc -o policy.pt\n"
      "  orasp solve hubble-upc --method dqn --policy policy.pt\n"
      "  orasp train jwst-upc -o policy.pt --time-limit 600 --log training.jsonl\n"
      "  orasp train jwst-upc --resume policy.pt -o policy.pt --time-limit 600\n"
      "  orasp train --problems tree:12:1 tree:14:2 grid:3x4 -o general.pt\n"
      "  orasp solve tree:40:3 --method dqn --policy general.pt\n"
      "\n"
      "Exit codes: 0 trained, 10 proved infeasible, 20 a limit or Ctrl-C stopped it (the\n"
      "best policy so far is written), 30 wrong input or no libtorch.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
