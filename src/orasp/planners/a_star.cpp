#include "orasp/planners/a_star.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/graph/state_graph.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/open_state.h"
#include "orasp/planners/detail/order_search.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// The search of a_star(). kWords is that of its StateTable.
template <std::size_t kWords>
class AStarSearch {
 public:
  AStarSearch(const TransitionSystem& system, Bound& bound, const Symmetry* symmetry,
              const Budget& budget, Result& result)
      : system_(system),
        expander_(system),
        bound_(bound),
        budget_(budget),
        allowed_(allowed_bytes(budget)),
        result_(result),
        look_(std::clamp<std::uint64_t>(8192 / (1 + system.num_connections()), 1, 256)),
        table_(system.words()) {
    if (symmetry != nullptr) form_ = symmetry->form();
  }

  /// Searches to the end, or until so many states were expanded; then it can go on.
  /// @returns whether it came to its end or was stopped.
  bool run(std::uint64_t pause) {
    if (table_.size() == 0) {
      const ConnectionSet start = system_.start();
      all_ = bound_(start.view());
      tick_ = kRewardTolerance * std::max(1.0, std::abs(all_));
      meet(start.view(), 0, 0, 0, all_, 0);
    }
    result_.stop = budget_.expired();
    while (!open_.empty() && result_.stop == Stop::None) {
      if (result_.statistics.expanded >= pause) return false;
      std::ranges::pop_heap(open_.span(), Open::later);
      const Open next = open_.back();
      open_.resize(open_.size() - 1);
      // A state stands in the heap once for each path by which it was met; the best came first.
      if (closed_[next.state] != 0) continue;
      closed_[next.state] = 1;
      if (next.depth == system_.num_steps()) {
        finish(next.state);
        break;
      }
      expand(next);
    }
    if (result_.stop != Stop::None)
      result_.bound = open_.empty() ? all_ : static_cast<double>(open_[0].promise + 1) * tick_;
    result_.statistics.states = table_.size();
    result_.statistics.peak_bytes = std::max(result_.statistics.peak_bytes, bytes());
    return true;
  }

 private:
  static constexpr std::uint64_t kLookGenerated = 4096;

  using Open = detail::OpenState;  // its promise in units of tick_

  void meet(SetView state, ConnectionIndex by, std::uint32_t from, double reward, double rest,
            std::uint32_t depth) {
    const auto [number, is_new] = table_.insert(state.data());
    if (is_new) {
      reward_.push_back(reward);
      by_.push_back(static_cast<std::uint16_t>(by));
      if (form_) from_.push_back(from);
      closed_.push_back(0);
    } else {
      if (reward <= reward_[number] + tick_ / 16) {
        ++result_.statistics.pruned;
        return;
      }
      ++result_.statistics.reopened;
      reward_[number] = reward;
      by_[number] = static_cast<std::uint16_t>(by);
      if (form_) from_[number] = from;
      closed_[number] = 0;
    }
    open_.push_back(
        {static_cast<std::int64_t>(std::floor((reward + rest) / tick_ + 0.5)), number, depth});
    std::ranges::push_heap(open_.span(), Open::later);
  }

  void expand(const Open& from) {
    ++result_.statistics.expanded;
    if (result_.statistics.expanded % look_ == 0 || budget_.max_expansions < look_) {
      // Memory is judged before it is taken: by what the states that are generated until the next
      // look may need at most.
      const std::uint64_t more = look_ * system_.num_connections();
      const std::uint64_t soon = bytes() - table_.bytes() + table_.bytes_with(more) +
                                 more * (sizeof(double) + sizeof(std::uint16_t) + 1 + sizeof(Open) +
                                         (form_ ? sizeof(std::uint32_t) : 0));
      result_.stop =
          soon > allowed_ ? Stop::MemoryLimit : budget_.expired(soon, result_.statistics.expanded);
      budget_.report(
          {.phase = "search", .done = result_.statistics.expanded, .states = table_.size()});
      if (result_.stop != Stop::None) {
        // The state was not expanded, so what it promises still counts for the bound.
        open_.push_back(from);
        std::ranges::push_heap(open_.span(), Open::later);
        return;
      }
    }
    ConnectionSet state(system_.num_connections(), {table_.key(from.state), system_.words()});
    const double reward = reward_[from.state];
    const auto legal = expander_.legal_actions(state.view());
    rests_.resize(legal.size());
    const double here =
        form_ ? bound_(state.view()) : static_cast<double>(from.promise) * tick_ - reward;
    bound_.of_successors(state.view(), here, legal, rests_);
    for (std::size_t i = 0; i < legal.size(); ++i) {
      // A state may have thousands of successors of thousands of bits each.
      if (++result_.statistics.generated % kLookGenerated == 0) result_.stop = budget_.expired();
      if (result_.stop != Stop::None) {
        open_.push_back(from);  // as above
        std::ranges::push_heap(open_.span(), Open::later);
        return;
      }
      const ConnectionIndex c = legal[i].connection;
      state.erase(c);
      SetView met = state.view();
      if (form_) {
        stands_.assign(met.begin(), met.end());
        form_->canonical_but_for(c, stands_);
        met = stands_;
      }
      meet(met, c, from.state, reward + legal[i].reward, rests_[i], from.depth + 1);
      state.insert(c);
    }
  }

