#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/model/objective.h"
#include "orasp/model/transition_system.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

/// Something of Python's in a value that the library copies and drops wherever it works.
struct Held {
  explicit Held(py::object the_object) : object(std::move(the_object)) {}
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  ~Held() {
    if (Py_IsInitialized() == 0) {
      static_cast<void>(object.release());
      return;
    }
    const py::gil_scoped_acquire acquired;
    object = {};
  }
  py::object object;
};

/// The ids of a problem as strings of Python, made once.
struct Names {
  explicit Names(const Problem& problem) {
    for (const Part& part : problem.parts()) parts.emplace_back(part.id);
    for (const Connection& c : problem.connections()) connections.emplace_back(c.id);
  }
  Names(const Names&) = delete;
  Names& operator=(const Names&) = delete;
  ~Names() {
    if (Py_IsInitialized() == 0) {
      for (py::str& id : parts) static_cast<void>(id.release());
      for (py::str& id : connections) static_cast<void>(id.release());
      return;
    }
    const py::gil_scoped_acquire acquired;
    parts.clear();
    connections.clear();
  }
  std::vector<py::str> parts;
  std::vector<py::str> connections;

  [[nodiscard]] static py::tuple some(const std::vector<py::str>& names, const auto& indices) {
    py::tuple ids(indices.size());
    for (std::size_t i = 0; i < indices.size(); ++i) ids[i] = names[indices[i]];
    return ids;
  }
};

/// A step as a function of the user sees it.
struct SeenByUser {
  Step step;
  std::shared_ptr<const Names> names;
};

/// Many steps as a function of the user sees them: only while it is called.
struct Steps {
  const StepTable* table = nullptr;

  [[nodiscard]] const StepTable& checked() const {
    if (table == nullptr)
      throw std::runtime_error("the steps are gone: they are there while the reward is asked for");
    return *table;
  }
  [[nodiscard]] py::object column(const std::string& name) const {
    const StepTable& steps = checked();
    for (std::size_t i = 0; i < steps.names.size(); ++i) {
      if (steps.names[i] != name) continue;
      const std::vector<double>& numbers = steps.columns[i];
      if (name == "index")
        return array_of(std::vector<std::int64_t>(numbers.begin(), numbers.end()));
      if (name == "separates" || name == "completes") {
        py::array_t<bool> truths(static_cast<py::ssize_t>(numbers.size()));
        bool* const truth = truths.mutable_data();
        for (std::size_t s = 0; s < numbers.size(); ++s) truth[s] = numbers[s] != 0;
        return truths;
      }
      return array_of(numbers);
    }
    return {};
  }
};

double reward_of(const py::object& answer) {
  const double reward = PyFloat_AsDouble(answer.ptr());
  if (reward == -1 && PyErr_Occurred() != nullptr) {
    if (PyErr_ExceptionMatches(PyExc_TypeError) == 0) throw py::error_already_set();
    PyErr_Clear();
    throw py::type_error(
        fmt::format("the reward of a step must be a number, not {}",
                    py::str(py::type::of(answer).attr("__name__")).cast<std::string>()));
  }
  return reward;
}

void write_rewards(const py::object& answer, std::span<double> rewards) {
  const auto numbers =
      py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(answer);
  if (!numbers) {
    PyErr_Clear();
    throw py::type_error("the rewards of many steps must be an array of numbers, not " +
                         py::str(py::type::of(answer).attr("__name__")).cast<std::string>());
  }
  if (numbers.ndim() != 1 || static_cast<std::size_t>(numbers.size()) != rewards.size()) {
    throw py::value_error(fmt::format(
        "the rewards of {} steps must be an array of shape ({},), not {}", rewards.size(),
        rewards.size(), py::str(numbers.attr("shape")).cast<std::string>()));
  }
  std::copy_n(numbers.data(), rewards.size(), rewards.data());
}

