#include <algorithm>
#include <atomic>
#include <numeric>

#include "orasp/containers/parallel.h"
#include "orasp/containers/state_table.h"
#include "orasp/containers/subset_rank.h"
#include "orasp/graph/state_graph.h"
#include "orasp/graph/wide_graph_builder.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// So many states are expanded between two looks at the clock.
constexpr std::size_t kPollEvery = 4096;
/// A layer with fewer states is left to one thread.
constexpr std::size_t kParallelFrom = 2048;
/// With so many actions, the part of the hash table that a shard needs stays in the second-level
/// cache.
constexpr std::size_t kActionsPerShard = 65'536;
constexpr std::size_t kMostShards = 256;
/// A table of so many subsets costs nothing, however few of them are reached.
constexpr std::uint64_t kAlwaysRanked = 4096;

/// How many shards a layer with so many actions is merged in: a function of the layer alone, so
/// that the numbering of states does not depend on the number of threads.
std::size_t shards_for(std::size_t actions) {
  return std::min(kMostShards, std::bit_ceil(actions / kActionsPerShard + 1));
}

}  // namespace

// Each layer is expanded (each thread takes a run of its states and writes down connections and
// rewards), then its successors are merged into the next layer in one of two ways.
//
// By rank, where the reached states are a fair part of all subsets of their size: a table over the
// subsets' ranks (containers/subset_rank.h) marks those that occur, is counted through, and
// translates ranks into numbers. No hashing, and without constraints not even a miss.
//
// By hash elsewhere, in passes that each run in parallel: scatter the successors' keys to one list
// for each shard; number each shard's keys, in the order of the layer, in a hash table of its own,
// small enough for the cache; gather the numbers back into the rows. Radix partitioning: Shatdal,
// Kant, Naughton (1994), VLDB, 510-521. kWords as in StateTable.
template <std::size_t kWords>
class StateGraphBuilder {
 public:
  StateGraphBuilder(const TransitionSystem& system, const Budget& budget)
      : graph_(system),
        budget_(budget),
        allowed_(allowed_bytes(budget)),
        words_(system.words()),
        narrow_(system.num_connections() <= 256),
        threads_(std::max(1U, budget.threads)) {}

  StateGraph build() {
    grow();
    graph_.peak_bytes_ = std::max(peak_, graph_.bytes());
    return std::move(graph_);
  }

 private:
  using Table = detail::StateTable<kWords>;

  /// What one thread found out about its run of states.
  struct Run {
    explicit Run(const TransitionSystem& system) : expander(system) {}
    Expander expander;
    detail::GrowingArray<std::uint16_t> connections;
    detail::GrowingArray<std::uint32_t> reward_numbers;
    /// The rewards themselves; used instead of their numbers once there are too many to number.
    detail::GrowingArray<double> reward_values;
    detail::ValueNumbers values;
    /// The keys of the successors that fall to each shard, and the numbers that the shard gave
    /// them.
    std::vector<detail::GrowingArray<std::uint64_t>> keys;
    std::vector<detail::GrowingArray<StateId>> numbers;
    /// The shard that the successor of each action falls to.
    detail::GrowingArray<std::uint8_t> shards;
  };

  void grow() {
    const TransitionSystem& system = *graph_.system_;
    const ConnectionSet start = system.start();
    reserve_address_space();
    graph_.states_.resize(words_);
    std::ranges::copy(start.view(), graph_.states_.data());
    graph_.row_begin_.push_back(0);
    graph_.layer_begin_ = {0, 1};
    std::vector<Run> runs;
    for (std::size_t layer = 0; layer < graph_.num_layers(); ++layer) {
      const std::size_t begin = graph_.layer_begin_[layer];
      const std::size_t size = graph_.layer_begin_[layer + 1] - begin;
      const std::size_t threads = size < kParallelFrom ? 1 : threads_;
      while (runs.size() < threads) runs.emplace_back(system);
      graph_.row_begin_.resize(begin + size + 1);
      stop_ = expired(memory(runs));
      if (stop_ == Stop::None) {
        expand(runs, begin, size, system.num_steps() - layer, threads);
      }
      if (stop_ == Stop::None) append_rows(runs, begin, size, threads);
      if (stop_ == Stop::None && graph_.row_begin_[begin + size] > graph_.row_begin_[begin]) {
        const std::size_t left = system.num_steps() - layer;
        const std::size_t actions = graph_.row_begin_[begin + size] - graph_.row_begin_[begin];
        if (kWords == 1 &&
            ranks_.subsets(system.num_connections(), left - 1) <= 2 * actions + kAlwaysRanked) {
          merge_by_rank(begin, size, left - 1, threads);
        } else {
          merge_by_hash(runs, begin, size, threads);
        }
      }
      if (stop_ != Stop::None) {
        leave_unexpanded(begin);
        break;
      }
      budget_.report({.phase = "building H",
                      .done = layer + 1,
                      .total = system.num_steps() + 1,
                      .states = graph_.num_states()});
    }
    graph_.stop_ = stop_;
    runs.clear();
    graph_.states_.shrink_to_fit();
    graph_.row_begin_.shrink_to_fit();
    graph_.successors_.shrink_to_fit();
    graph_.narrow_connections_.shrink_to_fit();
    graph_.wide_connections_.shrink_to_fit();
    graph_.rewards_.shrink_to_fit();
  }

