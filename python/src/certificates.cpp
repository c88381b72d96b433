#include <cmath>
#include <optional>
#include <string>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/certificate/certificate.h"
#include "orasp/io/certificate_json.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/problem_json.h"
#include "outcome.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

/// The certificate of a result as a file, and why there is none: one of them is empty.
py::tuple certificate_of(const Outcome& outcome, Run run) {
  const Problem& problem = *outcome.problem;
  if (const std::string reason = without_certificates(problem); !reason.empty())
    throw InputError(reason);
  const Result& result = outcome.result;
  if (!result.has_plan() && result.status != Status::Infeasible)
    throw InputError("there is neither a plan nor a proof that there is none");
  std::string text;
  std::string reason;
  run.calls_back = calls_python(problem);
  run_watched(run, true, [&](const Budget& budget) {
    const auto stop = [&budget] { return budget.expired() != Stop::None; };
    const Certified made = result.status == Status::Infeasible
                               ? certify(problem, std::nullopt, stop)
                               : certify(problem, result.sequence, stop);
    reason = made.reason;
    if (made.certificate) text = certificate_text(problem, *made.certificate);
  });
  return py::make_tuple(text, reason);
}

std::optional<double> finite(double number) {
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

/// The verdict on a plan, or on the claim that there is none: (proved, kind, reward, bound,
/// tolerance, inequalities, fault, whether the plan names another problem).
py::tuple check(const ProblemPointer& problem, const std::optional<std::string>& plan_text,
                const std::string& certificate_text, Run run) {
  if (const std::string reason = without_certificates(*problem); !reason.empty())
    throw InputError(reason);
  std::optional<PlanFile> plan;
  std::optional<Certificate> certificate;
  OptimalityCheck verdict;
  run.calls_back = calls_python(*problem);
  run_watched(run, false, [&](const Budget&) {
    if (plan_text) plan = parse_plan(*plan_text, problem->direction());
    certificate = parse_certificate(*problem, certificate_text);
    verdict = plan ? check_optimality(*problem, *plan, *certificate)
                   : check_infeasibility(*problem, *certificate);
  });
  const bool of_another_problem =
      plan && !plan->problem_digest.empty() && plan->problem_digest != problem_digest(*problem);
  return py::make_tuple(verdict.proved, kind_name(certificate->kind),
                        plan ? std::optional(verdict.reward) : std::nullopt, finite(verdict.bound),
                        verdict.tolerance, verdict.inequalities, verdict.fault, of_another_problem);
}

}  // namespace

void bind_certificates(py::module_& module) {
  module.def("certificate", &certificate_of);
  module.def("check", &check);
}

}  // namespace orasp::python
