#include <cstdint>
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
#include "orasp/drawing/figures.h"
#include "orasp/drawing/graphviz.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/graph_size.h"
#include "orasp/graph/state_graph.h"
#include "orasp/planners/bellman_ford.h"
#include "orasp/planners/value_iteration.h"
#include "outcome.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

/// H with what it refers to.
struct Graph {
  explicit Graph(ProblemPointer the_problem) : problem(std::move(the_problem)), system(*problem) {}

  ProblemPointer problem;
  TransitionSystem system;
  std::optional<StateGraph> graph;

  [[nodiscard]] const StateGraph& h() const { return *graph; }
};

std::shared_ptr<Graph> build(const ProblemPointer& problem, Run run) {
  require_one_robot(*problem, "graph");
  const auto made = std::make_shared<Graph>(problem);
  run.calls_back = calls_python(*problem);
  run_watched(run, false, [&](const Budget& budget) {
    if (const auto reason = graph_obstacle(made->system, budget))
      throw InputError("graph " + *reason);
    made->graph.emplace(StateGraph::build(made->system, budget));
  });
  return made;
}

template <class T>
py::array show(std::span<const T> numbers, const py::object& owner) {
  return view_of(numbers.data(), {static_cast<py::ssize_t>(numbers.size())}, owner);
}

py::array states_of_graph(const py::object& self) {
  const StateGraph& h = self.cast<const Graph&>().h();
  const std::span<const std::uint64_t> words = h.states();
  const auto states = static_cast<py::ssize_t>(h.num_states());
  const py::ssize_t width = states == 0 ? 0 : static_cast<py::ssize_t>(words.size()) / states;
  return view_of(words.data(), {states, width}, self);
}

py::array successors_of(const py::object& self) {
  const std::span<const StateId> successors = self.cast<const Graph&>().h().successors();
  static_assert(sizeof(StateId) == sizeof(std::uint32_t));
  return view_of(reinterpret_cast<const std::uint32_t*>(successors.data()),
                 {static_cast<py::ssize_t>(successors.size())}, self);
}

py::array connections_of(const py::object& self) {
  const StateGraph& h = self.cast<const Graph&>().h();
  return h.wide_connections().empty() ? show(h.narrow_connections(), self)
                                      : show(h.wide_connections(), self);
}

/// The rewards of all actions, in eight bytes each.
py::array rewards_of(const py::object& self) {
  const auto& rewards = self.cast<const Graph&>().h().rewards();
  if (!rewards.numbered()) return show(rewards.plain_values(), self);
  std::vector<double> all(rewards.size());
  {
    const py::gil_scoped_release released;
    rewards.with_reader([&](const auto& reader) {
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = reader(i);
    });
  }
  return array_of(std::move(all));
}

py::object reward_numbers_of(const py::object& self) {
  const auto& rewards = self.cast<const Graph&>().h().rewards();
  if (!rewards.numbered()) return py::none();
  return rewards.wide_numbers().empty() ? show(rewards.narrow_numbers(), self)
                                        : show(rewards.wide_numbers(), self);
}

py::object reward_table_of(const py::object& self) {
  const auto& rewards = self.cast<const Graph&>().h().rewards();
  if (!rewards.numbered()) return py::none();
  return show(std::span<const double>(rewards.distinct()), self);
}

py::array layer_offsets_of(const Graph& graph) {
  std::vector<std::int64_t> offsets;
  for (std::size_t layer = 0; layer < graph.h().num_layers(); ++layer)
    offsets.push_back(graph.h().layer_begin(layer));
  offsets.push_back(static_cast<std::int64_t>(graph.h().num_states()));
  return array_of(std::move(offsets));
}

py::array values_of(const Graph& graph, bool from_start, Run run) {
  Result result;
  run_watched(run, false, [&](const Budget& budget) {
    result =
        from_start ? bellman_ford(graph.h(), {}, budget) : value_iteration(graph.h(), {}, budget);
  });
  if (result.stop != Stop::None)
    throw InputError(fmt::format("the values are not known: the work was {}",
                                 result.stop == Stop::Cancelled
                                     ? std::string("interrupted")
                                     : fmt::format("stopped by the {}", stop_name(result.stop))));
  return array_of(std::move(result.values));
}

py::tuple size_of(const Graph& graph) {
  GraphSize size;
  {
    const py::gil_scoped_release released;
    size = graph_size(graph.h());
  }
  py::list layers;
  for (const LayerSize& layer : size.layers)
    layers.append(py::make_tuple(layer.states, layer.actions));
  return py::make_tuple(size.states, size.actions, std::move(layers), size.dead_ends,
                        size.tree_nodes, size.sequences);
}

std::vector<ConnectionIndex> indices_of(const std::vector<std::uint32_t>& numbers) {
  return {numbers.begin(), numbers.end()};
}

}  // namespace

void bind_graph(py::module_& module) {
  using Release = py::call_guard<py::gil_scoped_release>;
  py::class_<Graph, std::shared_ptr<Graph>>(module, "Graph")
      .def_property_readonly("num_states", [](const Graph& g) { return g.h().num_states(); })
      .def_property_readonly("num_actions", [](const Graph& g) { return g.h().num_actions(); })
      .def_property_readonly("open_words", [](const Graph& g) { return g.system.open_words(); })
      .def_property_readonly("wide", [](const Graph& g) { return g.system.wide(); })
      .def_property_readonly("stopped",
                             [](const Graph& g) -> std::optional<std::string_view> {
                               if (g.h().stop() == Stop::None) return std::nullopt;
                               return stop_name(g.h().stop());
                             })
      .def_property_readonly("goal",
                             [](const Graph& g) -> std::optional<std::uint32_t> {
                               const auto goal = g.h().goal();
                               return goal ? std::optional(goal->value()) : std::nullopt;
                             })
      .def_property_readonly("infeasible",
                             [](const Graph& g) -> std::optional<std::string> {
                               if (const auto reason = g.system.infeasibility())
                                 return reason->message;
                               return std::nullopt;
                             })
      .def_property_readonly("bytes", [](const Graph& g) { return g.h().bytes(); })
      .def_property_readonly("states", &states_of_graph)
      .def_property_readonly("row_offsets",
                             [](const py::object& self) {
                               return show(self.cast<const Graph&>().h().row_offsets(), self);
                             })
      .def_property_readonly("successors", &successors_of)
      .def_property_readonly("connections", &connections_of)
      .def_property_readonly("rewards", &rewards_of)
      .def_property_readonly("reward_numbers", &reward_numbers_of)
      .def_property_readonly("reward_table", &reward_table_of)
      .def_property_readonly("layer_offsets", &layer_offsets_of)
      .def("values", &values_of)
      .def("size", &size_of)
      .def(
          "dot",
          [](const Graph& g, const std::vector<std::uint32_t>& path) {
            return state_graph_dot(g.h(), indices_of(path));
          },
          Release())
      .def(
          "svg",
          [](const Graph& g, const std::vector<std::uint32_t>& path) {
            require_drawable(g.h());
            return svg_text(state_graph_dot(g.h(), indices_of(path)));
          },
          Release());
  module.def("build_graph", &build);
  module.def(
      "estimate_graph",
      [](const Problem& problem) {
        const GraphEstimate estimate = estimate_graph(TransitionSystem(problem));
        return std::make_tuple(estimate.states, estimate.actions, estimate.bytes, estimate.exact);
      },
      Release());
}

}  // namespace orasp::python
