#include "orasp/cluster/cluster_a_star.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/error.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/open_state.h"
#include "orasp/planners/detail/order_search.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

constexpr const char* kMethod = "a-star";
/// So many successors for one rank are sent together, or fewer where there is nothing else to do.
constexpr std::size_t kBatch = 64;
/// So many states are expanded from one look at the letters to the next.
constexpr int kExpansionsBetweenLooks = 16;

/// What a letter holds, by its first byte.
enum class Kind : char {
  States = 's',  ///< successors
  Best = 'b',    ///< the reward of a plan
  Stop = 'x',    ///< why a rank stops
  Ask = 'q',     ///< rank 0 asks how things stand
  Answer = 'a',  ///< a rank's answer
  End = 'e',     ///< the search is over
};

/// How things stand on a rank: what it sent and received of states, plans and stops.
struct Standing {
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t idle = 1;
};

template <class Value>
std::string letter_of(Kind kind, const Value& value) {
  std::string text(1, static_cast<char>(kind));
  text.append(reinterpret_cast<const char*>(&value), sizeof value);
  return text;
}
template <class Value>
Value value_of(const std::string& letter) {
  Value value;
  std::memcpy(&value, letter.data() + 1, sizeof value);
  return value;
}

/// The part of the search that is one rank's. kWords is that of its StateTable.
template <std::size_t kWords>
class RankSearch {
 public:
  RankSearch(const TransitionSystem& system, Bound& bound, const Budget& budget, Ranks& ranks,
             Result& result)
      : system_(system),
        expander_(system),
        bound_(bound),
        budget_(budget),
        allowed_(std::min(budget.max_bytes, allowed_bytes(Budget{}) / ranks.on_this_machine())),
        ranks_(ranks),
        result_(result),
        batches_(ranks.size()),
        asked_(ranks.size()),
        table_(system.words()) {}

  void run() {
    const ConnectionSet start = system_.start();
    const double all = bound_(start.view());
    tick_ = kRewardTolerance * std::max(1.0, std::abs(all));
    if (owner_of(start.view()) == ranks_.rank()) meet(start.view(), {0, all, 0, 0});
    note_stop(budget_.expired());
    work();
    conclude(all);
  }

 private:
  using Open = detail::OpenState;  // its promise in units of tick_
  /// A state that is met, beside its key.
  struct Met {
    double reward;
    double rest;
    std::uint32_t depth;
    std::uint32_t by;
  };

  [[nodiscard]] std::size_t owner_of(SetView state) const {
    std::uint64_t hash = 0x2545f4914f6cdd1dULL;
    for (const std::uint64_t word : state) hash = mixed(hash ^ word);
    return hash % ranks_.size();
  }
  [[nodiscard]] std::int64_t ticks_of(double promise) const {
    return static_cast<std::int64_t>(std::floor(promise / tick_ + 0.5));
  }
  /// Whether a state of that promise need not be expanded.
  [[nodiscard]] bool beaten(std::int64_t promise) const {
    return best_ != -kInfinity && promise <= ticks_of(best_);
  }

  void meet(SetView state, const Met& met) {
    const auto [number, is_new] = table_.insert(state.data());
    if (is_new) {
      reward_.push_back(met.reward);
      by_.push_back(static_cast<std::uint16_t>(met.by));
      closed_.push_back(0);
    } else {
      if (met.reward <= reward_[number] + tick_ / 16) {
        ++result_.statistics.pruned;
        return;
      }
      ++result_.statistics.reopened;
      reward_[number] = met.reward;
      by_[number] = static_cast<std::uint16_t>(met.by);
      closed_[number] = 0;
    }
    if (met.depth == system_.num_steps()) {
      // The goal, which is this rank's. Others learn what need not be expanded any more.
      best_ = met.reward;
      for (std::size_t rank = 0; rank < ranks_.size(); ++rank) {
        if (rank != ranks_.rank()) send(rank, letter_of(Kind::Best, best_));
      }
      return;
    }
    open_.push_back({ticks_of(met.reward + met.rest), number, met.depth});
    std::ranges::push_heap(open_.span(), Open::later);
  }

  // What is counted.
  void send(std::size_t to, std::string letter) {
    ++standing_.sent;
    ranks_.post(to, std::move(letter));
  }
  void flush(std::size_t to) {
    if (batches_[to].empty()) return;
    batch_bytes_ += batches_[to].size();
    send(to, static_cast<char>(Kind::States) + batches_[to]);
    batches_[to].clear();
  }
  void note_stop(Stop stop) {
    if (stop == Stop::None || result_.stop != Stop::None) return;
    result_.stop = stop;
    for (std::size_t rank = 0; rank < ranks_.size(); ++rank) {
      if (rank != ranks_.rank()) send(rank, letter_of(Kind::Stop, stop));
    }
  }

