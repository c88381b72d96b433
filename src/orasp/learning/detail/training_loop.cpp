#include "orasp/learning/detail/training_loop.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "orasp/model/error.h"
#include "orasp/planners/planner_support.h"

namespace orasp::detail {

void check_training(const DqnOptions& options) {
  const auto positive = [](double value, const char* name) {
    if (!(value > 0) || !std::isfinite(value))
      throw InputError(std::string(name) + " must be more than 0");
  };
  const auto share = [](double value, const char* name) {
    if (!(value >= 0 && value <= 1))
      throw InputError(std::string(name) + " must be between 0 and 1");
  };
  positive(options.learning_rate, "learning rate");
  positive(options.gradient_clip, "gradient clip");
  positive(options.epsilon_decay, "epsilon decay");
  positive(static_cast<double>(options.replay), "replay");
  positive(static_cast<double>(options.updates_per_step), "updates per step");
  share(options.discount, "discount");
  share(options.epsilon_start, "epsilon start");
  share(options.epsilon_end, "epsilon end");
  share(options.target_rate, "target rate");
  share(std::max(options.curriculum, 0.0), "curriculum");
  for (const std::size_t units : options.hidden) {
    if (units == 0 || units > 65'536)
      throw InputError("a hidden layer must have between 1 and 65536 units");
  }
}

void require_network_fits(const DqnOptions& options, std::size_t inputs, std::size_t outputs,
                          const Budget& budget) {
  double parameters = 0;
  auto before = static_cast<double>(inputs);
  for (const std::size_t units : options.hidden) {
    parameters += (before + 1) * static_cast<double>(units);
    before = static_cast<double>(units);
  }
  parameters += (before + 1) * static_cast<double>(outputs);
  constexpr double kCopies =
      7;  // network, target network, gradient, three moments, the policy kept
  const double bytes = parameters * kCopies * sizeof(float);
  if (bytes <= static_cast<double>(budget.max_bytes)) return;
  throw InputError("training a network of " +
                   std::to_string(static_cast<std::uint64_t>(parameters / 1e6)) +
                   " million weights needs about " +
                   std::to_string(static_cast<std::uint64_t>(bytes / (1 << 20))) +
                   " MiB, more than the memory limit; make its hidden layers smaller");
}

TrainingLoop::TrainingLoop(const TransitionSystem& system, const DqnOptions& options,
                           const Budget& budget, const TrainingHooks& hooks)
    : system_(system), options_(options), budget_(budget), random_(options.seed), hooks_(hooks) {
  training_.record.bound = bound_of_start(system);
}

Training TrainingLoop::run() {
  network_ = new_network();
  training_.device = network_->device();
  training_.warning = network_->warning();
  const TrainingState& state = training_.trained.training;
  if (!state.network.empty()) network_->restore(state.network);
  double saved = 0;
  while (!finished()) {
    if (!warmed_up()) {
      warm_up();
      if (stopped()) break;
      continue;
    }
    play(false);
    if (stopped()) break;
    judge_round();
    if (finished()) break;
    learn();
    tell();
    if (hooks_.save && watch_.seconds() - saved >= hooks_.save_every) {
      pack();
      hooks_.save(training_);
      saved = watch_.seconds();
    }
  }
  if (warmed_up()) judge_at_the_end();
  tell();
  pack();
  finish();
  return std::move(training_);
}

bool TrainingLoop::stopped() {
  if (stop_ == Stop::None) stop_ = budget_.expired(bytes(), expanded());
  return stop_ != Stop::None;
}

bool TrainingLoop::proved(double reward) const {
  return training_.record.bound && meets(reward, *training_.record.bound);
}

bool TrainingLoop::finished() {
  return stopped() || training_.trained.training.episodes >= options_.episodes ||
         (options_.stop_when_proved && proved(training_.trained.reward));
}

double TrainingLoop::epsilon() const {
  return options_.epsilon_end +
         (options_.epsilon_start - options_.epsilon_end) *
             std::exp(-static_cast<double>(training_.trained.training.steps) /
                      options_.epsilon_decay);
}

std::size_t TrainingLoop::begin_at() const {
  const std::size_t n = system_.num_connections();
  if (options_.curriculum <= 0) return n;
  const double done = static_cast<double>(training_.trained.training.episodes) /
                      (options_.curriculum * static_cast<double>(options_.episodes));
  return done >= 1 ? n : 1 + static_cast<std::size_t>(done * static_cast<double>(n));
}

bool TrainingLoop::best_so_far(double reward) {
  if (!(reward > training_.record.best)) return false;
  training_.record.best = reward;
  return true;
}

/// The greedy episode of the round: the network is kept if it is the best so far.
void TrainingLoop::judge_round() {
  training_.record.greedy = greedy_;
  if (greedy_ == -kInfinity || greedy_ > training_.trained.reward) judge(policy());
}

/// What the network earns when training is over, though its time may be: a single plan.
void TrainingLoop::judge_at_the_end() {
  training_.record.greedy = -kInfinity;
  Budget budget;
  budget.max_bytes = budget_.max_bytes;
  budget.max_expansions = system_.num_connections() + 100;
  judge(policy(), budget);
}

void TrainingLoop::judge(Policy now) {
  Budget budget = budget_;
  budget.max_expansions = 20 * system_.num_connections() + 100;
  budget.progress = nullptr;
  judge(std::move(now), budget);
}

void TrainingLoop::judge(Policy now, const Budget& budget) {
  const Result result = plan_of(now, budget);
  TrainedPolicy& kept = training_.trained;
  if (result.has_plan()) {
    training_.record.greedy = result.reward;
    if (best_so_far(result.reward)) keep_plan(result);
  }
  if (kept.policy.empty() || (result.has_plan() && result.reward > kept.reward)) {
    kept.policy = std::move(now);
    if (result.has_plan()) kept.reward = training_.record.best_greedy = result.reward;
  }
}

void TrainingLoop::tell() {
  TrainingRecord& record = training_.record;
  record.episodes = training_.trained.training.episodes;
  record.updates = training_.trained.training.updates;
  record.epsilon = epsilon();
  record.seconds = training_.trained.training.seconds + watch_.seconds();
  const std::tuple now(record.episodes, record.updates, record.greedy);
  if (told_ && *told_ == now) return;
  told_ = now;
  if (hooks_.log) hooks_.log(record);
  budget_.report({.phase = "episodes",
                  .done = record.episodes,
                  .total = options_.episodes,
                  .states = remembered(),
                  .best = record.best});
}

/// Brings the training state up to date.
void TrainingLoop::pack() {
  TrainingState& state = training_.trained.training;
  state.hidden = options_.hidden;
  state.known_reward = options_.known_reward;
  state.random = random_.state();
  if (warmed_up()) state.network = network_->state();
}

void TrainingLoop::finish() {
  training_.trained.training.seconds += watch_.seconds();
  Result& result = training_.result;
  result.statistics.states = remembered();
  result.statistics.expanded = expanded();
  result.statistics.sweeps = training_.trained.training.episodes;
  result.statistics.peak_bytes = bytes();
  result.stop = stop_;
  write_best(result);
  if (!result.has_plan()) return;
  judge_by(training_.record.bound, result);
}

}  // namespace orasp::detail
