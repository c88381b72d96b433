#include "orasp/drawing/graphviz.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <unordered_set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/drawing/drawing_process.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/detail/dot_text.h"
#include "orasp/model/error.h"
#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

using detail::dot_string;
using detail::short_number;

// -------------------------------------------------------------------------------------------------
// H as a text

constexpr const char* kFonts = "Helvetica,Arial,sans-serif";

/// How much a drawing names; the larger H, the less.
enum class Detail {
  Everything,  ///< states, actions and their rewards
  States,
  Shape,  ///< points and lines
};

Detail detail_for(std::uint64_t states, const StateGraphStyle& style) {
  if (states <= 40) return Detail::Everything;
  return states <= 250 && !style.compact ? Detail::States : Detail::Shape;
}

class StateNames {
 public:
  StateNames(const Problem& problem, Detail detail, bool compact)
      : problem_(problem), line_width_(detail == Detail::Everything && !compact ? 24 : 11) {}

  /// The connections present, a few a line; empty set: the sign for it.
  [[nodiscard]] std::string full(SetView open) const {
    std::string text;
    std::size_t column = 0;
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      if (contains(open, c) == (problem_.direction() == Direction::Assembly)) continue;
      const std::string& id = problem_.connection_id(c);
      if (!text.empty()) text += column + 1 + id.size() > line_width_ ? '\n' : ' ';
      column = text.empty() || text.back() == '\n' ? 0 : column + 1;
      text += id;
      column += id.size();
    }
    return text.empty() ? "\xe2\x88\x85" : text;  // U+2205 EMPTY SET
  }
  [[nodiscard]] std::string brief(SetView open) const {
    constexpr std::size_t kLongest = 52;
    std::string name = full(open);
    if (name.size() <= kLongest) return name;
    const std::size_t left = count(open);
    const bool assembly = problem_.direction() == Direction::Assembly;
    return fmt::format("{} present", assembly ? problem_.num_connections() - left : left);
  }

 private:
  const Problem& problem_;
  const std::size_t line_width_;
};

/// The states and actions of one path from the start.
struct Path {
  std::unordered_set<StateId> states;
  std::unordered_set<ActionId> actions;
};

Path path_of(const StateGraph& graph, std::span<const ConnectionIndex> connections) {
  Path path;
  if (connections.empty()) return path;
  StateId state = 0;
  path.states.insert(state);
  for (const ConnectionIndex connection : connections) {
    ActionId action = graph.begin(state);
    while (action < graph.end(state) && graph.connection(action) != connection) ++action;
    if (action == graph.end(state)) {
      throw InputError(
          fmt::format("the path to highlight is not in H: after {} step{} it handles connection "
                      "{}, which is not a "
                      "legal action there",
                      path.actions.size(), path.actions.size() == 1 ? "" : "s", connection));
    }
    path.actions.insert(action);
    state = graph.successor(action);
    path.states.insert(state);
  }
  return path;
}

constexpr const char* kPrunedState =
    R"(, style="rounded,dashed", color="#d0d7de", fontcolor="#afb8c1")";
constexpr const char* kPrunedAction = R"(, style=dashed, color="#d0d7de", fontcolor="#c8d1da")";

/// Which states and actions of a larger graph this one holds.
class Remaining {
 public:
  explicit Remaining(const StateGraph& graph) : graph_(graph) {
    for (StateId s = 0; s < graph.num_states(); ++s) {
      const SetView open = graph.state(s);
      numbers_.emplace(std::vector<std::uint64_t>(open.begin(), open.end()), s);
    }
  }
  [[nodiscard]] std::optional<StateId> state(SetView open) const {
    const auto found = numbers_.find(std::vector<std::uint64_t>(open.begin(), open.end()));
    return found == numbers_.end() ? std::nullopt : std::optional(found->second);
  }
  [[nodiscard]] bool action(SetView open, ConnectionIndex connection) const {
    const std::optional<StateId> s = state(open);
    if (!s) return false;
    for (ActionId a = graph_.begin(*s); a < graph_.end(*s); ++a) {
      if (graph_.connection(a) == connection) return true;
    }
    return false;
  }

