#include "orasp/learning/dqn.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <tuple>
#include <utility>

#include "orasp/learning/environment.h"
#include "orasp/learning/network.h"
#include "orasp/learning/piece_network.h"
#include "orasp/learning/replay_buffer.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/task.h"

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

void check(const DqnOptions& options) {
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

/// Refuses at once what is sure to need more memory than there is.
void require_network_fits(const DqnOptions& options, std::size_t connections,
                          const Budget& budget) {
  double parameters = 0;
  double inputs = static_cast<double>(connections);
  for (const std::size_t units : options.hidden) {
    parameters += (inputs + 1) * static_cast<double>(units);
    inputs = static_cast<double>(units);
  }
  parameters += (inputs + 1) * static_cast<double>(connections);
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

class Trainer {
 public:
  Trainer(const TransitionSystem& system, const DqnOptions& options, const Budget& budget,
          const TrainingHooks& hooks, const TrainedPolicy* resume)
      : system_(system),
        options_(with_defaults(options, system, budget)),
        budget_(budget),
        hooks_(hooks),
        random_(options.seed),
        world_(system, options_.environments + 1),
        replay_(options_.replay, system.num_connections()),
        best_episode_(system.num_connections(), system.num_connections()),
        traces_(options_.environments + 1, Trace(system.num_connections())),
        limits_(rest_limits(system)),
        rule_(options_, 1, {}, limits_) {
    training_.record.bound = detail::bound_of_start(system);
    if (resume != nullptr) go_on(*resume);
  }

  [[nodiscard]] Training run() {
    const Stopwatch watch;
    watch_ = &watch;
    const NetworkOptions shape = {.connections = system_.num_connections(),
                                  .hidden = options_.hidden,
                                  .learning_rate = options_.learning_rate,
                                  .target_rate = options_.target_rate,
                                  .gradient_clip = options_.gradient_clip,
                                  .zero_outputs = options_.known_reward,
                                  .seed = options_.seed,
                                  .device = options_.device};
    if (options_.inputs == NetworkInputs::Pieces) {
      auto pieces = std::make_unique<PieceNetwork>(system_, shape, options_.known_reward);
      pieces_ = pieces.get();
      network_ = std::move(pieces);
    } else {
      network_ = make_network(shape);
    }
    training_.device = network_->device();
    training_.warning = network_->warning();
    TrainingState& state = training_.trained.training;
    if (!state.network.empty()) network_->restore(state.network);
    double saved = 0;
    while (!finished()) {
      if (state.baseline.empty()) {
        warm_up();
        if (stopped()) break;
        continue;
      }
      play(false);
      if (stopped()) break;
      judge();
      if (finished()) break;
      learn();
      tell();
      if (hooks_.save && watch.seconds() - saved >= hooks_.save_every) {
        pack();
        hooks_.save(training_);
        saved = watch.seconds();
      }
    }
    if (!state.baseline.empty()) judge_at_the_end();
    tell();
    pack();
    finish();
    return std::move(training_);
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
    check(options);
    const std::size_t connections = system.num_connections();
    if (options.inputs == NetworkInputs::Auto) {
      options.inputs = connections < 128 ? NetworkInputs::Connections : NetworkInputs::Pieces;
    }
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
    require_network_fits(options, connections, budget);
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
    if (!state.best.empty()) keep(state.best, replayed(state.best));
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

  [[nodiscard]] std::uint64_t bytes() const {
    return replay_.size() * ReplayBuffer::bytes_per_step(system_.num_connections());
  }
  [[nodiscard]] bool stopped() {
    if (stop_ == Stop::None) stop_ = budget_.expired(bytes(), world_.expanded());
    return stop_ != Stop::None;
  }
  [[nodiscard]] bool proved(double reward) const {
    return training_.record.bound && detail::meets(reward, *training_.record.bound);
  }
  [[nodiscard]] bool finished() {
    return stopped() || training_.trained.training.episodes >= options_.episodes ||
           (options_.stop_when_proved && proved(training_.trained.reward));
  }
  [[nodiscard]] double epsilon() const {
    return options_.epsilon_end +
           (options_.epsilon_start - options_.epsilon_end) *
               std::exp(-static_cast<double>(training_.trained.training.steps) /
                        options_.epsilon_decay);
  }
  /// At how many open connections an episode begins to act by the network.
  [[nodiscard]] std::size_t begin_at() const {
    const std::size_t n = system_.num_connections();
    if (options_.curriculum <= 0) return n;
    const double done = static_cast<double>(training_.trained.training.episodes) /
                        (options_.curriculum * static_cast<double>(options_.episodes));
    return done >= 1 ? n : 1 + static_cast<std::size_t>(done * static_cast<double>(n));
  }

  /// One round of episodes, from start to end, all remembered. The first acts greedily unless all
  /// are random.
  void play(bool all_random) {
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
    if (keep(trace.sequence, world_.total(i))) best_episode_.add(trace.steps, false);
  }

  /// @returns whether it is the best so far.
  bool keep(const std::vector<ConnectionIndex>& sequence, double reward) {
    if (!(reward > training_.record.best)) return false;
    training_.record.best = reward;
    training_.trained.training.best = sequence;
    return true;
  }

  /// Random episodes: what the scale of the rewards is, and the first memories.
  void warm_up() {
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

  [[nodiscard]] Policy policy() const {
    return {.layers = network_->layers(),
            .pieces = pieces_ != nullptr ? std::optional(pieces_->policy()) : std::nullopt,
            .scale = training_.trained.training.scale,
            .adds_reward = options_.known_reward};
  }

  /// The greedy episode of the round: the network is kept if it is the best so far.
  void judge() {
    training_.record.greedy = greedy_;
    if (greedy_ == -kInfinity || greedy_ > training_.trained.reward) judge(policy());
  }
  /// What the network earns when training is over, though its time may be: a single plan.
  void judge_at_the_end() {
    training_.record.greedy = -kInfinity;
    Budget budget;
    budget.max_bytes = budget_.max_bytes;
    budget.max_expansions = system_.num_connections() + 100;
    judge(policy(), budget);
  }
  /// As the policy acts without libtorch, whose last digits differ.
  void judge(Policy now) {
    Budget budget = budget_;
    budget.max_expansions = 20 * system_.num_connections() + 100;
    budget.progress = nullptr;
    judge(std::move(now), budget);
  }
  void judge(Policy now, const Budget& budget) {
    const Result result = follow_policy(system_, now, system_.start(),
                                        ConnectionSet(system_.num_connections()), budget);
    TrainedPolicy& kept = training_.trained;
    if (result.has_plan()) {
      training_.record.greedy = result.reward;
      keep(result.sequence, result.reward);
    }
    if (kept.policy.empty() || (result.has_plan() && result.reward > kept.reward)) {
      kept.policy = std::move(now);
      if (result.has_plan()) kept.reward = training_.record.best_greedy = result.reward;
    }
  }

  void learn() {
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

  void tell() {
    TrainingRecord& record = training_.record;
    record.episodes = training_.trained.training.episodes;
    record.updates = training_.trained.training.updates;
    record.epsilon = epsilon();
    record.seconds = training_.trained.training.seconds + watch_->seconds();
    const std::tuple now(record.episodes, record.updates, record.greedy);
    if (told_ && *told_ == now) return;
    told_ = now;
    if (hooks_.log) hooks_.log(record);
    budget_.report({.phase = "episodes",
                    .done = record.episodes,
                    .total = options_.episodes,
                    .states = replay_.size(),
                    .best = record.best});
  }

  /// Brings the training state up to date.
  void pack() {
    TrainingState& state = training_.trained.training;
    state.hidden = options_.hidden;
    state.known_reward = options_.known_reward;
    state.random = random_.state();
    if (!state.baseline.empty()) state.network = network_->state();
  }

  void finish() {
    training_.trained.training.seconds += watch_->seconds();
    Result& result = training_.result;
    result.statistics.states = replay_.size();
    result.statistics.expanded = world_.expanded();
    result.statistics.sweeps = training_.trained.training.episodes;
    result.statistics.peak_bytes = bytes();
    result.stop = stop_;
    if (training_.trained.training.best.empty()) return;
    result.sequence = training_.trained.training.best;
    result.reward = training_.record.best;
    detail::judge_by(training_.record.bound, result);
  }

  const TransitionSystem& system_;
  const DqnOptions options_;
  const Budget& budget_;
  const TrainingHooks& hooks_;
  SplitMix64 random_;
  Environment world_;
  ReplayBuffer replay_;
  ReplayBuffer best_episode_;
  std::vector<Trace> traces_;
  const RestLimits limits_;
  TargetRule rule_;
  std::unique_ptr<Network> network_;
  /// The same where it values pieces, else null.
  PieceNetwork* pieces_ = nullptr;
  Training training_;
  const Stopwatch* watch_ = nullptr;
  Stop stop_ = Stop::None;
  /// The episodes, the updates and what the network earned of the last record.
  std::optional<std::tuple<std::uint64_t, std::uint64_t, double>> told_;
  /// What the first episode of the round earned, which acts greedily.
  double greedy_ = -kInfinity;
  std::uint64_t steps_of_round_ = 0;
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
  check(options);
  Training training;
  Result first;
  if (auto settled = detail::infeasible_at_once(system, "dqn")) {
    first = *settled;
  } else {
    first = first_plan(system, budget);
  }
  first.method = "dqn";
  if (first.status == Status::Infeasible || system.num_connections() == 0) {
    training.result = std::move(first);
  } else if (const Stop stop = budget.expired(); stop != Stop::None) {  // before 0.6 s of libtorch
    training.result = std::move(first);
    training.result.stop = stop;
  } else {
    training = Trainer(system, options, budget, hooks, resume).run();
    training.result.method = "dqn";
    if (!training.result.has_plan() && first.has_plan()) {
      training.result.status = first.status;
      training.result.sequence = first.sequence;
      training.result.reward = first.reward;
      training.result.notes.emplace_back("no episode found a plan; this one is greedy's");
    }
  }
  training.result.seed = options.seed;
  training.result.statistics.seconds = watch.seconds();
  return training;
}

Result dqn(const TransitionSystem& system, const DqnOptions& options, const Budget& budget) {
  if (auto result = detail::infeasible_at_once(system, "dqn")) return *result;
  if (system.wide()) throw Refusal("dqn", std::string(kPlainSteps));
  Training training = train(system, options, budget);
  if (!training.warning.empty()) training.result.notes.push_back(training.warning);
  return std::move(training.result);
}

}  // namespace orasp
