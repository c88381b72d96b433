#include "orasp/planners/beam.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/containers/parallel.h"
#include "orasp/graph/state_graph.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/advised_pass.h"
#include "orasp/planners/detail/crew.h"
#include "orasp/planners/detail/crew_cut.h"
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
        symmetry_use_(options.symmetry),
        result_(result),
        workers_(std::max(1U, budget.threads)),
        crew_(options.crew),
        proved_(options.most) {
    for (Worker& worker : workers_) {
      worker.expander = std::make_unique<Expander>(system);
      if (crew_ != nullptr) worker.found_for.resize(crew_->size());
      const Bound* const made = workers_.front().bound.get();
      worker.bound = make_bound(system, options.bound, made != nullptr ? made : options.like);
    }
    bounded_ = workers_.front().bound->known();
    const StartByPlaces by_places = start_by_places(*workers_.front().bound);
    proved_ = std::min(proved_, by_places.most);
    for (Worker& worker : workers_) {
      if (by_places.prices && detail::StepInFront::applies(system, *by_places.prices))
        worker.in_front = std::make_unique<detail::StepInFront>(system, by_places.prices);
    }
    if (by_places.prices) orders_ = std::make_unique<detail::OrderSearch>(system, by_places.prices);
    if (options.advice != nullptr && crew_ == nullptr && !system.completes_first()) {
      advised_ = std::make_unique<detail::AdvisedPass>(
          system, *options.advice, options.bound, workers_.front().bound.get(), budget.threads);
    }
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
      if (!done_ && advised_) follow_advice();
    }
    if (std::isfinite(proved_)) result_.bound = proved_;
    std::array<std::uint64_t, 2> counts = {merged_, reopened_};
    std::array<double, 1> peak = {static_cast<double>(peak_bytes_)};
    if (crew_ != nullptr) {
      crew_->take_sums(counts);
      crew_->take_greatest(peak);
    }
    result_.statistics.pruned += counts[0];
    result_.statistics.reopened += counts[1];
    result_.statistics.peak_bytes = static_cast<std::uint64_t>(peak[0]);
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
    if (crew_ != nullptr && !all_found_the_same(symmetry_)) symmetry_.reset();
    if (!symmetry_) return;
    form_ = symmetry_->form();
    for (Worker& worker : workers_) {
      worker.form = form_;
      worker.in_front.reset();  // it compares states as they are
    }
  }

  // Between two passes: passes by advice, each twice as wide as the one before, as long as a
  // question costs less than so many expansions that were made.
  void follow_advice() {
    constexpr std::uint64_t kExpansionsForQuestion = 64;
    constexpr double kLoose = 1e-3;
    const auto loose = [&] {
      return !bounded_ || !result_.has_plan() ||
             proved_ - result_.reward > kLoose * std::max(1.0, std::abs(proved_));
    };
    while (!done_ && result_.stop == Stop::None && loose() &&
           (asked_ + advised_width_ * system_.num_steps()) * kExpansionsForQuestion <=
               result_.statistics.expanded) {
      const std::uint64_t before = result_.statistics.expanded;
      const double left_out = advised_->run(advised_width_, tick_, budget_, result_);
      asked_ += result_.statistics.expanded - before;
      advised_width_ *= 2;
      if (result_.stop != Stop::None) return;
      proved_ = std::min(proved_, std::max(left_out, result_.reward));
      done_ = left_out == -kInfinity || meets_bound();
    }
  }

  // A member whose machine lacks the module for it knows no symmetry: then none uses it.
  [[nodiscard]] bool all_found_the_same(const std::optional<Symmetry>& symmetry) const {
    std::string mine;
    if (symmetry) {
      for (const Permutation& exchange : symmetry->generators()) {
        for (const auto image : exchange) mine += std::to_string(image) + ' ';
        mine += '\n';
      }
    }
    return std::ranges::all_of(crew_->told_by_all(mine),
                               [&](const std::string& told) { return told == mine; });
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
    if (first.size() > kHead)
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
    /// Its place in the layer; in a crew, the candidate's own in arrived_.
    std::uint32_t parent;
    ConnectionIndex connection;
  };
  /// Where a candidate of a crew comes from: a place in the layer of a member, and what orders the
  /// states of that layer.
  struct Origin {
    std::uint32_t parent;
    std::uint32_t member;
    double promise;
    std::uint64_t hash;
  };
  /// What the members found of the states that belong to this one. The survivors name places here.
  struct Arrived {
    std::vector<std::uint64_t> states;
    std::vector<Origin> origins;

    void clear() {
      states.clear();
      origins.clear();
    }
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
    /// In a crew, by member: what was found of the states that belong to it (append_record).
    std::vector<std::string> found_for;
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
  [[nodiscard]] bool same_state(const Candidate& a, const Candidate& b) {
    if (a.hash != b.hash) return false;
    if (crew_ != nullptr || form_) {
      if (words_ == 1 && form_) return true;  // hashes of one word differ where the words do
      return std::ranges::equal(bits_of(a, one_), bits_of(b, other_));
    }
    const SetView one = state_of(layer_, a.parent);
    const SetView other = state_of(layer_, b.parent);
    for (std::size_t w = 0; w < words_; ++w) {
      std::uint64_t x = one[w];
      std::uint64_t y = other[w];
      if (w == a.connection / 64) x &= ~(std::uint64_t{1} << (a.connection % 64));
      if (w == b.connection / 64) y &= ~(std::uint64_t{1} << (b.connection % 64));
      if (x != y) return false;
    }
    return true;
  }
  // The state of a candidate; `room` holds it where it has to be worked out.
  [[nodiscard]] SetView bits_of(const Candidate& candidate, std::vector<std::uint64_t>& room) {
    if (crew_ != nullptr) return {arrived_.states.data() + candidate.parent * words_, words_};
    write_successor(state_of(layer_, candidate.parent), candidate.connection, form_, room);
    return room;
  }
  [[nodiscard]] double ticks_of(double promise) const { return std::floor(promise / tick_ + 0.5); }
  [[nodiscard]] std::uint64_t order_of(std::uint64_t hash) const {
    return mixed(hash + result_.statistics.sweeps);
  }
  /// The order of candidates: greater promise first. Among equals a hash decides, another one in
  /// each pass, so that passes differ; where hashes meet, the states themselves.
  [[nodiscard]] bool before(const Candidate& a, const Candidate& b) {
    const double left = ticks_of(a.promise);
    const double right = ticks_of(b.promise);
    if (left != right) return left > right;
    const std::uint64_t one = order_of(a.hash);
    const std::uint64_t other = order_of(b.hash);
    if (one != other) return one < other;
    return std::ranges::lexicographical_compare(bits_of(a, one_), bits_of(b, other_));
  }
  /// Of two ways to the same state that earn the same: whether a crew takes `a`, whose parent comes
  /// first in its layer. So does a search that is alone, by the order in which it finds them.
  [[nodiscard]] bool comes_first(const Origin& a, ConnectionIndex by_a, const Origin& b,
                                 ConnectionIndex by_b) const {
    const double left = ticks_of(a.promise);
    const double right = ticks_of(b.promise);
    if (left != right) return left > right;
    const std::uint64_t one = order_of(a.hash);
    const std::uint64_t other = order_of(b.hash);
    return one != other ? one < other : by_a < by_b;
  }

  /// Runs one pass. Returns the greatest promise of a state that found no room in it; -infinity
  /// where every state did.
  double pass(std::size_t width) {
    const std::size_t depth = system_.num_steps();
    double left_out = -kInfinity;
    taken_.clear();
    taken_by_.clear();
    begins_.assign(1, 0);
    layer_.clear();
    if (crew_ == nullptr || member_of(0) == crew_->member()) {
      const ConnectionSet start = system_.start();
      layer_.states.assign(start.view().begin(), start.view().end());
      layer_.rewards.push_back(0);
      layer_.rests.push_back(bounded_ ? (*workers_.front().bound)(start.view()) : 0);
      layer_.hashes.push_back(0);
    }
    std::uint64_t size = 1;
    for (std::size_t k = 0; k < depth && size > 0; ++k) {
      const bool last = k + 1 == depth;
      left_out = std::max(left_out, crew_ != nullptr ? expand_layer_with_crew(width, last)
                                                     : expand_layer(width, last));
      if (result_.stop != Stop::None) return left_out;
      make_next_layer();
      size = crew_ != nullptr ? at_most_ : layer_.size();
    }
    // The only state of the last layer is the goal.
    std::array<double, 2> ends = {left_out,
                                  layer_.size() > 0 ? layer_.rewards.front() : -kInfinity};
    if (crew_ != nullptr) crew_->take_greatest(ends);
    if (size > 0 && (ends[1] > result_.reward || !result_.has_plan())) take_plan(ends[1]);
    return ends[0];
  }

  // Fills survivors_ with the best `width` successors of the layer.
  double expand_layer(std::size_t width, bool last) {
    double left_out = -kInfinity;
    survivors_.clear();
    slots_.assign(64, 0);
    const std::size_t size = layer_.size();
    // The same for any number of threads, so that the answer is the same.
    constexpr std::size_t chunk = 1024;
    width_ = width;
    for (std::size_t begin = 0; begin < size; begin += chunk) {
      const std::size_t survivors_before = survivors_.size();
      const std::size_t end = std::min(size, begin + chunk);
      merge_all(expand(begin, end, last));
      grew_by_ = survivors_.size() - survivors_before;
      if (survivors_.size() > 2 * width) left_out = std::max(left_out, cut_down(width));
      poll();
      if (result_.stop != Stop::None) return left_out;
    }
    if (survivors_.size() > width) left_out = std::max(left_out, cut_down(width));
    return left_out;
  }

  // Expands states of the layer. Returns how many workers did.
  std::size_t expand(std::size_t begin, std::size_t end, bool last) {
    const std::size_t size = end - begin;
    const std::size_t used = size < 4 * workers_.size() ? 1 : workers_.size();
    detail::run_parallel(used, [&](std::size_t t) {
      const detail::Share share = detail::share_of(size, used, t);
      work(workers_[t], begin + share.begin, begin + share.end, last);
    });
    return used;
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

  /// What a member of the crew tells each other before what it found.
  struct CrewHead {
    std::uint64_t expanded = 0;
    std::uint64_t generated = 0;
    std::uint64_t pruned = 0;
    std::uint64_t found = 0;  ///< for all members together
    std::uint64_t left = 0;   ///< states of the layer that it still has to expand
    Stop stop = Stop::None;
    bool fault = false;
  };
  /// A successor as it is sent to the member that it belongs to; its state follows.
  struct Record {
    double reward;
    double rest;
    double parent_promise;
    std::uint64_t parent_hash;
    std::uint32_t parent;
    ConnectionIndex connection;
  };

  /// Which member a state belongs to. By other bits of the hash than those by which it is found.
  [[nodiscard]] std::size_t member_of(std::uint64_t hash) const {
    return static_cast<std::size_t>(mixed(hash) >> 32U) % crew_->size();
  }

  // As expand_layer, of a layer of which each member of the crew holds the states that belong to
  // it. The members go through the same rounds, in each of which they expand some of their states
  // and send the successors to where they belong. What is kept depends on no order of arrival.
  double expand_layer_with_crew(std::size_t width, bool last) {
    double left_out = -kInfinity;
    survivors_.clear();
    arrived_.clear();
    slots_.assign(64, 0);
    at_most_ = 0;
    width_ = width;
    const std::size_t size = layer_.size();
    // Few enough states a round that what they lead to takes little beside the layer, and many
    // enough that rounds are few.
    constexpr std::size_t kMostBytes = std::size_t{64} << 20U;
    const std::size_t bytes_of_state = (sizeof(Record) + 8 * words_) * system_.num_connections();
    const std::size_t chunk = std::max<std::size_t>(
        1, std::min(kMostBytes / bytes_of_state, std::clamp<std::size_t>(width / 32, 128, 1024)));
    std::size_t begin = 0;
    for (std::uint64_t left = 1; left > 0;) {
      const std::size_t survivors_before = survivors_.size();
      const std::size_t end = std::min(size, begin + chunk);
      left = exchange_found(begin, end, last);
      begin = end;
      grew_by_ = survivors_.size() - survivors_before;
      if (result_.stop != Stop::None) return left_out;
      if (left > 0 && at_most_ > 2 * width) {
        if (width > kNarrow) count_survivors();
        if (at_most_ > 2 * width) left_out = std::max(left_out, cut_down_together(width));
      }
      poll();
    }
    if (at_most_ > width && width > kNarrow) count_survivors();
    if (at_most_ > width) left_out = std::max(left_out, cut_down_together(width));
    return left_out;
  }

  // One round: expands states, exchanges what was found, and takes over what belongs here. A stop
  // or a fault of any member is one of all, at this place. Returns how many states all members
  // still have to expand.
  std::uint64_t exchange_found(std::size_t begin, std::size_t end, bool last) {
    CrewHead head;
    head.stop = own_stop_;
    head.left = layer_.size() - end;
    std::string fault;
    std::size_t used = 0;
    if (head.stop == Stop::None) {
      try {
        used = expand(begin, end, last);
      } catch (const InputError& error) {
        fault = error.what();
        head.fault = true;
      }
    }
    for (std::size_t t = 0; t < used; ++t) {
      Worker& worker = workers_[t];
      head.expanded += worker.expanded;
      head.generated += worker.generated;
      head.pruned += worker.pruned;
      for (const std::string& found : worker.found_for) head.found += found.size();
      worker.expanded = worker.generated = worker.pruned = 0;
      if (head.stop == Stop::None) head.stop = worker.stop;
    }
    head.found /= sizeof(Record) + 8 * words_;
    std::vector<std::string> texts(crew_->size());
    exchanged_bytes_ = 0;
    for (std::size_t member = 0; member < texts.size(); ++member) {
      texts[member].assign(reinterpret_cast<const char*>(&head), sizeof head);
      for (std::size_t t = 0; t < used; ++t) {
        texts[member] += workers_[t].found_for[member];
        workers_[t].found_for[member].clear();
      }
      exchanged_bytes_ += texts[member].size();
    }
    texts = crew_->exchange(std::move(texts));
    std::uint64_t left = 0;
    bool any_fault = false;
    for (const std::string& text : texts) {
      std::memcpy(&head, text.data(), sizeof head);
      result_.statistics.expanded += head.expanded;
      result_.statistics.generated += head.generated;
      result_.statistics.pruned += head.pruned;
      if (result_.stop == Stop::None) result_.stop = head.stop;
      at_most_ += head.found;
      left += head.left;
      any_fault |= head.fault;
      exchanged_bytes_ += text.size();
    }
    if (any_fault) throw_first_fault(fault);
    if (result_.stop == Stop::None && result_.statistics.expanded >= budget_.max_expansions)
      result_.stop = Stop::ExpansionLimit;
    if (result_.stop != Stop::None) return left;
    for (std::size_t member = 0; member < texts.size(); ++member) take_over(member, texts[member]);
    return left;
  }
  void throw_first_fault(const std::string& mine) {
    for (const std::string& told : crew_->told_by_all(mine)) {
      if (!told.empty()) throw InputError(told);
    }
  }

  void append_record(Worker& worker, std::uint32_t parent, ConnectionIndex connection,
                     double reward, double rest) const {
    write_successor(state_of(layer_, parent), connection, worker.form, worker.next);
    const std::uint64_t parent_hash = layer_.hashes[parent];
    const Record record{.reward = reward,
                        .rest = rest,
                        .parent_promise = layer_.rewards[parent] + layer_.rests[parent],
                        .parent_hash = parent_hash,
                        .parent = parent,
                        .connection = connection};
    std::string& found = worker.found_for[member_of(
        worker.form ? hash_value(worker.next) : parent_hash ^ mark_of(connection))];
    found.append(reinterpret_cast<const char*>(&record), sizeof record);
    found.append(reinterpret_cast<const char*>(worker.next.data()), 8 * words_);
  }
  // Takes over what `member` found of the states that belong here.
  void take_over(std::size_t member, const std::string& text) {
    for (std::size_t at = sizeof(CrewHead); at < text.size();) {
      Record record;
      std::memcpy(&record, text.data() + at, sizeof record);
      at += sizeof record;
      const auto slot = static_cast<std::uint32_t>(arrived_.origins.size());
      arrived_.states.resize(arrived_.states.size() + words_);
      std::uint64_t* const state = arrived_.states.data() + slot * words_;
      std::memcpy(state, text.data() + at, 8 * words_);
      at += 8 * words_;
      arrived_.origins.push_back({.parent = record.parent,
                                  .member = static_cast<std::uint32_t>(member),
                                  .promise = record.parent_promise,
                                  .hash = record.parent_hash});
      const std::uint64_t hash = form_ ? hash_value(SetView(state, words_))
                                       : record.parent_hash ^ mark_of(record.connection);
      if (merge({record.reward + record.rest, record.reward, record.rest, hash, slot,
                 record.connection}))
        continue;
      arrived_.states.resize(slot * words_);
      arrived_.origins.resize(slot);
    }
  }

  // Sets at_most_ to the number of survivors that all members have.
  void count_survivors() {
    std::array<std::uint64_t, 1> count = {survivors_.size()};
    crew_->take_sums(count);
    at_most_ = count[0];
  }
  // Keeps the best `width` survivors of all members together, where there are more. Returns the
  // greatest promise of those of this member that are left out.
  double cut_down_together(std::size_t width) {
    std::ranges::sort(survivors_,
                      [this](const Candidate& a, const Candidate& b) { return before(a, b); });
    const std::size_t kept = width > kNarrow ? kept_of_width(width) : kept_of_narrow(width);
    const double left_out = drop_from(kept);
    Arrived packed;
    packed.states.reserve(kept * words_);
    packed.origins.reserve(kept);
    for (Candidate& candidate : survivors_) {
      const SetView state = bits_of(candidate, one_);
      packed.states.insert(packed.states.end(), state.begin(), state.end());
      packed.origins.push_back(arrived_.origins[candidate.parent]);
      candidate.parent = static_cast<std::uint32_t>(packed.origins.size() - 1);
    }
    arrived_ = std::move(packed);
    index(slots_.size());
    at_most_ = std::min<std::uint64_t>(at_most_, width);
    return left_out;
  }
  // The order of survivors as two numbers, of which the second counts where the first are equal.
  [[nodiscard]] std::uint64_t promise_key(std::size_t i) const {
    const auto bits = std::bit_cast<std::uint64_t>(ticks_of(survivors_[i].promise) + 0.0);
    constexpr std::uint64_t sign = std::uint64_t{1} << 63U;
    return (bits & sign) != 0 ? bits : ~(bits | sign);  // ascending where doubles descend
  }
  [[nodiscard]] std::uint64_t hash_key(std::size_t i) const { return order_of(survivors_[i].hash); }

  // How many of this member's survivors, which are sorted, are among the best `width` of all, where
  // there may be fewer: all tell their best ones. Sets at_most_.
  [[nodiscard]] std::size_t kept_of_narrow(std::size_t width) {
    const std::size_t words = 2 + words_;
    std::vector<std::vector<std::uint64_t>> mine;
    std::string text;
    for (std::size_t i = 0; i < std::min(width, survivors_.size()); ++i) {
      std::vector<std::uint64_t>& one = mine.emplace_back();
      one = {promise_key(i), hash_key(i)};
      const SetView state = bits_of(survivors_[i], one_);
      one.insert(one.end(), state.begin(), state.end());
      text.append(reinterpret_cast<const char*>(one.data()), 8 * words);
    }
    std::vector<std::vector<std::uint64_t>> all = words_told(text, words);
    at_most_ = all.size();
    if (all.size() <= width) return mine.size();
    std::ranges::nth_element(all, all.begin() + static_cast<std::ptrdiff_t>(width - 1));
    return static_cast<std::size_t>(std::ranges::upper_bound(mine, all[width - 1]) - mine.begin());
  }
  // What all members tell, each so many words long.
  [[nodiscard]] std::vector<std::vector<std::uint64_t>> words_told(const std::string& mine,
                                                                   std::size_t words) {
    std::vector<std::vector<std::uint64_t>> all;
    for (const std::string& told : crew_->told_by_all(mine)) {
      for (std::size_t at = 0; at < told.size(); at += 8 * words) {
        all.emplace_back(words);
        std::memcpy(all.back().data(), told.data() + at, 8 * words);
      }
    }
    return all;
  }
  // The same of a wide beam, of which there are more than `width`.
  [[nodiscard]] std::size_t kept_of_width(std::size_t width) {
    // By promise; those that promise as much as the last by hash; then by the states themselves.
    std::size_t begin = 0;
    std::size_t end = survivors_.size();
    std::uint64_t wanted = width;
    // Goes on with the stretch of equal keys in which the last one lies, or is done.
    const auto narrow = [&](auto key_of) {
      const detail::CrewCut cut = detail::cut_of_all(
          *crew_, end - begin, [&](std::size_t i) { return key_of(begin + i); }, wanted);
      end = begin + cut.end;
      begin += cut.begin;
      const bool done = cut.up_to == wanted;
      wanted -= cut.below;
      return done;
    };
    if (narrow([&](std::size_t i) { return promise_key(i); }) ||
        narrow([&](std::size_t i) { return hash_key(i); }))
      return end;
    std::string mine;
    for (std::size_t i = begin; i < end; ++i) {
      const SetView state = bits_of(survivors_[i], one_);
      mine.append(reinterpret_cast<const char*>(state.data()), 8 * words_);
    }
    std::vector<std::vector<std::uint64_t>> states = words_told(mine, words_);
    std::ranges::sort(states);
    const std::vector<std::uint64_t>& last = states[wanted - 1];
    while (begin < end &&
           !std::ranges::lexicographical_compare(last, bits_of(survivors_[begin], one_)))
      ++begin;
    return begin;
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
        if (crew_ != nullptr) {
          append_record(worker, static_cast<std::uint32_t>(i), c, reward, worker.rests[a]);
          continue;
        }
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

  // Returns whether its state is new.
  bool merge(const Candidate& candidate) {
    if (survivors_.size() * 2 >= slots_.size()) index(slots_.size() * 4);
    std::size_t i = mixed(candidate.hash) & (slots_.size() - 1);
    while (slots_[i] != 0) {
      Candidate& other = survivors_[slots_[i] - 1];
      if (same_state(other, candidate)) {
        ++merged_;
        if (candidate.reward > other.reward) {
          replace(other, candidate);
          ++reopened_;
        } else if (crew_ != nullptr && candidate.reward == other.reward &&
                   comes_first(arrived_.origins[candidate.parent], candidate.connection,
                               arrived_.origins[other.parent], other.connection)) {
          replace(other, candidate);
        }
        return false;
      }
      i = (i + 1) & (slots_.size() - 1);
    }
    survivors_.push_back(candidate);
    slots_[i] = static_cast<std::uint32_t>(survivors_.size());
    return true;
  }
  // Puts a better way to the same state in the place of a survivor.
  void replace(Candidate& survivor, const Candidate& candidate) {
    const std::uint32_t place = survivor.parent;
    survivor = candidate;
    if (crew_ == nullptr) return;
    arrived_.origins[place] = arrived_.origins[candidate.parent];
    survivor.parent = place;
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
    const double left_out = drop_from(width);
    // nth_element leaves an order of its own; what follows must not depend on it.
    std::sort(survivors_.begin(), survivors_.end(), order);
    index(slots_.size());
    return left_out;
  }

  // Leaves out all survivors from the given place on. Returns the greatest promise of them.
  double drop_from(std::size_t kept) {
    double left_out = -kInfinity;
    for (std::size_t i = kept; i < survivors_.size(); ++i)
      left_out = std::max(left_out, bounded_ ? survivors_[i].promise : kInfinity);
    survivors_.resize(kept);
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
      const SetView state = bits_of(candidate, one_);
      next_.states.insert(next_.states.end(), state.begin(), state.end());
      next_.rewards.push_back(candidate.reward);
      next_.rests.push_back(candidate.rest);
      next_.hashes.push_back(candidate.hash);
      std::uint32_t parent = candidate.parent;
      if (crew_ != nullptr) {
        const Origin& origin = arrived_.origins[candidate.parent];
        parent = origin.parent;
        taken_by_.push_back(origin.member);
      }
      taken_.push_back({parent, static_cast<std::uint16_t>(candidate.connection)});
    }
    begins_.push_back(taken_.size());
    std::swap(layer_, next_);
  }

  void take_plan(double reward) {
    const std::size_t depth = system_.num_steps();
    result_.reward = reward;
    result_.status = Status::Feasible;
    result_.sequence.assign(depth, 0);
    std::size_t index = 0;
    std::size_t member = crew_ != nullptr ? member_of_goal() : 0;
    for (std::size_t k = depth; k-- > 0;) {
      // Of a crew the member that holds the state knows how it was reached, and tells the others.
      std::array<double, 3> back = {-1, -1, -1};
      if (crew_ == nullptr || member == crew_->member()) {
        const Taken& taken = taken_[begins_[k] + index];
        back = {static_cast<double>(taken.connection), static_cast<double>(taken.parent),
                crew_ != nullptr ? static_cast<double>(taken_by_[begins_[k] + index]) : 0};
      }
      if (crew_ != nullptr) crew_->take_greatest(back);
      result_.sequence[k] = static_cast<std::uint32_t>(back[0]);
      index = static_cast<std::size_t>(back[1]);
      member = static_cast<std::size_t>(back[2]);
    }
    if (form_) result_.sequence = true_sequence(system_, *form_, result_.sequence);
  }
  // Only one member has a last layer.
  [[nodiscard]] std::size_t member_of_goal() {
    std::array<double, 1> member = {layer_.size() > 0 ? static_cast<double>(crew_->member()) : -1};
    crew_->take_greatest(member);
    return static_cast<std::size_t>(member[0]);
  }

  /// The memory that `vector` holds, and that of the copy that it moves to if it soon has `size`
  /// items.
  template <class Item>
  [[nodiscard]] static std::uint64_t bytes_with(const std::vector<Item>& vector, std::size_t size) {
    const std::size_t held = vector.capacity();
    return (size <= held ? held : held + std::max(size, 2 * held)) * sizeof(Item);
  }

  void poll() {
    std::uint64_t bytes =
        taken_.capacity() * sizeof(Taken) + taken_by_.capacity() * sizeof(std::uint32_t) +
        arrived_.states.capacity() * 8 + arrived_.origins.capacity() * sizeof(Origin) +
        exchanged_bytes_ + survivors_.capacity() * sizeof(Candidate) +
        slots_.capacity() * sizeof(std::uint32_t);
    for (const Layer* layer : {&layer_, &next_})
      bytes += layer->states.capacity() * 8 + layer->size() * 24;
    for (const Worker& worker : workers_) bytes += worker.found.capacity() * sizeof(Candidate);
    peak_bytes_ = std::max(peak_bytes_, bytes);
    // Memory is judged before it is taken: by what the next chunk and the next layer may need.
    // Tables grow by doubling, and for a moment both the old and the new one are there.
    const std::size_t survivors = survivors_.size() + 2 * grew_by_;
    const std::size_t next = std::min(survivors, width_);
    std::uint64_t soon = bytes_with(taken_, taken_.size() + next) + exchanged_bytes_ +
                         bytes_with(survivors_, survivors) +
                         bytes_with(slots_, survivors * 2 < slots_.size() ? 0 : slots_.size() * 4) +
                         bytes_with(next_.states, next * words_) + layer_.states.capacity() * 8 +
                         (layer_.size() + next_.rewards.capacity() + next) * 24;
    if (crew_ != nullptr) {
      soon += bytes_with(taken_by_, taken_by_.size() + next) +
              bytes_with(arrived_.states, survivors * words_) +
              bytes_with(arrived_.origins, survivors);
    }
    for (const Worker& worker : workers_) soon += worker.found.capacity() * sizeof(Candidate);
    // A member of a crew tells the others, and all stop in the next round.
    Stop& stop = crew_ != nullptr ? own_stop_ : result_.stop;
    if (stop == Stop::None)
      stop =
          soon > allowed_ ? Stop::MemoryLimit : budget_.expired(soon, result_.statistics.expanded);
    budget_.report({.phase = "pass",
                    .done = result_.statistics.sweeps,
                    .states = layer_.size(),
                    .best = result_.reward});
  }

  /// A crew that keeps so few states tells their promises instead of counting them.
  static constexpr std::size_t kNarrow = 1024;
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
  /// Where there is advice: the width of its next pass, and how many questions it was asked.
  std::unique_ptr<detail::AdvisedPass> advised_;
  std::size_t advised_width_ = 2;
  std::uint64_t asked_ = 0;
  /// Promises that differ by less than this are equal.
  double tick_ = 1;
  /// The least upper bound on any plan that was proved.
  double proved_;
  std::uint64_t peak_bytes_ = 0;
  /// How many successors met one of the same state, and how many of these were better.
  std::uint64_t merged_ = 0;
  std::uint64_t reopened_ = 0;
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
  /// Of a crew: what the survivors name; which member each item of taken_ came from; how many
  /// survivors all members have at most; and the bytes of the last exchange.
  Arrived arrived_;
  std::vector<std::uint32_t> taken_by_;
  std::uint64_t at_most_ = 0;
  std::uint64_t exchanged_bytes_ = 0;
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
