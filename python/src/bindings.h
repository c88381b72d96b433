#pragma once

#include <memory>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "orasp/model/problem.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/result.h"

/// What each file of this folder adds to the module orasp._orasp. The module is what the package
/// orasp/ is built on and is for nobody else: it takes and gives plain values, and checks what the
/// library checks.
namespace orasp::python {

void bind_certificates(pybind11::module_& module);
void bind_formats(pybind11::module_& module);
void bind_graph(pybind11::module_& module);
void bind_learning(pybind11::module_& module);
void bind_models(pybind11::module_& module);
void bind_pictures(pybind11::module_& module);
void bind_problem(pybind11::module_& module);
void bind_questions(pybind11::module_& module);
void bind_replanning(pybind11::module_& module);
void bind_rewards(pybind11::module_& module);
void bind_run(pybind11::module_& module);
void bind_solve(pybind11::module_& module);
void bind_environment(pybind11::module_& module);

using ProblemPointer = std::shared_ptr<Problem>;

/// Whether rewards come from a function of Python.
[[nodiscard]] bool calls_python(const Problem& problem);

/// The ids of connections as a list of strings.
[[nodiscard]] pybind11::list ids_of(const Problem& problem,
                                    std::span<const ConnectionIndex> connections);

/// Numbers of connections as an array of int64, shape [connections].
[[nodiscard]] pybind11::array numbers_of(std::span<const ConnectionIndex> connections);

/// An array that shows memory of `owner`, copies nothing, and keeps `owner` alive. Not writable.
template <class T>
[[nodiscard]] pybind11::array view_of(const T* data, std::vector<pybind11::ssize_t> shape,
                                      const pybind11::object& owner) {
  pybind11::array_t<T> view(std::move(shape), data, owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

/// An array of a vector's numbers, which it takes over: nothing is copied.
template <class T>
[[nodiscard]] pybind11::array array_of(std::vector<T> numbers) {
  auto held = std::make_unique<std::vector<T>>(std::move(numbers));
  std::vector<T>* const raw = held.get();
  const pybind11::capsule owner(raw,
                                [](void* vector) { delete static_cast<std::vector<T>*>(vector); });
  static_cast<void>(held.release());
  return pybind11::array_t<T>({static_cast<pybind11::ssize_t>(raw->size())}, raw->data(), owner);
}

}  // namespace orasp::python
