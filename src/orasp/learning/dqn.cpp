#include "orasp/learning/dqn.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>

#include "orasp/learning/detail/state_trainer.h"
#include "orasp/learning/detail/training_loop.h"
#include "orasp/learning/environment.h"
#include "orasp/learning/network.h"
#include "orasp/learning/piece_network.h"
#include "orasp/learning/replay_buffer.h"
#include "orasp/model/error.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

// -------------------------------------------------------------------------------------------------
// Targets

RestLimits rest_limits(const TransitionSystem& system) {
  const std::size_t n = system.num_connections();
  RewardRange step{kInfinity, -kInfinity};
  RewardRange last = step;
  for (std::size_t c = 0; c < n; ++c) {
    const auto widen = [&](bool completes, RewardRange& range) {
      const RewardRange one = system.reward_range(static_cast<ConnectionIndex>(c), n, completes);
      range.least = std::min(range.least, one.least);
      range.greatest = std::max(range.greatest, one.greatest);
    };
    widen(false, step);
    widen(true, last);
  }
  last.least = std::min(last.least, step.least);
  last.greatest = std::max(last.greatest, step.greatest);
  RestLimits limits{{0}, {0}};
  for (std::size_t k = 1; k <= n; ++k) {
    const auto others = static_cast<double>(k - 1);
    limits.least.push_back(last.least + (k > 1 ? others * step.least : 0));
    limits.greatest.push_back(last.greatest + (k > 1 ? others * step.greatest : 0));
  }
  return limits;
}

TargetRule::TargetRule(const DqnOptions& options, double scale, std::vector<double> baseline,
                       RestLimits limits)
    : options_(options),
      scale_(scale),
      baseline_(std::move(baseline)),
      limits_(std::move(limits)) {}

double TargetRule::baseline(std::size_t open) const {
  return open < baseline_.size() ? baseline_[open] : 0;
}

double TargetRule::centre(std::size_t open) const {
  // A sum over pieces has no use for what looks at all of them.
  if (options_.inputs == NetworkInputs::Pieces) return 0;
  return baseline(options_.known_reward ? open - 1 : open);
}

double TargetRule::value_of(double number, std::size_t open) const {
  return number * scale_ + centre(open);
}

double TargetRule::number_of(double value, std::size_t open) const {
  return (value - centre(open)) / scale_;
}

double TargetRule::dead_end(std::size_t open) const {
  constexpr double kScales = 10;
  return baseline(open) - kScales * scale_;
}

std::size_t TargetRule::reach(const ReplayBuffer& replay, std::size_t place) const {
  const std::size_t rest = replay.step(place).left + std::size_t{1};
  const std::size_t most = options_.n_step == 0 ? rest : std::min(options_.n_step, rest);
  if (options_.inputs != NetworkInputs::Pieces) return most;
  std::size_t ahead = 1;
  while (ahead < most && !replay.step(replay.later(place, ahead)).random) ++ahead;
  return ahead;
}

std::optional<std::size_t> TargetRule::asked(const ReplayBuffer& replay, std::size_t place) const {
  const std::size_t ahead = reach(replay, place);
  if (ahead > replay.step(place).left) return std::nullopt;
  return replay.later(place, ahead);
}

float TargetRule::target(const ReplayBuffer& replay, std::size_t place,
                         std::span<const float> online, std::span<const float> target) const {
  const ReplayBuffer::Step& step = replay.step(place);
  const std::size_t ahead = reach(replay, place);
  double value = 0;
  double weight = 1;
  for (std::size_t i = 0; i < ahead; ++i) {
    value += weight * replay.step(replay.later(place, i)).reward;
    weight *= options_.discount;
  }
  if (ahead > step.left) {
    if (step.dead_end) value += weight * dead_end(step.num_open - ahead);
  } else {
    const std::size_t place_there = replay.later(place, ahead);
    const std::size_t open = replay.step(place_there).num_open;
    const std::span<const float> rewards = replay.legal_rewards(place_there);
    const auto worth = [&](std::span<const float> numbers, std::size_t c) {
      return value_of(static_cast<double>(numbers[c]), open) +
             (options_.known_reward ? static_cast<double>(rewards[c]) : 0);
    };
    const std::span<const float> picks = options_.double_q ? online : target;
    std::size_t best = rewards.size();
    for (std::size_t c = 0; c < rewards.size(); ++c) {
      if (std::isnan(rewards[c])) continue;  // not legal there
      if (best == rewards.size() || worth(picks, c) > worth(picks, best)) best = c;
    }
    double rest = worth(target, best);
    if (options_.inputs == NetworkInputs::Pieces && options_.discount == 1 &&
        open < limits_.greatest.size()) {
      rest = std::min(std::max(rest, std::min(limits_.least[open], dead_end(open))),
                      limits_.greatest[open]);
    }
    value += weight * rest;
  }
  if (options_.returns && options_.discount == 1 && !step.dead_end)
    value = std::max(value, step.rest);
  if (options_.known_reward) value -= step.reward;
  return static_cast<float>(number_of(value, step.num_open));
}

