#include "orasp/planners/beam.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "orasp/containers/parallel.h"
#include "orasp/graph/state_graph.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/crew.h"
#include "orasp/planners/detail/order_search.h"
#include "orasp/planners/detail/step_in_front.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// With SymmetryUse::Auto so many states are expanded before symmetry is looked for.
constexpr std::uint64_t kBeforeBeamSymmetry = 10'000;

/// The search of beam(): passes over the layers of H, each pass twice as wide as the one before.
class BeamSearch {
 public:
  BeamSearch(const TransitionSystem& system, const BeamOptions& options, const Budget& budget,
             Result& result)
      : system_(system),
        budget_(budget),
        words_(system.words()),
        allowed_(allowed_bytes(budget)),
        // Copies that share the work would have to turn to it at the same moment.
        symmetry_use_(options.crew == nullptr ? options.symmetry : SymmetryUse::Off),
        result_(result),
        workers_(std::max(1U, budget.threads)),
        crew_(options.crew),
        proved_(options.most) {
    for (Worker& worker : workers_) {
      worker.expander = std::make_unique<Expander>(system);
      worker.bound = make_bound(system, options.bound, workers_.front().bound.get());
    }
    bounded_ = workers_.front().bound->known();
    const StartByPlaces by_places = start_by_places(*workers_.front().bound);
    proved_ = std::min(proved_, by_places.most);
    for (Worker& worker : workers_) {
      if (by_places.prices && detail::StepInFront::applies(system, *by_places.prices))
        worker.in_front = std::make_unique<detail::StepInFront>(system, by_places.prices);
    }
    if (by_places.prices) orders_ = std::make_unique<detail::OrderSearch>(system, by_places.prices);
  }

  [[nodiscard]] bool bounded() const { return bounded_; }

  void run() {
    const double most = bounded_ ? (*workers_.front().bound)(system_.start().view()) : kInfinity;
    tick_ = kRewardTolerance * (std::isfinite(most) ? std::max(1.0, std::abs(most)) : 1.0);
    proved_ = std::min(proved_, most);
    improve_order();
    done_ = meets_bound();
    for (std::size_t width = 1; !done_ && result_.stop == Stop::None; width *= 2) {
      ++result_.statistics.sweeps;
      look_for_symmetry();
      const double left_out = pass(width);
      if (result_.stop != Stop::None) break;
      proved_ = std::min(proved_, std::max(left_out, result_.reward));
      if (left_out > -kInfinity && !meets_bound()) improve_order();
      done_ = left_out == -kInfinity || meets_bound();
    }
    if (std::isfinite(proved_)) result_.bound = proved_;
    result_.statistics.peak_bytes = peak_bytes_;
  }

  /// Whether the search came to its end: then its plan is optimal, and where it has no plan there
  /// is none.
  [[nodiscard]] bool done() const { return done_; }

  /// The symmetry that was used in the end.
  [[nodiscard]] const std::optional<Symmetry>& symmetry() const { return symmetry_; }

 private:
  // Before a pass.
  void look_for_symmetry() {
    const bool automatic = symmetry_use_ == SymmetryUse::Auto;
    if (symmetry_use_ == SymmetryUse::Off) return;
    if (automatic &&
        (workers_.front().in_front != nullptr || result_.statistics.expanded < kBeforeBeamSymmetry))
      return;
    symmetry_ = symmetry_for(system_, symmetry_use_, "beam");
    symmetry_use_ = SymmetryUse::Off;  // known once and for all
    if (!symmetry_) return;
    form_ = symmetry_->form();
    for (Worker& worker : workers_) {
      worker.form = form_;
      worker.in_front.reset();  // it compares states as they are
    }
  }

  // Writes the state to which `connection` leads, or the one that stands for it.
  void write_successor(SetView state, ConnectionIndex connection, std::optional<OrbitForm>& form,
                       std::vector<std::uint64_t>& next) const {
    next.assign(state.begin(), state.end());
    next[connection / 64] &= ~(std::uint64_t{1} << (connection % 64));
    if (form) form->canonical_but_for(connection, next);
  }

