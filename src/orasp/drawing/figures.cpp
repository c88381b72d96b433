#include "orasp/drawing/figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "orasp/drawing/drawing_process.h"
#include "orasp/drawing/graphviz.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/graph_size.h"
#include "orasp/io/atomic_file.h"
#include "orasp/io/detail/dot_text.h"
#include "orasp/model/error.h"
#include "orasp/model/situation.h"

namespace orasp {
namespace {

using detail::dot_string;
using detail::short_number;

constexpr const char* kGreen = "#1a7f37";
constexpr const char* kFonts = "Helvetica,Arial,sans-serif";

constexpr std::array<std::string_view, 8> kColours = {"#0072b2", "#d55e00", "#cc79a7", "#56b4e9",
                                                      "#e69f00", "#4d4d4d", "#8c510a", "#5e3c99"};

// -------------------------------------------------------------------------------------------------
// The structure

/// How many pairs of connections cross that share no part, when drawn as straight lines.
std::size_t crossings(const Problem& problem, const std::vector<Place>& places) {
  const auto side = [](Place a, Place b, Place c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0;
  };
  std::size_t found = 0;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const auto& [a, b] = problem.ends(c);
    for (ConnectionIndex d = 0; d < c; ++d) {
      const auto& [e, f] = problem.ends(d);
      if (a == e || a == f || b == e || b == f) continue;
      if (side(places[a], places[b], places[e]) != side(places[a], places[b], places[f]) &&
          side(places[e], places[f], places[a]) != side(places[e], places[f], places[b]))
        ++found;
    }
  }
  return found;
}

/// Where the parts stand. Of structures whose parts are named Graphviz lays out several, from
/// different starts, and the one with the fewest crossings is taken.
std::vector<Place> structure_places(const Problem& problem) {
  constexpr std::array<const char*, 6> kStarts = {"regular", "", "2", "3", "4", "5"};
  constexpr std::size_t kMostParts = 60;
  std::vector<Place> best;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const char* start : kStarts) {
    AssemblyStyle style;
    style.start = start;
    std::vector<Place> places = places_of(assembly_dot(problem, style), problem.num_parts());
    if (problem.num_parts() > kMostParts) return places;
    const std::size_t found = crossings(problem, places);
    if (found < fewest) {
      fewest = found;
      best = std::move(places);
    }
    if (fewest == 0) break;
  }
  return best;
}

// -------------------------------------------------------------------------------------------------
// Steps

/// The whole structure laid out in a square of `side` points.
std::vector<Place> fitted_places(const Problem& problem, double side) {
  std::vector<Place> places = structure_places(problem);
  if (places.empty()) return places;
  const auto [left, right] = std::ranges::minmax(places, {}, &Place::x);
  const auto [bottom, top] = std::ranges::minmax(places, {}, &Place::y);
  const double width = right.x - left.x;
  const double height = top.y - bottom.y;
  const double scale = side / std::max({width, height, 1.0});
  const Place middle{(left.x + right.x) / 2, (bottom.y + top.y) / 2};
  for (Place& place : places) place = {(place.x - middle.x) * scale, (place.y - middle.y) * scale};
  return places;
}

/// The steps to draw: all, or `most` of them.
std::vector<std::size_t> chosen_steps(std::size_t steps, std::size_t most) {
  std::vector<std::size_t> chosen(std::min(steps, most));
  for (std::size_t i = 0; i < chosen.size(); ++i)
    chosen[i] = steps <= most ? i : i * (steps - 1) / (most - 1);
  return chosen;
}

/// One small structure of the strip, its centre at `centre`. Its nodes are named by the step.
class StepPanel {
 public:
  StepPanel(const TransitionSystem& system, const std::vector<Place>& places, bool named)
      : system_(system), problem_(system.problem()), places_(places), named_(named) {}

