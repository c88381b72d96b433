#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/catalogue.h"
#include "orasp/execution/plan_changes.h"
#include "orasp/execution/replanner.h"
#include "orasp/execution/waiting.h"
#include "orasp/explain/explain_problem.h"
#include "orasp/io/plan_json.h"
#include "outcome.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

using Ids = std::vector<std::string>;

ConnectionSet connections_called(const Problem& problem, const Ids& ids, const char* label) {
  ConnectionSet set(problem.num_connections());
  for (const std::string& id : ids) set.insert(problem.find_connection(id, label));
  return set;
}

/// All connections of the parts.
ConnectionSet connections_of_parts(const Problem& problem, const Ids& ids, const char* label) {
  ConnectionSet set(problem.num_connections());
  for (const std::string& id : ids) {
    const PartIndex part = problem.find_part(id, label);
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      if (problem.ends(c)[0] == part || problem.ends(c)[1] == part) set.insert(c);
    }
  }
  return set;
}

std::vector<ConnectionIndex> listed(const ConnectionSet& set) {
  std::vector<ConnectionIndex> list;
  for_each_connection(set.view(), [&](ConnectionIndex c) { list.push_back(c); });
  return list;
}

/// The steps of an old plan, none of which handles a connection twice.
std::vector<PlanStep> old_steps(const Problem& problem, const std::string& text) {
  std::vector<PlanStep> steps = plan_steps(problem, parse_plan(text, problem.direction()));
  ConnectionSet met(problem.num_connections());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    for (const ConnectionIndex c : steps[i].connections) {
      if (met.contains(c)) {
        throw InputError(fmt::format("plan: step {}: \"{}\" is handled a second time", i + 1,
                                     problem.connection_id(c)));
      }
      met.insert(c);
    }
  }
  return steps;
}

/// What is known beside the plan.
struct Replanned {
  std::unique_ptr<Outcome> outcome;
  std::optional<PlanChanges> changes;
  std::optional<std::vector<ConnectionIndex>> waiting;
  std::optional<std::vector<ConnectionIndex>> reachable;
  std::optional<ProblemExplanation> why;
};

py::tuple as_tuple(Replanned found) {
  const Problem& problem = *found.outcome->problem;
  const auto ids = [&](const std::optional<std::vector<ConnectionIndex>>& connections) {
    return connections ? py::object(ids_of(problem, *connections)) : py::object(py::none());
  };
  py::object changes = py::none();
  if (found.changes) {
    const PlanChanges& made = *found.changes;
    py::dict all;
    all["kept"] = ids_of(problem, made.kept);
    all["moved"] = ids_of(problem, made.moved);
    all["dropped"] = ids_of(problem, made.dropped);
    all["added"] = ids_of(problem, made.added);
    all["reward_before"] = made.before;
    all["price"] = made.price;
    changes = std::move(all);
  }
  py::object conflict = py::none();
  if (found.why) {
    py::list items;
    for (const ConflictItem& item : found.why->conflict)
      items.append(py::make_tuple(constraint_name(item.constraint), item.where, item.message));
    conflict = std::move(items);
  }
  py::object waiting = ids(found.waiting);
  py::object reachable = ids(found.reachable);
  return py::make_tuple(std::move(found.outcome), std::move(changes), std::move(waiting),
                        std::move(reachable), std::move(conflict));
}

py::tuple replan(const ProblemPointer& problem, const std::optional<std::string>& plan,
                 std::size_t done, const Ids& removed, const Ids& inaccessible, const Ids& not_next,
                 const Ids& lost_parts, const Ids& late_parts, Run run) {
  require_one_robot(*problem, "replan");
  std::vector<PlanStep> old;
  if (plan) old = old_steps(*problem, *plan);
  if (done > old.size()) {
    throw InputError(plan ? fmt::format("done: the plan has only {} step{}, so {} cannot be done",
                                        old.size(), old.size() == 1 ? "" : "s", done)
                          : std::string("done counts the steps of an old plan; give it with plan"));
  }
  Replanned found;
  run.calls_back = calls_python(*problem);
  run_watched(run, true, [&](const Budget& budget) {
    Situation now = Situation::whole(problem->num_connections());
    const bool wide = TransitionSystem(*problem).wide();
    for (const PlanStep& step : std::span(old).first(done)) {
      if (wide) {
        note_done(*problem, step, now);
      } else {
        for (const ConnectionIndex c : step.connections) now.open.erase(c);
      }
    }
    for (const ConnectionIndex c : listed(connections_called(*problem, removed, "removed")))
      now.open.erase(c);
    now.inaccessible = connections_called(*problem, inaccessible, "inaccessible");
    now.not_next = connections_called(*problem, not_next, "not_next");
    if (!lost_parts.empty()) {
      const Waiting lost = waiting_for(
          *problem, now, connections_of_parts(*problem, lost_parts, "lost_parts"), budget);
      found.waiting = listed(lost.connections);
      for (const ConnectionIndex c : *found.waiting) now.inaccessible.insert(c);
    }
    now.late = connections_of_parts(*problem, late_parts, "late_parts");
    found.outcome = std::make_unique<Outcome>(Outcome{problem, now, {}, {}, {}});
    Result& result = found.outcome->result;
    result = solve(found.outcome->task(), "auto", {}, budget);
    if (result.status == Status::Infeasible) {
      found.why = explain_problem(*problem, now, budget);
      if (problem->spec().goal) found.reachable = still_reachable(*problem, now, budget);
    }
    if (plan && result.has_plan()) found.changes = changes_between(*problem, now, old, result);
  });
  return as_tuple(std::move(found));
}