 private:
  const StateGraph& graph_;
  std::map<std::vector<std::uint64_t>, StateId> numbers_;
};

/// A place for each state of a large H, in points: one row a layer, evenly spaced, rows centred,
/// ordered so that neighbours are near each other. Graphviz's own layout of thousands of states
/// takes minutes, this takes milliseconds. Reference. The barycentre heuristic: Sugiyama, Tagawa
/// and Toda (1981), IEEE Trans. Systems, Man, Cybernetics 11(2).
class LayeredLayout {
 public:
  explicit LayeredLayout(const StateGraph& graph) : x_(graph.num_states()), y_(graph.num_states()) {
    std::vector<std::vector<StateId>> rows(graph.num_layers());
    std::vector<std::vector<StateId>> above(graph.num_states());
    std::vector<std::vector<StateId>> below(graph.num_states());
    std::size_t widest = 0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      for (StateId s = graph.layer_begin(k); s < graph.layer_end(k); ++s) {
        rows[k].push_back(s);
        for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
          below[s].push_back(graph.successor(a));
          above[graph.successor(a)].push_back(s);
        }
      }
      widest = std::max(widest, rows[k].size());
      space(rows[k]);
    }
    constexpr int kRounds = 4;
    for (int round = 0; round < kRounds; ++round) {
      for (auto& row : rows) order(row, above);
      for (std::size_t k = rows.size(); k-- > 0;) order(rows[k], below);
    }
    // Twice as wide as high, or higher.
    const double gap =
        std::max(60.0, kGap * static_cast<double>(widest) / static_cast<double>(2 * rows.size()));
    for (std::size_t k = 0; k < rows.size(); ++k) {
      for (const StateId s : rows[k]) y_[s] = -gap * static_cast<double>(k);
    }
  }
  /// How many times wider than a page.
  [[nodiscard]] double pages() const {
    constexpr double kPage = 700;
    return std::max(1.0, (*std::ranges::max_element(x_) - *std::ranges::min_element(x_)) / kPage);
  }
  [[nodiscard]] double x(StateId state) const { return x_[state]; }
  [[nodiscard]] double y(StateId state) const { return y_[state]; }

 private:
  static constexpr double kGap = 14;  ///< between neighbours in a row

  void space(const std::vector<StateId>& row) {
    const double middle = static_cast<double>(row.size() - 1) / 2;
    for (std::size_t i = 0; i < row.size(); ++i)
      x_[row[i]] = kGap * (static_cast<double>(i) - middle);
  }
  void order(std::vector<StateId>& row, const std::vector<std::vector<StateId>>& neighbours) {
    std::vector<std::pair<double, StateId>> wanted;
    for (const StateId s : row) {
      double sum = 0;
      for (const StateId neighbour : neighbours[s]) sum += x_[neighbour];
      wanted.emplace_back(
          neighbours[s].empty() ? x_[s] : sum / static_cast<double>(neighbours[s].size()), s);
    }
    std::ranges::sort(wanted);
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = wanted[i].second;
    space(row);
  }

  std::vector<double> x_;
  std::vector<double> y_;
};

constexpr std::size_t kMostNamedParts = 60;

/// The parts' positions as seen from the side and a little above, in points; nothing where one is
/// missing or two would be drawn on top of each other. The nearest two stand 54 points apart.
std::optional<std::vector<Place>> stated_places(const Problem& problem) {
  constexpr std::size_t kMost = 500;  // every pair is looked at
  if (problem.num_parts() < 2 || problem.num_parts() > kMost) return std::nullopt;
  std::vector<Place> places;
  for (const Part& part : problem.parts()) {
    if (!part.position) return std::nullopt;
    const auto& [x, y, z] = *part.position;
    places.push_back({x + 0.45 * z, y + 0.3 * z});
  }
  double nearest = kInfinity;
  double farthest = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double distance = std::hypot(places[i].x - places[j].x, places[i].y - places[j].y);
      nearest = std::min(nearest, distance);
      farthest = std::max(farthest, distance);
    }
  }
  if (!(nearest > farthest / 60)) return std::nullopt;
  for (Place& place : places) {
    place.x *= 54 / nearest;
    place.y *= 54 / nearest;
  }
  return places;
}