  /// `open` is the state before the step.
  [[nodiscard]] std::string text(std::size_t number, const ConnectionSet& open, const Step& step,
                                 Place centre, double half) const {
    const bool assembly = problem_.direction() == Direction::Assembly;
    ConnectionSet shown = system_.present(open.view());
    shown.insert(step.connection);
    std::vector<bool> held(problem_.num_parts(), false);
    for_each_connection(shown.view(), [&](ConnectionIndex c) {
      for (const PartIndex part : problem_.ends(c)) held[part] = true;
    });
    std::vector<bool> moved(problem_.num_parts(), false);
    if (step.separates) {
      for (const PartIndex part : step.moved()) moved[part] = true;
    }
    std::string text = fmt::format(
        "  t{} [shape=plaintext, style=\"\", fixedsize=false, margin=0, label={}, fontsize={}, "
        "pos=\"{:.1f},{:.1f}\"]\n",
        number,
        dot_string(fmt::format("{}. {} {}", number + 1, assembly ? "make" : "remove",
                               problem_.connection_id(step.connection))),
        std::max(9.0, half / 7), centre.x, centre.y + half + 15);
    for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
      text += fmt::format("  s{}p{} [pos=\"{:.1f},{:.1f}\"", number, part,
                          centre.x + places_[part].x, centre.y + places_[part].y);
      if (named_) text += fmt::format(", label={}", dot_string(problem_.part_id(part)));
      if (moved[part]) {
        text += fmt::format(R"(, color="{0}", fillcolor="{0}", fontcolor=white)", kGreen);
      } else if (!held[part]) {
        text += R"(, color="#d0d7de", fillcolor=white, fontcolor="#afb8c1")";
      }
      text += "]\n";
    }
    for_each_connection(shown.view(), [&](ConnectionIndex c) {
      const auto& [first, second] = problem_.ends(c);
      text += fmt::format("  s{0}p{1} -- s{0}p{2}", number, first, second);
      if (c == step.connection) {
        text +=
            fmt::format(R"( [color="{}", penwidth=2{}])", kGreen, assembly ? "" : ", style=dashed");
      } else if (moved[first] && moved[second]) {
        text += fmt::format(R"( [color="{}"])", kGreen);
      }
      text += '\n';
    });
    return text;
  }

 private:
  const TransitionSystem& system_;
  const Problem& problem_;
  const std::vector<Place>& places_;
  const bool named_;
};

// -------------------------------------------------------------------------------------------------
// H~

/// H~ in the DOT language, built node by node.
class TreeText {
 public:
  TreeText(const TransitionSystem& system, std::span<const ConnectionIndex> path)
      : problem_(system.problem()),
        expander_(system),
        path_(path),
        colours_(connection_colours(problem_)) {
    grow(system.start(), 0, !path.empty());
  }
  [[nodiscard]] std::string text() const {
    const bool small = nodes_ <= 40;
    return fmt::format(
               "digraph T {{\n"
               "  graph [rankdir=TB, bgcolor=white, margin=0.05, nodesep={}, ranksep={}]\n"
               "  node [shape=circle, label=\"\", width={}, fixedsize=true, style=filled, "
               "color=\"#57606a\", fillcolor=\"#f6f8fa\"]\n"
               "  edge [color=\"#8c959f\", penwidth={}, arrowsize={}, fontname=\"{}\", "
               "fontsize=10]\n",
               small ? 0.2 : 0.05, small ? 0.5 : 0.7, small ? 0.18 : 0.08, small ? 1.6 : 0.8,
               small ? 0.6 : 0.3, kFonts) +
           body_ + "}\n";
  }

 private:
  /// @returns the node's number.
  std::size_t grow(const ConnectionSet& open, std::size_t depth, bool on_path) {
    const std::size_t node = nodes_++;
    if (nodes_ > kMaxTreeNodes) {
      throw InputError(
          fmt::format("H~ has more than {} nodes, and its drawing cannot be read", kMaxTreeNodes));
    }
    std::string present;
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      if (open.contains(c) == (problem_.direction() == Direction::Disassembly))
        present += (present.empty() ? "" : " ") + problem_.connection_id(c);
    }
    body_ += fmt::format("  n{} [tooltip={}", node,
                         dot_string(present.empty() ? "\xe2\x88\x85" : present));  // the empty set
    if (on_path) body_ += fmt::format(R"(, color="{}", fillcolor="#dafbe1", penwidth=2)", kGreen);
    body_ += "]\n";
    const std::span<const Action> legal = expander_.legal_actions(open.view());
    const std::vector<Action> actions(legal.begin(), legal.end());
    for (const Action& action : actions) {
      ConnectionSet next = open;
      next.erase(action.connection);
      const bool follows = on_path && depth < path_.size() && path_[depth] == action.connection;
      const std::size_t child = grow(next, depth + 1, follows);
      body_ +=
          fmt::format("  n{} -> n{} [tooltip={}", node, child,
                      dot_string(fmt::format("{}  {}", problem_.connection_id(action.connection),
                                             short_number(action.reward))));
      if (follows) {
        body_ += fmt::format(R"(, color="{}", penwidth=3)", kGreen);
      } else if (!colours_.empty()) {
        body_ += fmt::format(R"(, color="{}")", colours_[action.connection % colours_.size()]);
      }
      body_ += "]\n";
    }
    return node;
  }