/// A Replanner with the problem that it was made for.
class HeldReplanner {
 public:
  HeldReplanner(ProblemPointer problem, double most_actions, Run run)
      : problem_(std::move(problem)) {
    require_one_robot(*problem_, "replan");
    run.calls_back = calls_python(*problem_);
    run_watched(run, true, [&](const Budget& budget) {
      replanner_.emplace(*problem_, ReplannerOptions{most_actions}, budget);
    });
  }

  void each(const Ids& connections, const char* label,
            const std::function<void(ConnectionIndex)>& change) {
    // All are known before the first is changed.
    for (const ConnectionIndex c : listed(connections_called(*problem_, connections, label)))
      change(c);
  }
  void each_part(const Ids& parts, const char* label,
                 const std::function<void(PartIndex)>& change) {
    std::vector<PartIndex> numbers;
    for (const std::string& id : parts) numbers.push_back(problem_->find_part(id, label));
    for (const PartIndex part : numbers) change(part);
  }
  [[nodiscard]] Replanner& get() { return *replanner_; }

  void limit(std::optional<std::size_t> subassemblies, std::optional<std::size_t> parts,
             std::optional<double> mass, Run run) {
    Limits limits = problem_->limits();
    if (subassemblies) limits.max_subassemblies = subassemblies;
    if (parts) limits.max_moved_parts = parts;
    if (mass) limits.max_moved_mass = mass;
    auto changed = std::make_shared<Problem>(problem_->with_limits(limits));
    run.calls_back = calls_python(*problem_);
    run_watched(run, false, [&](const Budget& budget) { replanner_->set_limits(limits, budget); });
    problem_ = std::move(changed);
  }
  bool reweigh(const ProblemPointer& problem, Run run) {
    bool replaced = false;
    run.calls_back = calls_python(*problem);
    run_watched(run, false,
                [&](const Budget& budget) { replaced = replanner_->reweigh(*problem, budget); });
    problem_ = problem;
    return replaced;
  }
  std::unique_ptr<Outcome> plan(Run run) {
    auto outcome =
        std::make_unique<Outcome>(Outcome{problem_, replanner_->situation(), {}, {}, {}});
    run.calls_back = calls_python(*problem_);
    run_watched(run, true,
                [&](const Budget& budget) { outcome->result = replanner_->plan(budget); });
    return outcome;
  }

 private:
  ProblemPointer problem_;
  std::optional<Replanner> replanner_;
};

}  // namespace

void bind_replanning(py::module_& module) {
  module.def("replan", &replan);
  py::class_<HeldReplanner>(module, "Replanner")
      .def(py::init<ProblemPointer, double, Run>())
      .def("set_done",
           [](HeldReplanner& r, const Ids& ids, bool done) {
             r.each(ids, "done", [&](ConnectionIndex c) { r.get().set_done(c, done); });
           })
      .def("set_accessible",
           [](HeldReplanner& r, const Ids& ids, bool accessible) {
             r.each(ids, "accessible",
                    [&](ConnectionIndex c) { r.get().set_accessible(c, accessible); });
           })
      .def("set_possible_next",
           [](HeldReplanner& r, const Ids& ids, bool possible) {
             r.each(ids, "possible_next",
                    [&](ConnectionIndex c) { r.get().set_possible_next(c, possible); });
           })
      .def("set_lost",
           [](HeldReplanner& r, const Ids& ids, bool lost) {
             r.each_part(ids, "lost", [&](PartIndex part) { r.get().set_lost(part, lost); });
           })
      .def("set_late",
           [](HeldReplanner& r, const Ids& ids, bool late) {
             r.each_part(ids, "late", [&](PartIndex part) { r.get().set_late(part, late); });
           })
      .def("limit", &HeldReplanner::limit)
      .def("reweigh", &HeldReplanner::reweigh)
      .def("plan", &HeldReplanner::plan)
      .def_property_readonly("holds_graph", [](HeldReplanner& r) { return r.get().holds_graph(); })
      .def_property_readonly("held_states", [](HeldReplanner& r) { return r.get().held_states(); })
      .def_property_readonly("seconds_to_build",
                             [](HeldReplanner& r) { return r.get().seconds_to_build(); })
      .def_property_readonly("open", [](HeldReplanner& r) {
        return ids_of(r.get().problem(), listed(r.get().situation().open));
      });
}

}  // namespace orasp::python
