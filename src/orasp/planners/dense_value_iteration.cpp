#include "orasp/planners/dense_value_iteration.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/parallel.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/model/error.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/dense_sizes.h"
#include "orasp/planners/detail/forest_blocks.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

constexpr const char* kMethod = "value-iteration";
/// More connections would need more than 2 GiB of doubles.
constexpr std::size_t kMostConnectionsDouble = 28;
/// The states of so many connections or fewer are one block.
constexpr std::size_t kLeastBlockBits = 10;
constexpr std::size_t kMostBlockBits = 14;
/// So many states are worked out between two looks at the clock.
constexpr std::uint64_t kPollEvery = 256;

using detail::bit;
using detail::dense_forest_of;
using detail::DenseForest;
using detail::Doubles;
using detail::FixedPoint;
using detail::ForestBlocks;
using detail::kMostDenseConnections;
using detail::Mask;

/// How many low bits of a mask make a block.
std::size_t block_bits(std::size_t connections) {
  return connections <= kLeastBlockBits
             ? connections
             : std::min(kMostBlockBits, std::max(kLeastBlockBits, connections - 8));
}

/// The memory that the table of values and the order of its blocks take.
double table_bytes(std::size_t connections, bool doubles) {
  return std::exp2(connections) *
             static_cast<double>(doubles ? sizeof(double) : sizeof(std::int32_t)) +
         std::exp2(connections - block_bits(connections)) * sizeof(std::uint32_t);
}

/// The order of work: masks are a block number above block_bits low bits; blocks are sorted by
/// their number of ones.
struct Blocks {
  std::size_t bits = 0;
  std::vector<std::uint32_t> numbers;
  std::vector<std::size_t> layer_begin;

  explicit Blocks(std::size_t connections) {
    bits = block_bits(connections);
    numbers.resize(std::size_t{1} << (connections - bits));
    const std::size_t layers = connections - bits + 1;
    layer_begin.assign(layers + 1, 0);
    const auto ones = [](std::size_t number) {
      return static_cast<std::size_t>(std::popcount(number));
    };
    for (std::size_t b = 0; b < numbers.size(); ++b) ++layer_begin[ones(b) + 1];
    std::partial_sum(layer_begin.begin(), layer_begin.end(), layer_begin.begin());
    std::vector<std::size_t> next = layer_begin;
    for (std::size_t b = 0; b < numbers.size(); ++b)
      numbers[next[ones(b)]++] = static_cast<std::uint32_t>(b);
  }
  [[nodiscard]] Mask size() const { return bit(bits); }
};

/// One pass over all states.
template <class Numbers>
class DenseSweep {
 public:
  using Value = typename Numbers::Value;

  DenseSweep(const TransitionSystem& system, const Budget& budget, const Blocks& blocks,
             const std::optional<DenseForest>& forest, const Numbers& numbers, Value* values)
      : system_(system),
        budget_(budget),
        blocks_(blocks),
        forest_(forest),
        numbers_(numbers),
        values_(values) {}

  void run(std::uint64_t bytes, Statistics& statistics) {
    const std::size_t threads = std::max(1U, budget_.threads);
    std::vector<Run> runs;
    for (std::size_t layer = 0; layer + 1 < blocks_.layer_begin.size(); ++layer) {
      stop_ = budget_.expired(bytes, statistics.expanded);
      if (stop_ != Stop::None) return;
      const std::size_t begin = blocks_.layer_begin[layer];
      const std::size_t end = blocks_.layer_begin[layer + 1];
      const std::size_t workers = std::min(threads, end - begin);
      while (runs.size() < workers) runs.emplace_back(*this);
      next_ = begin;
      detail::run_parallel(workers, [&](std::size_t t) {
        if (forest_) {
          while (!give_up()) {
            const std::size_t i = next_++;
            if (i >= end) break;
            poll();
            runs[t].forest->work_out(blocks_.numbers[i] * blocks_.size(), blocks_.size(), values_);
            if (t == 0 && i % 256 == 0) report(i);
          }
        } else {
          // Runs of blocks, so that the first error in the order of the states is the one reported.
          const auto [first, last] = detail::share_of(end - begin, workers, t);
          for (std::size_t i = first; i < last && !give_up(); ++i) {
            work_out(runs[t], blocks_.numbers[begin + i] * blocks_.size());
            if (t == 0 && i % 16 == 0) report(begin + i);
          }
        }
      });
      if (give_up()) return;
      statistics.expanded += (end - begin) * blocks_.size();
      report(end);
    }
    for (const Run& run : runs) {
      error_ = std::max(error_, run.error);
      statistics.generated += run.generated;
    }
    if (forest_)
      statistics.generated +=
          blocks_.numbers.size() * blocks_.size() / 2 * system_.num_connections();
  }

