#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/catalogue.h"
#include "orasp/drawing/figures.h"
#include "orasp/graph/graph_size.h"
#include "orasp/planners/reward_statistics.h"

/// The numbers of the paper, computed again. What is done with them stands in paper_page.h.
namespace orasp::cli {

/// How much is done.
struct PaperEffort {
  bool quick = false;
  bool learning = true;
  [[nodiscard]] std::size_t repeats() const { return quick ? 5 : 21; }
  [[nodiscard]] std::size_t most_connections() const { return quick ? 12 : 20; }
  [[nodiscard]] double training_seconds(std::size_t connections) const {
    if (quick) return connections > 100 ? 2 : 1;
    return connections > 30 ? 120 : 60;
  }
};

/// A method on a problem, as in the paper's table of runtimes.
struct PaperTime {
  std::string problem;
  std::string method;
  std::string objective;
  double printed = 0;  ///< s
  double process = 0;  ///< s: the program from its start to its end; the median
  double least_process = 0;
  double solve = 0;  ///< s: the method alone; the median
  double reward = 0;
  std::string status;
};

/// A search for several robots beside the integer program of the paper's table.
struct PaperIlpTime {
  std::string problem;            ///< as the paper calls it
  std::string objective;          ///< as the paper calls it
  std::string steps;              ///< horizon; empty: none
  double printed = 0;             ///< s
  std::optional<PaperTime> ours;  ///< empty where there is no file of the paper's problem
};

/// H of a problem and its best and worst plan.
struct PaperSize {
  std::string problem;
  GraphSize size;
  double best = 0;
  double worst = 0;
};

struct PaperReward {
  std::string problem;
  std::string objective;
  double reward = 0;
};

/// H with and without a constraint.
struct PaperConstraint {
  std::string problem;
  std::string objective;
  std::string constraint;
  std::uint64_t states = 0;
  std::uint64_t actions = 0;
  double best = 0;
  std::uint64_t states_without = 0;
  std::uint64_t actions_without = 0;
  double best_without = 0;
};

/// An optimal plan through one H under one objective.
struct PaperPath {
  std::string objective;
  double reward = 0;
  std::vector<ConnectionIndex> plan;
};

/// Random sequences of a problem, the learned plan and the proved optimum.
struct PaperDistribution {
  std::string problem;
  std::size_t parts = 0;
  std::size_t connections = 0;
  std::vector<double> rewards;
  RewardFigures figures;
  double greedy = 0;  ///< of the best step each time: the policy before it is trained
  /// What the network earns with which training ended, and the policy that is kept: the best that
  /// it ever was, or what it was before it was trained.
  std::optional<double> final_reward;
  std::optional<double> learned;
  std::uint64_t episodes = 0;
  double training_seconds = 0;
  double best = 0;
  std::optional<double> bound;
  Status status = Status::Unknown;
};

struct Paper {
  PaperEffort effort;
  /// A program that was run for it was stopped: Ctrl-C on a terminal reaches all.
  bool interrupted = false;
  std::string processor;
  unsigned threads = 1;
  double load = 0;  ///< processes that wanted to run, the mean of the last minute, when it began
  std::vector<PaperTime> times;
  std::vector<PaperIlpTime> ilp_times;
  std::vector<PaperSize> sizes;
  std::vector<PaperReward> rewards;
  std::vector<PaperConstraint> constraints;
  std::vector<PaperPath> paths;
  std::vector<GrowthSeries> growth;          ///< without constraints, H~ counted too
  std::vector<GrowthSeries> limited_growth;  ///< with the paper's limits
  std::vector<PaperDistribution> distributions;
  std::string learning_left_out;  ///< why; empty if it was not
};

/// The problem of the figure on two objectives, and of the one on a constraint.
inline constexpr std::string_view kPaperRing = "4piece";
/// As it is in the figure on a constraint, under `time`, with whole numbers as rewards; and with
/// the paper's constraint: connection 2-3 before 1-2.
[[nodiscard]] Problem ring_of_paper();
[[nodiscard]] Problem constrained_ring();
/// The same problem without its precedence.
[[nodiscard]] Problem without_precedence(const Problem& problem);

/// Computes everything, telling `say` what comes next. Stops early when `budget` is told to stop;
/// then the answer is empty. `program` is the path of this program, which is run for the times of
/// whole processes.
/// @throws InputError.
[[nodiscard]] std::optional<Paper> computed_paper(const PaperEffort& effort,
                                                  const std::string& program, const Budget& budget,
                                                  const std::function<void(std::string_view)>& say);

}  // namespace orasp::cli
