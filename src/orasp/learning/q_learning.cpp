#include "orasp/learning/q_learning.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "orasp/bounds/wide_bound.h"
#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/detail/listing_watch.h"

namespace orasp {

namespace {

/// The position of the entry with the greatest value; each of several is as likely.
template <typename Entry>
std::size_t greatest_of(std::span<Entry> entries, SplitMix64& random) {
  std::size_t chosen = 0;
  std::uint64_t equal = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (equal == 0 || entries[i].value > entries[chosen].value) {
      chosen = i;
      equal = 1;
    } else if (entries[i].value == entries[chosen].value && random.below(++equal) == 0) {
      chosen = i;
    }
  }
  return chosen;
}

class Learner {
 public:
  Learner(const TransitionSystem& system, const QLearningOptions& options, const Budget& budget,
          Bound& bound, Result& result)
      : system_(system),
        expander_(system),
        bound_(bound),
        budget_(budget),
        random_(options.seed),
        result_(result),
        table_(system.words()) {}

  void run() {
    while (true) {
      result_.stop = budget_.expired(bytes(), result_.statistics.expanded);
      if (result_.stop != Stop::None) break;
      if (!episode()) break;
      ++result_.statistics.sweeps;
      if (result_.statistics.sweeps % 256 == 0) {
        budget_.report({.phase = "episodes",
                        .done = result_.statistics.sweeps,
                        .states = table_.size(),
                        .best = result_.reward});
      }
      if (detail::meets(result_.reward, start_value())) break;
    }
    result_.statistics.states = table_.size();
    result_.statistics.actions = entries_.size();
    result_.statistics.peak_bytes = bytes();
    if (table_.size() == 0) return;
    const double most = start_value();
    const auto bound = std::isfinite(most) ? std::optional(most) : std::nullopt;
    if (!result_.sequence.empty()) {
      detail::judge_by(bound, result_);
    } else if (most == -kInfinity && result_.stop == Stop::None) {
      result_.status = Status::Infeasible;
    } else {
      result_.bound = bound;
    }
  }

 private:
  struct Entry {
    double reward;
    /// Q, which is never below the truth.
    double value;
    ConnectionIndex connection;
  };
  struct Taken {
    std::uint32_t state;
    std::size_t entry;
  };

  [[nodiscard]] std::uint64_t bytes() const {
    return table_.bytes() + first_.bytes() + entries_.bytes();
  }
  [[nodiscard]] std::span<Entry> entries_of(std::uint32_t state) {
    const std::size_t end =
        state + std::size_t{1} < first_.size() ? first_[state + 1] : entries_.size();
    return entries_.span().subspan(first_[state], end - first_[state]);
  }
  [[nodiscard]] double value(std::uint32_t state) {
    double best = -kInfinity;
    for (const Entry& entry : entries_of(state)) best = std::max(best, entry.value);
    return best;
  }
  [[nodiscard]] double start_value() { return value(0); }

  /// The number of a state, whose actions are worked out when it is met first.
  std::uint32_t meet(const ConnectionSet& state, std::size_t open) {
    const auto [number, is_new] = table_.insert(state.view().data());
    if (!is_new) return number;
    ++result_.statistics.expanded;
    first_.push_back(entries_.size());
    const auto legal = expander_.legal_actions(state.view());
    rests_.assign(legal.size(), open == 1 ? 0 : kInfinity);
    if (open > 1 && bound_.known())
      bound_.of_successors(state.view(), bound_(state.view()), legal, rests_);
    for (std::size_t i = 0; i < legal.size(); ++i)
      entries_.push_back({legal[i].reward, legal[i].reward + rests_[i], legal[i].connection});
    return number;
  }