  const Problem& problem_;
  Expander expander_;
  std::span<const ConnectionIndex> path_;
  std::span<const std::string_view> colours_;
  std::size_t nodes_ = 0;
  std::string body_;
};

// -------------------------------------------------------------------------------------------------
// Charts

/// A string of gnuplot in single quotes, in which nothing is expanded: no escapes, no commands, no
/// macros.
std::string gnuplot_string(std::string_view text) {
  std::string result = "'";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      result += ' ';
    } else {
      if (c == '\'') result += c;
      result += c;
    }
  }
  return result + '\'';
}

/// What gnuplot makes of a script. It reads no one's settings.
std::string chart(std::string_view script) {
  const std::vector<std::string> arguments = {"-d"};
  std::string svg = drawn_by("gnuplot", "gnuplot-nox", arguments, script);
  constexpr std::string_view kFont = "font-family=\"Helvetica\"";
  const std::string fonts = fmt::format("font-family=\"{}\"", kFonts);
  for (std::size_t at = svg.find(kFont); at != std::string::npos;
       at = svg.find(kFont, at + fonts.size()))
    svg.replace(at, kFont.size(), fonts);
  constexpr std::string_view kTitle = "<title>Gnuplot</title>";  // a viewer would show it
  const std::size_t title = svg.find(kTitle);
  if (title != std::string::npos) svg.erase(title, kTitle.size());
  return svg;
}

std::string terminal(int width, int height) {
  return fmt::format(
      "set encoding utf8\n"
      "set terminal svg size {},{} fixed font \"Helvetica,11\" background rgb \"white\" "
      "linewidth 1\n"
      "set border lc rgb \"#57606a\" lw 0.8\nset tics textcolor rgb \"#1f2328\"\n",
      width, height);
}

double mean_of(std::span<const double> rewards) {
  double above_first = 0;  // so that equal rewards have exactly their own mean
  for (const double reward : rewards) above_first += reward - rewards.front();
  return rewards.front() + above_first / static_cast<double>(rewards.size());
}

/// Silverman's rule of thumb; at least a hundredth of the range, so that the curve is one.
double bandwidth(std::span<const double> rewards) {
  std::vector<double> sorted(rewards.begin(), rewards.end());
  std::ranges::sort(sorted);
  const double mean = mean_of(rewards);
  double squares = 0;
  for (const double reward : sorted) squares += (reward - mean) * (reward - mean);
  const auto n = static_cast<double>(sorted.size());
  const double deviation = std::sqrt(squares / std::max(1.0, n - 1));
  const double quartiles = sorted[sorted.size() * 3 / 4] - sorted[sorted.size() / 4];
  const double spread = quartiles > 0 ? std::min(deviation, quartiles / 1.34) : deviation;
  return std::max(0.9 * spread * std::pow(n, -0.2), (sorted.back() - sorted.front()) / 100);
}

}  // namespace

std::span<const std::string_view> connection_colours(const Problem& problem) {
  if (problem.num_connections() > kColours.size()) return {};
  return kColours;
}

std::string structure_svg(const Problem& problem) {
  const std::vector<Place> places = structure_places(problem);
  AssemblyStyle style;
  style.colours = connection_colours(problem);
  style.places = places;
  return svg_text(assembly_dot(problem, style));
}

std::string state_graph_svg(const StateGraph& graph, const StateGraphFigure& figure) {
  require_drawable(figure.whole != nullptr ? *figure.whole : graph);
  StateGraphStyle style;
  style.compact = true;
  style.whole = figure.whole;
  if (figure.coloured) style.colours = connection_colours(graph.system().problem());
  return svg_text(state_graph_dot(graph, figure.path, style));
}

std::string tree_svg(const TransitionSystem& system, std::span<const ConnectionIndex> path) {
  return svg_text(TreeText(system, path).text());
}

std::size_t most_drawn_steps(const Problem& problem) {
  return problem.num_parts() <= 60 ? 30 : 12;
}