std::string header(Detail detail, const StateGraphStyle& style) {
  std::string text = fmt::format(
      "digraph H {{\n"
      "  graph [rankdir=TB, bgcolor=white, margin={}, outputorder=edgesfirst",
      style.compact ? 0.05 : 0.2);
  text += detail == Detail::Shape    ? ", layout=nop2"
          : style.compact            ? ", nodesep=0.25, ranksep=0.5"
          : detail == Detail::States ? ", nodesep=0.2, ranksep=1.1"
                                     : ", nodesep=0.45, ranksep=0.75";
  text += "]\n";
  text += detail == Detail::Shape
              ? "  node [shape=circle, label=\"\", width=0.1, fixedsize=true, style=filled, "
                "color=\"#57606a\", fillcolor=\"#8c959f\"]\n"
                "  edge [color=\"#8c959f60\", arrowhead=none, penwidth=0.5]\n"
              : fmt::format(
                    "  node [shape=box, style=\"rounded,filled\", color=\"#8c959f\", "
                    "fillcolor=\"#f6f8fa\", fontname=\"{}\", fontsize=12, margin=\"{}\", "
                    "height={}]\n"
                    "  edge [color=\"#8c959f\", fontcolor=\"#57606a\", fontname=\"{}\", "
                    "fontsize=10, arrowsize={}]\n",
                    kFonts, style.compact ? "0.06,0.03" : "0.12,0.06", style.compact ? 0.2 : 0.3,
                    kFonts, style.compact ? 0.5 : 0.7);
  return text;
}

}  // namespace

void require_drawable(const StateGraph& graph) {
  if (graph.num_states() > kMaxDrawnStates) {
    throw InputError(fmt::format(
        "H has {} states, and a drawing of more than {} cannot be read; its text in the DOT "
        "language is written up to {}",
        graph.num_states(), kMaxDrawnStates, kMaxDotStates));
  }
}

