#pragma once

/// orasp: the best order in which robots put a product together, with proof. A tour of the library:
///
///     #include "orasp/orasp.h"
///
///     // A problem: parts, connections, constraints, an objective; built in, from a file, by hand.
///     orasp::Problem problem = orasp::load_scenario("hubble");
///     problem = orasp::read_problem("shelf.json");
///
///     // A plan. Status says what was proved; "no plan" is a status, not an exception.
///     const orasp::Result result = orasp::solve(problem, "value-iteration");
///     if (result.status == orasp::Status::Optimal) use(result.reward, result.sequence);
///
///     // The same by hand: rules, the state-action graph H, a planner on it.
///     const orasp::TransitionSystem system(problem);
///     const orasp::StateGraph graph = orasp::StateGraph::build(system, {});
///     use(orasp::bellman_ford(graph, {}, {}).values);  // best reward from the start to each state
///
///     // Step by step: what is legal, what it earns, and why not.
///     orasp::Expander expander(system);
///     orasp::ConnectionSet state = system.start();
///     use(expander.legal_actions(state.view()));
///     use(expander.violations(state.view(), 3));       // every reason, in words and as data
///
///     // Why there is no plan: a smallest set of constraints that conflict.
///     use(orasp::explain_problem(problem, {}).conflict);
///
///     // Your own objective: any function of the step.
///     orasp::Callable mine;
///     mine.reward = [](const orasp::Step& step) { return -1.0 * step.after; };
///     use(orasp::solve(problem.with_objective({"callable", mine}), "dijkstra"));
///
///     // Learning: a policy that answers in microseconds from any state. Training needs libtorch,
///     // planning does not.
///     const orasp::Budget minute = orasp::Budget::with_time_limit(60);
///     const orasp::Training training = orasp::train(system, {}, minute);
///     use(orasp::follow_policy(system, training.trained.policy, {}));
///
///     // A learner of your own: episodes side by side, millions of steps a second.
///     orasp::VectorEnvironment world(system, 1024);
///     std::vector<std::int64_t> actions(world.size());
///     std::vector<double> rewards(world.size());
///     world.sample(actions);
///     world.step(actions, {.rewards = rewards});
///
///     // Several robots in synchronous steps: the fewest steps, or the least travel.
///     const orasp::Problem lattice = orasp::load_scenario("fleet-lattice");
///     use(orasp::solve(lattice, "fleet-search").fleet_plan.steps);
///
///     // From CAD: parts, contacts, what blocks what. Reading needs OpenCASCADE or assimp,
///     // planning does not.
///     const orasp::ImportedAssembly pump =
///         orasp::assembly_from_cad(orasp::read_model({.models = {"pump.step"}}, {}), {});
///     use(orasp::solve(orasp::Problem(pump.problem), "auto"));
///
///     // Figures for a paper, as SVG files: structure, steps, H, growth.
///     orasp::write_figures(problem, {.plan = result.sequence}, "figures", {});
///
/// Folders: model (problem, rules), task (budget, result), bounds, graph (H), planners (one method
/// a pair of files), cluster (several processes), mip, explain, execution (replanning), learning,
/// fleet, geometry (CAD), io (files), drawing, report, catalogue (all planners by name). Errors:
/// InputError, and nothing else is thrown on purpose. Units: kg, m, s; geometry: mm.

#include "orasp/bounds/bound_kinds.h"
#include "orasp/bounds/connection_bound.h"
#include "orasp/bounds/piece_bound.h"
#include "orasp/catalogue.h"
#include "orasp/certificate/certificate.h"
#include "orasp/cluster/cluster_a_star.h"
#include "orasp/cluster/cluster_beam.h"
#include "orasp/cluster/cluster_value_iteration.h"
#include "orasp/cluster/ranks.h"
#include "orasp/cluster/share_out.h"
#include "orasp/cluster/workshop.h"
#include "orasp/drawing/document.h"
#include "orasp/drawing/figures.h"
#include "orasp/execution/plan_changes.h"
#include "orasp/execution/replanner.h"
#include "orasp/execution/simulation.h"
#include "orasp/explain/alternatives.h"
#include "orasp/explain/explain_connection.h"
#include "orasp/explain/explain_problem.h"
#include "orasp/explain/plan_order.h"
#include "orasp/fleet/fleet.h"
#include "orasp/fleet/fleet_expander.h"
#include "orasp/fleet/fleet_heuristics.h"
#include "orasp/fleet/fleet_mip.h"
#include "orasp/fleet/fleet_search.h"
#include "orasp/fleet/fleet_validate.h"
#include "orasp/geometry/assembly_from_cad.h"
#include "orasp/geometry/cad_reader.h"
#include "orasp/geometry/mesh_reader.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/graph_size.h"
#include "orasp/graph/state_graph.h"
#include "orasp/graph/state_index.h"
#include "orasp/graph/uncertain_graph.h"
#include "orasp/io/certificate_json.h"
#include "orasp/io/explanation_json.h"
#include "orasp/io/fleet_plan_json.h"
#include "orasp/io/formats.h"
#include "orasp/io/import_files.h"
#include "orasp/io/model_files.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/problem_source.h"
#include "orasp/io/scenarios.h"
#include "orasp/io/state_policy_json.h"
#include "orasp/learning/dqn.h"
#include "orasp/learning/environment.h"
#include "orasp/learning/policy.h"
#include "orasp/learning/q_learning.h"
#include "orasp/learning/vector_environment.h"
#include "orasp/mip/mip.h"
#include "orasp/model/operations.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/problem.h"
#include "orasp/model/random.h"
#include "orasp/model/scenario_generators.h"
#include "orasp/model/step_directions.h"
#include "orasp/model/transition_system.h"
#include "orasp/model/validate.h"
#include "orasp/planners/a_star.h"
#include "orasp/planners/and_or.h"
#include "orasp/planners/automatic.h"
#include "orasp/planners/beam.h"
#include "orasp/planners/bellman_ford.h"
#include "orasp/planners/dense_value_iteration.h"
#include "orasp/planners/dijkstra.h"
#include "orasp/planners/exhaustive.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/orasp_search.h"
#include "orasp/planners/random_rewards.h"
#include "orasp/planners/random_sequence.h"
#include "orasp/planners/reward_statistics.h"
#include "orasp/planners/uncertain_search.h"
#include "orasp/planners/uncertain_value_iteration.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/task/memory_limit.h"
#include "orasp/task/task.h"
