#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "orasp/mip/mip_model.h"
#include "orasp/model/tolerance.h"
#include "orasp/task/result.h"
namespace orasp {

/// What a solver tells while it works. Values are those of the model's objective, its constant
/// included.
struct MipProgress {
  std::uint64_t nodes = 0;
  double best = kInfinity;    ///< of the best solution so far
  double bound = -kInfinity;  ///< proved: no solution is below
};

/// What a solver answers.
struct MipSolution {
  enum class Status {
    Optimal,     ///< `values`, proved best within the tolerances below
    Feasible,    ///< `values`, no proof
    Infeasible,  ///< proved that there is no solution
    Unbounded,   ///< the objective falls without end
    Unknown,     ///< stopped with neither
  };
  Status status = Status::Unknown;
  Stop stop = Stop::None;  ///< what the watcher said
  std::vector<double>
      values;  ///< of all columns; whole where they must be. Empty without a solution
  double objective = kInfinity;
  double bound = -kInfinity;  ///< proved: no solution is below
  std::uint64_t nodes = 0;
};

struct MipSettings {
  std::optional<double> seconds;  ///< for parts of the work in which the watcher is not asked
  /// Asked a few times a second, and at every better solution; says why to stop, Stop::None to go
  /// on. May be empty.
  std::function<Stop(const MipProgress&)> watcher;
};

/// Branch and cut for a MipModel by CBC, on one thread.
///
/// Reference.  Forrest and Lougee-Heimer (2005), CBC User Guide, INFORMS; Land and Doig (1960),
///             Econometrica 28, 497-520.
/// Guarantee.  Exact within the solver's tolerances: rows hold to 1e-7, whole numbers to 1e-6, and
///             a better solution may be missed by less than 1e-7 of the greatest term of the
///             objective. Values of whole columns are rounded.
/// Threads.    One model at a time in a process: CBC is not made for more. A second waits, and may
///             be stopped meanwhile.
/// Repeatable. The same model gives the same answer on the same machine and library, unless it is
/// stopped.
///
/// Lives in a module of its own, which is loaded when the first model is solved: linked in, it
/// would slow every start of the program.
class MipSolver {
 public:
  MipSolver() = default;
  MipSolver(const MipSolver&) = delete;
  MipSolver& operator=(const MipSolver&) = delete;
  virtual ~MipSolver() = default;
  [[nodiscard]] virtual MipSolution solve(const MipModel& model, const MipSettings& settings) = 0;
};

/// Whether the module is there. It is looked for beside the program, in the folder above, in
/// ../lib/orasp and where this library was to be installed.
[[nodiscard]] bool mip_solver_available();
/// Why the method mip cannot solve here, a clause that goes on from its name; empty where it can.
[[nodiscard]] std::optional<std::string> mip_solver_obstacle();

/// @throws InputError if the module is missing or cannot be loaded, with how to get it.
[[nodiscard]] std::unique_ptr<MipSolver> make_mip_solver();

}  // namespace orasp