std::string state_graph_dot(const StateGraph& graph,
                            std::span<const ConnectionIndex> highlighted_path,
                            const StateGraphStyle& style) {
  const StateGraph& drawn = style.whole != nullptr ? *style.whole : graph;
  if (drawn.num_states() > kMaxDotStates) {
    throw InputError(
        fmt::format("H has {} states, and its text in the DOT language is written up to {}",
                    drawn.num_states(), kMaxDotStates));
  }
  const Problem& problem = drawn.system().problem();
  const Path path = path_of(drawn, highlighted_path);
  const Detail detail = detail_for(drawn.num_states(), style);
  const StateNames names(problem, detail, style.compact);
  const std::optional<StateId> goal = drawn.goal();
  std::optional<Remaining> remaining;
  if (style.whole != nullptr) remaining.emplace(graph);

  std::optional<LayeredLayout> layout;
  if (detail == Detail::Shape) layout.emplace(drawn);

  // The path must be seen when the picture is made as small as a page.
  const double thick = layout && style.compact ? layout->pages() : 1;

  std::string text = header(detail, style);
  for (StateId s = 0; s < drawn.num_states(); ++s) {
    const SetView open = drawn.state(s);
    const bool dead_end = drawn.begin(s) == drawn.end(s) && s != goal;
    text += fmt::format("  s{} [", s);
    if (detail != Detail::Shape) text += fmt::format("label={}, ", dot_string(names.brief(open)));
    if (layout) text += fmt::format("pos=\"{:.1f},{:.1f}\", ", layout->x(s), layout->y(s));
    text += fmt::format("tooltip={}", dot_string(names.full(open)));
    if (path.states.contains(s)) text += R"(, color="#1a7f37", fillcolor="#dafbe1", penwidth=2)";
    if (path.states.contains(s) && detail == Detail::Shape)
      text += fmt::format(R"(, fillcolor="#1a7f37", width={:.2f})", 0.2 * std::min(thick, 3.0));
    if (dead_end) text += R"(, color="#cf222e", fillcolor="#ffebe9")";
    if (remaining && !remaining->state(open)) text += kPrunedState;
    text += "]\n";
  }
  for (StateId s = 0; s < drawn.num_states(); ++s) {
    for (ActionId a = drawn.begin(s); a < drawn.end(s); ++a) {
      const ConnectionIndex connection = drawn.connection(a);
      std::string label = short_number(drawn.reward(a));
      if (!style.compact || detail != Detail::Everything)
        label = fmt::format(" {}  {} ", problem.connection_id(connection), label);
      text += fmt::format("  s{} -> s{} [{}={}", s, drawn.successor(a),
                          detail == Detail::Everything ? "label" : "tooltip", dot_string(label));
      if (path.actions.contains(a)) {
        text += fmt::format(R"(, color="#1a7f37", fontcolor="#1a7f37", penwidth={})",
                            detail == Detail::Shape ? 2 * thick : 2.4);
      } else if (remaining && !remaining->action(drawn.state(s), connection)) {
        text += kPrunedAction;
      } else if (!style.colours.empty()) {
        text += fmt::format(R"(, color="{0}", fontcolor="{0}", penwidth=1.4)",
                            style.colours[connection % style.colours.size()]);
      }
      text += "]\n";
    }
  }
  return text + "}\n";
}

std::string assembly_dot(const Problem& problem, const AssemblyStyle& style) {
  const std::size_t parts = problem.num_parts();
  std::vector<Place> places(style.places.begin(), style.places.end());
  if (places.size() != parts) places = stated_places(problem).value_or(std::vector<Place>());
  const bool placed = !places.empty();
  const bool named = parts <= kMostNamedParts;
  // Lines that bend around circles take half a minute for 256 connections, straight ones nothing.
  std::string text = fmt::format(
      "graph G {{\n"
      "  graph [bgcolor=white, margin=0.05, {}, splines={}{}{}]\n"
      "  node [shape=circle, style=filled, color=\"#57606a\", fillcolor=\"#eaf3fb\", "
      "fontname=\"{}\", fontsize={}, margin=0.02, {}]\n"
      "  edge [color=\"#57606a\", penwidth={}]\n",
      placed  ? "layout=nop"
      : named ? "layout=neato, overlap=false"
              : "layout=sfdp, overlap=prism",
      named ? "true" : "line", style.start.empty() ? "" : ", start=", style.start, kFonts,
      named ? 12 : 8, named ? "width=0.3" : "width=0.12, fixedsize=true",
      style.colours.empty() ? 1.2 : 2.4);
  for (PartIndex part = 0; part < parts; ++part) {
    const Part& spec = problem.parts()[part];
    text += fmt::format("  p{} [label={}, tooltip={}", part, named ? dot_string(spec.id) : "\"\"",
                        dot_string(spec.name.empty() ? spec.id : spec.name));
    if (placed) text += fmt::format(", pos=\"{:.1f},{:.1f}\"", places[part].x, places[part].y);
    text += "]\n";
  }
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const auto& [first, second] = problem.ends(c);
    text += fmt::format("  p{} -- p{} [tooltip={}", first, second,
                        dot_string(problem.connection_id(c)));
    if (!style.colours.empty())
      text += fmt::format(", color=\"{}\"", style.colours[c % style.colours.size()]);
    text += "]\n";
  }
  return text + "}\n";
}

std::vector<Place> places_of(std::string_view dot, std::size_t nodes) {
  const std::vector<std::string> arguments = {"-Tplain"};
  std::istringstream lines(drawn_by("dot", "graphviz", arguments, dot));
  std::vector<Place> places(nodes);
  constexpr double kPointsInAnInch = 72;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    char letter = 0;
    std::size_t node = 0;
    Place place;
    if (words >> kind >> letter >> node >> place.x >> place.y && kind == "node" && node < nodes)
      places[node] = {place.x * kPointsInAnInch, place.y * kPointsInAnInch};
  }
  return places;
}

std::string svg_text(std::string_view dot) {
  const std::vector<std::string> arguments = {"-Tsvg"};
  return drawn_by("dot", "graphviz", arguments, dot);
}

void write_svg(std::string_view dot, const std::filesystem::path& file) {
  write_file(file, svg_text(dot));
}

}  // namespace orasp