  [[nodiscard]] Stop stop() const { return stop_; }
  /// A reward was too large for its number system.
  [[nodiscard]] bool overflowed() const { return overflowed_; }
  /// Greatest difference between a reward and its value.
  [[nodiscard]] double error() const { return error_; }

 private:
  /// What one thread holds.
  struct Run {
    explicit Run(const DenseSweep& sweep) : expander(sweep.system_) {
      if (!sweep.forest_) return;
      forest.emplace(*sweep.forest_, sweep.system_, sweep.numbers_);
      error = forest->error();
    }
    Expander expander;
    std::optional<ForestBlocks<Numbers>> forest;
    std::vector<Mask> masks;
    double error = 0;
    std::uint64_t generated = 0;
  };

  [[nodiscard]] bool give_up() const { return stop_ != Stop::None || overflowed_; }
  void poll() {
    if (const Stop stop = budget_.expired(); stop != Stop::None) stop_ = stop;
  }
  void report(std::size_t blocks) const {
    const std::uint64_t total = blocks_.numbers.size() * blocks_.size();
    budget_.report({.phase = "values of all states",
                    .done = blocks * blocks_.size(),
                    .total = total,
                    .states = total});
  }

  // Works out a block by legal actions and rewards from the Expander, which do for any problem.
  void work_out(Run& run, Mask first) {
    const Mask chunk = std::min<Mask>(blocks_.size(), kPollEvery);
    run.masks.resize(chunk);
    for (Mask begin = first; begin < first + blocks_.size(); begin += chunk) {
      poll();
      if (give_up()) return;
      std::iota(run.masks.begin(), run.masks.end(), begin);
      run.expander.for_each_expansion(
          run.masks, [&](std::size_t i, std::span<const Action> actions) {
            const Mask mask = begin + i;
            const bool completes = std::has_single_bit(mask);
            Value best = mask == 0 ? Value{} : Numbers::kNever;
            for (const Action& action : actions) {
              if (!numbers_.holds(action.reward, completes)) {
                overflowed_ = true;
                return;
              }
              run.error = std::max(run.error, numbers_.error(action.reward));
              best = std::max(best, Numbers::plus(numbers_.rounded(action.reward),
                                                  values_[mask ^ bit(action.connection)]));
            }
            run.generated += actions.size();
            values_[mask] = best;
          });
    }
  }

  const TransitionSystem& system_;
  const Budget& budget_;
  const Blocks& blocks_;
  const std::optional<DenseForest>& forest_;
  const Numbers& numbers_;
  Value* values_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<Stop> stop_ = Stop::None;
  std::atomic<bool> overflowed_ = false;
  double error_ = 0;
};

/// Follows the best actions from the start. Rewards are added as doubles in either number system.
template <class Numbers>
void roll_out(const TransitionSystem& system, const Numbers& numbers,
              const typename Numbers::Value* values, Result& result) {
  Expander expander(system);
  result.reward = 0;
  for (Mask mask = bit(system.num_connections()) - 1; mask != 0;) {
    const Action* best = nullptr;
    double most = 0;
    for (const Action& action : expander.legal_actions(SetView(&mask, 1))) {
      const auto left = values[mask ^ bit(action.connection)];
      if (left == Numbers::kNever) continue;
      const double sum = action.reward + numbers.value(left);
      if (best != nullptr && !(sum > most)) continue;
      best = &action;
      most = sum;
    }
    result.sequence.push_back(best->connection);
    result.reward += best->reward;
    mask ^= bit(best->connection);
  }
}

/// Writes the plan and what is proved of it to `result`. `error` is the greatest rounding error of
/// a step.
template <class Numbers>
void conclude(const TransitionSystem& system, const Numbers& numbers,
              const typename Numbers::Value* values, double error, Result& result) {
  const auto start = values[bit(system.num_connections()) - 1];
  if (start == Numbers::kNever) {
    result = detail::exhausted(kMethod, result.statistics);
    return;
  }
  roll_out(system, numbers, values, result);
  detail::judge_dense(numbers, system.num_connections(), start, error, result);
}

