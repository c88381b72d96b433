#include "orasp/cluster/cluster_value_iteration.h"

#include <algorithm>
#include <bit>
#include <new>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/parallel.h"
#include "orasp/model/error.h"
#include "orasp/planners/detail/dense_sizes.h"
#include "orasp/planners/detail/forest_blocks.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

using detail::bit;
using detail::dense_forest_of;
using detail::DenseForest;
using detail::Doubles;
using detail::FixedPoint;
using detail::ForestBlocks;
using detail::kMostDenseConnections;
using detail::Mask;

constexpr const char* kMethod = "value-iteration";
/// More connections are held in four bytes, as on one process.
constexpr std::size_t kMostConnectionsDouble = 28;
/// A block has so many states, or fewer where a slab has.
constexpr std::size_t kBlockBits = 13;
/// For so many blocks of each neighbour receipts are open.
constexpr std::size_t kAhead = 8;
/// A rank works out about so many blocks between two looks at what the other ranks say: the leading
/// rank is at most twice that far in front. Fewer where a block takes longer.
constexpr std::uint64_t kBlocksBetweenLooks = 64;
constexpr std::uint64_t kSlowBlocksBetweenLooks = 4;
/// Where the number of ranks is no power of two there are so many slabs for each, or up to twice as
/// many, so that the shares differ by a sixteenth at most.
constexpr std::size_t kSlabsOfRank = 16;

/// What a rank tells the others; below these, a bit for each Stop.
constexpr std::uint64_t kOverflow = 1U << 8U;
constexpr std::uint64_t kFault = 1U << 9U;
constexpr std::uint64_t kStops = kOverflow - 1;

std::uint64_t flag_of(Stop stop) {
  return stop == Stop::None ? 0 : std::uint64_t{1} << static_cast<unsigned>(stop);
}
Stop stop_of(std::uint64_t flags) {
  const std::uint64_t stops = flags & kStops;
  return stops == 0 ? Stop::None : static_cast<Stop>(std::countr_zero(stops));
}

/// How the table lies in the memory of the ranks.
struct Layout {
  std::size_t high = 0;              ///< bits of a mask that say which slab
  std::size_t low = 0;               ///< the others: which state of the slab
  std::size_t block_bits = 0;        ///< the low bits that make a block
  std::vector<std::uint32_t> owner;  ///< by slab: its rank

  /// A slab has `least_low` bits or more, where there are so many.
  Layout(std::size_t connections, std::size_t ranks, std::size_t least_low) {
    const std::size_t wanted = std::has_single_bit(ranks)
                                   ? static_cast<std::size_t>(std::countr_zero(ranks))
                                   : static_cast<std::size_t>(std::bit_width(kSlabsOfRank * ranks));
    high = std::min(wanted, connections - std::min(connections, least_low));
    low = connections - high;
    block_bits = std::min(low, kBlockBits);
    owner.resize(slabs());
    for (std::size_t r = 0; r < ranks; ++r) {
      const auto [begin, end] = detail::share_of(slabs(), ranks, r);
      std::fill(owner.begin() + static_cast<std::ptrdiff_t>(begin),
                owner.begin() + static_cast<std::ptrdiff_t>(end), static_cast<std::uint32_t>(r));
    }
  }

