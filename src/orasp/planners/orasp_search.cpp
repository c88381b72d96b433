#include "orasp/planners/orasp_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/order_search.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/planner_support.h"
#include "orasp/planners/random_sequence.h"
#include "orasp/symmetry/symmetry.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// The search of orasp_search(). kWords is that of its StateTable.
template <std::size_t kWords>
class OraspSearch {
 public:
  OraspSearch(const TransitionSystem& system, Bound& bound, const Symmetry* symmetry,
              const Budget& budget, Result& result)
      : expander_(system),
        bound_(bound),
        budget_(budget),
        allowed_(allowed_bytes(budget)),
        result_(result),
        state_(system.start()),
        num_open_(system.num_steps()),
        met_(system.words()) {
    if (symmetry != nullptr) form_ = symmetry->form();
  }

  /// Searches to the end, or until so many states were expanded; then it can go on.
  /// @returns whether it came to its end or was stopped.
  bool run(std::uint64_t pause) {
    if (met_.size() == 0) {
      rest_ = bound_(state_.view());
      met(0);
      enter();
    }
    while (!frames_.empty() && result_.stop == Stop::None) {
      if (result_.statistics.expanded >= pause) return false;
      if (actions_.size() == frames_.back()) {
        leave();
        continue;
      }
      const Untried action = actions_.back();
      actions_.pop_back();
      follow(action);
    }
    // Where the search was stopped, the actions that were not followed may still earn more.
    double open = result_.reward;
    while (!frames_.empty()) {
      while (actions_.size() > frames_.back()) {
        open = std::max(open, running_ + actions_.back().reward + actions_.back().rest);
        actions_.pop_back();
      }
      leave();
    }
    result_.bound = open;
    result_.statistics.states = met_.size();
    result_.statistics.peak_bytes = std::max(result_.statistics.peak_bytes, bytes());
    return true;
  }

 private:
  /// A legal action not yet followed, and the bound of the state after it.
  struct Untried {
    ConnectionIndex connection;
    double reward;
    double rest;
  };

  /// Notes that the present state is reached with `running_`; false if it was met before with no
  /// less, or one into which an exchange of equal parts takes it.
  bool met(double running) {
    SetView state = state_.view();
    if (form_) {
      stands_.assign(state.begin(), state.end());
      form_->canonical(stands_);
      state = stands_;
    }
    const auto [number, is_new] = met_.insert(state.data());
    if (is_new) {
      best_.push_back(running);
      return true;
    }
    // The same steps in another order add up to the same number but for rounding.
    const double rounding =
        1e-15 * static_cast<double>(state_.universe()) * std::max(1.0, std::abs(running));
    if (running <= best_[number] + rounding) return false;
    best_[number] = running;
    ++result_.statistics.reopened;
    return true;
  }

  void enter() {
    const auto legal = expander_.legal_actions(state_.view());
    frames_.push_back(actions_.size());
    rests_.resize(legal.size());
    bound_.of_successors(state_.view(), rest_, legal, rests_);
    for (std::size_t i = 0; i < legal.size(); ++i)
      actions_.push_back({legal[i].connection, legal[i].reward, rests_[i]});
    // Best promise first (under the bound `none` that is the best reward, as in the paper), then
    // the best reward, then the lowest connection; they are taken from the back.
    std::ranges::sort(
        std::span(actions_).subspan(frames_.back()), [](const Untried& a, const Untried& b) {
          const double left = std::floor((a.reward + a.rest) / kRewardTolerance + 0.5);
          const double right = std::floor((b.reward + b.rest) / kRewardTolerance + 0.5);
          if (left != right) return left < right;
          return a.reward != b.reward ? a.reward < b.reward : a.connection > b.connection;
        });
    ++result_.statistics.expanded;
    if (result_.statistics.expanded % kLook == 0 || budget_.max_expansions < kLook) {
      // Memory is judged before it is taken: until the next look the table gains a state with each
      // expansion.
      const std::uint64_t soon = bytes() - met_.bytes() + met_.bytes_with(kLook);
      result_.stop =
          soon > allowed_ ? Stop::MemoryLimit : budget_.expired(soon, result_.statistics.expanded);
      budget_.report({.phase = "search",
                      .done = result_.statistics.expanded,
                      .states = met_.size(),
                      .best = result_.reward});
    }
  }

  void follow(const Untried& action) {
    const double running = running_ + action.reward;
    const double rest = action.rest;
    ++result_.statistics.generated;
    if (running + rest <= result_.reward + kRewardTolerance) {
      ++result_.statistics.pruned;
      return;
    }
    state_.erase(action.connection);
    if (!met(running)) {
      state_.insert(action.connection);
      ++result_.statistics.pruned;
      return;
    }
    taken_.push_back({action.connection, running_, rest_});
    running_ = running;
    rest_ = rest;
    --num_open_;
    if (num_open_ == 0) {
      result_.reward = running;
      result_.sequence.clear();
      for (const Taken& step : taken_) result_.sequence.push_back(step.connection);
      frames_.push_back(actions_.size());
    } else {
      enter();
    }
  }