  /// Works until rank 0 says that the search is over.
  void work() {
    constexpr int kLooksBeforeNap = 200;
    int idle_looks = 0;
    while (!over_) {
      bool idle = true;
      while (const auto letter = ranks_.next_letter()) {
        take(*letter);
        idle = false;
      }
      for (int i = 0; i < kExpansionsBetweenLooks && expand_next(); ++i) idle = false;
      if (!idle) {
        idle_looks = 0;
        continue;
      }
      for (std::size_t rank = 0; rank < batches_.size(); ++rank) flush(rank);
      note_stop(budget_.expired());
      if (ranks_.rank() == 0) ask();
      if (++idle_looks < kLooksBeforeNap) {
        std::this_thread::yield();
      } else {
        std::this_thread::sleep_for(std::chrono::microseconds(100));
      }
    }
  }

  void take(const Ranks::Letter& letter) {
    const auto kind = static_cast<Kind>(letter.text.front());
    if (kind == Kind::States || kind == Kind::Best || kind == Kind::Stop) ++standing_.received;
    switch (kind) {
      case Kind::States: take_states(letter.text); break;
      case Kind::Best: best_ = std::max(best_, value_of<double>(letter.text)); break;
      case Kind::Stop:
        if (result_.stop == Stop::None) result_.stop = value_of<Stop>(letter.text);
        break;
      case Kind::Ask:
        // A batch that was not sent is work left.
        standing_.idle = has_work() ? 0 : 1;
        ranks_.post(0, letter_of(Kind::Answer, standing_));
        break;
      case Kind::Answer:
        asked_[letter.from] = value_of<Standing>(letter.text);
        if (--answers_due_ == 0) judge();
        break;
      case Kind::End: over_ = true; break;
    }
  }
  void take_states(const std::string& text) {
    const std::size_t words = system_.words();
    std::vector<std::uint64_t> key(words);
    for (std::size_t at = 1; at < text.size();) {
      std::memcpy(key.data(), text.data() + at, words * sizeof(std::uint64_t));
      at += words * sizeof(std::uint64_t);
      Met met;
      std::memcpy(&met, text.data() + at, sizeof met);
      at += sizeof met;
      meet(SetView(key.data(), words), met);
    }
  }

  [[nodiscard]] bool has_work() {
    drop_settled();
    const bool unsent = std::ranges::any_of(batches_, [](const auto& one) { return !one.empty(); });
    return unsent || (result_.stop == Stop::None && !open_.empty());
  }
  /// Takes what need not be expanded off the top of the heap; the rest promises no more.
  void drop_settled() {
    while (!open_.empty()) {
      if (beaten(open_[0].promise)) {
        open_.resize(0);
        return;
      }
      if (closed_[open_[0].state] == 0) return;
      std::ranges::pop_heap(open_.span(), Open::later);
      open_.resize(open_.size() - 1);
    }
  }

  /// Expands the state that promises most. @returns whether there was one.
  bool expand_next() {
    if (result_.stop != Stop::None) return false;
    drop_settled();
    if (open_.empty()) return false;
    constexpr std::uint64_t kLook = 64;
    if (++looks_ % kLook == 0) {
      const std::uint64_t more = kLook * system_.num_connections();
      const std::uint64_t soon = bytes() - table_.bytes() + table_.bytes_with(more) +
                                 more * (sizeof(double) + sizeof(std::uint16_t) + 1 + sizeof(Open));
      note_stop(soon > allowed_ ? Stop::MemoryLimit
                                : budget_.expired(soon, result_.statistics.expanded));
      budget_.report(
          {.phase = "search", .done = result_.statistics.expanded, .states = table_.size()});
      if (result_.stop != Stop::None) return false;
    }
    const Open from = open_[0];
    std::ranges::pop_heap(open_.span(), Open::later);
    open_.resize(open_.size() - 1);
    closed_[from.state] = 1;
    try {
      expand(from);
    } catch (const InputError& error) {
      fault_ = error.what();
      note_stop(Stop::Cancelled);
    }
    return true;
  }

