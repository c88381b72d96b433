#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/transition_system.h"

namespace orasp::detail {

/// The steps of a problem as numbers from 0, the same in every state: its *columns*. Column c is to
/// handle connection c. Where the objective looks at the direction in which a piece leaves
/// (`changeover` of `direction`), each connection has 1 + directions columns: the first where
/// nothing moves, then one for each direction of Problem::directions(). Where a plan may end before
/// nothing is left (Goal::Stop::Best), the last column is to end it.
class ActionColumns {
 public:
  /// @throws InputError where steps take parts off: these are too many to be numbered.
  explicit ActionColumns(const TransitionSystem& system);

  [[nodiscard]] std::size_t size() const { return connections_ * ways_ + (may_stop_ ? 1 : 0); }
  [[nodiscard]] std::uint32_t column(const PlanStep& step) const;
  /// What a column takes; no connections: the plan ends.
  [[nodiscard]] PlanStep step(std::uint32_t column) const;

 private:
  std::vector<DirectionIndex> directions_;  ///< where steps are told apart by them
  std::size_t connections_;
  std::size_t ways_;  ///< columns of a connection
  bool may_stop_;
};

/// What a state permits, remembered: for each state that was met its legal actions, what they earn
/// and where they lead, as Expander said it once. States have numbers from 0.
///
/// Memory. A state that was met: its words and 28 to 40 bytes; one that was expanded: 16 bytes for
///         each legal action and a bit for each column more.
class TransitionCache {
 public:
  static constexpr std::uint32_t kUnknown = 0xffffffffU;
  struct Transition {
    double reward;
    std::uint32_t column;
    std::uint32_t next;  ///< the state that it leads to; kUnknown until it is asked for
  };

  enum class Steps {
    Columns,  ///< steps are told apart by ActionColumns
    Places,   ///< the column of a step is its place among those of its state; there are no masks
  };
  /// The system must outlive it; with Steps::Places it must be wide().
  /// @throws InputError as ActionColumns.
  explicit TransitionCache(const TransitionSystem& system, Steps steps = Steps::Columns);

  /// Not with Steps::Places.
  [[nodiscard]] const ActionColumns& columns() const { return *columns_; }
  /// The number of a state, which is added if it is new.
  std::uint32_t number(SetView state);
  [[nodiscard]] SetView state(std::uint32_t number) const { return {table_.key(number), words_}; }
  /// Sees to it that expand() expands this state, unless that was done before.
  void want(std::uint32_t number) {
    if (expansion_[number] == kUnknown) wanted_.push_back(number);
  }
  /// Expands the states that are wanted, together. @throws what Expander::legal_actions throws;
  /// then those that were not expanded are as if they had not been wanted.
  void expand();

  // Of states that were expanded.

  /// The number under which a state's actions stand; O(1).
  [[nodiscard]] std::uint32_t expansion(std::uint32_t number) const { return expansion_[number]; }
  /// The legal columns of an expansion, a bit each.
  [[nodiscard]] SetView mask(std::uint32_t expansion) const {
    return {masks_.data() + expansion * mask_words_, mask_words_};
  }
  /// Its actions, ascending by column.
  [[nodiscard]] std::span<const Transition> transitions(std::uint32_t expansion) const {
    return {transitions_.data() + first_[expansion], first_[expansion + 1] - first_[expansion]};
  }
  /// The place of a column among all transitions; it must be legal. O(columns / 64).
  [[nodiscard]] std::uint64_t place(std::uint32_t expansion, std::uint32_t column) const {
    const std::uint64_t* const words = masks_.data() + expansion * mask_words_;
    std::uint64_t place = first_[expansion];
    for (std::size_t w = 0; w < column / 64; ++w)
      place += static_cast<std::uint64_t>(std::popcount(words[w]));
    const std::uint64_t below = (std::uint64_t{1} << (column % 64)) - 1;
    return place + static_cast<std::uint64_t>(std::popcount(words[column / 64] & below));
  }
  [[nodiscard]] const Transition& transition(std::uint64_t place) const {
    return transitions_[place];
  }
  /// The state that a transition out of `number` leads to.
  std::uint32_t next(std::uint32_t number, std::uint64_t place) {
    const std::uint32_t known = transitions_[place].next;
    return known != kUnknown ? known : find_next(number, place);
  }

  /// States expanded, here and in those that came before this one.
  [[nodiscard]] std::uint64_t expanded() const { return expanded_; }
  void count_as_well(std::uint64_t expanded) { expanded_ += expanded; }
  [[nodiscard]] std::size_t states() const { return table_.size(); }
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  std::uint32_t find_next(std::uint32_t from, std::uint64_t place);
  void remember(std::uint32_t from, std::span<const Action> legal);

  const TransitionSystem& system_;
  Expander expander_;
  std::optional<ActionColumns> columns_;  ///< none with Steps::Places
  std::size_t words_;
  std::size_t mask_words_;
  StateTable<0> table_;
  GrowingArray<std::uint32_t> expansion_;  ///< by state; kUnknown where it was not expanded
  GrowingArray<std::uint64_t> masks_;      ///< of shape [expansions, mask_words_]
  GrowingArray<std::uint64_t> first_;      ///< by expansion, and one more: where its actions begin
  GrowingArray<Transition> transitions_;
  std::vector<std::uint32_t> wanted_;
  std::vector<std::uint64_t> batch_;
  std::vector<std::uint64_t> scratch_;
  std::uint64_t expanded_ = 0;
};

}  // namespace orasp::detail