std::string steps_svg(const TransitionSystem& system, std::span<const ConnectionIndex> plan) {
  const Problem& problem = system.problem();
  const std::size_t parts = problem.num_parts();
  const bool named = parts <= 12;
  const double half = parts <= 12 ? 38 : parts <= 60 ? 52 : 110;  // of a panel, in points
  const double node_size = named ? 15 : parts <= 40 ? 7 : 4;
  const std::vector<Place> places = fitted_places(problem, 2 * half);
  const StepPanel panel(system, places, named);

  std::string text = fmt::format(
      "graph S {{\n"
      "  graph [layout=nop2, bgcolor=white, margin=0.05, outputorder=edgesfirst]\n"
      "  node [shape=circle, label=\"\", width={}, fixedsize=true, style=filled, "
      "color=\"#57606a\", fillcolor=\"#eaeef2\", fontname=\"{}\", fontsize=8]\n"
      "  edge [color=\"#57606a\", penwidth=1]\n",
      node_size / 72, kFonts);
  const std::vector<std::size_t> chosen = chosen_steps(plan.size(), most_drawn_steps(problem));
  const std::size_t columns =
      std::min<std::size_t>(std::max<std::size_t>(chosen.size(), 1), parts <= 60 ? 6 : 4);
  Expander expander(system);
  ConnectionSet open = system.start();
  std::size_t drawn = 0;
  for (std::size_t k = 0; k < plan.size(); ++k) {
    if (drawn < chosen.size() && chosen[drawn] == k) {
      const Place centre{static_cast<double>(drawn % columns) * (2 * half + 34),
                         -static_cast<double>(drawn / columns) * (2 * half + 46)};
      text += panel.text(k, open, expander.step(open.view(), plan[k]), centre, half);
      ++drawn;
    }
    open.erase(plan[k]);
  }
  return svg_text(text + "}\n");
}

std::string distribution_svg(const DistributionFigure& figure) {
  if (figure.rewards.empty()) throw InputError("a distribution needs at least one reward");
  const auto [least, greatest] = std::ranges::minmax(figure.rewards);
  double low = least;
  double high = greatest;
  for (const Mark& mark : figure.marks) {
    low = std::min(low, mark.reward);
    high = std::max(high, mark.reward);
  }
  const double room = high > low ? 0.04 * (high - low) : std::max(0.1, std::abs(low) * 0.1);
  const bool spread = greatest - least > 1e-12 * std::max(1.0, std::abs(least));

  const int key = 20 + 15 * static_cast<int>(1 + figure.marks.size());  // its height
  const int height = key + 130;
  std::string script = terminal(460, height);
  script += "set xrange [*:*]\n$sample << EOD\n";
  for (const double reward : figure.rewards) script += fmt::format("{}\n", reward);
  script += "EOD\n";
  if (spread) {
    script += fmt::format(
        "set xrange [{}:{}]\nset samples 240\nset table $density\n"
        "plot $sample using 1:(1) smooth kdensity bandwidth {}\nunset table\n"
        "stats $density using 2 nooutput name 'D'\n",
        least, greatest, bandwidth(figure.rewards));
  }
  script += fmt::format(
      "set xrange [{}:{}]\nset yrange [-1.2:1.2]\nunset ytics\nset border 1\n"
      "set xtics nomirror out scale 0.6\nset xlabel 'reward'\n"
      "set key at screen 0.03,0.97 left top Left reverse vertical noenhanced samplen 1.6 "
      "spacing 1.0\nset margins 2, 2, 3.4, 0\nset tmargin at screen {:.3f}\n",
      low - room, high + room, 1 - static_cast<double>(key) / height);
  std::vector<std::string> plots;
  if (spread) {
    plots.emplace_back(
        "$density using 1:($2/D_max):(-$2/D_max) with filledcurves fc rgb '#d7e6f7' notitle");
    for (const char* sign : {"", "-"}) {
      plots.push_back(fmt::format(
          "$density using 1:({}$2/D_max) with lines lc rgb '#5b8ec4' lw 1 notitle", sign));
    }
  }
  const auto add = [&](const std::string& name, double reward, double half,
                       const std::string& style) {
    script += fmt::format("$mark{} << EOD\n{}\nEOD\n", plots.size(), reward);
    plots.push_back(fmt::format("$mark{} using 1:({}):(0):({}) with vectors nohead {} title {}",
                                plots.size(), -half, 2 * half, style, gnuplot_string(name)));
  };
  const auto named = [](std::string_view name, double reward) {
    return fmt::format("{} {}", name, short_number(reward));
  };
  add(named(fmt::format("{} random, mean", figure.rewards.size()), mean_of(figure.rewards)),
      mean_of(figure.rewards), spread ? 0.35 : 1, "lc rgb '#2f6299' lw 2");
  for (const double end : {least, greatest}) {
    if (!spread) break;
    script += fmt::format("$mark{} << EOD\n{}\nEOD\n", plots.size(), end);
    plots.push_back(fmt::format(
        "$mark{} using 1:(-0.18):(0):(0.36) with vectors nohead lc rgb '#2f6299' lw 1 notitle",
        plots.size()));
  }
  for (const Mark& mark : figure.marks) {
    if (mark.kind == Mark::Kind::Best) {
      add(named(mark.name, mark.reward), mark.reward, 1.1, "lc rgb '#1f2328' lw 1 dt (6,4)");
      continue;
    }
    script += fmt::format("$mark{} << EOD\n{}\nEOD\n", plots.size(), mark.reward);
    plots.push_back(fmt::format("$mark{} using 1:(0) with points {} title {}", plots.size(),
                                mark.kind == Mark::Kind::Plan
                                    ? "pt 13 ps 1.1 lc rgb '#1a7f37'"
                                    : "pt 8 ps 0.9 lw 1.4 lc rgb '#bc4c00'",
                                gnuplot_string(named(mark.name, mark.reward))));
  }
  script += fmt::format("plot {}\n", fmt::join(plots, ", \\\n     "));
  return chart(script);
}

