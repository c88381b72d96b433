#include "orasp/planners/dense_value_iteration.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/parallel.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/model/detail/connectivity.h"
#include "orasp/model/error.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

constexpr const char* kMethod = "value-iteration";
constexpr std::size_t kMostConnections = 40;        // 4 TiB of four-byte values
constexpr std::size_t kMostConnectionsDouble = 28;  // 2 GiB of doubles
constexpr std::size_t kWholeBlock = 10;             // so many connections or fewer are one block
constexpr std::size_t kMostBlockBits = 14;
constexpr std::size_t kLaneBits = 5;
constexpr std::size_t kLanes = std::size_t{1} << kLaneBits;
constexpr std::uint64_t kPollEvery = 256;  // states between looks at the clock

/// Low bits of a mask that make a block.
std::size_t block_bits(std::size_t connections) {
  return connections <= kWholeBlock
             ? connections
             : std::min(kMostBlockBits, std::max(kWholeBlock, connections - 8));
}

/// The table and the order of its blocks.
double table_bytes(std::size_t connections, bool doubles) {
  return std::exp2(connections) *
             static_cast<double>(doubles ? sizeof(double) : sizeof(std::int32_t)) +
         std::exp2(connections - block_bits(connections)) * sizeof(std::uint32_t);
}

using Mask = std::uint64_t;

Mask bit(std::size_t c) {
  return Mask{1} << c;
}

// Number systems. take() turns a reward into a value, or says that it is too large; plus() is a
// step before what is left; value() turns back.

struct Doubles {
  using Value = double;
  static constexpr Value kNever = -kInfinity;

  static Value rounded(double reward) { return reward; }
  static double value(Value value) { return value; }
  static bool holds(double, bool) { return true; }
  static double error(double) { return 0; }
  static Value plus(Value reward, Value left) { return reward + left; }
};

struct FixedPoint {
  using Value = std::int32_t;
  static constexpr Value kNever = std::numeric_limits<Value>::min();
  /// No plan's sum is larger than this, in units: a sum and one more reward still fit.
  static constexpr double kMostSum = (1 << 30) - 1024;
  static constexpr double kLargestSum = 1e290;

  double per_unit = 1;   ///< units in 1: a power of ten
  double most_step = 0;  ///< greatest size of a reward
  double most_last = 0;  ///< of the reward that completes

  /// The finest unit for rewards of these sizes.
  FixedPoint(std::size_t connections, double step, double last) {
    const double sum = static_cast<double>(connections) * step + last;
    if (sum > kLargestSum) {
      // A unit in which forty of the largest doubles fit.
      per_unit = 1e-302;
      most_step = most_last = std::numeric_limits<double>::max();
      return;
    }
    if (sum == 0) return;
    int power = static_cast<int>(std::max(std::ceil(std::log10(sum / kMostSum)), -300.0));
    while (sum > kMostSum * std::pow(10.0, power)) ++power;
    per_unit = power <= 0 ? std::pow(10.0, -power) : 1 / std::pow(10.0, power);
    const double room = kMostSum / (sum * per_unit);
    most_step = step * room;
    most_last = last * room;
  }

  [[nodiscard]] Value rounded(double reward) const {
    const double units = reward * per_unit;
    return static_cast<Value>(units + (units < 0 ? -0.5 : 0.5));
  }
  [[nodiscard]] double value(Value value) const { return value / per_unit; }
  [[nodiscard]] bool holds(double reward, bool completes) const {
    return std::abs(reward) <= (completes ? most_last : most_step);
  }
  [[nodiscard]] double error(double reward) const {
    return std::abs(reward - value(rounded(reward)));
  }
  static Value plus(Value reward, Value left) { return left == kNever ? kNever : reward + left; }
};

// -------------------------------------------------------------------------------------------------

/// What forest blocks need to know of the assembly. Slots as in AssemblyGraph::forest(), numbered
/// anew: the edges in their order, then the roots that have an edge.
struct Forest {
  struct Edge {
    ConnectionIndex connection;
    std::uint32_t parent;  ///< slot
    bool lower_is_a;       ///< the lower part is the connection's first
  };
  std::vector<Edge> edges;
  std::size_t slots = 0;
  std::vector<ConnectionIndex> loops;
  bool assembly = false;
};