  // Takes room for all of H at once where H cannot become large. Pages are only taken when they are
  // touched, and the system gives huge pages to an array that never moves.
  void reserve_address_space() {
    const std::size_t steps = graph_.system_->num_steps();
    if (steps > 24) return;
    const std::size_t states = std::size_t{1} << steps;
    const std::size_t actions = states / 2 * steps;
    graph_.states_.reserve(states);
    graph_.row_begin_.reserve(states + 1);
    graph_.successors_.reserve(actions);
    graph_.narrow_connections_.reserve(actions);
    graph_.rewards_.reserve(actions);
  }

  // Writes the actions of the layer from state `begin` on to `runs`, and their number for each
  // state to the graph.
  void expand(std::vector<Run>& runs, std::size_t begin, std::size_t size, std::size_t most_actions,
              std::size_t threads) {
    const bool numbered = graph_.rewards_.numbered();
    std::atomic<bool> give_up = false;
    std::atomic<Stop> reason = Stop::None;
    std::atomic<std::uint64_t> bytes = memory(runs);
    std::atomic<std::uint64_t> actions_found = 0;
    detail::run_parallel(threads, [&](std::size_t t) {
      Run& run = runs[t];
      run.connections.clear();
      run.reward_numbers.clear();
      run.reward_values.clear();
      const auto [first, last] = detail::share_of(size, threads, t);
      std::uint64_t counted = 0;
      std::uint64_t counted_actions = 0;
      for (std::size_t chunk = first; chunk < last && !give_up; chunk += kPollEvery) {
        const std::size_t states = std::min(kPollEvery, last - chunk);
        std::size_t next = run.connections.size();
        run.connections.resize(next + states * most_actions);
        (numbered ? run.reward_numbers.resize(next + states * most_actions)
                  : run.reward_values.resize(next + states * most_actions));
        const auto keys = graph_.states_.span().subspan((begin + chunk) * words_, states * words_);
        run.expander.for_each_expansion(keys, [&](std::size_t i, std::span<const Action> actions) {
          graph_.row_begin_[begin + chunk + i + 1] = actions.size();
          for (const Action& action : actions) {
            run.connections[next] = static_cast<std::uint16_t>(action.connection);
            if (numbered) {
              run.reward_numbers[next] = run.values.number(action.reward);
            } else {
              run.reward_values[next] = action.reward;
            }
            ++next;
          }
        });
        run.connections.resize(next);
        (numbered ? run.reward_numbers.resize(next) : run.reward_values.resize(next));

        const std::uint64_t now =
            run.connections.bytes() + run.reward_numbers.bytes() + run.reward_values.bytes();
        bytes += now - counted;
        counted = now;
        // Each action will take its row, the key of its successor and the number of that key.
        actions_found += next - counted_actions;
        counted_actions = next;
        const std::uint64_t coming = actions_found * (8 * words_ + 16);
        if (const Stop stop = expired(bytes + coming); stop != Stop::None) {
          reason = stop;
          give_up = true;
        }
      }
    });
    stop_ = reason;
  }