  [[nodiscard]] std::size_t slabs() const { return std::size_t{1} << high; }
  [[nodiscard]] Mask slab_size() const { return bit(low); }
  [[nodiscard]] Mask block_size() const { return bit(block_bits); }
  [[nodiscard]] std::uint64_t rounds() const { return bit(low - block_bits); }
  [[nodiscard]] std::vector<std::size_t> slabs_of(std::size_t rank) const {
    std::vector<std::size_t> mine;
    for (std::size_t s = 0; s < slabs(); ++s) {
      if (owner[s] == rank) mine.push_back(s);
    }
    return mine;
  }
  /// The other ranks that need the values of a slab.
  [[nodiscard]] std::vector<std::size_t> readers(std::size_t slab) const {
    std::vector<std::size_t> ranks;
    for (std::size_t c = 0; c < high; ++c) {
      const std::size_t above = slab | std::size_t{1} << c;
      if (above != slab && owner[above] != owner[slab]) ranks.push_back(owner[above]);
    }
    std::ranges::sort(ranks);
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
    return ranks;
  }
  /// The slabs of other ranks that a slab's values follow from.
  [[nodiscard]] std::vector<std::size_t> sources(std::size_t slab) const {
    std::vector<std::size_t> below;
    for (std::size_t c = 0; c < high; ++c) {
      const std::size_t source = slab & ~(std::size_t{1} << c);
      if (source != slab && owner[source] != owner[slab]) below.push_back(source);
    }
    return below;
  }
};

/// The slabs of one rank, and the blocks of its neighbours that are here.
template <class Numbers>
class Slabs {
 public:
  using Value = typename Numbers::Value;

  Slabs(const Layout& layout, Ranks& ranks)
      : layout_(layout), ranks_(ranks), mine_(layout.slabs_of(ranks.rank())) {
    for (const std::size_t slab : mine_) {
      sources_.push_back(layout.sources(slab));
      readers_.push_back(layout.readers(slab));
      foreign_.insert(foreign_.end(), sources_.back().begin(), sources_.back().end());
    }
    std::ranges::sort(foreign_);
    foreign_.erase(std::unique(foreign_.begin(), foreign_.end()), foreign_.end());
    ahead_ = std::min<std::uint64_t>(kAhead, layout.rounds());
  }

  [[nodiscard]] std::uint64_t bytes() const {
    return (mine_.size() * layout_.slab_size() + foreign_.size() * ahead_ * layout_.block_size()) *
           sizeof(Value);
  }
  /// @throws std::bad_alloc.
  void allocate() {
    values_.reserve(mine_.size() * layout_.slab_size());
    values_.resize(mine_.size() * layout_.slab_size());
    buffers_.reserve(foreign_.size() * ahead_ * layout_.block_size());
    buffers_.resize(foreign_.size() * ahead_ * layout_.block_size());
    places_.assign(layout_.slabs(), {});
    for (std::size_t i = 0; i < mine_.size(); ++i)
      places_[mine_[i]] = {values_.data() + i * layout_.slab_size(), layout_.slab_size() - 1};
  }

  [[nodiscard]] std::span<const std::size_t> mine() const { return mine_; }

  /// The place of a value: of a state of this rank, or of one in a block that is here.
  [[nodiscard]] Value* at(Mask mask) const {
    const Place& place = places_[mask >> layout_.low];
    return place.values + (mask & place.low);
  }

  /// Opens the receipts of the first blocks.
  void begin() {
    tickets_.assign(foreign_.size() * ahead_, 0);
    arrived_.assign(foreign_.size(), 0);
    for (std::uint64_t round = 0; round < ahead_; ++round) receive(round);
    open_ = ahead_;
  }
  /// Waits for the blocks of other ranks that a block of the i-th slab needs.
  void await(std::size_t i, std::uint64_t round) {
    for (const std::size_t source : sources_[i]) {
      const auto f =
          static_cast<std::size_t>(std::ranges::lower_bound(foreign_, source) - foreign_.begin());
      if (arrived_[f] > round) continue;
      const std::size_t slot = f * ahead_ + round % ahead_;
      ranks_.wait(tickets_[slot]);
      arrived_[f] = round + 1;
      places_[source] = {buffers_.data() + slot * layout_.block_size(), layout_.block_size() - 1};
    }
  }
  /// Sends the block of the i-th slab to those who need it.
  void pass_on(std::size_t i, std::uint64_t round) {
    const Value* const block =
        values_.data() + i * layout_.slab_size() + round * layout_.block_size();
    for (const std::size_t reader : readers_[i])
      ranks_.send(reader, std::as_bytes(std::span(block, layout_.block_size())));
  }
  /// After a round: its buffers are free again.
  void end_round(std::uint64_t round) {
    if (round + ahead_ < layout_.rounds()) receive(round + ahead_);
    ++open_;
  }
  /// Ends the exchange before `round`, at which all ranks ended.
  void end(std::uint64_t round) {
    for (; round < layout_.rounds() && round < open_; ++round) {
      for (std::size_t f = 0; f < foreign_.size(); ++f)
        ranks_.cancel(tickets_[f * ahead_ + round % ahead_]);
    }
    ranks_.finish_sends();
  }