/// An objective that calls `function`.
Objective objective_of(const Problem& problem, py::object function, const std::string& name,
                       bool vectorized, double least, double greatest, const Vector3& depot) {
  const auto held = std::make_shared<const Held>(std::move(function));
  Callable callable;
  callable.name = name;
  callable.least = least;
  callable.greatest = greatest;
  callable.depot = depot;
  if (vectorized) {
    callable.rewards = [held](const StepTable& table, std::span<double> rewards) {
      end_if_overdue();
      const py::gil_scoped_acquire acquired;
      const py::object steps = py::cast(Steps{&table});
      // Whoever keeps the steps finds them gone afterwards.
      struct Close {
        Steps& steps;
        ~Close() { steps.table = nullptr; }
      } close{steps.cast<Steps&>()};
      write_rewards(held->object(steps), rewards);
    };
  } else {
    const auto names = std::make_shared<const Names>(problem);
    callable.reward = [held, names](const Step& step) {
      end_if_overdue();
      const py::gil_scoped_acquire acquired;
      return reward_of(held->object(SeenByUser{step, names}));
    };
  }
  return {"callable", std::move(callable)};
}

}  // namespace

void bind_rewards(py::module_& module) {
  const auto of_step = [](auto member) {
    return [member](const SeenByUser& seen) { return seen.step.*member; };
  };
  py::class_<SeenByUser>(module, "Step")
      .def_property_readonly("index",
                             [](const SeenByUser& seen) { return seen.step.connection.value(); })
      .def_property_readonly(
          "connection",
          [](const SeenByUser& seen) { return seen.names->connections[seen.step.connection]; })
      .def_property_readonly("connections",
                             [](const SeenByUser& seen) {
                               if (seen.step.connections.empty())
                                 return Names::some(seen.names->connections,
                                                    std::vector{seen.step.connection});
                               return Names::some(seen.names->connections, seen.step.connections);
                             })
      .def_property_readonly("before", of_step(&Step::before))
      .def_property_readonly("after", of_step(&Step::after))
      .def_property_readonly("separates", of_step(&Step::separates))
      .def_property_readonly("completes", of_step(&Step::completes))
      .def_property_readonly("moves", [](const SeenByUser& seen) { return seen.step.moves(); })
      .def_property_readonly(
          "a", [](const SeenByUser& seen) { return Names::some(seen.names->parts, seen.step.a); })
      .def_property_readonly(
          "b", [](const SeenByUser& seen) { return Names::some(seen.names->parts, seen.step.b); })
      .def_property_readonly(
          "moved",
          [](const SeenByUser& seen) {
            return Names::some(seen.names->parts,
                               seen.step.moves() ? seen.step.moved() : std::vector<PartIndex>());
          })
      .def_property_readonly(
          "kept",
          [](const SeenByUser& seen) {
            return Names::some(seen.names->parts,
                               seen.step.separates ? seen.step.kept() : std::vector<PartIndex>());
          })
      .def_property_readonly("moved_mass", of_step(&Step::moved_mass))
      .def_property_readonly("kept_mass", of_step(&Step::kept_mass))
      .def_property_readonly("subassemblies", of_step(&Step::subassemblies));

  py::class_<Steps>(module, "Steps")
      .def("__len__", [](const Steps& steps) { return steps.checked().num_steps(); })
      .def_property_readonly("names", [](const Steps& steps) { return steps.checked().names; })
      .def("__getitem__",
           [](const Steps& steps, const std::string& name) {
             py::object column = steps.column(name);
             if (!column) throw py::key_error(name);
             return column;
           })
      .def("__getattr__", [](const Steps& steps, const std::string& name) {
        py::object column = steps.column(name);
        if (!column) {
          throw py::attribute_error(fmt::format("steps have no column {}; they have {}", name,
                                                fmt::join(steps.checked().names, ", ")));
        }
        return column;
      });

  module.def("objective_of", &objective_of, py::arg("problem"), py::arg("function"),
             py::arg("name"), py::arg("vectorized"), py::arg("least"), py::arg("greatest"),
             py::arg("depot"));
}

}  // namespace orasp::python