  // Where rewards depend on when steps come, moves the steps of a new plan about.
  void improve_order() {
    if (!orders_ || result_.reward == improved_) return;
    if (crew_ == nullptr || crew_->member() == 0) orders_->improve(budget_, kOrderRounds, result_);
    if (crew_ != nullptr) take_plan_of_first();
    improved_ = result_.reward;
  }

  // The first member's plan, for all of the crew: it was improved against a clock.
  void take_plan_of_first() {
    std::string mine(sizeof(double), '\0');
    std::memcpy(mine.data(), &result_.reward, sizeof(double));
    mine += result_.has_plan() ? '+' : '-';
    for (const ConnectionIndex c : result_.sequence)
      mine.append(reinterpret_cast<const char*>(&c), sizeof c);
    const std::string first = crew_->told_by_all(mine).front();
    std::memcpy(&result_.reward, first.data(), sizeof(double));
    if (first[sizeof(double)] == '+' && !result_.has_plan()) result_.status = Status::Feasible;
    constexpr std::size_t kHead = sizeof(double) + 1;
    result_.sequence.resize((first.size() - kHead) / sizeof(ConnectionIndex));
    std::memcpy(result_.sequence.data(), first.data() + kHead, first.size() - kHead);
  }

  /// A state of the next layer: the state `parent` of this layer less `connection`, or the one that
  /// stands for it.
  struct Candidate {
    double promise;
    double reward;
    double rest;
    /// The hash of the state itself.
    std::uint64_t hash;
    std::uint32_t parent;
    ConnectionIndex connection;
  };
  struct Layer {
    std::vector<std::uint64_t> states;
    std::vector<double> rewards;
    std::vector<double> rests;
    std::vector<std::uint64_t> hashes;

    void clear() {
      states.clear();
      rewards.clear();
      rests.clear();
      hashes.clear();
    }
    [[nodiscard]] std::size_t size() const { return rewards.size(); }
  };
  struct Taken {
    std::uint32_t parent;
    std::uint16_t connection;
  };
  struct Worker {
    std::unique_ptr<Expander> expander;
    std::unique_ptr<Bound> bound;
    /// Where what a step earns depends on when it comes and on nothing else.
    std::unique_ptr<detail::StepInFront> in_front;
    std::optional<OrbitForm> form;
    std::vector<std::uint64_t> next;
    std::vector<Candidate> found;
    std::vector<double> rests;
    std::uint64_t expanded = 0;
    std::uint64_t generated = 0;
    std::uint64_t pruned = 0;
    Stop stop = Stop::None;
  };

  [[nodiscard]] bool meets_bound() const {
    return result_.has_plan() && detail::meets(result_.reward, proved_);
  }
  [[nodiscard]] SetView state_of(const Layer& layer, std::size_t i) const {
    return {layer.states.data() + i * words_, words_};
  }
  [[nodiscard]] static std::uint64_t mark_of(ConnectionIndex c) { return mixed(c + 1U); }
  [[nodiscard]] bool same_state(const Layer& layer, const Candidate& a, const Candidate& b) {
    if (a.hash != b.hash) return false;
    if (form_) {
      if (words_ == 1) return true;  // hashes of one word differ where the words do
      write_successor(state_of(layer, a.parent), a.connection, form_, one_);
      write_successor(state_of(layer, b.parent), b.connection, form_, other_);
      return one_ == other_;
    }
    const SetView one = state_of(layer, a.parent);
    const SetView other = state_of(layer, b.parent);
    for (std::size_t w = 0; w < words_; ++w) {
      std::uint64_t x = one[w];
      std::uint64_t y = other[w];
      if (w == a.connection / 64) x &= ~(std::uint64_t{1} << (a.connection % 64));
      if (w == b.connection / 64) y &= ~(std::uint64_t{1} << (b.connection % 64));
      if (x != y) return false;
    }
    return true;
  }
  /// The order of candidates: greater promise first. Among equals a hash decides, another one in
  /// each pass, so that passes differ.
  [[nodiscard]] bool before(const Candidate& a, const Candidate& b) const {
    const double left = std::floor(a.promise / tick_ + 0.5);
    const double right = std::floor(b.promise / tick_ + 0.5);
    if (left != right) return left > right;
    const std::uint64_t one = mixed(a.hash + result_.statistics.sweeps);
    const std::uint64_t other = mixed(b.hash + result_.statistics.sweeps);
    return one != other ? one < other
                        : std::pair(a.parent, a.connection) < std::pair(b.parent, b.connection);
  }

