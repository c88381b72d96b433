#include "orasp/graph/state_graph.h"

#include <algorithm>
#include <atomic>

#include "orasp/containers/parallel.h"
#include "orasp/model/tolerance.h"

namespace orasp {

namespace {

/// A block with fewer states is left to one thread.
constexpr std::size_t kParallelFrom = 2048;

}  // namespace

StateGraph::Reweighed StateGraph::reweigh(const TransitionSystem& system, const Budget& budget) {
  if (system.num_connections() != system_->num_connections() ||
      !(system.start() == system_->start()) ||
      system.problem().direction() != system_->problem().direction())
    return Reweighed::Differs;
  if (system.wide() || system_->wide()) return Reweighed::Differs;
  struct Run {
    explicit Run(const TransitionSystem& of) : expander(of) {}
    Expander expander;
    detail::ValueNumbers values;
    /// The rewards of one block, as numbers in `values`.
    std::vector<std::uint32_t> numbers;
    /// The rewards themselves; used instead of their numbers once there are too many to number.
    std::vector<double> plain;
  };
  constexpr std::size_t kBlock = std::size_t{1} << 16;
  std::vector<Run> runs;
  for (unsigned t = 0; t < std::max(1U, budget.threads); ++t) runs.emplace_back(system);
  detail::RewardColumn fresh;
  std::atomic<bool> differs = false;
  for (std::size_t begin = 0; begin < num_states(); begin += kBlock) {
    if (budget.expired(bytes() + fresh.bytes()) != Stop::None) return Reweighed::Stopped;
    const std::size_t size = std::min<std::size_t>(kBlock, num_states() - begin);
    const std::size_t threads = size < kParallelFrom ? 1 : runs.size();
    const bool numbered = fresh.numbered();
    detail::run_parallel(threads, [&](std::size_t t) {
      Run& run = runs[t];
      const auto [first, last] = detail::share_of(size, threads, t);
      const std::size_t most = row_begin_[begin + last] - row_begin_[begin + first];
      run.numbers.resize(numbered ? most : 0);
      run.plain.resize(numbered ? 0 : most);
      std::uint32_t* number = run.numbers.data();
      double* plain = run.plain.data();
      bool same = true;
      const auto keys = states().subspan((begin + first) * words_, (last - first) * words_);
      run.expander.for_each_expansion(keys, [&](std::size_t i, std::span<const Action> actions) {
        const auto state = static_cast<StateId>(begin + first + i);
        ActionId mine = this->begin(state);
        same = same && actions.size() == end(state) - mine;
        if (!same) return;
        for (const Action& action : actions) {
          same = same && connection(mine++) == action.connection;
          if (numbered) {
            *number++ = run.values.number(action.reward);
          } else {
            *plain++ = action.reward;
          }
        }
      });
      if (!same) differs = true;
    });
    if (differs) return Reweighed::Differs;
    std::vector<std::vector<std::uint32_t>> numbers;
    for (std::size_t t = 0; t < threads; ++t)
      numbers.push_back(fresh.admit(runs[t].values.values()));
    const ActionId from = this->begin(static_cast<StateId>(begin));
    fresh.extend(row_begin_[begin + size] - from);
    detail::run_parallel(threads, [&](std::size_t t) {
      const Run& run = runs[t];
      std::size_t at =
          this->begin(static_cast<StateId>(begin + detail::share_of(size, threads, t).begin));
      if (!numbered) {
        for (const double reward : run.plain) fresh.set_value(at++, reward);
      } else if (fresh.numbered()) {
        for (const std::uint32_t number : run.numbers) fresh.set_number(at++, numbers[t][number]);
      } else {
        // Only with this block the values became too many to number.
        for (const std::uint32_t number : run.numbers)
          fresh.set_value(at++, run.values.values()[number]);
      }
    });
  }
  fresh.shrink_to_fit();
  rewards_ = std::move(fresh);
  system_ = &system;
  return Reweighed::Done;
}

std::optional<StateId> StateGraph::goal() const {
  if (system_->wide()) {
    if (!goal_reached_) return std::nullopt;
    return static_cast<StateId>(num_states() - 1);
  }
  if (num_layers() != system_->num_steps() + 1) return std::nullopt;
  return layer_begin(num_layers() - 1);
}

PlanWalk StateGraph::steps_along(std::span<const StateId> path) const {
  std::vector<std::uint64_t> states;
  for (const StateId state : path) {
    const SetView words = key(state);
    states.insert(states.end(), words.begin(), words.end());
  }
  return Expander(*system_).steps_along(states);
}

double StateGraph::greatest_reward() const {
  double greatest = -kInfinity;
  rewards_.with_reader([&](auto reward_of) {
    for (ActionId a = 0; a < num_actions(); ++a) greatest = std::max(greatest, reward_of(a));
  });
  return greatest;
}

std::uint64_t StateGraph::bytes() const {
  return states_.bytes() + row_begin_.bytes() + successors_.bytes() + narrow_connections_.bytes() +
         wide_connections_.bytes() + rewards_.bytes();
}

}  // namespace orasp
