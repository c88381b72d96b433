#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <stop_token>
#include <string_view>

#include "orasp/model/tolerance.h"
#include "orasp/task/result.h"

namespace orasp {

/// What a planner tells while it works.
struct Progress {
  std::string_view phase;    ///< "building H", "sweep", "search"
  std::uint64_t done = 0;    ///< in units of the phase
  std::uint64_t total = 0;   ///< 0 where unknown
  std::uint64_t states = 0;  ///< states held
  double best = -kInfinity;  ///< incumbent's reward
};

/// What a planner may spend, and how it is told to stop. Polled by the planner: expired() looks at
/// the clock, so call it every few thousand units of work. Cheap to copy. The library reads the
/// clock for nothing else but `seconds`.
struct Budget {
  using Clock = std::chrono::steady_clock;

  std::optional<Clock::time_point> deadline;
  std::uint64_t max_bytes =
      std::numeric_limits<std::uint64_t>::max();  ///< of the planner's own tables
  std::uint64_t max_expansions = std::numeric_limits<std::uint64_t>::max();
  std::stop_token stop;
  unsigned threads = 1;
  /// Called from the planner's own thread, at most a few times a second is useful; may be empty.
  std::function<void(const Progress&)> progress;

  [[nodiscard]] static Budget with_time_limit(double seconds) {
    Budget budget;
    budget.set_time_limit(seconds);
    return budget;
  }
  void set_time_limit(double seconds) {
    constexpr double kLongest = 1e9;  // about 30 years: far below overflow of the clock
    deadline =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(
                           std::chrono::duration<double>(seconds < kLongest ? seconds : kLongest));
  }

  /// Why to stop now, given what was spent; Stop::None to go on.
  [[nodiscard]] Stop expired(std::uint64_t bytes = 0, std::uint64_t expansions = 0) const {
    if (stop.stop_requested()) return Stop::Cancelled;
    if (bytes > max_bytes) return Stop::MemoryLimit;
    if (expansions >= max_expansions) return Stop::ExpansionLimit;
    if (deadline && Clock::now() >= *deadline) return Stop::TimeLimit;
    return Stop::None;
  }
  void report(const Progress& state) const {
    if (progress) progress(state);
  }
};

/// Measures Statistics::seconds.
class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(Budget::Clock::now() - start_).count();
  }

 private:
  Budget::Clock::time_point start_ = Budget::Clock::now();
};

}  // namespace orasp
