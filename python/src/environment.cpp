#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/learning/vector_environment.h"
#include "orasp/model/error.h"
#include "orasp/model/problem.h"
#include "orasp/model/transition_system.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

template <class Number>
using Array = py::array_t<Number, py::array::c_style>;
using Actions = Array<std::int64_t>;

/// The numbers of an array that is written to, in the type in which the library writes them, which
/// may be another one of the same size: bool and int8 are bytes of 0 and 1.
template <class Written, class Number>
std::span<Written> numbers(Array<Number>& array) {
  static_assert(sizeof(Written) == sizeof(Number));
  return {reinterpret_cast<Written*>(array.mutable_data()), static_cast<std::size_t>(array.size())};
}

std::span<const std::int64_t> numbers(const Actions& actions) {
  return {actions.data(), static_cast<std::size_t>(actions.size())};
}

/// The arrays that an environment writes to. They are kept here, so that they live as long as it.
struct Arrays {
  py::object observations;  // float32 or uint8
  py::object final_observations;
  Array<std::int8_t> masks;
  Array<double> rewards;
  Array<bool> terminated;
  Array<bool> truncated;
  Array<double> returns;
  Array<std::int64_t> lengths;
};

/// One step or another call at a time: the lock of the interpreter is released while it runs.
class OneAtATime {
 public:
  explicit OneAtATime(std::atomic_flag& busy) : busy_(busy) {
    if (busy_.test_and_set())
      throw InputError("the environment is at work: it takes one call at a time");
  }
  ~OneAtATime() { busy_.clear(); }
  OneAtATime(const OneAtATime&) = delete;
  OneAtATime& operator=(const OneAtATime&) = delete;

 private:
  std::atomic_flag& busy_;
};

/// A VectorEnvironment with the problem that it is made of and the arrays that it writes to.
class Episodes {
 public:
  Episodes(ProblemPointer problem, std::size_t episodes, const std::string& autoreset,
           std::uint64_t max_bytes)
      : problem_(std::move(problem)),
        system_(std::make_unique<TransitionSystem>(*problem_)),
        environment_(*system_, episodes,
                     {.autoreset = autoreset == "same_step"   ? Autoreset::SameStep
                                   : autoreset == "next_step" ? Autoreset::NextStep
                                                              : Autoreset::Off,
                      .max_bytes = max_bytes}) {}

  void write_to(Arrays arrays) {
    const OneAtATime one(busy_);
    arrays_ = std::move(arrays);
    buffers_ = {};
    take(arrays_.observations, buffers_.observations, buffers_.observation_bytes);
    take(arrays_.final_observations, buffers_.final_observations, buffers_.final_observation_bytes);
    buffers_.masks = numbers<std::uint8_t>(arrays_.masks);
    buffers_.rewards = numbers<double>(arrays_.rewards);
    buffers_.terminated = numbers<std::uint8_t>(arrays_.terminated);
    buffers_.truncated = numbers<std::uint8_t>(arrays_.truncated);
    buffers_.returns = numbers<double>(arrays_.returns);
    buffers_.lengths = numbers<std::int64_t>(arrays_.lengths);
    environment_.observe(buffers_);
  }

  void reset(const std::optional<Array<bool>>& which) {
    const OneAtATime one(busy_);
    if (!which) {
      environment_.reset(buffers_);
      return;
    }
    environment_.reset({reinterpret_cast<const std::uint8_t*>(which->data()),
                        static_cast<std::size_t>(which->size())},
                       buffers_);
  }
  void start_after(const std::vector<std::int64_t>& actions) {
    const OneAtATime one(busy_);
    environment_.start_after(actions);
  }

  /// Whether the step ended an episode.
  bool step(const Actions& actions) {
    const OneAtATime one(busy_);
    const std::span<const std::int64_t> taken = numbers(actions);
    {
      const py::gil_scoped_release released;
      environment_.step(taken, buffers_);
    }
    const auto any = [](std::span<const std::uint8_t> flags) {
      return std::ranges::find(flags, 1) != flags.end();
    };
    return any(buffers_.terminated) || any(buffers_.truncated);
  }
  /// The step of an only episode: what it earned, whether it ended the plan, and whether it led to
  /// a dead end.
  py::tuple step_one(std::int64_t action) {
    const OneAtATime one(busy_);
    {
      const py::gil_scoped_release released;
      environment_.step({&action, 1}, buffers_);
    }
    return py::make_tuple(buffers_.rewards[0], buffers_.terminated[0] != 0,
                          buffers_.truncated[0] != 0);
  }
  void sample(Actions actions, std::optional<std::uint64_t> seed) {
    const OneAtATime one(busy_);
    const auto drawn = numbers<std::int64_t>(actions);
    if (seed) {
      SplitMix64 random(*seed);
      environment_.sample(drawn, random);
    } else {
      environment_.sample(drawn);
    }
  }
  void seed(std::uint64_t seed) { environment_.seed(seed); }

  [[nodiscard]] py::tuple plan(std::size_t episode) const {
    return plan_of(environment_.plan(episode));
  }
  /// None, or what the best plan earned, its connections and directions.
  [[nodiscard]] py::object best() const {
    const auto best = environment_.best();
    if (!best) return py::none();
    return py::make_tuple(best->reward, plan_of(best->plan));
  }
  /// "1-2", "1-2 +x" where it leaves in a direction, or "end".
  [[nodiscard]] std::string action_name(std::int64_t action) const {
    const PlanStep step = environment_.plan_step(action);
    if (step.connections.empty()) return "end";
    std::string name = problem_->connection_id(step.connections.front());
    if (step.direction) name += " " + problem_->direction_name(*step.direction);
    return name;
  }
  [[nodiscard]] std::vector<std::string> open(std::size_t episode) const {
    std::vector<std::string> ids;
    for_each_connection(environment_.open(episode),
                        [&](ConnectionIndex c) { ids.push_back(problem_->connection_id(c)); });
    return ids;
  }

