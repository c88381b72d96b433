#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp::detail {

/// What a learner sees of a state, a number 1 or 0 in each *column*. Column c < connections says
/// whether connection c is open: the paper's indicator vector. Where states have a context, what
/// the steps before left behind follows, 1 in at most one column each: of every attribute that the
/// objective looks back at the value in force, and the place of the last step. So the whole state
/// is seen, and two states that look the same are one.
class ObservedColumns {
 public:
  /// The system must outlive it.
  explicit ObservedColumns(const TransitionSystem& system);

  [[nodiscard]] std::size_t size() const { return size_; }
  /// What a column says: "open 1-2", "tool M4" or "place 3".
  /// @throws InputError if there is no such column.
  [[nodiscard]] std::string name(std::size_t column) const;

  /// Calls visit(column) for each column of the context that is 1. O(attributes).
  template <class Visit>
  void for_each_of_context(SetView state, Visit&& visit) const {
    std::size_t column = system_.num_connections();
    for (const Context& context : context_) {
      const std::size_t values = context.values.size();
      const std::uint64_t value = state[system_.open_words()] / context.stride % (values + 1);
      if (value != 0) visit(column + value - 1);
      column += values;
    }
  }
  /// The columns that are 1, as a set.
  void collect(SetView state, std::vector<std::uint64_t>& columns) const;

 private:
  struct Context {
    std::string name;
    std::vector<std::string> values;
    std::uint64_t stride;
  };
  const TransitionSystem& system_;
  std::vector<Context> context_;
  std::size_t size_;
};

}  // namespace orasp::detail