/// Empty where blocks must be worked out by Expander.
std::optional<Forest> forest_of(const TransitionSystem& system) {
  const Problem& problem = system.problem();
  if (system.num_connections() < kLaneBits || !unconstrained(system) || !system.sees_sizes_only() ||
      system.sees_starting_pieces())
    return std::nullopt;
  const detail::AssemblyGraph graph(problem);
  if (!graph.is_forest()) return std::nullopt;
  Forest forest;
  forest.assembly = problem.direction() == Direction::Assembly;
  forest.loops.assign(graph.loops().begin(), graph.loops().end());
  constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> slots(graph.num_slots(), kNone);
  for (const auto& edge : graph.forest()) {
    slots[edge.connection] = static_cast<std::uint32_t>(forest.slots++);
  }
  for (const auto& edge : graph.forest()) {
    std::uint32_t& parent = slots[edge.parent_slot];
    if (parent == kNone) parent = static_cast<std::uint32_t>(forest.slots++);
    forest.edges.push_back(
        {edge.connection, parent, problem.ends(edge.connection)[0] == edge.child});
  }
  return forest;
}

/// Values of forest blocks: 32 masks at once that differ in their lowest five bits. Below an edge
/// and in its piece there are at most connections + 1 parts, so sizes are bytes, and two of them
/// are the index of a table of rewards. One for each thread.
template <class Numbers>
class ForestBlocks {
 public:
  using Value = typename Numbers::Value;

  /// More than the parts of any piece.
  static constexpr std::size_t kStride = 64;
  static_assert(kMostConnections + 1 < kStride);

  ForestBlocks(const Forest& forest, const TransitionSystem& system, const Numbers& numbers)
      : forest_(forest), below_(forest.slots), piece_(forest.slots) {
    const std::size_t most = std::min(system.num_connections() + 1, system.problem().num_parts());
    for (std::vector<Value>& table : rewards_) table.assign(kStride * kStride, Value{});
    const auto reward = [&](std::size_t a, std::size_t b) {
      const double exact = system.greatest_size_reward(a, b, false);
      error_ = std::max(error_, numbers.error(exact));
      return numbers.rounded(exact);
    };
    for (std::size_t all = 2; all <= most; ++all) {
      for (std::size_t below = 1; below < all; ++below) {
        rewards_[0][below * kStride + all] = reward(all - below, below);
        rewards_[1][below * kStride + all] = reward(below, all - below);
      }
    }
    if (!forest.loops.empty()) loop_reward_ = reward(0, 0);
    Expander expander(system);
    for (ConnectionIndex c = 0; c < system.num_connections(); ++c) {
      const Mask alone = bit(c);
      const double exact = expander.legal_actions(SetView(&alone, 1)).front().reward;
      error_ = std::max(error_, numbers.error(exact));
      last_.push_back(numbers.rounded(exact));
    }
    for (std::size_t l = 0; l < kLanes; ++l) {
      all_[l] = 0xff;
      none_[l] = 0;
      for (std::size_t c = 0; c < kLaneBits; ++c) {
        const bool open = (l >> c & 1U) != 0;
        low_[c][l] = open != forest.assembly ? 0xff : 0;
      }
    }
  }

  /// Greatest difference between a reward and its value.
  [[nodiscard]] double error() const { return error_; }

  /// Masks first .. first + size - 1, ascending; both are multiples of 32.
  void work_out(Mask first, Mask size, Value* values) {
    for (Mask mask = first; mask < first + size; mask += kLanes) work_out(mask, values);
  }

 private:
  using Bytes = std::array<std::uint8_t, kLanes>;

  static void look_up(const Value* table, const std::array<std::uint16_t, kLanes>& places,
                      std::array<Value, kLanes>& rewards) {
#pragma GCC unroll 16  // measured: quicker than 8 and than all 32
    for (std::size_t l = 0; l < kLanes; ++l) rewards[l] = table[places[l]];
  }

