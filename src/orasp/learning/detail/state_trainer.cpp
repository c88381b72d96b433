#include "orasp/learning/detail/state_trainer.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "orasp/containers/episode_ring.h"
#include "orasp/learning/detail/observed_columns.h"
#include "orasp/learning/detail/training_loop.h"
#include "orasp/learning/detail/transition_cache.h"
#include "orasp/learning/environment.h"
#include "orasp/model/error.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/detail/listing_watch.h"

namespace orasp::detail {

namespace {

/// Rows of one pass of the network in learning.
constexpr std::size_t kMostRows = 4096;

/// One step of an episode that is over.
struct Remembered {
  std::uint32_t state = 0;
  std::uint32_t left = 0;  ///< steps of the episode after it
  bool random = false;     ///< whether it was taken at random
  double reward = 0;
  double rest = 0;  ///< what the episode earned from this step on; -infinity where it got stuck
};

using Memory = EpisodeRing<Remembered>;

class StateTrainer final : public TrainingLoop {
 public:
  StateTrainer(const TransitionSystem& system, const DqnOptions& options, const Budget& budget,
               const TrainingHooks& hooks, const TrainedPolicy* resume)
      : TrainingLoop(system, with_defaults(options, system, budget), budget, hooks),
        listing_(system, budget),
        columns_(system),
        cache_(new_cache()),
        memory_(options_.replay),
        best_episode_(system.num_steps() + 1),
        traces_(options_.environments + 1) {
    if (resume != nullptr) go_on(*resume);
  }

 private:
  /// An episode while it is played.
  struct Trace {
    std::vector<Remembered> steps;
    std::uint32_t state = 0;
    double total = 0;
    bool over = false;
  };

  static DqnOptions with_defaults(DqnOptions options, const TransitionSystem& system,
                                  const Budget& budget) {
    check_training(options);
    if (options.inputs == NetworkInputs::Pieces) {
      throw InputError(
          "inputs 'pieces' are for plans whose steps take one connection each and earn what they "
          "earn whatever came before; here a goal, part steps or costs between steps say "
          "otherwise");
    }
    if (!options.known_reward) {
      throw InputError(
          "known rewards cannot be left out here: with a goal, part steps or costs between steps "
          "the network values the states that steps lead to, not the steps");
    }
    options.inputs = NetworkInputs::Connections;
    const std::size_t columns = ObservedColumns(system).size();
    if (options.episodes == 0) options.episodes = 5'000;
    if (options.environments == 0) options.environments = 7;
    if (options.curriculum < 0) options.curriculum = 0.5;
    if (options.hidden.empty()) options.hidden.assign(2, 128);
    if (options.batch == 0) options.batch = 64;
    require_network_fits(options, columns, 1, budget);
    const std::uint64_t room = budget.max_bytes / 8 / sizeof(Remembered);
    options.replay = static_cast<std::size_t>(std::clamp<std::uint64_t>(room, 1, options.replay));
    return options;
  }

  void go_on(const TrainedPolicy& earlier) {
    const TrainingState& state = earlier.training;
    if (!earlier.policy.of_states || earlier.policy.num_inputs() != columns_.size() ||
        state.hidden != options_.hidden)
      throw InputError("the training to go on with has a network of another shape");
    training_.trained.training = state;
    random_ = SplitMix64(state.random);
    judge(earlier.policy);
  }

  [[nodiscard]] std::unique_ptr<TransitionCache> new_cache() const {
    return std::make_unique<TransitionCache>(system_, TransitionCache::Steps::Places);
  }
  [[nodiscard]] std::unique_ptr<Network> new_network() override {
    return make_network({.connections = columns_.size(),
                         .outputs = 1,
                         .hidden = options_.hidden,
                         .learning_rate = options_.learning_rate,
                         .target_rate = options_.target_rate,
                         .gradient_clip = options_.gradient_clip,
                         .zero_outputs = true,
                         .seed = options_.seed,
                         .device = options_.device});
  }
  [[nodiscard]] bool warmed_up() const override { return training_.trained.training.steps > 0; }
  [[nodiscard]] std::size_t remembered() const override { return memory_.size(); }
  [[nodiscard]] std::uint64_t bytes() const override {
    return cache_->bytes() + memory_.size() * sizeof(Remembered);
  }
  [[nodiscard]] std::uint64_t expanded() const override { return cache_->expanded(); }
  [[nodiscard]] double scale() const { return training_.trained.training.scale; }

