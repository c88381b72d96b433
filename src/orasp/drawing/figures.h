#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/graph/state_graph.h"
#include "orasp/model/problem.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"

namespace orasp {

/// Figures fit for a paper, as SVG texts: white ground, thin lines, sans serif, one accent, green,
/// for what is best.
///
/// Graphs are laid out and drawn by Graphviz (`dot`), charts by gnuplot, both as programs of their
/// own. Names from a problem are quoted as data of their languages and never run. The same
/// arguments and programs give the same bytes. Each function throws InputError if its program is
/// missing (the sentence names the Debian package) or fails.

/// The colours that tell connections apart in the figures of small problems; beyond as many
/// connections lines are grey. Reference. Okabe and Ito (2008), Color universal design, without
/// their green, and two more.
[[nodiscard]] std::span<const std::string_view> connection_colours(const Problem& problem);

/// The assembly graph G. Connections in colours where there are few.
[[nodiscard]] std::string structure_svg(const Problem& problem);

struct StateGraphFigure {
  std::span<const ConnectionIndex> path = {};  ///< in green: connections from the start on
  /// H of the same problem without some constraints: what they take from it is drawn faint and
  /// dashed.
  const StateGraph* whole = nullptr;
  bool coloured = false;  ///< actions in connection_colours()
};
/// H, one row a layer. Up to 40 states are named, by the connections present, and actions by what
/// they earn.
/// @throws InputError if H, or `whole`, has more than kMaxDrawnStates states.
[[nodiscard]] std::string state_graph_svg(const StateGraph& graph,
                                          const StateGraphFigure& figure = {});

/// The largest tree H~ that is drawn.
inline constexpr std::size_t kMaxTreeNodes = 400;
/// The tree H~: a node for every order in which connections can be handled, actions in
/// connection_colours(), `path` in green. @throws InputError if it has more than kMaxTreeNodes
/// nodes.
[[nodiscard]] std::string tree_svg(const TransitionSystem& system,
                                   std::span<const ConnectionIndex> path = {});

/// The most steps that one strip shows: 30, or 12 of more than 60 parts. Of longer plans as many
/// are drawn, evenly spread, the first and the last among them.
[[nodiscard]] std::size_t most_drawn_steps(const Problem& problem);
/// A plan as a strip of small structures: before each removal (after each joint in assembly), the
/// moved piece and the connection in green, single parts faint.
[[nodiscard]] std::string steps_svg(const TransitionSystem& system,
                                    std::span<const ConnectionIndex> plan);

/// A value beside a sample.
struct Mark {
  enum class Kind {
    Best,   ///< a line across
    Plan,   ///< a full green mark
    Other,  ///< a hollow mark
  };
  std::string name;
  double reward = 0;
  Kind kind = Kind::Plan;
};
struct DistributionFigure {
  std::span<const double> rewards;  ///< at least one
  std::span<const Mark> marks = {};
};
/// A violin: the density of a sample between its least and its greatest reward, with its mean, and
/// marks. Reference. Hintze and Nelson (1998), The American Statistician 52(2), 181-184; the
/// bandwidth by the rule of thumb of Silverman (1986), Density Estimation, p. 48.
[[nodiscard]] std::string distribution_svg(const DistributionFigure& figure);

/// Sizes measured at a number of connections.
struct GrowthPoint {
  std::size_t connections = 0;
  double states = 0;
  double actions = 0;
  double tree_nodes = 0;  ///< 0: not measured
};
struct GrowthSeries {
  std::string name;
  std::vector<GrowthPoint> points;
};
/// Where nothing is constrained, n connections make 2^n states, n 2^(n-1) actions, and a tree H~ of
/// the sum of n!/k! nodes.
[[nodiscard]] double states_of(std::size_t connections);
[[nodiscard]] double actions_of(std::size_t connections);
[[nodiscard]] double tree_nodes_of(std::size_t connections);
/// States and actions against connections, logarithmically: measured points and the formulas as
/// lines.
[[nodiscard]] std::string growth_svg(std::span<const GrowthSeries> series);

/// H of what the plan leaves to be done, step by step from its end: states and actions against
/// connections under the problem's own constraints. Ends before the first that has more than
/// `most_states` states, or with the budget.
[[nodiscard]] GrowthSeries growth_along(const Problem& problem,
                                        std::span<const ConnectionIndex> plan, double most_states,
                                        const Budget& budget);

/// What write_figures draws beside the problem. Empty where there is none.
struct FigureRequest {
  std::span<const ConnectionIndex> plan = {};
  std::span<const double> sample = {};  ///< rewards of random sequences
  std::vector<Mark> marks = {};         ///< beside the sample
};
struct FigureFile {
  std::string name;     ///< of the file: "structure.svg"
  std::string caption;  ///< a sentence
};
/// Draws into `folder`, which is made if it is missing: structure.svg; steps.svg and growth.svg of
/// a plan; state-graph.svg with the plan, where H has at most kMaxDrawnStates states; tree.svg,
/// where H~ has at most kMaxTreeNodes nodes; distribution.svg of a sample. Every figure is drawn
/// before the first file is written; each file is written whole or not at all.
/// @returns what was written, in that order. @throws InputError.
std::vector<FigureFile> write_figures(const Problem& problem, const FigureRequest& request,
                                      const std::filesystem::path& folder, const Budget& budget);

}  // namespace orasp