// -------------------------------------------------------------------------------------------------
// Training

namespace {

class Trainer final : public detail::TrainingLoop {
 public:
  Trainer(const TransitionSystem& system, const DqnOptions& options, const Budget& budget,
          const TrainingHooks& hooks, const TrainedPolicy* resume)
      : TrainingLoop(system, with_defaults(options, system, budget), budget, hooks),
        world_(system, options_.environments + 1),
        replay_(options_.replay, system.num_connections()),
        best_episode_(system.num_connections(), system.num_connections()),
        traces_(options_.environments + 1, Trace(system.num_connections())),
        limits_(rest_limits(system)),
        rule_(options_, 1, {}, limits_) {
    if (resume != nullptr) go_on(*resume);
  }

 private:
  /// An episode while it is played.
  struct Trace {
    explicit Trace(std::size_t connections) : steps(connections) {}
    ReplayBuffer::Episode steps;
    std::vector<ConnectionIndex> sequence;
    bool over = false;
  };

  static DqnOptions with_defaults(DqnOptions options, const TransitionSystem& system,
                                  const Budget& budget) {
    detail::check_training(options);
    const std::size_t connections = system.num_connections();
    options.inputs =
        trains_over_pieces(system, options) ? NetworkInputs::Pieces : NetworkInputs::Connections;
    if (options.inputs == NetworkInputs::Pieces) {
      if (options.device == "cuda") {
        throw InputError(
            "a network over pieces is trained on the processor, not on device 'cuda': inputs "
            "'connections' take one");
      }
      if (options.hidden.empty()) options.hidden = {32, 32};
      if (options.batch == 0) options.batch = 64;
      if (options.environments == 0) options.environments = 7;
      if (options.curriculum < 0) options.curriculum = 0;
    }
    if (options.curriculum < 0) options.curriculum = 0.5;
    if (options.episodes == 0) options.episodes = connections < 128 ? 5'000 : 20'000;
    if (options.environments == 0) options.environments = connections < 128 ? 7 : 31;
    if (options.hidden.empty()) options.hidden.assign(2, std::max<std::size_t>(128, connections));
    if (options.batch == 0) options.batch = 3 * connections;
    detail::require_network_fits(options, connections, connections, budget);
    const std::uint64_t room = budget.max_bytes / 2 / ReplayBuffer::bytes_per_step(connections);
    options.replay = static_cast<std::size_t>(std::clamp<std::uint64_t>(room, 1, options.replay));
    return options;
  }

  void go_on(const TrainedPolicy& earlier) {
    const TrainingState& state = earlier.training;
    if (earlier.policy.pieces.has_value() != (options_.inputs == NetworkInputs::Pieces) ||
        state.hidden != options_.hidden || state.known_reward != options_.known_reward ||
        earlier.policy.num_connections() != system_.num_connections())
      throw InputError("the training to go on with has a network of another shape");
    training_.trained.training = state;
    random_ = SplitMix64(state.random);
    rule_ = TargetRule(options_, state.scale, state.baseline, limits_);
    if (!state.best.empty() && best_so_far(replayed(state.best)))
      training_.trained.training.best = state.best;
    judge(earlier.policy);
  }
  /// What a sequence earns, which a file says is a plan.
  [[nodiscard]] double replayed(const std::vector<ConnectionIndex>& sequence) {
    world_.reset(0);
    for (const ConnectionIndex c : sequence) {
      const auto actions = world_.actions(0);
      if (std::ranges::find(actions, c, &Action::connection) == actions.end())
        throw InputError("the training to go on with holds a best plan that is not legal");
      world_.step(0, c);
    }
    if (!world_.done(0))
      throw InputError("the training to go on with holds a best plan that is not whole");
    return world_.total(0);
  }

