#include "orasp/model/objective.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "orasp/model/detail/wording.h"
#include "orasp/model/problem.h"

namespace orasp {
namespace {

using detail::in_quotes;
using detail::number_text;

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

PieceCost cubesat_cost() {
  return {.operation = 0, .pieces = {{1, 0.0967}, {2, 0.1248}, {3, 0.1368}}, .completion = 1};
}

PieceCost custom_cost() {
  return {.operation = 0.1, .pieces = {{1, 1}, {2, 1.5}, {3, 1.75}}, .completion = 1};
}

bool equal(const PieceCost& a, const PieceCost& b) {
  return a.operation == b.operation && a.pieces == b.pieces && a.completion == b.completion;
}

[[noreturn]] void fail(const std::string& place, const std::string& message) {
  throw InputError(detail::at(place, message));
}

void require_finite(double number, const std::string& place) {
  if (!std::isfinite(number)) fail(place, number_text(number) + " is not a finite number");
}

void require_above_zero(double number, const std::string& place) {
  require_finite(number, place);
  if (number <= 0) fail(place, number_text(number) + " is not allowed; it must be above 0");
}

void require_not_negative(double number, const std::string& place) {
  require_finite(number, place);
  if (number < 0) fail(place, number_text(number) + " is not allowed; it must be 0 or more");
}

void require_finite(const Vector3& point, const std::string& place) {
  for (std::size_t i = 0; i < point.size(); ++i)
    require_finite(point[i], place + "[" + std::to_string(i) + "]");
}

/// The parameters that go with a type; the objectives without parameters of their own must have
/// their exact numbers.
bool fits(const Objective& objective) {
  const std::string& type = objective.type;
  const auto fixed_cost = [](const PieceCost& cost, std::string_view name) {
    return equal(cost, std::get<PieceCost>(Objective::named(name).parameters));
  };
  return std::visit(Overloaded{
                        [&](const PieceCost& cost) {
                          return type == "piece_cost" || ((type == "cubesat" || type == "custom") &&
                                                          fixed_cost(cost, type));
                        },
                        [&](const CubesatZone&) { return type == "cubesat_zone"; },
                        [&](const Indexed&) { return type == "indexed"; },
                        [&](const TimeObjective&) { return type == "time"; },
                        [&](const Travel&) { return type == "travel"; },
                        [&](const Fuel&) { return type == "fuel"; },
                        [&](const CompletionObjective&) { return type == "completion"; },
                        [&](const Expression&) { return type == "expression"; },
                        [&](const Callable&) { return type == "callable"; },
                        [&](const WeightedSum&) { return type == "sum"; },
                        [&](const Makespan&) { return type == "makespan"; },
                        [&](const FleetTravel&) { return type == "fleet_travel"; },
                    },
                    objective.parameters);
}

constexpr std::size_t kLongestName = 64;

bool is_identifier(std::string_view name) {
  const auto letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  return !name.empty() && name.size() <= kLongestName && letter(name[0]) &&
         std::ranges::all_of(name, [&](char c) { return letter(c) || digit(c); });
}

void check_expression(const Expression& expression, const std::string& place) {
  require_finite(expression.depot, place + ".depot");
  for (const auto& constant : expression.constants) {
    const std::string& name = constant.first;
    const double value = constant.second;
    const std::string constant_place = place + ".constants";
    if (!is_identifier(name)) {
      fail(constant_place, in_quotes(name) + " is not a name; names are up to " +
                               std::to_string(kLongestName) +
                               " letters, digits and _, not a digit first");
    }
    if (std::ranges::any_of(kFormulaVariables,
                            [&](const FormulaVariable& v) { return v.name == name; })) {
      fail(constant_place,
           in_quotes(name) + " is a variable of every formula; give the constant another name");
    }
    if (!std::isfinite(value))
      fail(constant_place + ("." + name), number_text(value) + " is not a finite number");
  }
  const std::string formula_place = place + ".formula";
  if (expression.formula.find_first_not_of(" \t\r\n") == std::string::npos) {
    fail(formula_place, "the formula is empty");
  }
  if (!expression.compiler) {
    fail(formula_place,
         "no compiler is set; set Expression::compiler to compile_formula of io/formula_parser.h");
  }
  try {
    (void)expression.compiler(expression.formula, expression.constants);
  } catch (const InputError& error) {
    fail(formula_place, error.what());
  }
}

void check(const Objective& objective, const std::string& place, std::size_t sums_outside) {
  if (!fits(objective)) {
    if (objective.type == "cubesat" || objective.type == "custom") {
      fail(place, in_quotes(objective.type) +
                      " has fixed numbers and these parameters are others; use \"piece_cost\"");
    }
    fail(place + ".type",
         in_quotes(objective.type) + " does not go with the objective's parameters");
  }
  std::visit(Overloaded{
                 [&](const PieceCost& cost) {
                   require_finite(cost.operation, place + ".operation");
                   require_finite(cost.completion, place + ".completion");
                   for (const auto& [size, value] : cost.pieces) {
                     const std::string size_text = std::to_string(size);
                     if (size < 1 || size > kMaxParts) {
                       fail(place + ".pieces", in_quotes(size_text) +
                                                   " is not a piece size; sizes are \"1\" to " +
                                                   in_quotes(std::to_string(kMaxParts)));
                     }
                     require_finite(value, place + (".pieces." + size_text));
                   }
                 },
                 [](const CubesatZone&) {},
                 [](const Indexed&) {},
                 [&](const TimeObjective& time) {
                   require_finite(time.depot, place + ".depot");
                   require_above_zero(time.speed, place + ".speed");
                   require_not_negative(time.transfer, place + ".transfer");
                 },
                 [&](const Travel& travel) { require_finite(travel.depot, place + ".depot"); },
                 [&](const Fuel& fuel) {
                   require_not_negative(fuel.dry_mass, place + ".dry_mass");
                   require_not_negative(fuel.delta_v, place + ".delta_v");
                   require_above_zero(fuel.isp, place + ".isp");
                 },
                 [&](const CompletionObjective& completion) {
                   require_finite(completion.join, place + ".join");
                   require_finite(completion.step, place + ".step");
                   require_finite(completion.bonus, place + ".bonus");
                 },
                 [&](const Expression& expression) { check_expression(expression, place); },
                 [&](const Callable& callable) {
                   if (!callable.reward) fail(place + ".reward", "the callable holds no function");
                   if (!(callable.least <= callable.greatest)) {
                     fail(place, "least " + number_text(callable.least) + " and greatest " +
                                     number_text(callable.greatest) + " are not a range");
                   }
                 },
                 [&](const WeightedSum& sum) {
                   if (sums_outside == kMaxSumDepth) {
                     fail(place,
                          "sums stand in sums more than " + std::to_string(kMaxSumDepth) + " deep");
                   }
                   if (sum.terms.empty()) fail(place + ".terms", "a sum needs at least one term");
                   for (std::size_t i = 0; i < sum.terms.size(); ++i) {
                     const std::string term_place = place + ".terms[" + std::to_string(i) + "]";
                     require_finite(sum.terms[i].weight, term_place + ".weight");
                     if (sum.terms[i].objective.of_fleet()) {
                       fail(term_place + ".type", in_quotes(sum.terms[i].objective.type) +
                                                      " judges plans of several robots and cannot "
                                                      "stand in a sum");
                     }
                     check(sum.terms[i].objective, term_place, sums_outside + 1);
                   }
                 },
                 [](const Makespan&) {},
                 [](const FleetTravel&) {},
             },
             objective.parameters);
}

}  // namespace

Objective::Objective() : Objective("cubesat", cubesat_cost()) {}

Objective::Objective(std::string objective_type, Parameters objective_parameters)
    : type(std::move(objective_type)), parameters(std::move(objective_parameters)) {}

Objective Objective::named(std::string_view type) {
  const auto with = [type](Parameters parameters) {
    return Objective{std::string(type), std::move(parameters)};
  };
  if (type == "cubesat") return Objective{};
  if (type == "piece_cost") return with(PieceCost{});
  if (type == "cubesat_zone") return with(CubesatZone{});
  if (type == "custom") return with(custom_cost());
  if (type == "indexed") return with(Indexed{});
  if (type == "time") return with(TimeObjective{});
  if (type == "travel") return with(Travel{});
  if (type == "fuel") return with(Fuel{});
  if (type == "completion") return with(CompletionObjective{});
  if (type == "makespan") return with(Makespan{});
  if (type == "fleet_travel") return with(FleetTravel{});
  if (type == "expression") throw InputError("the objective \"expression\" needs a formula");
  if (type == "sum") throw InputError("the objective \"sum\" needs its terms");
  if (type == "callable")
    throw InputError("the objective \"callable\" needs a function of the step");
  std::vector<std::string_view> known(kObjectiveTypes.begin(), kObjectiveTypes.end());
  known.insert(known.end(), kFleetObjectiveTypes.begin(), kFleetObjectiveTypes.end());
  throw InputError("no objective " + in_quotes(type) + "; objectives are " + detail::listed(known) +
                   detail::suggestion(type, known));
}

bool Objective::of_fleet() const {
  return std::holds_alternative<Makespan>(parameters) ||
         std::holds_alternative<FleetTravel>(parameters);
}

void check_objective(const Objective& objective, const std::string& place) {
  check(objective, place, 0);
}

}  // namespace orasp
