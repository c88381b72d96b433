#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/catalogue.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/graph_policy_file.h"
#include "orasp/io/policy_file.h"
#include "orasp/io/problem_json.h"
#include "orasp/learning/dqn.h"
#include "orasp/learning/network.h"
#include "orasp/learning/policy.h"
#include "orasp/method_options.h"
#include "outcome.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

using PolicyPointer = std::shared_ptr<PolicyFile>;

std::optional<double> finite(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// As a line of the log that `orasp train --log` writes.
py::dict record_as_dict(const TrainingRecord& record) {
  py::dict line;
  line["episodes"] = record.episodes;
  line["updates"] = record.updates;
  line["epsilon"] = record.epsilon;
  line["loss"] = record.loss;
  line["greedy"] = finite(record.greedy);
  line["best_greedy"] = finite(record.best_greedy);
  line["best"] = finite(record.best);
  line["bound"] = record.bound;
  line["seconds"] = record.seconds;
  return line;
}

PolicyFile file_of(const Problem& problem, const TrainedPolicy& trained) {
  return {.problem_digest = problem_digest(problem),
          .problem_name = problem.name(),
          .trained = trained};
}

DqnOptions training_options_called(const OptionTexts& given, std::uint64_t seed) {
  Options options;
  for (const auto& [name, text] : given) {
    std::string of_table = name;
    std::ranges::replace(of_table, '_', '-');
    const std::span<const OptionSpec> rows = training_options();
    const auto row = std::ranges::find(rows, of_table, &OptionSpec::name);
    if (row == rows.end()) throw InputError(fmt::format("train has no option {}", name));
    set_option(*row, name, text, options);
  }
  options.dqn.seed = seed;
  return options.dqn;
}

py::tuple train_policy(const ProblemPointer& problem, const OptionTexts& given, std::uint64_t seed,
                       const PolicyPointer& resume, const std::string& checkpoint,
                       double checkpoint_every, const py::object& log, Run run) {
  require_one_robot(*problem, "train");
  DqnOptions options = training_options_called(given, seed);
  if (problem->uncertain()) {
    throw InputError(fmt::format(
        "train learns for attempts that always succeed, and an attempt at connection \"{}\" may "
        "fail (its success is below 1); `orasp solve` finds the optimal policy",
        problem->connection_id(*problem->first_uncertain())));
  }
  if (resume) {
    require_trained_on(*problem, *resume, "the policy");
    options.inputs =
        resume->trained.policy.pieces ? NetworkInputs::Pieces : NetworkInputs::Connections;
    options.hidden = resume->trained.training.hidden;
    options.known_reward = resume->trained.training.known_reward;
  }
  TrainingHooks hooks;
  hooks.save_every = checkpoint_every;
  if (!log.is_none()) {
    hooks.log = [&log](const TrainingRecord& record) {
      const py::gil_scoped_acquire acquired;
      log(record_as_dict(record));
    };
  }
  if (!checkpoint.empty()) {
    hooks.save = [&](const Training& now) {
      write_file(checkpoint, policy_bytes(file_of(*problem, now.trained)));
    };
  }
  Training training;
  run.calls_back = calls_python(*problem);
  run_watched(run, true, [&](const Budget& budget) {
    const TransitionSystem system(*problem);
    training = train(system, options, budget, hooks, resume ? &resume->trained : nullptr);
  });
  py::object policy = py::none();
  if (!training.trained.policy.empty()) {
    const auto file = std::make_shared<PolicyFile>(file_of(*problem, training.trained));
    if (!checkpoint.empty()) write_file(checkpoint, policy_bytes(*file));
    policy = py::cast(file);
  }
  auto outcome = std::make_unique<Outcome>(
      Outcome{problem, Situation::whole(problem->num_connections()), {}, {}, {}});
  outcome->result = std::move(training.result);
  return py::make_tuple(std::move(policy), std::move(outcome), record_as_dict(training.record),
                        training.device, training.warning);
}

std::unique_ptr<Outcome> follow(const ProblemPointer& problem, const PolicyFile& policy, Run run) {
  require_one_robot(*problem, "a policy");
  auto outcome = std::make_unique<Outcome>(
      Outcome{problem, Situation::whole(problem->num_connections()), {}, {}, {}});
  run.calls_back = calls_python(*problem);
  run_watched(run, true, [&](const Budget& budget) {
    const TransitionSystem system(*problem);
    outcome->result = follow_policy(system, policy.trained.policy, budget);
    require_honest(outcome->task(), outcome->result);
  });
  return outcome;
}

/// (weights, bias) of each layer as arrays of float32, shapes [inputs, outputs] and [outputs],
/// which copy nothing.
py::list layers_of(const py::object& self) {
  py::list layers;
  for (const DenseLayer& layer : self.cast<const PolicyFile&>().trained.policy.layers) {
    layers.append(py::make_tuple(
        view_of(layer.weights.data(),
                {static_cast<py::ssize_t>(layer.inputs), static_cast<py::ssize_t>(layer.outputs)},
                self),
        view_of(layer.bias.data(), {static_cast<py::ssize_t>(layer.outputs)}, self)));
  }
  return layers;
}

}  // namespace