  [[nodiscard]] std::unique_ptr<Network> new_network() override {
    const NetworkOptions shape = {.connections = system_.num_connections(),
                                  .hidden = options_.hidden,
                                  .learning_rate = options_.learning_rate,
                                  .target_rate = options_.target_rate,
                                  .gradient_clip = options_.gradient_clip,
                                  .zero_outputs = options_.known_reward,
                                  .seed = options_.seed,
                                  .device = options_.device};
    if (options_.inputs != NetworkInputs::Pieces) return make_network(shape);
    auto pieces = std::make_unique<PieceNetwork>(system_, shape, options_.known_reward);
    pieces_ = pieces.get();
    return pieces;
  }
  [[nodiscard]] bool warmed_up() const override {
    return !training_.trained.training.baseline.empty();
  }
  [[nodiscard]] std::size_t remembered() const override { return replay_.size(); }
  [[nodiscard]] std::uint64_t bytes() const override {
    return replay_.size() * ReplayBuffer::bytes_per_step(system_.num_connections());
  }
  [[nodiscard]] std::uint64_t expanded() const override { return world_.expanded(); }

  void play(bool all_random) override {
    const double share = all_random ? 1 : epsilon();
    const std::size_t from = begin_at();
    for (std::size_t i = 0; i < world_.size(); ++i) {
      world_.reset(i);
      traces_[i].steps.clear();
      traces_[i].sequence.clear();
      traces_[i].over = false;
    }
    greedy_ = -kInfinity;
    steps_of_round_ = 0;
    while (true) {
      asking_.clear();
      chosen_.assign(world_.size(), 0);
      random_step_.assign(world_.size(), false);
      bool any = false;
      for (std::size_t i = 0; i < world_.size(); ++i) {
        if (traces_[i].over) continue;
        if (world_.over(i)) {
          end_episode(i, all_random);
          continue;
        }
        any = true;
        const bool explores =
            all_random || (i > 0 && (world_.num_open(i) > from || random_.uniform() < share));
        random_step_[i] = explores;
        if (explores) {
          chosen_[i] = random_.below(world_.actions(i).size());
        } else {
          asking_.push_back(i);
        }
      }
      if (!any) break;
      choose_greedily();
      for (std::size_t i = 0; i < world_.size(); ++i) {
        if (traces_[i].over) continue;
        const std::span<const Action> actions = world_.actions(i);
        const ConnectionIndex connection = actions[chosen_[i]].connection;
        traces_[i].steps.push(world_.open(i), actions, chosen_[i], random_step_[i]);
        traces_[i].sequence.push_back(connection);
        world_.step(i, connection);
      }
      ++steps_of_round_;
      if (!all_random) ++training_.trained.training.steps;
      if (stopped()) return;
    }
    training_.trained.training.episodes += world_.size();
  }

  /// Sets chosen_ of the episodes asking_, with one pass of the network.
  void choose_greedily() {
    if (asking_.empty()) return;
    const std::size_t n = system_.num_connections();
    states_.resize(asking_.size() * n);
    numbers_.resize(asking_.size() * n);
    for (std::size_t k = 0; k < asking_.size(); ++k)
      world_.observe(asking_[k], std::span(states_).subspan(k * n, n));
    if (pieces_ != nullptr) {
      network_->target_values(states_, numbers_);
    } else {
      network_->values(states_, numbers_);
    }
    for (std::size_t k = 0; k < asking_.size(); ++k) {
      const std::span<const Action> actions = world_.actions(asking_[k]);
      double most = -kInfinity;
      for (std::size_t a = 0; a < actions.size(); ++a) {
        const double worth = training_.trained.training.scale *
                                 static_cast<double>(numbers_[k * n + actions[a].connection]) +
                             (options_.known_reward ? actions[a].reward : 0);
        if (a == 0 || worth > most) {
          most = worth;
          chosen_[asking_[k]] = a;
        }
      }
    }
  }

