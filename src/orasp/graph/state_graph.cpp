#include "orasp/graph/state_graph.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "orasp/bounds/bounds.h"
#include "orasp/containers/parallel.h"
#include "orasp/containers/state_table.h"
#include "orasp/containers/subset_rank.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

constexpr std::uint64_t kMostStates = std::numeric_limits<StateId>::max() - 1;
constexpr std::size_t kPollEvery = 4096;     // states between looks at the clock
constexpr std::size_t kParallelFrom = 2048;  // states of a layer worth a second thread
constexpr std::size_t kActionsPerShard =
    65'536;  // a shard's part of the hash table stays in the second-level cache
constexpr std::size_t kMostShards = 256;
constexpr std::uint64_t kAlwaysRanked = 4096;  // a table of so many subsets costs nothing

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
// subsets' ranks (detail/subset_rank.h) marks those that occur, is counted through, and translates
// ranks into numbers. No hashing, and without constraints not even a miss.
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
    detail::GrowingArray<double> reward_values;  ///< instead, once rewards are too many to number
    detail::ValueNumbers values;
    std::vector<detail::GrowingArray<std::uint64_t>> keys;  ///< by shard
    std::vector<detail::GrowingArray<StateId>> numbers;     ///< by shard, answers to keys
    detail::GrowingArray<std::uint8_t> shards;              ///< by action
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

  // Where H cannot become large, room for all of it at once: pages are only taken when they are
  // touched, and an array that never moves is served with huge ones.
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
        // Still to come for each action: its row, its successor's key and the key's number.
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

  // Row lengths become row begins; connections and rewards move to their place.
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
    if (first_number.back() > kMostStates) {
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
    if (number + reached > kMostStates) {
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

  // Keeps the states from `begin` on without their actions.
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
  std::vector<Table> tables_;  ///< by shard
  detail::SubsetRank ranks_;
  detail::GrowingArray<StateId> table_;  ///< by rank of a subset
};

StateGraph StateGraph::build(const TransitionSystem& system, const Budget& budget) {
  return system.words() == 1 ? StateGraphBuilder<1>(system, budget).build()
                             : StateGraphBuilder<0>(system, budget).build();
}

StateGraph::Reweighed StateGraph::reweigh(const TransitionSystem& system, const Budget& budget) {
  if (system.num_connections() != system_->num_connections() ||
      !(system.start() == system_->start()) ||
      system.problem().direction() != system_->problem().direction())
    return Reweighed::Differs;
  struct Run {
    explicit Run(const TransitionSystem& of) : expander(of) {}
    Expander expander;
    detail::ValueNumbers values;
    std::vector<std::uint32_t> numbers;  ///< of the rewards of one block, in `values`
    std::vector<double> plain;           ///< instead, once rewards are too many to number
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
      } else {  // values became too many only now
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
  if (num_layers() != system_->num_steps() + 1) return std::nullopt;
  return layer_begin(num_layers() - 1);
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

// -------------------------------------------------------------------------------------------------

namespace {

/// Memory to hold H with one number a state, and the largest layer's keys while it is merged.
double graph_bytes(const TransitionSystem& system, double states, double actions,
                   double widest_layer_actions) {
  const double key = 8.0 * static_cast<double>(system.words());
  return states * (key + 8 + 8) + actions * 7 + widest_layer_actions * (key + 11);
}

/// False where a state of a disassembly can be seen not to occur: a connection is gone before one
/// that it comes after, or there are too many subassemblies. In assembly such states are reached
/// (and are dead ends).
bool breaks_no_rule(const TransitionSystem& system, SetView open) {
  const Problem& problem = system.problem();
  if (problem.direction() == Direction::Assembly) return true;
  const ConnectionSet there = system.present(open);
  const auto present = [&](ConnectionIndex c) { return there.contains(c); };
  for (const PrecedenceClause& clause : problem.precedence()) {
    if (present(clause.connection)) continue;
    if (std::ranges::any_of(clause.after, present)) return false;
    if (!clause.after_any.empty() && std::ranges::all_of(clause.after_any, present)) return false;
  }
  const auto most = problem.limits().max_subassemblies;
  return !most || system.subassemblies(there.view()) <= *most;
}

/// Whether some legal action leads into a state, as far as can be seen from the states before it.
bool has_a_way_in(const TransitionSystem& system, Expander& expander, ConnectionSet& open) {
  if (!breaks_no_rule(system, open.view())) return false;
  bool at_start = true;
  for (ConnectionIndex c = 0; c < open.universe(); ++c) {
    if (open.contains(c) || !system.start().contains(c)) continue;
    at_start = false;
    open.insert(c);
    const bool way = breaks_no_rule(system, open.view()) && expander.legal(open.view(), c);
    open.erase(c);
    if (way) return true;
  }
  return at_start;
}

/// Sequential Monte Carlo over the layers (Gordon, Salmond, Smith 1993; for counting, Knuth 1975).
/// With s uniform in layer k and s' a uniform successor, the mean of b(s) / p(s') is N(k+1) / N(k);
/// particles are then resampled by these weights. Ways into s' that only come from unreachable
/// states are counted too, which makes the estimate low.
GraphEstimate sampled(const TransitionSystem& system) {
  const std::size_t n = system.num_connections();
  const std::size_t particles = n <= 64 ? 256 : 8;
  const std::size_t probes = n <= 64 ? 24 : 8;
  SplitMix64 random(1);
  Expander expander(system);
  std::vector<ConnectionSet> layer(particles, system.start());
  GraphEstimate estimate{1, 0, 0, false};
  double width = 1;
  double widest = 0;
  for (std::size_t k = 0; k < system.num_steps(); ++k) {
    std::vector<ConnectionSet> next;
    std::vector<double> weights;
    double mean_actions = 0;
    double mean_ratio = 0;
    for (ConnectionSet& state : layer) {
      const auto actions = expander.legal_actions(state.view());
      const double b = static_cast<double>(actions.size());
      mean_actions += b / static_cast<double>(particles);
      if (actions.empty()) continue;
      ConnectionSet successor = state;
      successor.erase(actions[random.below(actions.size())].connection);
      // Ways in: put back one of the k + 1 connections handled and ask whether handling it is
      // legal.
      std::vector<ConnectionIndex> handled;
      for (ConnectionIndex c = 0; c < n; ++c) {
        if (system.start().contains(c) && !successor.contains(c)) handled.push_back(c);
      }
      const std::size_t all = handled.size();
      const std::size_t looked_at = std::min(probes, all);
      std::size_t legal = 0;
      for (std::size_t i = 0; i < looked_at; ++i) {
        std::swap(handled[i], handled[i + random.below(all - i)]);
        successor.insert(handled[i]);
        if (expander.legal(successor.view(), handled[i]) &&
            has_a_way_in(system, expander, successor))
          ++legal;
        successor.erase(handled[i]);
      }
      const double ways_in = std::max(1.0, static_cast<double>(legal) * static_cast<double>(all) /
                                               static_cast<double>(looked_at));
      weights.push_back(b / ways_in);
      mean_ratio += weights.back() / static_cast<double>(particles);
      next.push_back(std::move(successor));
    }
    estimate.actions += width * mean_actions;
    widest = std::max(widest, width * mean_actions);
    if (next.empty()) break;
    width *= mean_ratio;
    estimate.states += width;
    // Systematic resampling.
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    double mark = random.uniform();
    double reached = 0;
    std::size_t i = 0;
    layer.clear();
    for (std::size_t p = 0; p < particles; ++p, mark += 1) {
      while (i + 1 < next.size() &&
             reached + weights[i] <= mark * total / static_cast<double>(particles)) {
        reached += weights[i++];
      }
      layer.push_back(next[i]);
    }
  }
  estimate.bytes = graph_bytes(system, estimate.states, estimate.actions, widest);
  return estimate;
}

std::string size_text(double count) {
  // 1,234,567 up to a million million, then powers of ten.
  if (count < 1e12) {
    std::string digits = std::to_string(static_cast<std::uint64_t>(count));
    for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(digits.size()) - 3; i > 0; i -= 3) {
      digits.insert(static_cast<std::size_t>(i), ",");
    }
    return digits;
  }
  const double power = std::floor(std::log10(count));
  const double leading = std::round(count / std::pow(10, power) * 10) / 10;
  std::string text = std::to_string(leading);
  text.erase(text.find('.') + 2);
  return text + "e" + std::to_string(static_cast<int>(power));
}

std::string bytes_text(double bytes) {
  constexpr double kMebibyte = 1024.0 * 1024.0;
  return bytes < 1024 * kMebibyte ? size_text(std::ceil(bytes / kMebibyte)) + " MiB"
                                  : size_text(std::ceil(bytes / kMebibyte / 1024)) + " GiB";
}

}  // namespace

GraphEstimate estimate_without_constraints(const TransitionSystem& system) {
  const double n = static_cast<double>(system.num_steps());
  const double states = std::exp2(n);
  const double actions = n * states / 2;
  // The widest layer holds about sqrt(2 / (pi n)) of all.
  const double widest = actions * std::min(1.0, std::sqrt(0.64 / std::max(1.0, n)));
  return {states, actions, graph_bytes(system, states, actions, widest), true};
}

bool unconstrained(const TransitionSystem& system) {
  const Problem& problem = system.problem();
  const Limits& limits = problem.limits();
  return problem.precedence().empty() && !problem.directions() && !limits.max_subassemblies &&
         !limits.max_moved_parts && !limits.max_moved_mass && !system.ordered();
}

GraphEstimate estimate_graph(const TransitionSystem& system) {
  return unconstrained(system) ? estimate_without_constraints(system) : sampled(system);
}

namespace {

/// An estimate of a size that does not fit; empty if it does. `slack`: how far an estimate by
/// sampling may exceed what is allowed.
std::optional<GraphEstimate> too_large(const TransitionSystem& system, double allowed,
                                       double slack) {
  // Constraints only take states away: where all subsets fit there is nothing to estimate.
  if (estimate_without_constraints(system).bytes <= allowed) return std::nullopt;
  const GraphEstimate estimate = estimate_graph(system);
  if (estimate.exact) slack = 1;
  if (estimate.bytes <= slack * allowed &&
      estimate.states <= slack * static_cast<double>(kMostStates))
    return std::nullopt;
  return estimate;
}

}  // namespace

bool graph_fits(const TransitionSystem& system, const Budget& budget) {
  return !too_large(system, static_cast<double>(allowed_bytes(budget)), 1);
}

std::optional<std::string> graph_obstacle(const TransitionSystem& system, const Budget& budget,
                                          double other_bytes) {
  const auto allowed = static_cast<double>(allowed_bytes(budget));
  // An estimate by sampling may be off by a factor of two or so; the memory limit stands behind it.
  const auto estimate = too_large(system, allowed, 2);
  if (!estimate) return std::nullopt;
  const std::string other =
      other_bytes == 0 ? "" : ", or " + bytes_text(other_bytes) + " for the values of all subsets,";
  return std::string("needs the whole state-action graph: ") + (estimate->exact ? "" : "about ") +
         size_text(estimate->states) + " states and " + size_text(estimate->actions) +
         " actions, " + bytes_text(estimate->bytes) + " of memory" + other + " where " +
         bytes_text(allowed) + " are allowed";
}

}  // namespace orasp