  /// What this rank knows of a value, as a double; -infinity where it is another's, or never.
  [[nodiscard]] double known(const Numbers& numbers, Mask mask) const {
    if (layout_.owner[mask >> layout_.low] != ranks_.rank()) return -kInfinity;
    const Value value = *at(mask);
    return value == Numbers::kNever ? -kInfinity : numbers.value(value);
  }

 private:
  struct Place {
    Value* values = nullptr;
    Mask low = 0;
  };

  void receive(std::uint64_t round) {
    for (std::size_t f = 0; f < foreign_.size(); ++f) {
      const std::size_t slot = f * ahead_ + round % ahead_;
      tickets_[slot] =
          ranks_.receive(layout_.owner[foreign_[f]],
                         std::as_writable_bytes(std::span(
                             buffers_.data() + slot * layout_.block_size(), layout_.block_size())));
    }
  }

  const Layout& layout_;
  Ranks& ranks_;
  std::vector<std::size_t> mine_;
  std::vector<std::vector<std::size_t>> sources_;
  std::vector<std::vector<std::size_t>> readers_;
  /// All sources, ascending: the order in which their rank sends the blocks of a round.
  std::vector<std::size_t> foreign_;
  std::uint64_t ahead_ = 0;
  detail::GrowingArray<Value> values_;
  detail::GrowingArray<Value> buffers_;
  std::vector<Place> places_;
  std::vector<Ranks::Ticket> tickets_;
  std::vector<std::uint64_t> arrived_;
  std::uint64_t open_ = 0;
};

/// One pass over the states of a rank.
template <class Numbers>
class Pass {
 public:
  using Value = typename Numbers::Value;

  Pass(const TransitionSystem& system, const std::optional<DenseForest>& forest,
       const Budget& budget, const Layout& layout, const Numbers& numbers, Slabs<Numbers>& slabs,
       Ranks& ranks)
      : system_(system),
        budget_(budget),
        layout_(layout),
        numbers_(numbers),
        slabs_(slabs),
        ranks_(ranks),
        expander_(system) {
    if (!forest) return;
    forest_.emplace(*forest, system, numbers);
    error_ = forest_->error();
  }

  /// @returns the flags of all ranks: 0 where the pass is whole.
  std::uint64_t run(std::uint64_t bytes, Statistics& statistics) {
    const std::uint64_t blocks = forest_ ? kBlocksBetweenLooks : kSlowBlocksBetweenLooks;
    const std::uint64_t between_looks =
        std::max<std::uint64_t>(1, blocks * ranks_.size() / layout_.slabs());
    slabs_.begin();
    std::uint64_t round = 0;
    std::uint64_t united = 0;
    for (; round < layout_.rounds(); ++round) {
      if (round % between_looks == 0) {
        if (round > 0) united = ranks_.finish_union();
        if (united != 0) break;
        flags_ |= flag_of(budget_.expired(bytes, statistics.expanded));
        ranks_.start_union(flags_);
        report(round);
      }
      for (std::size_t i = 0; i < slabs_.mine().size(); ++i) {
        slabs_.await(i, round);
        // What is at fault is sent on as it is: all ranks end before anybody uses it.
        if (flags_ == 0)
          work_out(slabs_.mine()[i] * layout_.slab_size() + round * layout_.block_size());
        slabs_.pass_on(i, round);
      }
      slabs_.end_round(round);
      if (flags_ == 0) statistics.expanded += slabs_.mine().size() * layout_.block_size();
    }
    if (united == 0) {
      united = ranks_.finish_union();
      ranks_.start_union(flags_);
      united |= ranks_.finish_union();
    }
    slabs_.end(round);
    report(round);
    if (united == 0) statistics.generated += forest_ ? forest_generated() : generated_;
    return united;
  }