  void work_out(Mask high, Value* values) {
    measure(high);
    std::array<Value, kLanes> best;
    best.fill(Numbers::kNever);
    std::array<std::array<Value, kLanes>, kLaneBits> low_rewards;
    for (std::size_t e = 0; e < forest_.edges.size(); ++e) {
      const Forest::Edge& edge = forest_.edges[e];
      const bool is_low = edge.connection < kLaneBits;
      if (!is_low && (high & bit(edge.connection)) == 0) continue;
      std::array<std::uint16_t, kLanes> places;
      const Bytes& below = below_[e];
      const Bytes& above = piece_[edge.parent];
      // An open connection is there in disassembly: the piece above is the whole of it. In assembly
      // it is missing.
      if (forest_.assembly) {
        for (std::size_t l = 0; l < kLanes; ++l) {
          places[l] = static_cast<std::uint16_t>(below[l] * kStride + below[l] + above[l]);
        }
      } else {
        for (std::size_t l = 0; l < kLanes; ++l)
          places[l] = static_cast<std::uint16_t>(below[l] * kStride + above[l]);
      }
      const Value* const table = rewards_[edge.lower_is_a ? 1 : 0].data();
      if (is_low) {
        look_up(table, places, low_rewards[edge.connection]);
        continue;
      }
      const Value* const left = values + (high ^ bit(edge.connection));
      std::array<Value, kLanes> rewards;
      look_up(table, places, rewards);
      for (std::size_t l = 0; l < kLanes; ++l) {
        const Value sum = rewards[l] + left[l];
        best[l] = best[l] < sum ? sum : best[l];
      }
    }
    for (const ConnectionIndex c : forest_.loops) {
      if (c < kLaneBits) {
        low_rewards[c].fill(loop_reward_);
      } else if ((high & bit(c)) != 0) {
        const Value* const left = values + (high ^ bit(c));
        for (std::size_t l = 0; l < kLanes; ++l) {
          best[l] = std::max<Value>(best[l], loop_reward_ + left[l]);
        }
      }
    }
    // Lanes among each other, ascending.
    const bool lone = (high & (high - 1)) == 0;  // at most one high connection is open
    if (lone)
      best[0] = high == 0 ? Value{} : last_[static_cast<std::size_t>(std::countr_zero(high))];
    for (std::size_t l = 1; l < kLanes; ++l) {
      if (high == 0 && std::has_single_bit(l)) {
        best[l] = last_[static_cast<std::size_t>(std::countr_zero(l))];
        continue;
      }
      for (std::size_t c = 0; c < kLaneBits; ++c) {
        if ((l >> c & 1U) != 0) {
          best[l] = std::max<Value>(best[l], low_rewards[c][l] + best[l ^ (std::size_t{1} << c)]);
        }
      }
    }
    std::ranges::copy(best, values + high);
  }

  // Parts below each edge, then parts of each slot's piece.
  void measure(Mask high) {
    const Mask present = forest_.assembly ? ~high : high;
    const auto mask_of = [&](ConnectionIndex c) -> const Bytes& {
      return c < kLaneBits ? low_[c] : (present & bit(c)) != 0 ? all_ : none_;
    };
    std::memset(below_.data(), 1, below_.size() * sizeof(Bytes));
    for (std::size_t e = forest_.edges.size(); e-- > 0;) {
      const Forest::Edge& edge = forest_.edges[e];
      const Bytes& mask = mask_of(edge.connection);
      const Bytes& mine = below_[e];
      Bytes& parent = below_[edge.parent];
      for (std::size_t l = 0; l < kLanes; ++l) {
        parent[l] = static_cast<std::uint8_t>(parent[l] + (mine[l] & mask[l]));
      }
    }
    for (std::size_t s = forest_.edges.size(); s < forest_.slots; ++s) piece_[s] = below_[s];
    for (std::size_t e = 0; e < forest_.edges.size(); ++e) {
      const Forest::Edge& edge = forest_.edges[e];
      const Bytes& mask = mask_of(edge.connection);
      const Bytes& mine = below_[e];
      const Bytes& parent = piece_[edge.parent];
      Bytes& piece = piece_[e];
      for (std::size_t l = 0; l < kLanes; ++l) {
        piece[l] = static_cast<std::uint8_t>((parent[l] & mask[l]) | (mine[l] & ~mask[l]));
      }
    }
  }

  const Forest& forest_;
  std::vector<Bytes> below_;                   ///< by slot
  std::vector<Bytes> piece_;                   ///< by slot
  std::array<std::vector<Value>, 2> rewards_;  ///< [lower side is A][below * kStride + both sides]
  Value loop_reward_{};
  std::vector<Value> last_;  ///< by connection: reward of the step that completes
  Bytes all_;
  Bytes none_;
  std::array<Bytes, kLaneBits> low_;
  double error_ = 0;
};

// -------------------------------------------------------------------------------------------------

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

/// One pass over all masks.
template <class Numbers>
class Sweep {
 public:
  using Value = typename Numbers::Value;

