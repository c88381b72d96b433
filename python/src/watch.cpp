#include "watch.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include <pybind11/stl.h>
#include <signal.h>

#include "bindings.h"
#include "orasp/model/error.h"
#include "orasp/task/memory_limit.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

constexpr std::chrono::milliseconds kLookEvery{20};
constexpr std::chrono::milliseconds kPatience{150};

using Clock = std::chrono::steady_clock;

/// Thrown out of work that does not see in time that it is to stop.
struct Overdue {};

/// When the work of this thread was asked to stop, as time since the clock's epoch; 0: it was not.
using AskedAt = std::atomic<Clock::rep>;
thread_local const AskedAt* asked_at_of_this_thread = nullptr;

/// Counts the SIGINTs that come while somebody works, beside what is done about them anyway.
class Interrupts {
 public:
  static Interrupts& all() {
    static Interrupts interrupts;
    return interrupts;
  }
  /// Between these the signals are counted.
  void enter() {
    const std::scoped_lock lock(mutex_);
    if (working_++ > 0) return;
    known_ = sigaction(SIGINT, nullptr, &original_) == 0 && (original_.sa_flags & SA_SIGINFO) == 0;
    ours_ = original_;
    // Where SIGINT is ignored or kills the process there is no handler to go before.
    if (!known_ || original_.sa_handler == SIG_DFL || original_.sa_handler == SIG_IGN) return;
    before_ = original_.sa_handler;
    ours_.sa_handler = &Interrupts::count;
    sigaction(SIGINT, &ours_, nullptr);
  }
  /// A library that works for the library (CBC) may have taken SIGINT: takes it back.
  void keep() {
    const std::scoped_lock lock(mutex_);
    if (known_ && taken()) sigaction(SIGINT, &ours_, nullptr);
  }
  void leave() {
    const std::scoped_lock lock(mutex_);
    if (--working_ > 0 || !known_) return;
    struct sigaction now {};
    if (sigaction(SIGINT, nullptr, &now) != 0) return;
    if (now.sa_handler == &Interrupts::count || taken()) sigaction(SIGINT, &original_, nullptr);
  }
  [[nodiscard]] static int counted() { return counted_; }

 private:
  static void count(int signal) {
    ++counted_;
    if (before_ != nullptr) before_(signal);
  }
  /// Whether SIGINT has a handler that is neither ours nor Python's, whose are all the same.
  [[nodiscard]] bool taken() const {
    struct sigaction now {};
    if (sigaction(SIGINT, nullptr, &now) != 0 || now.sa_handler == SIG_DFL ||
        now.sa_handler == SIG_IGN)
      return false;
    return now.sa_handler != &Interrupts::count && now.sa_handler != original_.sa_handler;
  }
  using Handler = void (*)(int);
  static inline std::atomic<int> counted_ = 0;
  static inline std::atomic<Handler> before_ = nullptr;
  static_assert(std::atomic<int>::is_always_lock_free && std::atomic<Handler>::is_always_lock_free);
  std::mutex mutex_;
  int working_ = 0;
  bool known_ = false;
  struct sigaction original_ {};
  struct sigaction ours_ {};
};

/// The last thing that a planner told.
class Told {
 public:
  void tell(const Progress& progress) {
    const std::scoped_lock lock(mutex_);
    phase_ = progress.phase;
    last_ = progress;
    fresh_ = true;
  }
  /// Calls back with what was told since the last time, if anything was.
  void pass_on(const py::object& callback) {
    std::string phase;
    Progress last;
    {
      const std::scoped_lock lock(mutex_);
      if (!fresh_) return;
      fresh_ = false;
      phase = phase_;
      last = last_;
    }
    callback(phase, last.done, last.total, last.states, last.best);
  }

 private:
  std::mutex mutex_;
  std::string phase_;
  Progress last_;
  bool fresh_ = false;
};

bool is_main_thread() {
  const py::module_ threading = py::module_::import("threading");
  return threading.attr("current_thread")().is(threading.attr("main_thread")());
}

/// Whether Python raises KeyboardInterrupt on SIGINT, as it does unless told otherwise.
bool interrupts_raise() {
  const py::module_ signal = py::module_::import("signal");
  return signal.attr("getsignal")(signal.attr("SIGINT")).is(signal.attr("default_int_handler"));
}