  void end_episode(std::size_t i, bool all_random) {
    Trace& trace = traces_[i];
    trace.over = true;
    const bool done = world_.done(i);
    replay_.add(trace.steps, !done);
    if (!done) return;
    if (i == 0 && !all_random) greedy_ = world_.total(i);
    if (!best_so_far(world_.total(i))) return;
    training_.trained.training.best = trace.sequence;
    best_episode_.add(trace.steps, false);
  }

  void warm_up() override {
    constexpr std::size_t kEpisodes = 64;
    const std::size_t n = system_.num_connections();
    while (training_.trained.training.episodes < kEpisodes) {
      play(true);
      if (stopped()) return;
    }
    std::vector<double> sum(n + 1, 0);
    std::vector<double> times(n + 1, 0);
    for (std::size_t place = 0; place < replay_.size(); ++place) {
      const ReplayBuffer::Step& step = replay_.step(place);
      if (step.dead_end) continue;
      sum[step.num_open] += step.rest;
      times[step.num_open] += 1;
    }
    std::vector<double> mean(n + 1, 0);
    for (std::size_t k = 1; k <= n; ++k) mean[k] = times[k] > 0 ? sum[k] / times[k] : mean[k - 1];
    double variance = 0;
    double counted = 0;
    double largest = 0;
    for (std::size_t place = 0; place < replay_.size(); ++place) {
      const ReplayBuffer::Step& step = replay_.step(place);
      largest = std::max(largest, std::abs(step.reward));
      if (step.dead_end) continue;
      const double off = step.rest - mean[step.num_open];
      variance += off * off;
      counted += 1;
    }
    double scale = counted > 0 ? std::sqrt(variance / counted) : 0;
    if (!(scale > 1e-9 * largest)) scale = largest > 0 ? largest : 1;
    training_.trained.training.baseline = options_.scale ? mean : std::vector<double>(n + 1, 0);
    training_.trained.training.scale = options_.scale ? scale : 1;
    rule_ = TargetRule(options_, training_.trained.training.scale,
                       training_.trained.training.baseline, limits_);
    if (pieces_ == nullptr) return;
    if (options_.known_reward) judge(policy());  // untrained, it is greedy
    if (!finished()) pieces_->fit(replay_, training_.trained.training.scale);
  }

  [[nodiscard]] Policy policy() const override {
    return {.layers = network_->layers(),
            .pieces = pieces_ != nullptr ? std::optional(pieces_->policy()) : std::nullopt,
            .scale = training_.trained.training.scale,
            .adds_reward = options_.known_reward};
  }

  [[nodiscard]] Result plan_of(const Policy& policy, const Budget& budget) const override {
    return follow_policy(system_, policy, system_.start(), ConnectionSet(system_.num_connections()),
                         budget);
  }
  void keep_plan(const Result& plan) override { training_.trained.training.best = plan.sequence; }
  void write_best(Result& result) const override {
    if (training_.trained.training.best.empty()) return;
    result.status = Status::Feasible;
    result.sequence = training_.trained.training.best;
    result.reward = training_.record.best;
  }

  void learn() override {
    const std::size_t n = system_.num_connections();
    const std::size_t batch = options_.batch;
    double loss = 0;
    const auto imitated =
        best_episode_.size() == 0
            ? 0
            : static_cast<std::size_t>(options_.imitation * static_cast<double>(batch));
    const auto memory = [&](std::size_t b) -> const ReplayBuffer& {
      return b < imitated ? best_episode_ : replay_;
    };
    const std::uint64_t updates = steps_of_round_ * options_.updates_per_step;
    for (std::uint64_t u = 0; u < updates; ++u) {
      places_.resize(batch);
      row_.assign(batch, 0);
      states_.clear();
      std::size_t rows = 0;
      for (std::size_t b = 0; b < batch; ++b) {
        places_[b] = memory(b).sample(random_);
        if (const auto asked = rule_.asked(memory(b), places_[b])) {
          row_[b] = rows++;
          states_.resize(rows * n);
          indicate(memory(b).open(*asked), std::span(states_).last(n));
        }
      }
      ask();
      states_.resize(batch * n);
      actions_.resize(batch);
      targets_.resize(batch);
      for (std::size_t b = 0; b < batch; ++b) {
        indicate(memory(b).open(places_[b]), std::span(states_).subspan(b * n, n));
        actions_[b] = memory(b).step(places_[b]).connection;
        const auto of_row = [&](const std::vector<float>& all) {
          return rows == 0 ? std::span<const float>()
                           : std::span<const float>(all).subspan(row_[b] * n, n);
        };
        targets_[b] =
            rule_.target(memory(b), places_[b], of_row(numbers_), of_row(target_numbers_));
      }
      loss += network_->learn(states_, actions_, targets_);
      ++training_.trained.training.updates;
      if (stopped()) {
        training_.record.loss = loss / static_cast<double>(u + 1);
        return;
      }
    }
    if (updates > 0) training_.record.loss = loss / static_cast<double>(updates);
  }