  /// What a picture is made of: the positions of the parts, float64 [parts, 3], NaN where a part
  /// has none, and the parts of each connection, int64 [connections, 2].
  [[nodiscard]] py::tuple layout() const {
    const auto parts = static_cast<py::ssize_t>(problem_->num_parts());
    const auto connections = static_cast<py::ssize_t>(problem_->num_connections());
    Array<double> positions(std::array<py::ssize_t, 2>{parts, 3});
    Array<std::int64_t> ends(std::array<py::ssize_t, 2>{connections, 2});
    auto position = positions.mutable_unchecked<2>();
    for (py::ssize_t p = 0; p < parts; ++p) {
      const auto& given = problem_->parts()[static_cast<std::size_t>(p)].position;
      for (py::ssize_t axis = 0; axis < 3; ++axis)
        position(p, axis) = given ? (*given)[static_cast<std::size_t>(axis)]
                                  : std::numeric_limits<double>::quiet_NaN();
    }
    auto end = ends.mutable_unchecked<2>();
    for (py::ssize_t c = 0; c < connections; ++c) {
      const auto& both = problem_->ends(static_cast<ConnectionIndex>(c));
      end(c, 0) = both[0];
      end(c, 1) = both[1];
    }
    return py::make_tuple(positions, ends);
  }

  [[nodiscard]] const VectorEnvironment& environment() const { return environment_; }

 private:
  /// Takes an array of observations of one of the two types.
  static void take(py::object& array, std::span<float>& floats, std::span<std::uint8_t>& bytes) {
    if (py::isinstance<Array<float>>(array)) {
      auto typed = py::cast<Array<float>>(array);
      floats = numbers<float>(typed);
    } else {
      auto typed = py::cast<Array<std::uint8_t>>(array);
      bytes = numbers<std::uint8_t>(typed);
    }
  }
  [[nodiscard]] py::tuple plan_of(const std::vector<PlanStep>& plan) const {
    py::list connections;
    py::list directions;
    for (const PlanStep& step : plan) {
      connections.append(problem_->connection_id(step.connections.front()));
      directions.append(step.direction
                            ? py::object(py::str(problem_->direction_name(*step.direction)))
                            : py::none());
    }
    return py::make_tuple(connections, directions);
  }

  ProblemPointer problem_;
  std::unique_ptr<TransitionSystem> system_;
  VectorEnvironment environment_;
  Arrays arrays_;
  EpisodeBuffers buffers_;
  std::atomic_flag busy_;
};

}  // namespace

void bind_environment(py::module_& module) {
  py::class_<Episodes>(module, "Episodes")
      .def(py::init<ProblemPointer, std::size_t, const std::string&, std::uint64_t>(),
           py::arg("problem"), py::arg("episodes"), py::arg("autoreset"), py::arg("max_bytes"))
      .def(
          "write_to",
          [](Episodes& episodes, py::object observations, py::object final_observations,
             Array<std::int8_t> masks, Array<double> rewards, Array<bool> terminated,
             Array<bool> truncated, Array<double> returns, Array<std::int64_t> lengths) {
            episodes.write_to({std::move(observations), std::move(final_observations),
                               std::move(masks), std::move(rewards), std::move(terminated),
                               std::move(truncated), std::move(returns), std::move(lengths)});
          },
          py::arg("observations").noconvert(), py::arg("final_observations").noconvert(),
          py::arg("masks").noconvert(), py::arg("rewards").noconvert(),
          py::arg("terminated").noconvert(), py::arg("truncated").noconvert(),
          py::arg("returns").noconvert(), py::arg("lengths").noconvert())
      .def("reset", &Episodes::reset, py::arg("which") = py::none())
      .def("start_after", &Episodes::start_after, py::arg("actions"))
      .def("step", &Episodes::step, py::arg("actions").noconvert())
      .def("step_one", &Episodes::step_one, py::arg("action"))
      .def("sample", &Episodes::sample, py::arg("actions").noconvert(),
           py::arg("seed") = py::none())
      .def("seed", &Episodes::seed, py::arg("seed"))
      .def("plan", &Episodes::plan, py::arg("episode"))
      .def("best", &Episodes::best)
      .def("open", &Episodes::open, py::arg("episode"))
      .def("layout", &Episodes::layout)
      .def("action_name", &Episodes::action_name, py::arg("action"))
      .def("column_name", [](const Episodes& e,
                             std::size_t column) { return e.environment().column_name(column); })
      .def("total", [](const Episodes& e, std::size_t i) { return e.environment().total(i); })
      .def("obstacle", [](const Episodes& e, std::size_t i,
                          std::int64_t action) { return e.environment().obstacle(i, action); })
      .def_property_readonly("num_actions",
                             [](const Episodes& e) { return e.environment().num_actions(); })
      .def_property_readonly("observation_size",
                             [](const Episodes& e) { return e.environment().observation_size(); })
      .def_property_readonly("max_steps",
                             [](const Episodes& e) { return e.environment().max_steps(); })
      .def_property_readonly("expanded",
                             [](const Episodes& e) { return e.environment().expanded(); })
      .def_property_readonly("remembered",
                             [](const Episodes& e) { return e.environment().remembered(); })
      .def_property_readonly("bytes", [](const Episodes& e) { return e.environment().bytes(); })
      .def_property_readonly("forgotten",
                             [](const Episodes& e) { return e.environment().forgotten(); });
}

}  // namespace orasp::python
