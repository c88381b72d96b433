#include "orasp/explain/grounds.h"

#include <algorithm>
#include <optional>

#include "orasp/model/detail/wording.h"
#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

using detail::in_quotes;
using detail::number_text;

std::string counted_parts(std::size_t number) {
  return std::to_string(number) + (number == 1 ? " part" : " parts");
}

std::string joined(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
  return text;
}

/// A plan's steps with the number that each connection has in either order.
class Numbers {
 public:
  Numbers(const Problem& problem, std::span<const Step> steps)
      : problem_(problem), total_(steps.size()), number_(problem.num_connections()) {
    const bool assembly = problem.direction() == Direction::Assembly;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      for (const ConnectionIndex c : steps[i].connections)
        number_[c] = assembly ? total_ - i : i + 1;
    }
  }
  /// In disassembly order; empty where the plan does not handle it.
  [[nodiscard]] std::optional<std::size_t> of(ConnectionIndex c) const { return number_[c]; }
  /// `"1-2" (step 3)`.
  [[nodiscard]] std::string disassembly(ConnectionIndex c) const {
    return name(c) + (number_[c] ? " (step " + std::to_string(*number_[c]) + ")" : "");
  }
  [[nodiscard]] std::string assembly(ConnectionIndex c) const {
    return name(c) + (number_[c] ? " (step " + std::to_string(total_ + 1 - *number_[c]) + ")" : "");
  }

 private:
  [[nodiscard]] std::string name(ConnectionIndex c) const {
    return in_quotes(problem_.connection_id(c));
  }
  const Problem& problem_;
  std::size_t total_;
  std::vector<std::optional<std::size_t>> number_;
};

/// The clauses of precedence that bind this step and are met. What is removed after a connection is
/// made before it: in disassembly the clause binds the one that goes later, in assembly the one
/// that is made later.
void add_precedence(const Problem& problem, const Numbers& numbers, ConnectionIndex c,
                    std::vector<Ground>& found) {
  const auto own = numbers.of(c);
  const bool assembly = problem.direction() == Direction::Assembly;
  const auto comes_off_before = [&](ConnectionIndex other) {
    const auto number = numbers.of(other);
    // In an assembly that is cut short, what is not made is off.
    if (!number) return problem.direction() == Direction::Assembly;
    return own && *number < *own;
  };
  for (const PrecedenceClause& clause : problem.precedence()) {
    const std::string where = "precedence[" + std::to_string(clause.entry) + "]";
    if (assembly && clause.connection != c && numbers.of(clause.connection) && own &&
        *own < *numbers.of(clause.connection) &&
        std::ranges::find(clause.after, c) != clause.after.end()) {
      found.push_back({Constraint::Precedence, where,
                       "goes before " + numbers.disassembly(clause.connection),
                       "is made only after " + numbers.assembly(clause.connection)});
    }
    if (clause.connection != c) continue;
    if (!assembly && !clause.after.empty() && std::ranges::all_of(clause.after, comes_off_before)) {
      std::vector<std::string> off;
      std::vector<std::string> on;
      for (const ConnectionIndex other : clause.after) {
        off.push_back(numbers.disassembly(other));
        on.push_back(numbers.assembly(other));
      }
      found.push_back({Constraint::Precedence, where, "goes only after " + joined(off),
                       "is made before " + joined(on)});
    }
    const auto comes_off_later = [&](ConnectionIndex other) {
      const auto number = numbers.of(other);
      return number ? own && *number > *own : !assembly;
    };
    const auto held = std::ranges::find_if(clause.made_after_any, comes_off_later);
    if (held != clause.made_after_any.end()) {
      std::vector<std::string> any;
      for (const ConnectionIndex other : clause.made_after_any)
        any.push_back(in_quotes(problem.connection_id(other)));
      found.push_back(
          {Constraint::PrecedenceMadeAny, where,
           "goes while at least one of " + joined(any) + " is there, here " +
               numbers.disassembly(*held),
           "is made after at least one of " + joined(any) + ", here " + numbers.assembly(*held)});
    }
    const auto one = std::ranges::find_if(clause.after_any, comes_off_before);
    if (one != clause.after_any.end()) {
      std::vector<std::string> any;
      for (const ConnectionIndex other : clause.after_any)
        any.push_back(in_quotes(problem.connection_id(other)));
      found.push_back(
          {Constraint::PrecedenceAny, where,
           "goes only after at least one of " + joined(any) + ", here " + numbers.disassembly(*one),
           "is made before at least one of " + joined(any) + ", here " + numbers.assembly(*one)});
    }
  }
}