template <class Numbers>
using Values = detail::GrowingArray<typename Numbers::Value>;

void solve_in_doubles(const TransitionSystem& system, const Budget& budget, const Blocks& blocks,
                      const std::optional<DenseForest>& forest, Result& result) {
  Values<Doubles> values;
  values.reserve(bit(system.num_connections()));
  values.resize(bit(system.num_connections()));
  const Doubles numbers;
  DenseSweep<Doubles> sweep(system, budget, blocks, forest, numbers, values.data());
  result.statistics.sweeps = 1;
  sweep.run(result.statistics.peak_bytes, result.statistics);
  result.stop = sweep.stop();
  if (result.stop == Stop::None) conclude(system, numbers, values.data(), 0, result);
}

void solve_in_fixed_point(const TransitionSystem& system, const Budget& budget,
                          const Blocks& blocks, const std::optional<DenseForest>& forest,
                          Result& result) {
  Values<FixedPoint> values;
  values.reserve(bit(system.num_connections()));
  values.resize(bit(system.num_connections()));
  detail::RewardSizes sizes = detail::reward_sizes(system);
  // Where a reward turns out too large for its number system, all begins again with ten, a hundred,
  // ten thousand times the size. So the sizes do not depend on which thread met the large reward.
  for (double factor = 10;; factor *= factor) {
    const FixedPoint numbers(system.num_connections(), sizes.step, sizes.last);
    DenseSweep<FixedPoint> sweep(system, budget, blocks, forest, numbers, values.data());
    ++result.statistics.sweeps;
    sweep.run(result.statistics.peak_bytes, result.statistics);
    result.stop = sweep.stop();
    if (result.stop != Stop::None) return;
    if (!sweep.overflowed()) {
      conclude(system, numbers, values.data(), sweep.error(), result);
      return;
    }
    sizes.step = sizes.last = factor * std::max(numbers.most_step, numbers.most_last);
  }
}

bool takes_doubles(const TransitionSystem& system, const DenseValueIterationOptions& options,
                   const Budget& budget) {
  using Option = DenseValueIterationOptions::Values;
  if (options.values != Option::Automatic) return options.values == Option::Double;
  const std::size_t n = system.num_connections();
  return n <= kMostConnectionsDouble && bit(n) * sizeof(double) <= allowed_bytes(budget) / 2;
}

}  // namespace

double dense_table_bytes(const TransitionSystem& system, const Budget& budget) {
  return table_bytes(system.num_connections(), takes_doubles(system, {}, budget));
}

bool dense_table_fits(const TransitionSystem& system, const Budget& budget) {
  return system.whole() && system.num_connections() <= kMostDenseConnections &&
         dense_table_bytes(system, budget) <= static_cast<double>(allowed_bytes(budget));
}

bool dense_values_safe(const TransitionSystem& system) {
  return !system.wide() && (unconstrained(system) || !system.calls_out());
}

Result dense_value_iteration(const TransitionSystem& system,
                             const DenseValueIterationOptions& options, const Budget& budget) {
  const Stopwatch watch;
  if (auto result = detail::infeasible_at_once(system, kMethod)) return *result;
  if (!system.whole())
    throw InputError(
        "value-iteration: the table of all 2^n states begins with all connections open");
  const std::size_t n = system.num_connections();
  const bool doubles = takes_doubles(system, options, budget);
  const double needed = table_bytes(n, doubles);
  if (n > kMostDenseConnections || needed > static_cast<double>(allowed_bytes(budget))) {
    throw InputError("value-iteration: a table of all 2^" + std::to_string(n) +
                     " states does not fit in the memory allowed");
  }
  Result result;
  result.method = kMethod;
  const Blocks blocks(n);
  const std::optional<DenseForest> forest = dense_forest_of(system);
  result.statistics.peak_bytes = static_cast<std::uint64_t>(needed);
  result.statistics.states = bit(n);
  if (doubles) {
    solve_in_doubles(system, budget, blocks, forest, result);
  } else {
    solve_in_fixed_point(system, budget, blocks, forest, result);
  }
  if (result.stop != Stop::None)
    result = detail::stopped_with_quick_plan(system, kMethod, result.stop, result.statistics);
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