  [[nodiscard]] std::span<const TransitionCache::Transition> steps_of(std::uint32_t state) const {
    return cache_->transitions(cache_->expansion(state));
  }

  void warm_up() override {
    constexpr std::size_t kEpisodes = 64;
    double squares = 0;
    double counted = 0;
    while (training_.trained.training.episodes < kEpisodes) {
      play(true);
      if (stopped()) return;
    }
    for (std::size_t place = 0; place < memory_.size(); ++place) {
      if (memory_[place].rest == -kInfinity) continue;
      squares += memory_[place].rest * memory_[place].rest;
      counted += 1;
    }
    const double size = counted > 0 ? std::sqrt(squares / counted) : 0;
    training_.trained.training.scale = options_.scale && size > 0 ? size : 1;
    training_.trained.training.steps = 1;
    judge(policy());  // untrained, it is greedy
  }

  void play(bool all_random) override {
    forget_where_too_much();
    for (Trace& trace : traces_) {
      trace = {};
      trace.state = cache_->number(system_.start_state());
    }
    greedy_ = -kInfinity;
    steps_of_round_ = 0;
    const double share = all_random ? 1 : epsilon();
    while (true) {
      for (const Trace& trace : traces_) {
        if (!trace.over) cache_->want(trace.state);
      }
      if (!expand()) return;
      bool any = false;
      for (std::size_t i = 0; i < traces_.size(); ++i) {
        if (traces_[i].over) continue;
        if (steps_of(traces_[i].state).empty()) {
          end_episode(i, all_random);
        } else {
          take_step(i, all_random, share);
          any = true;
        }
      }
      if (!any) break;
      ++steps_of_round_;
      if (!all_random) ++training_.trained.training.steps;
      if (stopped()) return;
    }
    training_.trained.training.episodes += traces_.size();
  }

  /// False where the budget was spent before all steps were listed.
  [[nodiscard]] bool expand() {
    try {
      cache_->expand();
      return true;
    } catch (const ListingStopped&) {
      static_cast<void>(stopped());
      return false;
    }
  }

  void take_step(std::size_t i, bool all_random, double share) {
    Trace& trace = traces_[i];
    const std::size_t open = count(system_.open(cache_->state(trace.state)));
    const auto steps = steps_of(trace.state);
    const bool explores = all_random || (i > 0 && (open > begin_at() || random_.uniform() < share));
    const std::size_t taken = explores ? random_.below(steps.size()) : best_step(trace.state);
    trace.steps.push_back(
        {.state = trace.state, .random = explores, .reward = steps[taken].reward});
    trace.total += steps[taken].reward;
    trace.state = steps[taken].next;
  }

  /// The step that the network values most; of several the first.
  [[nodiscard]] std::size_t best_step(std::uint32_t state) {
    observe_ahead(state);
    ask(online_, false);
    const std::vector<double> worth = worths(state, online_);
    return static_cast<std::size_t>(std::ranges::max_element(worth) - worth.begin());
  }

  // What steps lead to, in units of the network: rows_ are the states to be asked about, one for
  // each step of a state that does not end the plan.

