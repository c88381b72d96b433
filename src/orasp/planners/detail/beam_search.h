#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "orasp/bounds/bound.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/beam.h"
#include "orasp/planners/detail/advised_pass.h"
#include "orasp/planners/detail/crew.h"
#include "orasp/planners/detail/order_search.h"
#include "orasp/planners/detail/step_in_front.h"
#include "orasp/planners/planner_support.h"
#include "orasp/symmetry/symmetry.h"

namespace orasp::detail {

/// The search of beam(): passes over the layers of H, each pass twice as wide as the one before.
/// What a search that is alone does stands in beam_search.cpp, what a crew does in place of it in
/// beam_crew.cpp.
class BeamSearch {
 public:
  BeamSearch(const TransitionSystem& system, const BeamOptions& options, const Budget& budget,
             Result& result);

  [[nodiscard]] bool bounded() const { return bounded_; }

  void run();

  /// Whether the search came to its end: then its plan is optimal, and where it has no plan there
  /// is none.
  [[nodiscard]] bool done() const { return done_; }

  /// The symmetry that was used in the end.
  [[nodiscard]] const std::optional<Symmetry>& symmetry() const { return symmetry_; }

 private:
  void look_for_symmetry();

  void follow_advice();

  [[nodiscard]] bool all_found_the_same(const std::optional<Symmetry>& symmetry) const;

  // Writes the state to which `connection` leads, or the one that stands for it.
  void write_successor(SetView state, ConnectionIndex connection, std::optional<OrbitForm>& form,
                       std::vector<std::uint64_t>& next) const {
    next.assign(state.begin(), state.end());
    next[connection / 64] &= ~(std::uint64_t{1} << (connection % 64));
    if (form) form->canonical_but_for(connection, next);
  }

  void improve_order();

  void take_plan_of_first();

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
    std::unique_ptr<StepInFront> in_front;
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
    return result_.has_plan() && meets(result_.reward, proved_);
  }
  [[nodiscard]] SetView state_of(const Layer& layer, std::size_t i) const {
    return {layer.states.data() + i * words_, words_};
  }
  [[nodiscard]] static std::uint64_t mark_of(ConnectionIndex c) { return mixed(c + 1U); }
  [[nodiscard]] bool same_state(const Candidate& a, const Candidate& b);
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
  [[nodiscard]] bool before(const Candidate& a, const Candidate& b);
  /// Of two ways to the same state that earn the same: whether a crew takes `a`, whose parent comes
  /// first in its layer. So does a search that is alone, by the order in which it finds them.
  [[nodiscard]] bool comes_first(const Origin& a, ConnectionIndex by_a, const Origin& b,
                                 ConnectionIndex by_b) const;

  /// Runs one pass. Returns the greatest promise of a state that found no room in it; -infinity
  /// where every state did.
  double pass(std::size_t width);

  double expand_layer(std::size_t width, bool last);

  std::size_t expand(std::size_t begin, std::size_t end, bool last);

  void merge_all(std::size_t workers);

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

  double expand_layer_with_crew(std::size_t width, bool last);

  std::uint64_t exchange_found(std::size_t begin, std::size_t end, bool last);
  void throw_first_fault(const std::string& mine) {
    for (const std::string& told : crew_->told_by_all(mine)) {
      if (!told.empty()) throw InputError(told);
    }
  }

  void append_record(Worker& worker, std::uint32_t parent, ConnectionIndex connection,
                     double reward, double rest) const;
  void take_over(std::size_t member, const std::string& text);

  // Sets at_most_ to the number of survivors that all members have.
  void count_survivors() {
    std::array<std::uint64_t, 1> count = {survivors_.size()};
    crew_->take_sums(count);
    at_most_ = count[0];
  }
  double cut_down_together(std::size_t width);
  // The order of survivors as two numbers, of which the second counts where the first are equal.
  [[nodiscard]] std::uint64_t promise_key(std::size_t i) const {
    const auto bits = std::bit_cast<std::uint64_t>(ticks_of(survivors_[i].promise) + 0.0);
    constexpr std::uint64_t sign = std::uint64_t{1} << 63U;
    return (bits & sign) != 0 ? bits : ~(bits | sign);  // ascending where doubles descend
  }
  [[nodiscard]] std::uint64_t hash_key(std::size_t i) const { return order_of(survivors_[i].hash); }

  [[nodiscard]] std::size_t kept_of_narrow(std::size_t width);
  [[nodiscard]] std::vector<std::vector<std::uint64_t>> words_told(const std::string& mine,
                                                                   std::size_t words);
  [[nodiscard]] std::size_t kept_of_width(std::size_t width);

  void work(Worker& worker, std::size_t begin, std::size_t end, bool last);

  bool merge(const Candidate& candidate);
  void replace(Candidate& survivor, const Candidate& candidate);
  void index(std::size_t slots);
  double cut_down(std::size_t width);

  double drop_from(std::size_t kept);

  void make_next_layer();

  void take_plan(double reward);
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

  void poll();

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
  Crew* crew_;
  /// Why this member of the crew has to stop.
  Stop own_stop_ = Stop::None;
  bool bounded_ = false;
  bool done_ = false;
  /// Where rewards depend on when steps come; and the reward of the last plan that it improved.
  std::unique_ptr<OrderSearch> orders_;
  double improved_ = kInfinity;
  /// Where there is advice: the width of its next pass, and how many questions it was asked.
  std::unique_ptr<AdvisedPass> advised_;
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

}  // namespace orasp::detail