  // Turns the lengths of the rows into their begins, and moves connections and rewards to their
  // place in the graph.
  void append_rows(std::vector<Run>& runs, std::size_t begin, std::size_t size,
                   std::size_t threads) {
    const auto rows = graph_.row_begin_.span().subspan(begin, size + 1);
    std::partial_sum(rows.begin(), rows.end(), rows.begin());
    const bool were_numbered = graph_.rewards_.numbered();
    std::vector<std::vector<std::uint32_t>> numbers;
    for (std::size_t t = 0; t < threads; ++t)
      numbers.push_back(graph_.rewards_.admit(runs[t].values.values()));
    const std::size_t actions = rows.back() - rows.front();
    graph_.rewards_.extend(actions);
    graph_.successors_.resize(rows.back());
    if (narrow_) {
      graph_.narrow_connections_.resize(rows.back());
    } else {
      graph_.wide_connections_.resize(rows.back());
    }
    detail::run_parallel(threads, [&](std::size_t t) {
      Run& run = runs[t];
      const std::size_t at = rows[detail::share_of(size, threads, t).begin];
      if (narrow_) {
        std::ranges::transform(run.connections.span(), graph_.narrow_connections_.data() + at,
                               [](std::uint16_t c) { return static_cast<std::uint8_t>(c); });
      } else {
        std::ranges::copy(run.connections.span(), graph_.wide_connections_.data() + at);
      }
      for (std::size_t i = 0; i < run.connections.size(); ++i) {
        if (graph_.rewards_.numbered()) {
          graph_.rewards_.set_number(at + i, numbers[t][run.reward_numbers[i]]);
        } else {
          graph_.rewards_.set_value(at + i, were_numbered
                                                ? run.values.values()[run.reward_numbers[i]]
                                                : run.reward_values[i]);
        }
      }
    });
    peak_ = std::max(peak_, memory(runs));
  }

  // Numbers the successors of a layer by hashing them, and makes them the next layer.
  void merge_by_hash(std::vector<Run>& runs, std::size_t begin, std::size_t size,
                     std::size_t threads) {
    const auto rows = graph_.row_begin_.span().subspan(begin, size + 1);
    const std::size_t actions = rows.back() - rows.front();
    const std::size_t shards = shards_for(actions);
    const unsigned shift = 64U - static_cast<unsigned>(std::countr_zero(shards));
    while (tables_.size() < shards) tables_.emplace_back(words_);
    const std::span<Table> tables = std::span(tables_).first(shards);

    detail::run_parallel(threads, [&](std::size_t t) {
      Run& run = runs[t];
      run.keys.resize(std::max(run.keys.size(), shards));
      run.numbers.resize(run.keys.size());
      for (auto& keys : run.keys) keys.clear();
      run.shards.resize(run.connections.size());
      const Table hasher(words_);
      std::vector<std::uint64_t> key(words_);
      const auto [first, last] = detail::share_of(size, threads, t);
      std::size_t a = 0;
      for (std::size_t i = first; i < last; ++i) {
        const SetView state = graph_.state(static_cast<StateId>(begin + i));
        for (std::size_t left = rows[i + 1] - rows[i]; left > 0; --left, ++a) {
          const ConnectionIndex c = run.connections[a];
          std::ranges::copy(state, key.begin());
          key[c / 64] &= ~(std::uint64_t{1} << (c % 64));
          const std::size_t shard = shards == 1 ? 0 : hasher.hash(key.data()) >> shift;
          run.shards[a] = static_cast<std::uint8_t>(shard);
          for (std::size_t w = 0; w < Table::words(words_); ++w) run.keys[shard].push_back(key[w]);
        }
      }
    });
    peak_ = std::max(peak_, memory(runs));

    detail::run_parallel(threads, [&](std::size_t t) {
      for (std::size_t shard = t; shard < shards; shard += threads) {
        Table& table = tables[shard];
        table.clear();
        for (std::size_t r = 0; r < threads; ++r) {
          const auto keys = runs[r].keys[shard].span();
          auto& numbers = runs[r].numbers[shard];
          numbers.resize(keys.size() / words_);
          for (std::size_t k = 0; k < numbers.size(); ++k)
            numbers[k] = table.insert(&keys[k * words_]).number;
        }
      }
    });
    std::uint64_t table_bytes = 0;
    for (const Table& table : tables) table_bytes += table.bytes();
    peak_ = std::max(peak_, memory(runs) + table_bytes);

    std::vector<std::uint64_t> first_number(shards + 1, begin + size);
    for (std::size_t s = 0; s < shards; ++s)
      first_number[s + 1] = first_number[s] + tables[s].size();
    if (first_number.back() > StateGraph::kMostStates) {
      stop_ = Stop::MemoryLimit;
      return;
    }
    graph_.states_.resize(first_number.back() * words_);
    detail::run_parallel(threads, [&](std::size_t t) {
      for (std::size_t shard = t; shard < shards; shard += threads) {
        std::ranges::copy(tables[shard].keys(),
                          graph_.states_.data() + first_number[shard] * words_);
      }
      Run& run = runs[t];
      std::vector<const StateId*> next(shards);
      for (std::size_t s = 0; s < shards; ++s) next[s] = run.numbers[s].data();
      StateId* const to =
          graph_.successors_.data() + rows[detail::share_of(size, threads, t).begin];
      for (std::size_t a = 0; a < run.shards.size(); ++a) {
        const std::size_t shard = run.shards[a];
        to[a] = static_cast<StateId>(first_number[shard] + *next[shard]++);
      }
    });
    graph_.layer_begin_.push_back(static_cast<StateId>(first_number.back()));
  }