  void finish(std::uint32_t goal) {
    ConnectionSet state(system_.num_connections());
    std::vector<ConnectionIndex>& sequence = result_.sequence;
    std::uint32_t number = goal;
    while (sequence.size() < system_.num_steps()) {
      sequence.push_back(by_[number]);
      state.insert(by_[number]);
      number = form_ ? from_[number] : table_.find(state.view().data());
    }
    std::ranges::reverse(sequence);
    if (form_) sequence = true_sequence(system_, *form_, sequence);
    result_.reward = reward_[goal];
    result_.bound = result_.reward;
    result_.status = Status::Optimal;
  }

  [[nodiscard]] std::uint64_t bytes() const {
    return table_.bytes() + reward_.bytes() + by_.bytes() + from_.bytes() + closed_.bytes() +
           open_.bytes();
  }

  const TransitionSystem& system_;
  Expander expander_;
  Bound& bound_;
  const Budget& budget_;
  std::uint64_t allowed_;
  Result& result_;
  /// Promises that differ by less than this are equal.
  double tick_ = 1;
  /// The bound of the start.
  double all_ = 0;
  /// How many states are expanded from one look at the budget to the next.
  std::uint64_t look_;
  detail::StateTable<kWords> table_;
  /// By state: the best reward from the start, the connection that was handled last on that path,
  /// and whether the state was expanded.
  detail::GrowingArray<double> reward_;
  detail::GrowingArray<std::uint16_t> by_;
  detail::GrowingArray<unsigned char> closed_;
  /// With symmetry: what brings a state to the one that stands for it, that one, and by state, the
  /// one before it on its path.
  std::optional<OrbitForm> form_;
  std::vector<std::uint64_t> stands_;
  detail::GrowingArray<std::uint32_t> from_;
  detail::GrowingArray<Open> open_;
  std::vector<double> rests_;
};

/// With SymmetryUse::Auto so many states are expanded before symmetry is looked for: where fewer
/// are enough, it would cost more than it saves.
constexpr std::uint64_t kBeforeSymmetry = 2000;

/// @returns the symmetry that was used.
template <std::size_t kWords>
std::optional<Symmetry> search(const TransitionSystem& system, const AStarOptions& options,
                               Bound& bound, const Budget& budget, Result& result) {
  std::optional<Symmetry> symmetry;
  if (options.symmetry != SymmetryUse::On) {
    AStarSearch<kWords> plain(system, bound, nullptr, budget, result);
    const bool automatic = options.symmetry == SymmetryUse::Auto;
    if (plain.run(automatic ? kBeforeSymmetry : std::numeric_limits<std::uint64_t>::max()))
      return symmetry;
    symmetry = symmetry_for(system, options.symmetry, "a-star");
    if (!symmetry) {
      plain.run(std::numeric_limits<std::uint64_t>::max());
      return symmetry;
    }
  } else {
    symmetry = symmetry_for(system, options.symmetry, "a-star");
  }
  AStarSearch<kWords>(system, bound, symmetry ? &*symmetry : nullptr, budget, result)
      .run(std::numeric_limits<std::uint64_t>::max());
  return symmetry;
}

Result searched(const TransitionSystem& system, const AStarOptions& options, const Budget& budget) {
  static_assert(kMaxConnections <= std::size_t{1} << 16);
  if (auto result = detail::infeasible_at_once(system, "a-star")) return *result;
  const std::unique_ptr<Bound> bound = make_bound(system, options.bound);
  if (auto reason = detail::bound_obstacle(*bound, system, options.bound))
    throw Refusal("a-star", *reason);
  Result result;
  result.method = "a-star";
  const std::optional<Symmetry> symmetry = system.words() == 1
                                               ? search<1>(system, options, *bound, budget, result)
                                               : search<0>(system, options, *bound, budget, result);
  if (result.stop != Stop::None) {
    const std::optional<double> most = result.bound;
    result = detail::stopped_with_quick_plan(system, "a-star", result.stop, result.statistics);
    const StartByPlaces by_places = start_by_places(*bound);
    result.bound = most;
    if (by_places.prices && most) {
      detail::OrderSearch(system, by_places.prices).improve(budget, 1, result);
      result.bound = std::max(result.reward, std::min(*most, by_places.most));
    }
  } else if (result.status != Status::Optimal) {
    result = detail::exhausted("a-star", result.statistics);
  }
  if (symmetry) result.notes.push_back(symmetry->text());
  return result;
}

}  // namespace

Result a_star(const TransitionSystem& system, const AStarOptions& options, const Budget& budget) {
  if (system.wide()) {
    if (const auto reason = symmetry_obstacle(system, options.symmetry))
      throw Refusal("a-star", *reason);
    return detail::wide_a_star(system, budget);
  }
  return detail::from_the_end(
      system, [&](const TransitionSystem& from) { return searched(from, options, budget); });
}

}  // namespace orasp
