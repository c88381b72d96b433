#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include <pybind11/pybind11.h>

#include "orasp/task/budget.h"

namespace orasp::python {

/// What a piece of work may spend, and what is called and asked while it goes on.
struct Run {
  std::optional<double> time_limit;           ///< s; empty: none
  std::optional<std::uint64_t> memory_limit;  ///< MiB; empty: default_memory_limit()
  std::optional<std::uint64_t> threads;       ///< empty: all of the machine's
  /// Called with (phase, done, total, states, best) up to 50 times a second, in the thread that
  /// asked; what it raises stops the work and comes out. None: nobody is told.
  pybind11::object progress = pybind11::none();
  /// Something with a method is_set(), such as threading.Event: once that is true the work stops as
  /// after Ctrl-C. None: nothing is asked.
  pybind11::object stop = pybind11::none();
  /// Whether the work calls functions of Python, which take the lock of the interpreter in turn:
  /// then one thread works unless more are asked for.
  bool calls_back = false;
};

/// Runs `work` in a thread of its own, with the lock of the interpreter released, and waits for it.
///
/// Idea.       A planner looks at its stop token every few thousand units of work, and knows no
///             Python. So the thread that asked waits, and every 20 ms takes the lock, lets Python
///             see its signals, and calls what `run` names. Whatever is raised there requests the
///             stop, and is raised once the work has ended.
/// Ctrl-C.     Is a request to stop, not an error: where `work` then ends, what it has so far
///             counts, and nothing is raised unless Ctrl-C comes a second time before that, or
///             `keeps_partial` is false. In a thread that is not the main one Python delivers no
///             signals; there a SIGINT that Python is left to handle in its own way stops the work
///             too.
/// Functions   of the user that `work` calls may take the lock in its thread; what they raise ends
///             `work` and is raised here. They call end_if_overdue() first.
void run_watched(const Run& run, bool keeps_partial,
                 const std::function<void(const Budget&)>& work);

/// Ends the work that this thread does for run_watched() where it was asked to stop 0.15 s ago and
/// has not: a planner counts work, and with a function of Python each unit may take long. Then
/// there is no answer, and KeyboardInterrupt is raised, or InputError where Run::stop asked.
void end_if_overdue();

}  // namespace orasp::python