  // Does the same by a table of all subsets of `left` connections.
  void merge_by_rank(std::size_t begin, std::size_t size, std::size_t left, std::size_t threads) {
    const auto rows = graph_.row_begin_.span().subspan(begin, size + 1);
    const std::size_t subsets = ranks_.subsets(graph_.system_->num_connections(), left);
    table_.resize(subsets);
    std::ranges::fill(table_.span(), 0U);
    StateId* const successors = graph_.successors_.data();
    detail::run_parallel(threads, [&](std::size_t t) {
      const auto [first, last] = detail::share_of(size, threads, t);
      std::uint64_t a = rows[first];
      for (std::size_t i = first; i < last; ++i) {
        const std::uint64_t end = rows[i + 1];
        ranks_.for_each_without(graph_.states_[begin + i], [&](std::uint8_t c, std::uint64_t rank) {
          if (a == end || graph_.narrow_connections_[a] != c) return;
          successors[a++] = static_cast<StateId>(rank);
          std::atomic_ref(table_[rank]).store(1, std::memory_order_relaxed);
        });
      }
    });
    auto number = static_cast<std::uint64_t>(begin + size);
    const std::uint64_t first_number = number;
    const auto reached = static_cast<std::uint64_t>(std::ranges::count(table_.span(), StateId{1}));
    if (number + reached > StateGraph::kMostStates) {
      stop_ = Stop::MemoryLimit;
      return;
    }
    graph_.states_.resize(number + reached);
    std::uint64_t subset = detail::SubsetRank::first(left);
    for (StateId& entry : table_.span()) {
      if (entry != 0) {
        graph_.states_[number] = subset;
        entry = static_cast<StateId>(number++);
      }
      subset = detail::SubsetRank::next(subset);
    }
    detail::run_parallel(threads, [&](std::size_t t) {
      const auto [first, last] = detail::share_of(size, threads, t);
      if (reached == subsets) {
        for (std::uint64_t a = rows[first]; a < rows[last]; ++a)
          successors[a] += static_cast<StateId>(first_number);
      } else {
        for (std::uint64_t a = rows[first]; a < rows[last]; ++a)
          successors[a] = table_[successors[a]];
      }
    });
    graph_.layer_begin_.push_back(static_cast<StateId>(number));
  }

  // Leaves the states from `begin` on without actions.
  void leave_unexpanded(std::size_t begin) {
    const std::uint64_t actions = graph_.row_begin_[begin];
    graph_.row_begin_.resize(graph_.num_states() + 1);
    std::ranges::fill(graph_.row_begin_.span().subspan(begin), actions);
    graph_.successors_.resize(actions);
  }

  [[nodiscard]] Stop expired(std::uint64_t bytes) const {
    return bytes > allowed_ ? Stop::MemoryLimit : budget_.expired(bytes, graph_.num_states());
  }

  [[nodiscard]] std::uint64_t memory(const std::vector<Run>& runs) const {
    std::uint64_t sum = graph_.bytes() + table_.bytes();
    for (const Run& run : runs) {
      sum += run.connections.bytes() + run.reward_numbers.bytes() + run.reward_values.bytes() +
             run.shards.bytes();
      for (const auto& keys : run.keys) sum += keys.bytes();
      for (const auto& numbers : run.numbers) sum += numbers.bytes();
    }
    return sum;
  }

  StateGraph graph_;
  const Budget& budget_;
  std::uint64_t allowed_;
  std::size_t words_;
  bool narrow_;
  std::size_t threads_;
  Stop stop_ = Stop::None;
  std::uint64_t peak_ = 0;
  /// The hash table of each shard.
  std::vector<Table> tables_;
  detail::SubsetRank ranks_;
  /// By the rank of a subset: first whether it occurs, then its number in the graph.
  detail::GrowingArray<StateId> table_;
};

StateGraph StateGraph::build(const TransitionSystem& system, const Budget& budget) {
  if (system.wide()) return WideGraphBuilder(system, budget).build();
  return system.words() == 1 ? StateGraphBuilder<1>(system, budget).build()
                             : StateGraphBuilder<0>(system, budget).build();
}

}  // namespace orasp