double states_of(std::size_t connections) {
  return std::exp2(static_cast<double>(connections));
}

double actions_of(std::size_t connections) {
  return static_cast<double>(connections) * std::exp2(static_cast<double>(connections) - 1);
}

double tree_nodes_of(std::size_t connections) {
  double nodes = 1;  // nodes(n) = 1 + n nodes(n - 1): the root, and a tree below each first step
  for (std::size_t n = 1; n <= connections; ++n) nodes = 1 + static_cast<double>(n) * nodes;
  return nodes;
}

std::string growth_svg(std::span<const GrowthSeries> series) {
  constexpr std::array<const char*, 5> kMarks = {
      "pt 6 ps 0.7 lw 1.3 lc rgb '#0072b2'", "pt 4 ps 0.7 lw 1.3 lc rgb '#d55e00'",
      "pt 8 ps 0.75 lw 1.3 lc rgb '#5e3c99'", "pt 12 ps 0.8 lw 1.3 lc rgb '#8c510a'",
      "pt 10 ps 0.75 lw 1.3 lc rgb '#cc79a7'"};
  std::size_t most = 1;
  bool tree = false;
  std::string script = terminal(560, 290);
  for (std::size_t i = 0; i < series.size(); ++i) {
    script += fmt::format("$points{} << EOD\n", i);
    for (const GrowthPoint& point : series[i].points) {
      most = std::max(most, point.connections);
      tree = tree || point.tree_nodes > 0;
      script += fmt::format("{} {} {} {}\n", point.connections, point.states, point.actions,
                            point.tree_nodes > 0 ? fmt::to_string(point.tree_nodes) : "NaN");
    }
    script += "EOD\n";
  }
  script += "$formula << EOD\n";
  for (std::size_t n = 1; n <= most; ++n) {
    script += fmt::format("{} {} {} {}\n", n, states_of(n), actions_of(n), tree_nodes_of(n));
  }
  script += fmt::format(
      "EOD\nset logscale y 10\nset format y '10^{{%T}}'\nset border 3\n"
      "set tics nomirror out scale 0.6\nset xlabel 'connections'\nset xrange [0:{}]\n"
      "set key noenhanced top left Left reverse samplen 1.6 spacing 1.15 width -2\n"
      "set grid ytics lc rgb '#eaeef2' lw 0.8 lt 1\n"
      "set multiplot layout 1,2 margins 0.09,0.985,0.15,0.9 spacing 0.11\n",
      most + 1);
  constexpr const char* kLine = "with lines lw 1.2 lc rgb '#1f2328'";
  const auto panel = [&](const char* title, int column, const char* formula, bool with_tree) {
    std::vector<std::string> plots = {
        fmt::format("$formula using 1:{} {} title '{}'", column, kLine, formula)};
    if (with_tree) {
      plots.push_back(
          "$formula using 1:4 with lines lw 1.2 dt (5,3) lc rgb '#8c959f' title "
          "'nodes of the tree: Σ n!/k!'");
    }
    for (std::size_t i = 0; i < series.size(); ++i) {
      const char* const mark = kMarks[i % kMarks.size()];
      plots.push_back(fmt::format("$points{} using 1:{} with points {} title {}", i, column, mark,
                                  gnuplot_string(series[i].name)));
      if (with_tree)
        plots.push_back(fmt::format("$points{} using 1:4 with points {} notitle", i, mark));
    }
    script += fmt::format("set title '{}'\nplot {}\n", title, fmt::join(plots, ", \\\n     "));
  };
  panel("states", 2, "2ⁿ", tree);
  panel("actions", 3, "n 2ⁿ⁻¹", false);
  script += "unset multiplot\n";
  return chart(script);
}