  void leave() {
    frames_.pop_back();
    if (taken_.empty()) return;
    const Taken& step = taken_.back();
    state_.insert(step.connection);
    running_ = step.running_before;
    rest_ = step.rest_before;
    ++num_open_;
    taken_.pop_back();
  }

  [[nodiscard]] std::uint64_t bytes() const {
    return met_.bytes() + best_.bytes() + actions_.capacity() * sizeof(Untried);
  }

  /// How many states are expanded from one look at the budget to the next.
  static constexpr std::uint64_t kLook = 1024;

  /// A step of the path to the present state, with what held before it.
  struct Taken {
    ConnectionIndex connection;
    double running_before;
    double rest_before;
  };

  Expander expander_;
  Bound& bound_;
  const Budget& budget_;
  std::uint64_t allowed_;
  Result& result_;
  ConnectionSet state_;
  std::size_t num_open_;
  /// The reward of the path to the present state, and the bound of that state.
  double running_ = 0;
  double rest_ = 0;
  std::vector<Taken> taken_;
  /// The bounds of the states after the legal actions of one state.
  std::vector<double> rests_;
  /// The actions that are not yet followed, of each state of the path; the last is followed first.
  std::vector<Untried> actions_;
  /// Where the actions of each state of the path begin in actions_.
  std::vector<std::size_t> frames_;
  /// With symmetry: what brings a state to the one that stands for it, and that one.
  std::optional<OrbitForm> form_;
  std::vector<std::uint64_t> stands_;
  /// The states that were met, and the best reward with which each was met.
  detail::StateTable<kWords> met_;
  detail::GrowingArray<double> best_;
};

/// With SymmetryUse::Auto so many states are expanded before symmetry is looked for: where fewer
/// are enough, it would cost more than it saves.
constexpr std::uint64_t kExpansionsBeforeSymmetry = 2000;

/// @returns the symmetry that was used.
template <std::size_t kWords>
std::optional<Symmetry> search(const TransitionSystem& system, SymmetryUse use, Bound& bound,
                               const Budget& budget, Result& result) {
  constexpr std::uint64_t kToTheEnd = std::numeric_limits<std::uint64_t>::max();
  std::optional<Symmetry> symmetry;
  if (use == SymmetryUse::On) {
    symmetry = symmetry_for(system, use, "orasp-search");
  } else {
    OraspSearch<kWords> plain(system, bound, nullptr, budget, result);
    if (plain.run(use == SymmetryUse::Auto ? kExpansionsBeforeSymmetry : kToTheEnd))
      return symmetry;
    symmetry = symmetry_for(system, use, "orasp-search");
    if (!symmetry) {
      plain.run(kToTheEnd);
      return symmetry;
    }
  }
  // The best plan so far stays the incumbent.
  OraspSearch<kWords>(system, bound, symmetry ? &*symmetry : nullptr, budget, result)
      .run(kToTheEnd);
  return symmetry;
}

/// How often the first plan is improved, where rewards depend on when steps come.
constexpr std::uint64_t kOrderRounds = 20;

Result searched(const TransitionSystem& system, const OraspSearchOptions& options,
                const Budget& budget) {
  if (auto result = detail::infeasible_at_once(system, "orasp-search")) return *result;
  const std::unique_ptr<Bound> bound = make_bound(system, options.bound, options.like);
  if (auto reason = detail::bound_obstacle(*bound, system, options.bound))
    throw Refusal("orasp-search", *reason);
  Result result;
  if (options.incumbent != nullptr && options.incumbent->has_plan()) {
    result.status = Status::Feasible;
    result.sequence = options.incumbent->sequence;
    result.reward = options.incumbent->reward;
  } else {
    result = random_sequence(system, {.seed = options.seed}, budget);
  }
  result.method = "orasp-search";
  if (result.stop != Stop::None) {
    result =
        detail::stopped_with_quick_plan(system, "orasp-search", result.stop, result.statistics);
  } else if (result.status == Status::Feasible) {
    const StartByPlaces by_places = start_by_places(*bound);
    if (by_places.prices)
      detail::OrderSearch(system, by_places.prices).improve(budget, kOrderRounds, result);
    const std::optional<Symmetry> symmetry =
        system.words() == 1 ? search<1>(system, options.symmetry, *bound, budget, result)
                            : search<0>(system, options.symmetry, *bound, budget, result);
    if (symmetry) result.notes.push_back(symmetry->text());
    if (result.stop == Stop::None) {
      result.status = Status::Optimal;
      result.bound = result.reward;
    } else if (result.bound) {
      result.bound = std::max(result.reward, std::min(*result.bound, by_places.most));
    }
  }
  result.seed = options.seed;
  return result;
}

}  // namespace

Result orasp_search(const TransitionSystem& system, const OraspSearchOptions& options,
                    const Budget& budget) {
  if (system.wide()) {
    if (const auto reason = symmetry_obstacle(system, options.symmetry))
      throw Refusal("orasp-search", *reason);
    return detail::wide_depth_first(system, options.seed, budget);
  }
  return detail::from_the_end(system, options,
                              [&](const TransitionSystem& from, const OraspSearchOptions& turned) {
                                return searched(from, turned, budget);
                              });
}

}  // namespace orasp