  /// Both networks' numbers in states_.
  void ask() {
    numbers_.resize(states_.size());
    target_numbers_.resize(states_.size());
    if (states_.empty()) return;
    if (options_.double_q) network_->values(states_, numbers_);
    network_->target_values(states_, target_numbers_);
  }

  Environment world_;
  ReplayBuffer replay_;
  ReplayBuffer best_episode_;
  std::vector<Trace> traces_;
  const RestLimits limits_;
  TargetRule rule_;
  /// The network where it values pieces, else null.
  PieceNetwork* pieces_ = nullptr;
  // Scratch.
  std::vector<std::size_t> asking_;
  std::vector<std::size_t> chosen_;
  std::vector<bool> random_step_;
  std::vector<std::size_t> places_;
  std::vector<std::size_t> row_;
  std::vector<float> states_;
  std::vector<float> numbers_;
  std::vector<float> target_numbers_;
  std::vector<float> targets_;
  std::vector<std::int64_t> actions_;
};

/// Whether there is a plan at all, and one to fall back upon, by a search that gives up soon.
Result first_plan(const TransitionSystem& system, const Budget& budget) {
  Budget small = budget;
  small.max_expansions = std::min<std::uint64_t>(budget.max_expansions, 100'000);
  small.progress = nullptr;
  return greedy(system, small);
}

}  // namespace

Training train(const TransitionSystem& system, const DqnOptions& options, const Budget& budget,
               const TrainingHooks& hooks, const TrainedPolicy* resume) {
  const Stopwatch watch;
  detail::check_training(options);
  Training training;
  Result first;
  if (auto settled = detail::infeasible_at_once(system, "dqn")) {
    first = *settled;
  } else {
    first = first_plan(system, budget);
  }
  first.method = "dqn";
  if (first.status == Status::Infeasible || system.ends(system.start_state())) {
    training.result = std::move(first);
  } else if (const Stop stop = budget.expired(); stop != Stop::None) {  // before 0.6 s of libtorch
    training.result = std::move(first);
    training.result.stop = stop;
  } else {
    training = system.wide() ? detail::train_on_states(system, options, budget, hooks, resume)
                             : Trainer(system, options, budget, hooks, resume).run();
    training.result.method = "dqn";
    if (!training.result.has_plan() && first.has_plan()) {
      training.result.status = first.status;
      training.result.sequence = first.sequence;
      training.result.steps = first.steps;
      training.result.reward = first.reward;
      training.result.notes.emplace_back("no episode found a plan; this one is greedy's");
    }
  }
  training.result.seed = options.seed;
  training.result.statistics.seconds = watch.seconds();
  return training;
}

bool trains_over_pieces(const TransitionSystem& system, const DqnOptions& options) {
  return !system.wide() &&
         (options.inputs == NetworkInputs::Pieces ||
          (options.inputs == NetworkInputs::Auto && system.num_connections() >= 128));
}

Result dqn(const TransitionSystem& system, const DqnOptions& options, const Budget& budget) {
  if (auto result = detail::infeasible_at_once(system, "dqn")) return *result;
  Training training = train(system, options, budget);
  if (!training.warning.empty()) training.result.notes.push_back(training.warning);
  return std::move(training.result);
}

}  // namespace orasp
