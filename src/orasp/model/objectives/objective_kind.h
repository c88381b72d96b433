#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "orasp/model/detail/checked_reward.h"
#include "orasp/model/formula.h"
#include "orasp/model/objective.h"
#include "orasp/model/objectives/objective_term.h"
#include "orasp/model/problem.h"

namespace orasp {

enum class NumberRange { Any, NotNegative, AboveZero };

/// What objectives want to know of the steps before the one at hand.
struct LookBack {
  std::vector<std::string> attributes{};  ///< each once, in the order in which they are met
  bool place = false;                     ///< where the step before was done

  void add_attribute(const std::string& name) {
    if (std::ranges::find(attributes, name) == attributes.end()) attributes.push_back(name);
  }
};

/// Walks the parameters of an objective, key by key, in the order in which a file lists them.
/// Whoever checks, reads or writes objectives derives from it; which member is called says what
/// kind of value stands under the key.
class ParameterVisitor {
 public:
  ParameterVisitor() = default;
  ParameterVisitor(const ParameterVisitor&) = delete;
  ParameterVisitor& operator=(const ParameterVisitor&) = delete;
  virtual ~ParameterVisitor() = default;

  virtual void number(std::string_view key, double& value, NumberRange allowed) = 0;
  void number(std::string_view key, double& value) { number(key, value, NumberRange::Any); }
  virtual void point(std::string_view key, Vector3& value) = 0;
  virtual void costs_by_size(std::string_view key, std::map<std::size_t, double>& costs) = 0;
  virtual void constants(std::string_view key, std::map<std::string, double>& constants) = 0;
  virtual void name(std::string_view key, std::string& name) = 0;
  virtual void optional_name(std::string_view key, std::optional<std::string>& name) = 0;
  virtual void optional_point(std::string_view key, std::optional<Vector3>& value) = 0;
  virtual void changes(std::string_view key, std::vector<ChangeCost>& changes) = 0;
  /// A file must state it; whoever reads it sets the compiler.
  virtual void formula(std::string_view key, std::string& text, FormulaCompiler& compiler) = 0;
  /// A file must state them.
  virtual void terms(std::string_view key, std::vector<WeightedObjective>& terms) = 0;
};

/// What is known of the objectives of one formula. There is one object for each, without state; its
/// row in objective_table.h names it. Errors are InputError with one sentence, in which `place`
/// stands in front.
class ObjectiveKind {
 public:
  ObjectiveKind() = default;
  ObjectiveKind(const ObjectiveKind&) = delete;
  ObjectiveKind& operator=(const ObjectiveKind&) = delete;
  virtual ~ObjectiveKind() = default;