  /// Runs one pass. Returns the greatest promise of a state that found no room in it; -infinity
  /// where every state did.
  double pass(std::size_t width) {
    const std::size_t depth = system_.num_steps();
    double left_out = -kInfinity;
    taken_.clear();
    begins_.assign(1, 0);
    layer_.clear();
    const ConnectionSet start = system_.start();
    layer_.states.assign(start.view().begin(), start.view().end());
    layer_.rewards.push_back(0);
    layer_.rests.push_back(bounded_ ? (*workers_.front().bound)(start.view()) : 0);
    layer_.hashes.push_back(0);
    for (std::size_t k = 0; k < depth && layer_.size() > 0; ++k) {
      left_out = std::max(left_out, expand_layer(width, k + 1 == depth));
      if (result_.stop != Stop::None) return left_out;
      make_next_layer();
    }
    if (layer_.size() > 0) {
      // The only state of the last layer is the goal.
      if (layer_.rewards.front() > result_.reward || !result_.has_plan()) take_plan();
    }
    return left_out;
  }

  // Fills survivors_ with the best `width` successors of the layer.
  double expand_layer(std::size_t width, bool last) {
    double left_out = -kInfinity;
    survivors_.clear();
    slots_.assign(64, 0);
    const std::size_t size = layer_.size();
    const std::size_t threads = workers_.size();
    // The same for any number of threads, so that the answer is the same.
    constexpr std::size_t chunk = 1024;
    width_ = width;
    for (std::size_t begin = 0; begin < size; begin += chunk) {
      const std::size_t survivors_before = survivors_.size();
      const std::size_t end = std::min(size, begin + chunk);
      const detail::Share mine =
          crew_ == nullptr ? detail::Share{0, end - begin}
                           : detail::share_of(end - begin, crew_->size(), crew_->member());
      const std::size_t mine_size = mine.end - mine.begin;
      const std::size_t used = mine_size < 4 * threads ? 1 : threads;
      detail::run_parallel(used, [&](std::size_t t) {
        const detail::Share share = detail::share_of(mine_size, used, t);
        work(workers_[t], begin + mine.begin + share.begin, begin + mine.begin + share.end, last);
      });
      if (crew_ != nullptr) {
        merge_all_of_crew(used);
      } else {
        merge_all(used);
      }
      grew_by_ = survivors_.size() - survivors_before;
      if (survivors_.size() > 2 * width) left_out = std::max(left_out, cut_down(width));
      poll();
      if (result_.stop != Stop::None) return left_out;
    }
    if (survivors_.size() > width) left_out = std::max(left_out, cut_down(width));
    return left_out;
  }

  // Takes over what the workers found, in the order of the layer.
  void merge_all(std::size_t workers) {
    for (std::size_t t = 0; t < workers; ++t) {
      Worker& worker = workers_[t];
      result_.statistics.expanded += worker.expanded;
      result_.statistics.generated += worker.generated;
      result_.statistics.pruned += worker.pruned;
      worker.expanded = worker.generated = worker.pruned = 0;
      if (result_.stop == Stop::None) result_.stop = worker.stop;
      for (const Candidate& candidate : worker.found) merge(candidate);
      worker.found.clear();
    }
  }