  void observe_ahead(std::uint32_t state) {
    rows_.clear();
    add_rows(state);
  }
  void add_rows(std::uint32_t state) {
    for (const TransitionCache::Transition& step : steps_of(state)) {
      if (!system_.ends(cache_->state(step.next))) add_row(step.next, rows_);
    }
  }
  void add_row(std::uint32_t state, std::vector<float>& rows) {
    columns_.collect(cache_->state(state), bits_);
    rows.resize(rows.size() + columns_.size());
    indicate(bits_, std::span(rows).last(columns_.size()));
  }
  void ask(std::vector<float>& numbers, bool of_target) {
    numbers.resize(rows_.size() / columns_.size());
    if (numbers.empty()) return;
    of_target ? network_->target_values(rows_, numbers) : network_->values(rows_, numbers);
  }
  /// What each step is worth by the numbers of its row, from `row` on.
  [[nodiscard]] std::vector<double> worths(std::uint32_t state, std::span<const float> numbers,
                                           std::size_t row = 0) const {
    std::vector<double> worth;
    for (const TransitionCache::Transition& step : steps_of(state)) {
      const bool ends = system_.ends(cache_->state(step.next));
      const double rest = ends ? 0 : scale() * static_cast<double>(numbers[row++]);
      worth.push_back(step.reward + options_.discount * rest);
    }
    return worth;
  }

  void end_episode(std::size_t i, bool all_random) {
    Trace& trace = traces_[i];
    trace.over = true;
    const bool done = system_.ends(cache_->state(trace.state));
    double rest = done ? 0 : -kInfinity;
    if (!done) trace.steps.push_back({.state = trace.state});  // so that its value is learned too
    for (std::size_t t = trace.steps.size(); t-- > 0;) {
      Remembered& step = trace.steps[t];
      step.left = static_cast<std::uint32_t>(trace.steps.size() - 1 - t);
      step.rest = rest += step.reward;
    }
    memory_.add(trace.steps);
    if (!done) return;
    if (i == 0 && !all_random) greedy_ = trace.total;
    if (!best_so_far(trace.total)) return;
    best_episode_.clear();
    best_episode_.add(trace.steps);
    best_states_.clear();
    for (const Remembered& step : trace.steps) remember_best(cache_->state(step.state));
    remember_best(cache_->state(trace.state));
    best_plan_ = {};
  }
  void remember_best(SetView state) {
    best_states_.insert(best_states_.end(), state.begin(), state.end());
  }

  /// Begins anew with an empty cache where the states take too much.
  void forget_where_too_much() {
    constexpr std::uint64_t kMost = std::uint64_t{256} << 20U;
    if (cache_->bytes() <= std::min(kMost, budget_.max_bytes / 2)) return;
    auto fresh = new_cache();
    fresh->count_as_well(cache_->expanded());
    cache_ = std::move(fresh);
    memory_.clear();
    best_episode_.clear();
  }

  void learn() override {
    const std::uint64_t updates = steps_of_round_ * options_.updates_per_step;
    double loss = 0;
    std::uint64_t done = 0;
    while (done < updates && memory_.size() != 0) {
      loss += learn_once();
      ++done;
      ++training_.trained.training.updates;
      if (stopped()) break;
    }
    if (done > 0) training_.record.loss = loss / static_cast<double>(done);
  }

  /// A state to learn from, and where its target asks the network.
  struct Sample {
    const Memory* memory;
    std::size_t place;
    std::size_t ahead;  ///< steps of its episode before the network is asked
    std::size_t row;    ///< of the state asked about
    bool asks;
  };