  [[nodiscard]] double error() const { return error_; }
  [[nodiscard]] const std::string& fault() const { return fault_; }

 private:
  void report(std::uint64_t round) const {
    const std::uint64_t total = bit(layout_.high + layout_.low);
    budget_.report({.phase = "values of all states",
                    .done = total / layout_.rounds() * round,
                    .total = total,
                    .states = total});
  }

  // In a forest without constraints every open connection is an action.
  [[nodiscard]] std::uint64_t forest_generated() const {
    std::uint64_t open = 0;
    for (const std::size_t slab : slabs_.mine()) {
      open += layout_.slab_size() * static_cast<std::uint64_t>(std::popcount(slab)) +
              layout_.slab_size() / 2 * layout_.low;
    }
    return open;
  }

  void work_out(Mask first) {
    const auto at = [this](Mask mask) { return slabs_.at(mask); };
    if (forest_) {
      forest_->work_out_at(first, layout_.block_size(), at);
      return;
    }
    masks_.resize(layout_.block_size());
    std::iota(masks_.begin(), masks_.end(), first);
    try {
      expander_.for_each_expansion(masks_, [&](std::size_t i, std::span<const Action> actions) {
        const Mask mask = first + i;
        const bool completes = std::has_single_bit(mask);
        Value best = mask == 0 ? Value{} : Numbers::kNever;
        for (const Action& action : actions) {
          if (!numbers_.holds(action.reward, completes)) {
            flags_ |= kOverflow;
            return;
          }
          error_ = std::max(error_, numbers_.error(action.reward));
          best = std::max(best, Numbers::plus(numbers_.rounded(action.reward),
                                              *at(mask ^ bit(action.connection))));
        }
        generated_ += actions.size();
        *at(mask) = best;
      });
    } catch (const InputError& error) {
      flags_ |= kFault;
      fault_ = error.what();
    }
  }

  const TransitionSystem& system_;
  const Budget& budget_;
  const Layout& layout_;
  const Numbers& numbers_;
  Slabs<Numbers>& slabs_;
  Ranks& ranks_;
  Expander expander_;
  std::optional<ForestBlocks<Numbers>> forest_;
  std::vector<Mask> masks_;
  std::uint64_t flags_ = 0;
  std::string fault_;
  double error_ = 0;
  std::uint64_t generated_ = 0;
};

/// Throws, on every rank, the first fault that a rank has; nothing where none has.
void throw_first(const std::string& mine, Ranks& ranks) {
  std::string first;
  for (std::string& fault : ranks.gather(mine)) {
    if (first.empty()) first = std::move(fault);
  }
  first = ranks.broadcast(std::move(first), 0);
  if (!first.empty()) throw InputError(first);
}

/// Follows the best actions from the start, on all ranks in step: each tells the values it holds.
template <class Numbers>
void roll_out(const TransitionSystem& system, const Numbers& numbers, const Slabs<Numbers>& slabs,
              Ranks& ranks, Result& result) {
  Expander expander(system);
  std::vector<double> left;
  result.reward = 0;
  for (Mask mask = bit(system.num_connections()) - 1; mask != 0;) {
    const auto actions = expander.legal_actions(SetView(&mask, 1));
    left.clear();
    for (const Action& action : actions)
      left.push_back(slabs.known(numbers, mask ^ bit(action.connection)));
    ranks.take_greatest(left);
    const Action* best = nullptr;
    double most = 0;
    for (std::size_t i = 0; i < actions.size(); ++i) {
      if (left[i] == -kInfinity) continue;
      const double sum = actions[i].reward + left[i];
      if (best != nullptr && !(sum > most)) continue;
      best = &actions[i];
      most = sum;
    }
    result.sequence.push_back(best->connection);
    result.reward += best->reward;
    mask ^= bit(best->connection);
  }
}