  /// What a member of the crew counted in its share of a chunk, and why it has to stop.
  struct CrewHead {
    std::uint64_t expanded = 0;
    std::uint64_t generated = 0;
    std::uint64_t pruned = 0;
    Stop stop = Stop::None;
  };
  // The same for what all members found, whose shares follow each other as those of threads do. A
  // stop of any of them is one of all, at this place.
  void merge_all_of_crew(std::size_t workers) {
    static_assert(std::is_trivially_copyable_v<Candidate>);
    CrewHead head;
    head.stop = own_stop_;
    std::string mine(sizeof head, '\0');
    for (std::size_t t = 0; t < workers; ++t) {
      Worker& worker = workers_[t];
      head.expanded += worker.expanded;
      head.generated += worker.generated;
      head.pruned += worker.pruned;
      worker.expanded = worker.generated = worker.pruned = 0;
      if (head.stop == Stop::None) head.stop = worker.stop;
      mine.append(reinterpret_cast<const char*>(worker.found.data()),
                  worker.found.size() * sizeof(Candidate));
      worker.found.clear();
    }
    std::memcpy(mine.data(), &head, sizeof head);
    for (const std::string& told : crew_->told_by_all(mine)) {
      std::memcpy(&head, told.data(), sizeof head);
      result_.statistics.expanded += head.expanded;
      result_.statistics.generated += head.generated;
      result_.statistics.pruned += head.pruned;
      if (result_.stop == Stop::None) result_.stop = head.stop;
      for (std::size_t at = sizeof head; at < told.size(); at += sizeof(Candidate)) {
        Candidate candidate;
        std::memcpy(&candidate, told.data() + at, sizeof candidate);
        merge(candidate);
      }
    }
  }

  void work(Worker& worker, std::size_t begin, std::size_t end, bool last) {
    for (std::size_t i = begin; i < end; ++i) {
      if ((i - begin) % 64 == 63 && (worker.stop = budget_.expired()) != Stop::None) return;
      const SetView open = state_of(layer_, i);
      const auto legal = worker.expander->legal_actions(open);
      ++worker.expanded;
      worker.rests.assign(legal.size(), 0);
      // What is known of a state may be more than of the one that stands for it, or less.
      const double here = form_ && bounded_ ? (*worker.bound)(open) : layer_.rests[i];
      if (bounded_) worker.bound->of_successors(open, here, legal, worker.rests);
      std::optional<ConnectionIndex> alone;
      if (worker.in_front && result_.has_plan())
        alone = worker.in_front->find(open, legal,
                                      layer_.rewards[i] + layer_.rests[i] - result_.reward);
      for (std::size_t a = 0; a < legal.size(); ++a) {
        if (alone && legal[a].connection != *alone) continue;
        const double reward = layer_.rewards[i] + legal[a].reward;
        const double promise = reward + worker.rests[a];
        ++worker.generated;
        // The reward at the goal is no promise but a fact, so it needs no tolerance.
        if (bounded_ && result_.has_plan() && promise <= result_.reward + (last ? 0 : tick_)) {
          ++worker.pruned;
          continue;
        }
        const ConnectionIndex c = legal[a].connection;
        std::uint64_t hash = layer_.hashes[i] ^ mark_of(c);
        if (worker.form) {
          write_successor(open, c, worker.form, worker.next);
          hash = hash_value(worker.next);
        }
        worker.found.push_back(
            {promise, reward, worker.rests[a], hash, static_cast<std::uint32_t>(i), c});
      }
    }
  }