  /// One episode, and what it teaches. False where the budget ended it, or nothing promises a plan.
  bool episode() {
    ConnectionSet state = system_.start();
    path_.clear();
    double reward = 0;
    bool ended = false;
    for (std::size_t open = system_.num_steps(); open > 0; --open) {
      const std::uint64_t before = result_.statistics.expanded;
      const std::uint32_t number = meet(state, open);
      if (value(number) == -kInfinity) {
        if (path_.empty()) return false;
        ended = true;
        break;
      }
      const std::size_t chosen = greatest_of(entries_of(number), random_);
      const Entry& entry = entries_of(number)[chosen];
      path_.push_back({number, chosen});
      ++result_.statistics.generated;
      reward += entry.reward;
      state.erase(entry.connection);
      const std::uint64_t now = result_.statistics.expanded;
      if (now != before && (now % kLook == 0 || budget_.max_expansions < kLook)) {
        result_.stop = budget_.expired(bytes(), now);
        if (result_.stop != Stop::None && open > 1) return false;
      }
    }
    double rest = ended ? -kInfinity : 0;
    for (std::size_t t = path_.size(); t-- > 0;) {
      Entry& entry = entries_of(path_[t].state)[path_[t].entry];
      entry.value = std::min(entry.value, entry.reward + rest);
      rest = value(path_[t].state);
    }
    if (!ended && (result_.sequence.empty() || reward > result_.reward)) {
      result_.reward = reward;
      result_.sequence.clear();
      for (const Taken& step : path_)
        result_.sequence.push_back(entries_of(step.state)[step.entry].connection);
    }
    return result_.stop == Stop::None;
  }

  /// How many states are expanded from one look at the budget to the next.
  static constexpr std::uint64_t kLook = 256;

  const TransitionSystem& system_;
  Expander expander_;
  Bound& bound_;
  const Budget& budget_;
  SplitMix64 random_;
  Result& result_;
  detail::StateTable<0> table_;
  /// For each state, its first entry.
  detail::GrowingArray<std::size_t> first_;
  detail::GrowingArray<Entry> entries_;
  std::vector<double> rests_;
  std::vector<Taken> path_;
};

/// The same where states and steps are wide: an entry knows the state that it leads to, and an
/// episode ends where a plan does.
class WideLearner {
 public:
  WideLearner(const TransitionSystem& system, const QLearningOptions& options, const Budget& budget,
              Result& result)
      : system_(system),
        expander_(system),
        bound_(system),
        budget_(budget),
        random_(options.seed),
        result_(result),
        words_(system.words()),
        table_(words_) {}

  void run() {
    number_of(system_.start_state());
    const detail::ListingWatch listing(system_, budget_);
    while (result_.stop == Stop::None) {
      result_.stop = budget_.expired(bytes(), result_.statistics.expanded);
      if (result_.stop != Stop::None) break;
      try {
        if (!episode()) break;
      } catch (const detail::ListingStopped& stopped) {
        result_.stop = listing.reason(stopped);
        break;
      }
      ++result_.statistics.sweeps;
      if (result_.statistics.sweeps % 256 == 0) {
        budget_.report({.phase = "episodes",
                        .done = result_.statistics.sweeps,
                        .states = table_.size(),
                        .best = result_.reward});
      }
      if (detail::meets(result_.reward, value(0))) break;
    }
    result_.statistics.states = table_.size();
    result_.statistics.actions = entries_.size();
    result_.statistics.peak_bytes = bytes();
    const bool begun = rows_[0].first != kNotExpanded;
    const double most = begun ? value(0) : bound_(system_.start_state());
    if (result_.has_plan()) {
      detail::judge_by(std::isfinite(most) ? std::optional(most) : std::nullopt, result_);
    } else if (most == -kInfinity && result_.stop == Stop::None) {
      result_.status = Status::Infeasible;
    } else if (std::isfinite(most)) {
      result_.bound = most;
    }
  }

 private:
  static constexpr std::size_t kNotExpanded = std::numeric_limits<std::size_t>::max();
  struct Entry {
    double reward;
    double value;  ///< Q, never below the truth
  };
  struct Row {
    std::size_t first = kNotExpanded;
    std::size_t size = 0;
  };

