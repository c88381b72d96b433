#include "orasp/model/objectives/fleet_objectives.h"

#include <string>
#include <utility>
#include <vector>

#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

/// Planners for fleets work these objectives out from the steps of their plans. They say nothing of
/// a step of one robot.
template <class Parameters>
class FleetObjectiveKind : public ObjectiveKindOf<Parameters> {
 public:
  explicit FleetObjectiveKind(std::string type) : type_(std::move(type)) {}

 private:
  void add(const Parameters& parameters, double weight, const detail::ProblemTotals& totals,
           std::vector<WeightedTerm>& terms) const override {
    static_cast<void>(parameters);
    static_cast<void>(weight);
    static_cast<void>(totals);
    static_cast<void>(terms);
    refuse();
  }
  void add_checked(const Parameters& parameters, double weight,
                   const detail::CheckedProblem& problem,
                   std::vector<detail::CheckedTerm>& terms) const override {
    static_cast<void>(parameters);
    static_cast<void>(weight);
    static_cast<void>(problem);
    static_cast<void>(terms);
    refuse();
  }
  [[noreturn]] void refuse() const {
    throw InputError("objective: \"" + type_ +
                     "\" judges plans of several robots and no plan of one; name another "
                     "objective, or plan for the fleet");
  }

  std::string type_;
};

}  // namespace

const ObjectiveKind& makespan_kind() {
  static const FleetObjectiveKind<Makespan> kind("makespan");
  return kind;
}

const ObjectiveKind& fleet_travel_kind() {
  static const FleetObjectiveKind<FleetTravel> kind("fleet_travel");
  return kind;
}

}  // namespace orasp