  void merge(const Candidate& candidate) {
    if (survivors_.size() * 2 >= slots_.size()) index(slots_.size() * 4);
    std::size_t i = mixed(candidate.hash) & (slots_.size() - 1);
    while (slots_[i] != 0) {
      Candidate& other = survivors_[slots_[i] - 1];
      if (same_state(layer_, other, candidate)) {
        ++result_.statistics.pruned;
        if (candidate.reward > other.reward) {
          other = candidate;
          ++result_.statistics.reopened;
        }
        return;
      }
      i = (i + 1) & (slots_.size() - 1);
    }
    survivors_.push_back(candidate);
    slots_[i] = static_cast<std::uint32_t>(survivors_.size());
  }
  void index(std::size_t slots) {
    slots_.assign(slots, 0);
    for (std::size_t k = 0; k < survivors_.size(); ++k) {
      std::size_t i = mixed(survivors_[k].hash) & (slots - 1);
      while (slots_[i] != 0) i = (i + 1) & (slots - 1);
      slots_[i] = static_cast<std::uint32_t>(k + 1);
    }
  }
  double cut_down(std::size_t width) {
    const auto order = [this](const Candidate& a, const Candidate& b) { return before(a, b); };
    std::nth_element(survivors_.begin(), survivors_.begin() + static_cast<std::ptrdiff_t>(width),
                     survivors_.end(), order);
    double left_out = -kInfinity;
    for (std::size_t i = width; i < survivors_.size(); ++i)
      left_out = std::max(left_out, bounded_ ? survivors_[i].promise : kInfinity);
    survivors_.resize(width);
    // nth_element leaves an order of its own; what follows must not depend on it.
    std::sort(survivors_.begin(), survivors_.end(), order);
    index(slots_.size());
    return left_out;
  }

  void make_next_layer() {
    next_.clear();
    next_.states.reserve(survivors_.size() * words_);
    next_.rewards.reserve(survivors_.size());
    next_.rests.reserve(survivors_.size());
    next_.hashes.reserve(survivors_.size());
    std::sort(survivors_.begin(), survivors_.end(),
              [this](const Candidate& a, const Candidate& b) { return before(a, b); });
    for (const Candidate& candidate : survivors_) {
      const SetView parent = state_of(layer_, candidate.parent);
      write_successor(parent, candidate.connection, form_, one_);
      next_.states.insert(next_.states.end(), one_.begin(), one_.end());
      next_.rewards.push_back(candidate.reward);
      next_.rests.push_back(candidate.rest);
      next_.hashes.push_back(candidate.hash);
      taken_.push_back({candidate.parent, static_cast<std::uint16_t>(candidate.connection)});
    }
    begins_.push_back(taken_.size());
    std::swap(layer_, next_);
  }

  void take_plan() {
    const std::size_t depth = system_.num_steps();
    result_.reward = layer_.rewards.front();
    result_.status = Status::Feasible;
    result_.sequence.assign(depth, 0);
    std::size_t index = 0;
    for (std::size_t k = depth; k-- > 0;) {
      const Taken& taken = taken_[begins_[k] + index];
      result_.sequence[k] = taken.connection;
      index = taken.parent;
    }
    if (form_) result_.sequence = true_sequence(system_, *form_, result_.sequence);
  }

  /// The memory that `vector` holds, and that of the copy that it moves to if it soon has `size`
  /// items.
  template <class Item>
  [[nodiscard]] static std::uint64_t bytes_with(const std::vector<Item>& vector, std::size_t size) {
    const std::size_t held = vector.capacity();
    return (size <= held ? held : held + std::max(size, 2 * held)) * sizeof(Item);
  }

  void poll() {
    std::uint64_t bytes = taken_.capacity() * sizeof(Taken) +
                          survivors_.capacity() * sizeof(Candidate) +
                          slots_.capacity() * sizeof(std::uint32_t);
    for (const Layer* layer : {&layer_, &next_})
      bytes += layer->states.capacity() * 8 + layer->size() * 24;
    for (const Worker& worker : workers_) bytes += worker.found.capacity() * sizeof(Candidate);
    peak_bytes_ = std::max(peak_bytes_, bytes);
    // Memory is judged before it is taken: by what the next chunk and the next layer may need.
    // Tables grow by doubling, and for a moment both the old and the new one are there.
    const std::size_t survivors = survivors_.size() + 2 * grew_by_;
    const std::size_t next = std::min(survivors, width_);
    std::uint64_t soon = bytes_with(taken_, taken_.size() + next) +
                         bytes_with(survivors_, survivors) +
                         bytes_with(slots_, survivors * 2 < slots_.size() ? 0 : slots_.size() * 4) +
                         bytes_with(next_.states, next * words_) + layer_.states.capacity() * 8 +
                         (layer_.size() + next_.rewards.capacity() + next) * 24;
    for (const Worker& worker : workers_) soon += worker.found.capacity() * sizeof(Candidate);
    // A member of a crew tells the others, and all stop after the next chunk.
    Stop& stop = crew_ != nullptr ? own_stop_ : result_.stop;
    if (stop == Stop::None)
      stop =
          soon > allowed_ ? Stop::MemoryLimit : budget_.expired(soon, result_.statistics.expanded);
    budget_.report({.phase = "pass",
                    .done = result_.statistics.sweeps,
                    .states = layer_.size(),
                    .best = result_.reward});
  }

