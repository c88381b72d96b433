// 08: a report. One HTML page that needs nothing else: it steps through plans, says what allows
// each step, and shows what is proved. Give a file name to write it there:
//
//     example_08_report shelf.html
#include <fstream>
#include <iostream>
#include <string>

#include "orasp/orasp.h"
#include "orasp/report/report.h"

namespace {

orasp::ReportPlan shown(const orasp::Problem& problem, const orasp::Result& result,
                        const std::string& origin) {
  orasp::ReportPlan plan;
  plan.label = result.method;
  plan.origin = origin;
  for (const orasp::ConnectionIndex c : result.sequence)
    plan.sequence.push_back(problem.connection_id(c));
  return plan;
}

}  // namespace

int main(int argc, char** argv) try {
  const orasp::Problem problem = orasp::read_problem("examples/shelf.json");
  const orasp::Result best = orasp::solve(problem, "value-iteration");
  const orasp::Result quick = orasp::solve(problem, "greedy");

  orasp::Report report;
  report.title = problem.name();
  report.best = best;
  report.plans = {shown(problem, best, "The best order, proved by value iteration."),
                  shown(problem, quick, "The best step each time.")};
  const orasp::TransitionSystem system(problem);
  const std::string page = orasp::report_html(system, report);

  std::cout << "a page with " << report.plans.size() << " plans of "
            << report.plans.front().sequence.size() << " steps, "
            << (page.size() <= orasp::kMaxReportBytes ? "at most" : "more than") << " 2 MB\n";
  if (argc > 1) std::ofstream(argv[1], std::ios::binary) << page;
} catch (const orasp::InputError& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