  void expand(const Open& from) {
    ++result_.statistics.expanded;
    ConnectionSet state(system_.num_connections(), {table_.key(from.state), system_.words()});
    const double reward = reward_[from.state];
    const auto legal = expander_.legal_actions(state.view());
    rests_.resize(legal.size());
    const double here = static_cast<double>(from.promise) * tick_ - reward;
    bound_.of_successors(state.view(), here, legal, rests_);
    for (std::size_t i = 0; i < legal.size(); ++i) {
      ++result_.statistics.generated;
      const ConnectionIndex c = legal[i].connection;
      const Met met{reward + legal[i].reward, rests_[i], from.depth + 1,
                    static_cast<std::uint32_t>(c)};
      // The goal is a fact, whose reward need not be a whole unit better.
      if (met.depth < system_.num_steps() && beaten(ticks_of(met.reward + met.rest))) {
        ++result_.statistics.pruned;
        continue;
      }
      state.erase(c);
      const std::size_t owner = owner_of(state.view());
      if (owner == ranks_.rank()) {
        meet(state.view(), met);
      } else {
        const SetView view = state.view();
        std::string& batch = batches_[owner];
        batch.append(reinterpret_cast<const char*>(view.data()),
                     system_.words() * sizeof(std::uint64_t));
        batch.append(reinterpret_cast<const char*>(&met), sizeof met);
        if (batch.size() >= kBatch * (system_.words() * sizeof(std::uint64_t) + sizeof met))
          flush(owner);
      }
      state.insert(c);
    }
  }

  // Rank 0 asks all others how things stand; one wave at a time.
  void ask() {
    if (answers_due_ > 0) return;
    answers_due_ = ranks_.size() - 1;
    if (answers_due_ == 0) {
      over_ = !has_work();
      return;
    }
    const std::string question(1, static_cast<char>(Kind::Ask));
    for (std::size_t rank = 1; rank < ranks_.size(); ++rank) ranks_.post(rank, question);
  }
  // Whether all is done: all are idle, nothing is under way, and nothing moved since the wave
  // before.
  void judge() {
    Standing sum = standing_;
    sum.idle = has_work() ? 0 : 1;
    for (std::size_t rank = 1; rank < ranks_.size(); ++rank) {
      sum.sent += asked_[rank].sent;
      sum.received += asked_[rank].received;
      sum.idle &= asked_[rank].idle;
    }
    const bool quiet = sum.idle == 1 && sum.sent == sum.received;
    over_ = quiet && was_quiet_ && sum.sent == before_.sent;
    was_quiet_ = quiet;
    before_ = sum;
    if (!over_) return;
    const std::string end(1, static_cast<char>(Kind::End));
    for (std::size_t rank = 1; rank < ranks_.size(); ++rank) ranks_.post(rank, end);
  }

  /// What all ranks found, on each of them.
  void conclude(double all) {
    throw_first_fault();
    drop_settled();
    std::vector<double> greatest = {
        best_, open_.empty() ? -kInfinity : static_cast<double>(open_[0].promise),
        static_cast<double>(static_cast<int>(result_.stop)), static_cast<double>(bytes()),
        static_cast<double>(table_.size())};
    ranks_.take_greatest(greatest);
    const double best = greatest[0];
    const double top = greatest[1];
    result_.stop = static_cast<Stop>(static_cast<int>(greatest[2]));
    Statistics& statistics = result_.statistics;
    std::vector<std::uint64_t> sums = {table_.size(),        statistics.expanded,
                                       statistics.generated, statistics.reopened,
                                       statistics.pruned,    batch_bytes_};
    ranks_.take_sums(sums);
    statistics.states = sums[0];
    statistics.expanded = sums[1];
    statistics.generated = sums[2];
    statistics.reopened = sums[3];
    statistics.pruned = sums[4];
    statistics.peak_bytes = static_cast<std::uint64_t>(greatest[3]);
    result_.notes.push_back("the states lay on " + std::to_string(ranks_.size()) + " ranks, with " +
                            std::to_string(static_cast<std::uint64_t>(greatest[4])) +
                            " of them on the fullest; " + std::to_string(sums[5]) +
                            " bytes of states were sent between them");
    if (best != -kInfinity) read_plan_off();
    // What is left open is beaten by the plan where there is nothing more to be proved.
    if (best != -kInfinity && top == -kInfinity) {
      result_.status = Status::Optimal;
      result_.stop = Stop::None;
      result_.bound = result_.reward;
    } else if (result_.stop != Stop::None) {
      if (best != -kInfinity) result_.status = Status::Feasible;
      result_.bound = top == -kInfinity ? all : (top + 1) * tick_;
    }
  }