  /// How often a new plan is improved.
  static constexpr std::uint64_t kOrderRounds = 300;

  const TransitionSystem& system_;
  const Budget& budget_;
  std::size_t words_;
  std::uint64_t allowed_;
  /// What is still to be done about symmetry, what was found, and this thread's form of states.
  SymmetryUse symmetry_use_;
  std::optional<Symmetry> symmetry_;
  std::optional<OrbitForm> form_;
  std::vector<std::uint64_t> one_;
  std::vector<std::uint64_t> other_;
  Result& result_;
  std::vector<Worker> workers_;
  detail::Crew* crew_;
  /// Why this member of the crew has to stop.
  Stop own_stop_ = Stop::None;
  bool bounded_ = false;
  bool done_ = false;
  /// Where rewards depend on when steps come; and the reward of the last plan that it improved.
  std::unique_ptr<detail::OrderSearch> orders_;
  double improved_ = kInfinity;
  /// Promises that differ by less than this are equal.
  double tick_ = 1;
  /// The least upper bound on any plan that was proved.
  double proved_;
  std::uint64_t peak_bytes_ = 0;
  /// How many states of a layer this pass keeps.
  std::size_t width_ = 1;
  /// How many survivors the last chunk added.
  std::size_t grew_by_ = 0;
  Layer layer_;
  Layer next_;
  /// The best successors so far of the layer that is being expanded, and an index of them by hash.
  std::vector<Candidate> survivors_;
  std::vector<std::uint32_t> slots_;
  /// How each state of each layer was reached, layer after layer, and where the layers begin.
  std::vector<Taken> taken_;
  std::vector<std::size_t> begins_;
};

Result searched(const TransitionSystem& system, const BeamOptions& options, const Budget& budget) {
  static_assert(kMaxConnections <= std::size_t{1} << 16);
  if (auto result = detail::infeasible_at_once(system, "beam")) return *result;
  Result result;
  if (options.incumbent != nullptr && options.incumbent->has_plan()) result = *options.incumbent;
  result.method = "beam";
  result.stop = Stop::None;
  result.statistics = {};
  BeamSearch search(system, options, budget, result);
  if (!search.bounded() && options.bound != BoundKind::Best)
    throw Refusal("beam", detail::unknown_bound(system, options.bound));
  if (const auto reason = symmetry_obstacle(system, options.symmetry))
    throw Refusal("beam", *reason);
  search.run();
  if (search.done()) {
    if (result.has_plan()) {
      result.status = Status::Optimal;
      result.bound = result.reward;
    } else {
      result = detail::exhausted("beam", result.statistics);
    }
  } else if (!result.has_plan()) {
    const std::optional<double> most = result.bound;
    result = detail::stopped_with_quick_plan(system, "beam", result.stop, result.statistics);
    result.bound = most;
  }
  if (search.symmetry()) result.notes.push_back(search.symmetry()->text());
  return result;
}

}  // namespace

Result beam(const TransitionSystem& system, const BeamOptions& options, const Budget& budget) {
  if (system.wide()) {
    if (const auto reason = symmetry_obstacle(system, options.symmetry))
      throw Refusal("beam", *reason);
    return detail::wide_beam(system, options.incumbent, budget);
  }
  return detail::from_the_end(system, options,
                              [&](const TransitionSystem& from, const BeamOptions& turned) {
                                return searched(from, turned, budget);
                              });
}

}  // namespace orasp