/// What a rank of a machine may take.
std::uint64_t allowed_bytes_of_rank(const Budget& budget, const Ranks& ranks) {
  return std::min(budget.max_bytes, allowed_bytes(Budget{}) / ranks.on_this_machine());
}

std::string mebibytes(std::uint64_t bytes) {
  return std::to_string((bytes + (std::uint64_t{1} << 20U) - 1) >> 20U) + " MiB";
}

template <class Numbers>
void require_memory(Slabs<Numbers>& slabs, const Budget& budget, Ranks& ranks) {
  const std::string who = "value-iteration: rank " + std::to_string(ranks.rank()) + " on " +
                          ranks.machine() + " needs " + mebibytes(slabs.bytes()) +
                          " for its share of the table, and ";
  std::string fault;
  const std::uint64_t allowed = allowed_bytes_of_rank(budget, ranks);
  if (slabs.bytes() > allowed) {
    fault = who + mebibytes(allowed) + " are allowed a rank: start more ranks, on more machines";
  } else {
    try {
      slabs.allocate();
    } catch (const std::bad_alloc&) {
      fault = who + "cannot get it";
    }
  }
  throw_first(fault, ranks);
}

/// The value of the start, on every rank.
template <class Numbers>
typename Numbers::Value value_of_start(const Slabs<Numbers>& slabs, const Layout& layout,
                                       std::size_t connections, Ranks& ranks) {
  using Value = typename Numbers::Value;
  const Mask start = bit(connections) - 1;
  std::vector<double> value = {-kInfinity};
  // A value of either number system is a double as it is.
  if (layout.owner[start >> layout.low] == ranks.rank())
    value[0] = static_cast<double>(*slabs.at(start));
  ranks.take_greatest(value);
  return static_cast<Value>(value[0]);
}

template <class Numbers, class NextNumbers>
void solve(const TransitionSystem& system, const Budget& budget, const Layout& layout,
           const std::optional<DenseForest>& forest, Ranks& ranks, NextNumbers next_numbers,
           Result& result) {
  Slabs<Numbers> slabs(layout, ranks);
  require_memory(slabs, budget, ranks);
  result.statistics.peak_bytes = slabs.bytes();
  for (;;) {
    const Numbers numbers = next_numbers();
    Pass<Numbers> pass(system, forest, budget, layout, numbers, slabs, ranks);
    ++result.statistics.sweeps;
    const std::uint64_t flags = pass.run(result.statistics.peak_bytes, result.statistics);
    if ((flags & kFault) != 0) throw_first(pass.fault(), ranks);
    result.stop = stop_of(flags);
    if (result.stop != Stop::None) return;
    if ((flags & kOverflow) != 0) continue;
    const auto start = value_of_start(slabs, layout, system.num_connections(), ranks);
    if (start == Numbers::kNever) {
      result = detail::exhausted(kMethod, result.statistics);
      return;
    }
    roll_out(system, numbers, slabs, ranks, result);
    std::vector<double> error = {pass.error()};
    ranks.take_greatest(error);
    detail::judge_dense(numbers, system.num_connections(), start, error[0], result);
    return;
  }
}

/// What the ranks counted together, and what they sent.
void count_together(Ranks& ranks, std::uint64_t sent_before, Result& result) {
  Statistics& statistics = result.statistics;
  std::vector<std::uint64_t> sums = {statistics.expanded, statistics.generated,
                                     ranks.bytes_sent() - sent_before};
  ranks.take_sums(sums);
  statistics.expanded = sums[0];
  statistics.generated = sums[1];
  std::vector<double> most = {static_cast<double>(statistics.peak_bytes)};
  ranks.take_greatest(most);
  statistics.peak_bytes = static_cast<std::uint64_t>(most[0]);
  result.notes.push_back("the table lay on " + std::to_string(ranks.size()) + " ranks, with " +
                         std::to_string(statistics.peak_bytes) + " bytes on the fullest; " +
                         std::to_string(sums[2]) + " bytes of values were sent between them");
}