  void throw_first_fault() {
    for (const std::string& fault : ranks_.gather_everywhere(fault_)) {
      if (!fault.empty()) throw InputError(fault);
    }
  }

  // Goes back from the goal; each rank knows the last step to its own states.
  void read_plan_off() {
    ConnectionSet state(system_.num_connections());
    std::vector<ConnectionIndex>& sequence = result_.sequence;
    while (sequence.size() < system_.num_steps()) {
      std::vector<double> by = {-1};
      if (owner_of(state.view()) == ranks_.rank()) by[0] = by_[table_.find(state.view().data())];
      ranks_.take_greatest(by);
      sequence.push_back(static_cast<ConnectionIndex>(std::lround(by[0])));
      state.insert(sequence.back());
    }
    std::ranges::reverse(sequence);
    result_.reward = detail::reward_of(system_, sequence);
  }

  [[nodiscard]] std::uint64_t bytes() const {
    return table_.bytes() + reward_.bytes() + by_.bytes() + closed_.bytes() + open_.bytes();
  }

  const TransitionSystem& system_;
  Expander expander_;
  Bound& bound_;
  const Budget& budget_;
  std::uint64_t allowed_;
  Ranks& ranks_;
  Result& result_;
  /// By rank: successors that are its, not sent yet.
  std::vector<std::string> batches_;
  std::uint64_t batch_bytes_ = 0;
  Standing standing_;
  /// Of rank 0: the answers of the wave under way, and what the wave before it found.
  std::vector<Standing> asked_;
  std::size_t answers_due_ = 0;
  bool was_quiet_ = false;
  Standing before_;
  bool over_ = false;
  std::string fault_;
  /// The reward of the best plan that any rank told of.
  double best_ = -kInfinity;
  double tick_ = 1;
  std::uint64_t looks_ = 0;
  detail::StateTable<kWords> table_;
  /// By state: as in a_star().
  detail::GrowingArray<double> reward_;
  detail::GrowingArray<std::uint16_t> by_;
  detail::GrowingArray<unsigned char> closed_;
  detail::GrowingArray<Open> open_;
  std::vector<double> rests_;
};

/// What a search that was stopped answers: the better of its own plan and one that is found
/// quickly. By rank 0 alone, whose answer it is.
void add_quick_plan(const TransitionSystem& system, const Bound& bound, const Budget& budget,
                    Result& result) {
  const std::optional<double> most = result.bound;
  Result quick = detail::stopped_with_quick_plan(system, kMethod, result.stop, result.statistics);
  quick.notes.insert(quick.notes.end(), result.notes.begin(), result.notes.end());
  if (!result.has_plan() || (quick.has_plan() && quick.reward > result.reward))
    result = std::move(quick);
  const StartByPlaces by_places = start_by_places(bound);
  result.bound = most;
  if (by_places.prices && most) {
    detail::OrderSearch(system, by_places.prices).improve(budget, 1, result);
    result.bound = std::max(result.reward, std::min(*most, by_places.most));
  }
}

Result searched(const TransitionSystem& system, const AStarOptions& options, const Budget& budget,
                Ranks& ranks) {
  if (auto result = detail::infeasible_at_once(system, kMethod)) return *result;
  const std::unique_ptr<Bound> bound = make_bound(system, options.bound);
  if (auto reason = detail::bound_obstacle(*bound, system, options.bound))
    throw Refusal(kMethod, *reason);
  Result result;
  result.method = kMethod;
  if (system.words() == 1) {
    RankSearch<1>(system, *bound, budget, ranks, result).run();
  } else {
    RankSearch<0>(system, *bound, budget, ranks, result).run();
  }
  if (result.stop != Stop::None) {
    if (ranks.rank() == 0) add_quick_plan(system, *bound, budget, result);
  } else if (result.status != Status::Optimal) {
    std::vector<std::string> notes = std::move(result.notes);
    result = detail::exhausted(kMethod, result.statistics);
    result.notes.insert(result.notes.end(), notes.begin(), notes.end());
  }
  return result;
}

}  // namespace

Result cluster_a_star(const TransitionSystem& system, const AStarOptions& options,
                      const Budget& budget, Ranks& ranks) {
  if (system.wide() || system.problem().uncertain())
    throw Refusal(kMethod,
                  "does its work in one process where there is a goal, a cost between steps or an "
                  "attempt that may fail");
  return detail::from_the_end(
      system, [&](const TransitionSystem& from) { return searched(from, options, budget, ranks); });
}

}  // namespace orasp
