#include "orasp/model/objective.h"

#include <cassert>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "orasp/model/detail/wording.h"
#include "orasp/model/objectives/objective_kind.h"
#include "orasp/model/problem.h"

namespace orasp {
namespace {

using detail::in_quotes;
using detail::number_text;

[[noreturn]] void fail(const std::string& place, const std::string& message) {
  throw InputError(detail::at(place, message));
}

void require_finite(double number, const std::string& place) {
  if (!std::isfinite(number)) fail(place, number_text(number) + " is not a finite number");
}

void check(const Objective& objective, const std::string& place, std::size_t sums_outside);

/// Checks every parameter on its own.
class ParameterCheck : public ParameterVisitor {
 public:
  ParameterCheck(std::string place, std::size_t sums_outside)
      : place_(std::move(place)), sums_outside_(sums_outside) {}

  void number(std::string_view key, double& value, NumberRange allowed) override {
    const std::string place = place_of(key);
    require_finite(value, place);
    if (allowed == NumberRange::AboveZero && value <= 0)
      fail(place, number_text(value) + " is not allowed; it must be above 0");
    if (allowed == NumberRange::NotNegative && value < 0)
      fail(place, number_text(value) + " is not allowed; it must be 0 or more");
  }
  void point(std::string_view key, Vector3& value) override {
    for (std::size_t i = 0; i < value.size(); ++i)
      require_finite(value[i], place_of(key) + "[" + std::to_string(i) + "]");
  }
  void costs_by_size(std::string_view key, std::map<std::size_t, double>& costs) override {
    const std::string place = place_of(key);
    for (const auto& [size, value] : costs) {
      const std::string size_text = std::to_string(size);
      if (size < 1 || size > kMaxParts) {
        fail(place, in_quotes(size_text) + " is not a piece size; sizes are \"1\" to " +
                        in_quotes(std::to_string(kMaxParts)));
      }
      require_finite(value, place + "." + size_text);
    }
  }
  void terms(std::string_view key, std::vector<WeightedObjective>& terms) override {
    if (sums_outside_ == kMaxSumDepth)
      fail(place_, "sums stand in sums more than " + std::to_string(kMaxSumDepth) + " deep");
    const std::string place = place_of(key);
    if (terms.empty()) fail(place, "a sum needs at least one term");
    for (std::size_t i = 0; i < terms.size(); ++i) {
      const std::string term_place = place + "[" + std::to_string(i) + "]";
      const Objective& objective = terms[i].objective;
      require_finite(terms[i].weight, term_place + ".weight");
      if (objective.of_fleet()) {
        fail(term_place + ".type", in_quotes(objective.type) +
                                       " judges plans of several robots and cannot stand in a sum");
      }
      check(objective, term_place, sums_outside_ + 1);
    }
  }
  void optional_point(std::string_view key, std::optional<Vector3>& value) override {
    if (value) point(key, *value);
  }
  void changes(std::string_view key, std::vector<ChangeCost>& changes) override {
    for (std::size_t i = 0; i < changes.size(); ++i)
      require_finite(changes[i].cost, place_of(key) + "[" + std::to_string(i) + "].cost");
  }
  // What these may hold is seen only from all parameters together (ObjectiveKind::check).
  void optional_name(std::string_view /*key*/, std::optional<std::string>& /*name*/) override {}
  void constants(std::string_view /*key*/, std::map<std::string, double>& /*constants*/) override {}
  void name(std::string_view /*key*/, std::string& /*name*/) override {}
  void formula(std::string_view /*key*/, std::string& /*text*/,
               FormulaCompiler& /*compiler*/) override {}

 private:
  [[nodiscard]] std::string place_of(std::string_view key) const {
    return place_ + "." + std::string(key);
  }

  std::string place_;
  std::size_t sums_outside_;
};

void check(const Objective& objective, const std::string& place, std::size_t sums_outside) {
  const ObjectiveRow* const row = objective_row(objective.type);
  if (row != nullptr && !row->stated_as.empty() && !row->kind().takes(objective.parameters)) {
    fail(place, in_quotes(objective.type) +
                    " has fixed numbers and these parameters are others; use " +
                    in_quotes(row->stated_as));
  }
  if (row == nullptr || !row->kind().takes(objective.parameters)) {
    fail(place + ".type",
         in_quotes(objective.type) + " does not go with the objective's parameters");
  }
  ParameterCheck each(place, sums_outside);
  ObjectiveParameters parameters = objective.parameters;
  row->kind().visit_parameters(parameters, each);
  row->kind().check(objective.parameters, place);
}

}  // namespace

Objective::Objective() : Objective(named("cubesat")) {}

Objective::Objective(std::string objective_type, Parameters objective_parameters)
    : type(std::move(objective_type)), parameters(std::move(objective_parameters)) {}

Objective Objective::named(std::string_view type) {
  const ObjectiveRow* const row = objective_row(type);
  if (row == nullptr) {
    const auto known = std::span<const std::string_view>(kFileObjectiveTypes);
    throw InputError("no objective " + in_quotes(type) + "; objectives are " +
                     detail::listed(known) + detail::suggestion(type, known));
  }
  if (!row->needs.empty()) {
    throw InputError("the objective " + in_quotes(type) + " needs " + std::string(row->needs));
  }
  return {std::string(type), row->kind().defaults()};
}

bool Objective::of_fleet() const {
  const ObjectiveRow* const row = objective_row(type);
  return row != nullptr && row->of_fleet;
}

const ObjectiveKind& kind_of(const Objective& objective) {
  const ObjectiveRow* const row = objective_row(objective.type);
  assert(row != nullptr && row->kind().takes(objective.parameters));
  return row->kind();
}

void check_objective(const Objective& objective, const std::string& place) {
  check(objective, place, 0);
}

}  // namespace orasp