  Sweep(const TransitionSystem& system, const Budget& budget, const Blocks& blocks,
        const std::optional<Forest>& forest, const Numbers& numbers, Value* values)
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
    explicit Run(const Sweep& sweep) : expander(sweep.system_) {
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

  // Any problem: legal actions and rewards by Expander.
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
  const std::optional<Forest>& forest_;
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

/// Greatest sizes of rewards.
struct Sizes {
  double step = 0;
  double last = 0;
};

/// By reward_range, or nothing.
std::optional<Sizes> known_sizes(const TransitionSystem& system) {
  const std::size_t n = system.num_connections();
  Sizes sizes;
  for (ConnectionIndex c = 0; c < n; ++c) {
    for (const bool completes : {false, true}) {
      const RewardRange range = system.reward_range(c, n, completes);
      double& size = completes ? sizes.last : sizes.step;
      size = std::max({size, std::abs(range.least), std::abs(range.greatest)});
    }
  }
  if (!std::isfinite(sizes.step) || !std::isfinite(sizes.last)) return std::nullopt;
  return sizes;
}

/// Twice what is met on the way of the greedy plan.
Sizes sampled_sizes(const TransitionSystem& system) {
  Expander expander(system);
  double most = 0;
  for (Mask mask = bit(system.num_connections()) - 1; mask != 0;) {
    const auto actions = expander.legal_actions(SetView(&mask, 1));
    if (actions.empty()) break;
    for (const Action& action : actions) most = std::max(most, std::abs(action.reward));
    mask ^= bit(std::ranges::max_element(actions, {}, &Action::reward)->connection);
  }
  if (most == 0) most = 1;
  return {2 * most, 2 * most};
}

/// `error`: greatest rounding error of a step.
template <class Numbers>
void conclude(const TransitionSystem& system, const Numbers& numbers,
              const typename Numbers::Value* values, double error, Result& result) {
  const std::size_t n = system.num_connections();
  const auto start = values[bit(n) - 1];
  if (start == Numbers::kNever) {
    result = detail::exhausted(kMethod, result.statistics);
    return;
  }
  roll_out(system, numbers, values, result);
  result.status = Status::Optimal;
  result.bound = result.reward;
  if constexpr (std::is_same_v<Numbers, FixedPoint>) {
    const auto steps = static_cast<double>(n);
    const double most = numbers.value(start) + steps * error;
    const double rounding = steps * std::numeric_limits<double>::epsilon() *
                            (steps * numbers.most_step + numbers.most_last);
    std::string unit = "1e" + std::to_string(std::lround(-std::log10(numbers.per_unit)));
    if (!std::isfinite(rounding) || most - result.reward > kRewardTolerance + rounding) {
      result.status = Status::Feasible;
      if (std::isfinite(most)) {
        result.bound = most;
      } else {
        result.bound.reset();
      }
      result.notes.push_back("values were rounded to multiples of " + unit +
                             ", to hold them in four bytes each; the bound allows for it");
    }
  }
}

template <class Numbers>
using Values = detail::GrowingArray<typename Numbers::Value>;

void solve_in_doubles(const TransitionSystem& system, const Budget& budget, const Blocks& blocks,
                      const std::optional<Forest>& forest, Result& result) {
  Values<Doubles> values;
  values.reserve(bit(system.num_connections()));
  values.resize(bit(system.num_connections()));
  const Doubles numbers;
  Sweep<Doubles> sweep(system, budget, blocks, forest, numbers, values.data());
  result.statistics.sweeps = 1;
  sweep.run(result.statistics.peak_bytes, result.statistics);
  result.stop = sweep.stop();
  if (result.stop == Stop::None) conclude(system, numbers, values.data(), 0, result);
}

void solve_in_fixed_point(const TransitionSystem& system, const Budget& budget,
                          const Blocks& blocks, const std::optional<Forest>& forest,
                          Result& result) {
  Values<FixedPoint> values;
  values.reserve(bit(system.num_connections()));
  values.resize(bit(system.num_connections()));
  const auto known = known_sizes(system);
  Sizes sizes = known ? *known : sampled_sizes(system);
  // Tenfold, a hundredfold, ten-thousandfold: a function of the problem alone, whichever thread met
  // the large reward.
  for (double factor = 10;; factor *= factor) {
    const FixedPoint numbers(system.num_connections(), sizes.step, sizes.last);
    Sweep<FixedPoint> sweep(system, budget, blocks, forest, numbers, values.data());
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
  return system.whole() && system.num_connections() <= kMostConnections &&
         dense_table_bytes(system, budget) <= static_cast<double>(allowed_bytes(budget));
}

bool dense_values_safe(const TransitionSystem& system) {
  return unconstrained(system) || !system.calls_out();
}

Result dense_value_iteration(const TransitionSystem& system,
                             const DenseValueIterationOptions& options, const Budget& budget) {
  const Stopwatch watch;
  if (auto result = detail::settled(system, kMethod)) return *result;
  if (!system.whole())
    throw InputError(
        "value-iteration: the table of all 2^n states begins with all connections open");
  const std::size_t n = system.num_connections();
  const bool doubles = takes_doubles(system, options, budget);
  const double needed = table_bytes(n, doubles);
  if (n > kMostConnections || needed > static_cast<double>(allowed_bytes(budget))) {
    throw InputError("value-iteration: a table of all 2^" + std::to_string(n) +
                     " states does not fit in the memory allowed");
  }
  Result result;
  result.method = kMethod;
  const Blocks blocks(n);
  const std::optional<Forest> forest = forest_of(system);
  result.statistics.peak_bytes = static_cast<std::uint64_t>(needed);
  result.statistics.states = bit(n);
  if (doubles) {
    solve_in_doubles(system, budget, blocks, forest, result);
  } else {
    solve_in_fixed_point(system, budget, blocks, forest, result);
  }
  if (result.stop != Stop::None)
    result = detail::stopped(system, kMethod, result.stop, result.statistics);
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