  /// The parameters that hold where a file states none.
  [[nodiscard]] virtual ObjectiveParameters defaults() const = 0;
  /// Whether the parameters are of this kind. All members below ask for such.
  [[nodiscard]] virtual bool takes(const ObjectiveParameters& parameters) const = 0;
  /// Shows the visitor every parameter that a file may state.
  virtual void visit_parameters(ObjectiveParameters& parameters,
                                ParameterVisitor& visitor) const = 0;
  /// Checks what is not seen from one parameter alone.
  virtual void check(const ObjectiveParameters& parameters, const std::string& place) const = 0;
  /// Checks that the problem, whose parts and connections are checked already, has what the formula
  /// looks at.
  virtual void check_problem(const ObjectiveParameters& parameters, const ProblemSpec& problem,
                             const std::string& place) const = 0;
  /// Adds what the formula wants to know of the steps before.
  virtual void add_look_back(const ObjectiveParameters& parameters, LookBack& look_back) const = 0;
  /// Adds the formula, resolved for one problem, to the addends of the problem's objective. The
  /// terms may refer to the parameters and to `totals`.
  virtual void add_terms(const ObjectiveParameters& parameters, double weight,
                         const detail::ProblemTotals& totals,
                         std::vector<WeightedTerm>& terms) const = 0;
  /// Adds the formula stated a second time, for the check of plans. It shares nothing with the
  /// first: a mistake in one of the two must show. The terms may refer to the parameters and to
  /// `problem`.
  virtual void add_checked_terms(const ObjectiveParameters& parameters, double weight,
                                 const detail::CheckedProblem& problem,
                                 std::vector<detail::CheckedTerm>& terms) const = 0;
};

/// A kind whose parameters are a `P`. What an objective says of itself is what it overrides here.
template <class P>
class ObjectiveKindOf : public ObjectiveKind {
 public:
  [[nodiscard]] ObjectiveParameters defaults() const override { return P{}; }
  [[nodiscard]] bool takes(const ObjectiveParameters& parameters) const override {
    return std::holds_alternative<P>(parameters);
  }
  void visit_parameters(ObjectiveParameters& parameters, ParameterVisitor& visitor) const final {
    list(std::get<P>(parameters), visitor);
  }
  void check(const ObjectiveParameters& parameters, const std::string& place) const final {
    check_whole(std::get<P>(parameters), place);
  }
  void check_problem(const ObjectiveParameters& parameters, const ProblemSpec& problem,
                     const std::string& place) const final {
    require_of_problem(std::get<P>(parameters), problem, place);
  }
  void add_look_back(const ObjectiveParameters& parameters, LookBack& look_back) const final {
    look_back_at(std::get<P>(parameters), look_back);
  }
  void add_terms(const ObjectiveParameters& parameters, double weight,
                 const detail::ProblemTotals& totals,
                 std::vector<WeightedTerm>& terms) const final {
    add(std::get<P>(parameters), weight, totals, terms);
  }
  void add_checked_terms(const ObjectiveParameters& parameters, double weight,
                         const detail::CheckedProblem& problem,
                         std::vector<detail::CheckedTerm>& terms) const final {
    add_checked(std::get<P>(parameters), weight, problem, terms);
  }

 protected:
  /// Names each parameter to the visitor.
  virtual void list(P& parameters, ParameterVisitor& visitor) const {
    static_cast<void>(parameters);
    static_cast<void>(visitor);
  }
  virtual void check_whole(const P& parameters, const std::string& place) const {
    static_cast<void>(parameters);
    static_cast<void>(place);
  }
  virtual void require_of_problem(const P& parameters, const ProblemSpec& problem,
                                  const std::string& place) const {
    static_cast<void>(parameters);
    static_cast<void>(problem);
    static_cast<void>(place);
  }
  virtual void look_back_at(const P& parameters, LookBack& look_back) const {
    static_cast<void>(parameters);
    static_cast<void>(look_back);
  }
  virtual void add(const P& parameters, double weight, const detail::ProblemTotals& totals,
                   std::vector<WeightedTerm>& terms) const {
    terms.push_back({weight, term(parameters, totals)});
  }
  /// The formula with its parameters resolved for one problem; null where `add` is overridden.
  [[nodiscard]] virtual std::unique_ptr<const ObjectiveTerm> term(
      const P& parameters, const detail::ProblemTotals& totals) const {
    static_cast<void>(parameters);
    static_cast<void>(totals);
    return nullptr;
  }
  virtual void add_checked(const P& parameters, double weight,
                           const detail::CheckedProblem& problem,
                           std::vector<detail::CheckedTerm>& terms) const {
    detail::CheckedTerm term = checked(parameters, problem);
    term.weight = weight;
    terms.push_back(std::move(term));
  }
  /// The formula once more; without a function where `add_checked` is overridden.
  [[nodiscard]] virtual detail::CheckedTerm checked(const P& parameters,
                                                    const detail::CheckedProblem& problem) const {
    static_cast<void>(parameters);
    static_cast<void>(problem);
    return {};
  }
};

/// The kind of a checked objective.
[[nodiscard]] const ObjectiveKind& kind_of(const Objective& objective);

}  // namespace orasp