  double learn_once() {
    const auto imitated =
        best_episode_.size() == 0
            ? std::size_t{0}
            : static_cast<std::size_t>(options_.imitation * static_cast<double>(options_.batch));
    samples_.clear();
    rows_.clear();
    while (samples_.size() < options_.batch && rows_.size() < kMostRows * columns_.size()) {
      const Memory& memory = samples_.size() < imitated ? best_episode_ : memory_;
      Sample sample{&memory, random_.below(memory.size()), 0, rows_.size() / columns_.size(), true};
      const std::size_t left = memory[sample.place].left + std::size_t{1};
      const std::size_t most = options_.n_step == 0 ? left : std::min(options_.n_step - 1, left);
      while (sample.ahead < most && !memory[memory.later(sample.place, sample.ahead)].random)
        ++sample.ahead;
      sample.asks = sample.ahead < left;
      if (sample.asks) add_rows(memory[memory.later(sample.place, sample.ahead)].state);
      samples_.push_back(sample);
    }
    if (options_.double_q) ask(online_, false);
    ask(target_, true);
    targets_.clear();
    std::vector<float>& states = rows_;
    states.clear();
    for (const Sample& sample : samples_) {
      targets_.push_back(target_of(sample));
      add_row((*sample.memory)[sample.place].state, states);
    }
    actions_.assign(samples_.size(), 0);
    return network_->learn(states, actions_, targets_);
  }

  /// The value of a state in which nothing is legal: worse than anything seen.
  [[nodiscard]] double stuck() const {
    constexpr double kScales = 10;
    return -kScales * scale();
  }

  [[nodiscard]] float target_of(const Sample& sample) const {
    const Memory& memory = *sample.memory;
    double value = 0;
    double weight = 1;
    for (std::size_t i = 0; i < sample.ahead; ++i) {
      value += weight * memory[memory.later(sample.place, i)].reward;
      weight *= options_.discount;
    }
    const double rest = memory[sample.place].rest;
    if (sample.asks) {
      const std::uint32_t state = memory[memory.later(sample.place, sample.ahead)].state;
      const std::vector<double> by_target = worths(state, target_, sample.row);
      const std::vector<double> picks =
          options_.double_q ? worths(state, online_, sample.row) : by_target;
      const auto best = std::ranges::max_element(picks) - picks.begin();
      value += weight * (picks.empty() ? stuck() : by_target[static_cast<std::size_t>(best)]);
    } else if (rest == -kInfinity) {
      value += weight * stuck();
    }
    if (options_.returns && options_.discount == 1) value = std::max(value, rest);
    return static_cast<float>(value / scale());
  }

  [[nodiscard]] Policy policy() const override {
    return {.layers = network_->layers(),
            .pieces = std::nullopt,
            .scale = scale(),
            .adds_reward = true,
            .of_states = true};
  }
  [[nodiscard]] Result plan_of(const Policy& policy, const Budget& budget) const override {
    return follow_states(system_, policy, budget);
  }
  void keep_plan(const Result& plan) override { best_plan_ = plan; }
  void write_best(Result& result) const override {
    if (best_plan_.has_plan()) {
      result.status = Status::Feasible;
      result.sequence = best_plan_.sequence;
      result.steps = best_plan_.steps;
      result.reward = best_plan_.reward;
    } else if (!best_states_.empty()) {
      // Their steps were listed before and are listed to the end, although time may be over by now.
      // Where several lead from one state to the next, the walk takes the best: it may earn more.
      const ListingScope as_before(system_, {});
      take_walk(Expander(system_).steps_along(best_states_), result);
      result.status = Status::Feasible;
    }
  }

  const ListingWatch listing_;
  const ObservedColumns columns_;
  std::unique_ptr<TransitionCache> cache_;
  Memory memory_;
  Memory best_episode_;
  std::vector<Trace> traces_;
  /// The best plan: what a policy made of it, or else the states of an episode.
  Result best_plan_;
  std::vector<std::uint64_t> best_states_;
  // Scratch.
  std::vector<std::uint64_t> bits_;
  std::vector<float> rows_;
  std::vector<float> online_;
  std::vector<float> target_;
  std::vector<float> targets_;
  std::vector<std::int64_t> actions_;
  std::vector<Sample> samples_;
};

}  // namespace

Training train_on_states(const TransitionSystem& system, const DqnOptions& options,
                         const Budget& budget, const TrainingHooks& hooks,
                         const TrainedPolicy* resume) {
  return StateTrainer(system, options, budget, hooks, resume).run();
}

}  // namespace orasp::detail