  [[nodiscard]] std::uint64_t bytes() const {
    return table_.bytes() + rows_.bytes() + entries_.bytes() + successors_.bytes();
  }
  std::uint32_t number_of(SetView state) {
    const auto [number, is_new] = table_.insert(state.data());
    if (is_new) rows_.push_back({});
    return number;
  }
  [[nodiscard]] SetView key(std::uint32_t state) const { return {table_.key(state), words_}; }
  /// The entries of a state, whose actions are worked out when it is met first.
  [[nodiscard]] std::span<Entry> entries_of(std::uint32_t state) {
    if (rows_[state].first == kNotExpanded) expand(state);
    return entries_.span().subspan(rows_[state].first, rows_[state].size);
  }
  void expand(std::uint32_t state) {
    ++result_.statistics.expanded;
    const std::vector<std::uint64_t> here(key(state).begin(), key(state).end());
    std::vector<std::uint64_t> next(words_);
    const auto legal = expander_.legal_actions(here);
    rows_[state] = {entries_.size(), legal.size()};
    for (const Action& action : legal) {
      expander_.successor(here, action, next);
      const double rest = system_.ends(next) ? 0 : bound_(next);
      entries_.push_back({action.reward, action.reward + rest});
      for (const std::uint64_t word : next) successors_.push_back(word);
    }
  }
  [[nodiscard]] double value(std::uint32_t state) {
    if (system_.ends(key(state))) return 0;
    double best = -kInfinity;
    for (const Entry& entry : entries_of(state)) best = std::max(best, entry.value);
    return best;
  }

  /// One episode, and what it teaches. False where nothing promises a plan.
  bool episode() {
    std::uint32_t state = 0;
    std::vector<std::pair<std::uint32_t, std::size_t>> path;
    std::vector<std::uint64_t> states(key(0).begin(), key(0).end());
    double reward = 0;
    while (!system_.ends(key(state)) && value(state) > -kInfinity) {
      const std::size_t chosen = greatest_of(entries_of(state), random_);
      path.emplace_back(state, chosen);
      ++result_.statistics.generated;
      reward += entries_of(state)[chosen].reward;
      const std::size_t entry = rows_[state].first + chosen;
      const std::vector<std::uint64_t> next(successors_.data() + entry * words_,
                                            successors_.data() + (entry + 1) * words_);
      states.insert(states.end(), next.begin(), next.end());
      state = number_of(next);
    }
    const bool arrived = system_.ends(key(state));
    if (path.empty() && !arrived) return false;
    double rest = value(state);
    for (std::size_t t = path.size(); t-- > 0;) {
      Entry& entry = entries_of(path[t].first)[path[t].second];
      entry.value = std::min(entry.value, entry.reward + rest);
      rest = value(path[t].first);
    }
    if (arrived && (!result_.has_plan() || reward > result_.reward)) {
      detail::take_walk(expander_.steps_along(states), result_);
      result_.status = Status::Feasible;
    }
    return true;
  }

  const TransitionSystem& system_;
  Expander expander_;
  WideBound bound_;
  const Budget& budget_;
  SplitMix64 random_;
  Result& result_;
  std::size_t words_;
  detail::StateTable<0> table_;
  detail::GrowingArray<Row> rows_;
  detail::GrowingArray<Entry> entries_;
  detail::GrowingArray<std::uint64_t> successors_;  ///< by entry, the words of the state after it
};

}  // namespace

Result q_learning(const TransitionSystem& system, const QLearningOptions& options,
                  const Budget& budget) {
  const Stopwatch watch;
  if (auto result = detail::infeasible_at_once(system, "q-learning")) return *result;
  Result result;
  result.method = "q-learning";
  if (system.num_steps() == 0) {
    result.status = Status::Optimal;
    result.reward = 0;
    result.bound = 0;
  } else {
    if (system.wide()) {
      WideLearner(system, options, budget, result).run();
    } else {
      const std::unique_ptr<Bound> bound = make_bound(system, options.bound);
      Learner(system, options, budget, *bound, result).run();
    }
    if (result.stop != Stop::None && !result.has_plan()) {
      const std::optional<double> most = result.bound;
      result =
          detail::stopped_with_quick_plan(system, "q-learning", result.stop, result.statistics);
      result.bound = most;
    } else if (result.status == Status::Infeasible) {
      result = detail::exhausted("q-learning", result.statistics);
    }
  }
  result.seed = options.seed;
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