/// Python is ending, in another thread, and this one can never return to it: whoever takes the lock
/// of the interpreter now is thrown out of it where it stands. Ends the work and waits.
[[noreturn]] void wait_for_the_end(std::stop_source& source) {
  source.request_stop();
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

/// A thread that is waited for, also where the one that waits is thrown out of Python meanwhile.
class Worker {
 public:
  template <class Work>
  Worker(std::stop_source& source, Work&& work)
      : source_(source), thread_(std::forward<Work>(work)) {}
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    if (!thread_.joinable()) return;
    if (_Py_IsFinalizing() != 0) wait_for_the_end(source_);
    source_.request_stop();
    thread_.join();
  }
  void join() { thread_.join(); }

 private:
  std::stop_source& source_;
  std::thread thread_;
};

}  // namespace

void run_watched(const Run& run, bool keeps_partial,
                 const std::function<void(const Budget&)>& work) {
  Budget budget;
  budget.max_bytes = run.memory_limit ? *run.memory_limit << 20U : default_memory_limit();
  budget.threads = run.threads      ? static_cast<unsigned>(*run.threads)
                   : run.calls_back ? 1U
                                    : std::max(1U, std::thread::hardware_concurrency());
  if (run.time_limit) budget.set_time_limit(*run.time_limit);
  std::stop_source source;
  budget.stop = source.get_token();
  Told told;
  if (!run.progress.is_none())
    budget.progress = [&told](const Progress& progress) { told.tell(progress); };

  std::mutex mutex;
  std::condition_variable ended;
  bool has_ended = false;
  bool overdue = false;
  std::exception_ptr failure;  // of the work
  std::exception_ptr raised;   // by a callback, or by a handler of signals
  int interrupts = 0;
  AskedAt asked_at = 0;
  const auto ask_to_stop = [&] {
    if (!source.request_stop()) return;
    asked_at = Clock::now().time_since_epoch().count();
  };
  const bool in_main_thread = is_main_thread();
  int counted = Interrupts::counted();

  // With the lock of the interpreter.
  const auto look = [&] {
    try {
      Interrupts::all().keep();
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!in_main_thread && Interrupts::counted() != counted) {
        counted = Interrupts::counted();
        if (interrupts_raise()) {
          ++interrupts;
          ask_to_stop();
        }
      }
      if (raised || interrupts > 0) return;
      if (!run.progress.is_none()) told.pass_on(run.progress);
      if (!run.stop.is_none() && run.stop.attr("is_set")().cast<bool>()) ask_to_stop();
    } catch (py::error_already_set& error) {
      ask_to_stop();
      if (error.matches(PyExc_KeyboardInterrupt)) {
        ++interrupts;
      } else if (!raised) {
        raised = std::current_exception();
      }
    }
  };

  Interrupts::all().enter();
  {
    const py::gil_scoped_release released;
    Worker worker(source, [&] {
      try {
        // Held in between, what Python knows of this thread is made once, not at each call.
        std::optional<py::gil_scoped_acquire> known;
        std::optional<py::gil_scoped_release> let_go;
        if (run.calls_back) {
          known.emplace();
          let_go.emplace();
        }
        asked_at_of_this_thread = &asked_at;
        work(budget);
      } catch (const Overdue&) {
        overdue = true;
      } catch (...) {
        failure = std::current_exception();
      }
      const std::scoped_lock lock(mutex);
      has_ended = true;
      ended.notify_all();
    });
    for (std::unique_lock lock(mutex);
         !ended.wait_for(lock, kLookEvery, [&] { return has_ended; });) {
      lock.unlock();
      if (_Py_IsFinalizing() != 0) wait_for_the_end(source);
      {
        const py::gil_scoped_acquire acquired;
        look();
      }
      lock.lock();
    }
    worker.join();
  }
  Interrupts::all().leave();
  if (!raised && interrupts == 0) look();
  if (raised) std::rethrow_exception(raised);
  if (failure) std::rethrow_exception(failure);
  if (interrupts > 1 || (interrupts == 1 && (overdue || !keeps_partial))) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }
  if (overdue) throw InputError("the work was stopped before there was an answer");
}

void end_if_overdue() {
  if (asked_at_of_this_thread == nullptr) return;
  const Clock::rep asked_at = *asked_at_of_this_thread;
  if (asked_at == 0) return;
  if (Clock::now().time_since_epoch() - Clock::duration(asked_at) > kPatience) throw Overdue();
}

void bind_run(py::module_& module) {
  py::class_<Run>(module, "Run")
      .def(py::init([](std::optional<double> time_limit, std::optional<std::uint64_t> memory_limit,
                       std::optional<std::uint64_t> threads, py::object progress, py::object stop) {
             return Run{time_limit, memory_limit, threads, std::move(progress), std::move(stop)};
           }),
           py::arg("time_limit") = std::nullopt, py::arg("memory_limit") = std::nullopt,
           py::arg("threads") = std::nullopt, py::arg("progress") = py::none(),
           py::arg("stop") = py::none());
}

}  // namespace orasp::python
