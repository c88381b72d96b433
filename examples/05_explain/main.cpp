// 05: explanations. Why is there no plan, and why can this step not come first?
//
// examples/shelf-locked.json is a cabinet with two rules too many.
#include <iostream>
#include <string>

#include "orasp/orasp.h"

int main(int argc, char** argv) try {
  const std::string file = argc > 1 ? argv[1] : "examples/shelf-locked.json";
  const orasp::Problem problem = orasp::read_problem(file);

  // "No plan" is an answer, not an error: it comes with a proof.
  const orasp::Result result = orasp::solve(problem, "auto");
  std::cout << problem.name() << ": " << orasp::status_name(result.status) << '\n';

  // A smallest set of constraints that conflict. Any one of them could be given up.
  const orasp::ProblemExplanation why = orasp::explain_problem(problem, {});
  std::cout << why.conflict.size() << " constraints conflict:\n";
  for (const orasp::ConflictItem& item : why.conflict)
    std::cout << "  " << item.where << ": " << item.message << '\n';

  // Why one connection cannot be the first to go, and what would have to be different.
  const orasp::ConnectionIndex screws = problem.find_connection("right-shelf", "");
  const orasp::TransitionSystem system(problem);
  const orasp::ConnectionExplanation first =
      orasp::explain_connection(problem, system.start(), screws, {});
  std::cout << "right-shelf first: " << (first.legal ? "legal" : "not legal") << '\n';
  for (const orasp::Violation& violation : first.violations)
    std::cout << "  " << violation.where << ": " << violation.message << '\n';
  for (const orasp::Remedy& remedy : first.remedies) std::cout << "  " << remedy.message << '\n';
} catch (const orasp::InputError& error) {
  // A file that cannot be read, or that is wrong: one sentence that says where.
  std::cerr << error.what() << '\n';
  return 1;
}