Layout layout_of(std::size_t connections, std::size_t ranks, bool forest) {
  return {connections, ranks, forest ? detail::kLaneBits : 0};
}

}  // namespace

std::uint64_t cluster_values_sent(std::size_t connections, std::size_t ranks) {
  const Layout layout = layout_of(connections, ranks, connections >= detail::kLaneBits);
  std::uint64_t sent = 0;
  for (std::size_t slab = 0; slab < layout.slabs(); ++slab)
    sent += layout.readers(slab).size() * layout.slab_size();
  return sent;
}

std::optional<std::string> cluster_values_obstacle(const TransitionSystem& system) {
  if (system.problem().uncertain())
    return "holds no values for attempts that may fail in a table on several ranks";
  if (system.wide())
    return "holds no values in a table on several ranks where there is a goal or a cost between "
           "steps";
  if (!dense_values_safe(system))
    return "would ask a formula for rewards of states that no plan reaches, in a table on several "
           "ranks";
  if (!system.whole())
    return "has a table on several ranks for the whole of a product, not for what is left";
  return std::nullopt;
}

Result cluster_value_iteration(const TransitionSystem& system,
                               const DenseValueIterationOptions& options, const Budget& budget,
                               Ranks& ranks) {
  const Stopwatch watch;
  if (const auto reason = cluster_values_obstacle(system)) throw Refusal(kMethod, *reason);
  if (auto result = detail::infeasible_at_once(system, kMethod)) return *result;
  const std::size_t n = system.num_connections();
  if (n > kMostDenseConnections)
    throw InputError("value-iteration: a table of all 2^" + std::to_string(n) +
                     " states is too large for any number of ranks");
  const std::optional<DenseForest> forest = dense_forest_of(system);
  // A slab has at least as many bits as a vector has lanes where the forest's code may be used.
  const Layout layout = layout_of(n, ranks.size(), n >= detail::kLaneBits);

  using Option = DenseValueIterationOptions::Values;
  bool doubles = options.values == Option::Double;
  if (options.values == Option::Automatic) {
    // As on one process, each by its own memory; where one cannot, none does.
    const bool fits = n <= kMostConnectionsDouble && Slabs<Doubles>(layout, ranks).bytes() <=
                                                         allowed_bytes_of_rank(budget, ranks) / 2;
    ranks.start_union(fits ? 0 : 1);
    doubles = ranks.finish_union() == 0;
  }

  Result result;
  result.method = kMethod;
  result.statistics.states = bit(n);
  const std::uint64_t sent_before = ranks.bytes_sent();
  if (doubles) {
    solve<Doubles>(
        system, budget, layout, forest, ranks, [] { return Doubles(); }, result);
  } else {
    // As on one process: where a reward turns out too large, all begins again with ten, a hundred,
    // ten thousand times the size.
    detail::RewardSizes sizes = detail::reward_sizes(system);
    double factor = 1;
    const auto next = [&] {
      const FixedPoint numbers(n, sizes.step, sizes.last);
      factor = factor == 1 ? 10 : factor * factor;
      sizes.step = sizes.last = factor * std::max(numbers.most_step, numbers.most_last);
      return numbers;
    };
    solve<FixedPoint>(system, budget, layout, forest, ranks, next, result);
  }
  count_together(ranks, sent_before, result);
  if (result.stop != Stop::None && ranks.rank() == 0) {
    std::vector<std::string> notes = std::move(result.notes);
    result = detail::stopped_with_quick_plan(system, kMethod, result.stop, result.statistics);
    result.notes.insert(result.notes.end(), notes.begin(), notes.end());
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