GrowthSeries growth_along(const Problem& problem, std::span<const ConnectionIndex> plan,
                          double most_states, const Budget& budget) {
  GrowthSeries series;
  Situation situation = Situation::whole(problem.num_connections());
  situation.open = ConnectionSet(problem.num_connections());
  for (std::size_t left = 1; left <= plan.size(); ++left) {
    situation.open.insert(plan[plan.size() - left]);
    const TransitionSystem system(problem, situation);
    if (estimate_graph(system).states > 2 * most_states) break;
    const StateGraph graph = StateGraph::build(system, budget);
    if (graph.stop() != Stop::None || static_cast<double>(graph.num_states()) > most_states) break;
    series.points.push_back({left, static_cast<double>(graph.num_states()),
                             static_cast<double>(graph.num_actions()), 0});
  }
  return series;
}

std::vector<FigureFile> write_figures(const Problem& problem, const FigureRequest& request,
                                      const std::filesystem::path& folder, const Budget& budget) {
  const TransitionSystem system(problem);
  std::vector<FigureFile> files;
  std::vector<std::string> drawings;
  const auto add = [&](std::string name, std::string caption, std::string svg) {
    files.push_back({std::move(name), std::move(caption)});
    drawings.push_back(std::move(svg));
  };
  add("structure.svg", "The structure: a circle a part, a line a connection.",
      structure_svg(problem));
  if (!request.plan.empty()) {
    const std::size_t drawn = std::min(request.plan.size(), most_drawn_steps(problem));
    add("steps.svg",
        drawn == request.plan.size()
            ? "The plan, step by step; in green what is moved and the connection handled."
            : fmt::format("{} of the plan's {} steps; in green what is moved and the connection "
                          "handled.",
                          drawn, request.plan.size()),
        steps_svg(system, request.plan));
  }
  if (estimate_graph(system).states <= 2.0 * kMaxDrawnStates) {
    const StateGraph graph = StateGraph::build(system, budget);
    if (graph.stop() == Stop::None && graph.num_states() <= kMaxDrawnStates) {
      add("state-graph.svg",
          fmt::format("The state-action graph H: {} states, {} actions{}.", graph.num_states(),
                      graph.num_actions(), request.plan.empty() ? "" : "; the plan in green"),
          state_graph_svg(graph, {.path = request.plan}));
      const std::string nodes = graph_size(graph).tree_nodes;
      if (nodes.size() < 10 && std::stoul(nodes) <= kMaxTreeNodes) {
        add("tree.svg",
            fmt::format("The tree H~ of all orders: {} nodes{}.", nodes,
                        request.plan.empty() ? "" : "; the plan in green"),
            tree_svg(system, request.plan));
      }
    }
  }
  if (!request.sample.empty()) {
    add("distribution.svg", fmt::format("Rewards of {} random sequences.", request.sample.size()),
        distribution_svg({request.sample, request.marks}));
  }
  if (!request.plan.empty()) {
    constexpr double kMostStates = 200'000;
    GrowthSeries series = growth_along(problem, request.plan, kMostStates, budget);
    series.name = "what the plan leaves";
    if (!series.points.empty()) {
      add("growth.svg",
          "States and actions of H of what the plan leaves to be done, against its connections; "
          "lines: without constraints.",
          growth_svg({&series, 1}));
    }
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw InputError(fmt::format("cannot make the folder {}: {}", folder.string(),
                                 error ? error.message() : "there is a file of that name"));
  }
  for (std::size_t i = 0; i < files.size(); ++i) write_file(folder / files[i].name, drawings[i]);
  return files;
}

}  // namespace orasp