void bind_learning(py::module_& module) {
  py::class_<PolicyFile, PolicyPointer>(module, "Policy")
      .def_readonly("problem_digest", &PolicyFile::problem_digest)
      .def_readonly("problem_name", &PolicyFile::problem_name)
      .def_property_readonly("reward", [](const PolicyFile& file) { return file.trained.reward; })
      .def_property_readonly("scale",
                             [](const PolicyFile& file) { return file.trained.policy.scale; })
      .def_property_readonly("adds_reward",
                             [](const PolicyFile& file) { return file.trained.policy.adds_reward; })
      .def_property_readonly("layers", &layers_of)
      .def("bytes", [](const PolicyFile& file) { return py::bytes(policy_bytes(file)); })
      .def("weights",
           [](const PolicyFile& file) {
             return std::make_shared<const Policy>(file.trained.policy);
           })
      .def("require_trained_on",
           [](const PolicyFile& file, const Problem& problem, const std::string& name) {
             require_trained_on(problem, file, name);
           });
  py::class_<Policy, std::shared_ptr<Policy>>(module, "Weights");
  module.def("parse_policy", [](const py::bytes& bytes) {
    return std::make_shared<PolicyFile>(parse_policy(std::string(bytes)));
  });
  py::class_<GraphPolicyFile, std::shared_ptr<GraphPolicyFile>>(module, "GeneralPolicy")
      .def_property_readonly("objective",
                             [](const GraphPolicyFile& file) { return file.kind.objective; })
      .def_property_readonly("direction",
                             [](const GraphPolicyFile& file) { return file.kind.direction; })
      .def_property_readonly("keys", [](const GraphPolicyFile& file) { return file.kind.keys; })
      .def_readonly("seed", &GraphPolicyFile::seed)
      .def("bytes", [](const GraphPolicyFile& file) { return py::bytes(graph_policy_bytes(file)); })
      .def("weights",
           [](const GraphPolicyFile& file) {
             return std::make_shared<const GraphPolicy>(file.policy);
           })
      .def("require_trained_on",
           [](const GraphPolicyFile& file, const Problem& problem, const std::string& name) {
             require_kind(problem, file.kind, name);
           });
  py::class_<GraphPolicy, std::shared_ptr<GraphPolicy>>(module, "GraphWeights");
  module.def("is_general_policy",
             [](const py::bytes& bytes) { return is_graph_policy(std::string(bytes)); });
  module.def("parse_general_policy", [](const py::bytes& bytes) {
    return std::make_shared<GraphPolicyFile>(parse_graph_policy(std::string(bytes)));
  });
  module.def("train", &train_policy);
  module.def("follow", &follow);
  module.def("learning_obstacle", &network_obstacle);
}

}  // namespace orasp::python