/// Names of the directions in which the moved piece leaves, and of their opposites, in which it
/// comes on.
struct Ways {
  std::vector<std::string> off;
  std::vector<std::string> on;
};

Ways ways_of(const Problem& problem, const std::vector<DirectionIndex>& free) {
  Ways ways;
  for (const DirectionIndex d : free) {
    ways.off.push_back(problem.direction_name(d));
    ways.on.push_back(problem.direction_name(opposite(d)));
  }
  return ways;
}

}  // namespace

std::vector<std::vector<Ground>> grounds(const TransitionSystem& system,
                                         std::span<const Step> steps) {
  const Problem& problem = system.problem();
  const Limits& limits = problem.limits();
  const bool assembly = problem.direction() == Direction::Assembly;
  const Numbers numbers(problem, steps);
  Expander expander(system);
  ConnectionSet open = system.start();

  std::vector<std::vector<Ground>> all;
  all.reserve(steps.size());
  for (const Step& step : steps) {
    std::vector<Ground> found;
    for (const ConnectionIndex c : step.connections) add_precedence(problem, numbers, c, found);
    if (step.separates) {
      if (limits.max_subassemblies) {
        // Counted where the two pieces are apart: after the removal, before the joining.
        const std::size_t apart = assembly
                                      ? system.subassemblies(system.present(open.view()).view())
                                      : step.subassemblies;
        const std::string most = std::to_string(*limits.max_subassemblies);
        const std::string count = std::to_string(apart);
        if (apart <= *limits.max_subassemblies) {
          found.push_back({Constraint::MaxSubassemblies, "limits.max_subassemblies",
                           "leaves " + count + " of at most " + most + " subassemblies",
                           "starts from " + count + " of at most " + most + " subassemblies"});
        }
      }
      if (limits.grounded)
        found.push_back({Constraint::Grounded, "limits.grounded",
                         "each subassembly still holds a base part",
                         "the subassembly that it makes holds a base part"});
      if (limits.max_moved_parts && step.moves() &&
          step.moved().size() <= *limits.max_moved_parts) {
        const std::string text = "moves " + std::to_string(step.moved().size()) + " of at most " +
                                 counted_parts(*limits.max_moved_parts);
        found.push_back({Constraint::MaxMovedParts, "limits.max_moved_parts", text, text});
      }
      if (limits.max_moved_mass && step.moves() &&
          step.moved_mass <= *limits.max_moved_mass * (1 + kRelativeTolerance)) {
        const std::string text = "moves " + number_text(step.moved_mass) + " of at most " +
                                 number_text(*limits.max_moved_mass) + " kg";
        found.push_back({Constraint::MaxMovedMass, "limits.max_moved_mass", text, text});
      }
      const auto free = system.wide() ? step.free_directions
                                      : expander.free_directions(open.view(), step.connection);
      if (!free.empty()) {
        const Ways ways = ways_of(problem, free);
        const bool every = free.size() == problem.directions().size();
        found.push_back({Constraint::Blocking, "blocking",
                         every ? "nothing is in the way: free along " + joined(ways.off)
                               : "free to leave along " + joined(ways.off),
                         every ? "nothing is in the way: free along " + joined(ways.on)
                               : "free to come on along " + joined(ways.on)});
      }
    }
    all.push_back(std::move(found));
    for (const ConnectionIndex c : step.connections) open.erase(c);
  }
  return all;
}

}  // namespace orasp
