#include "orasp/io/graphviz.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <system_error>
#include <unordered_set>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "orasp/io/atomic_file.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

// ------------------------------------------------------------------------------------------------
// H as a text

/// How much a drawing names; the larger H, the less.
enum class Detail {
  Everything,  ///< states, actions and their rewards
  States,
  Shape,  ///< points and lines
};

Detail detail_for(std::uint64_t states) {
  if (states <= 40) return Detail::Everything;
  return states <= 250 ? Detail::States : Detail::Shape;
}

/// A string of the DOT language, quotes and all. Line breaks are part of labels ("\n"), so they are
/// made here.
std::string dot_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '\n') {
      result += "\\n";
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      result += '?';  // not allowed in XML, which SVG is
    } else {
      if (c == '"' || c == '\\') result += '\\';
      result += c;
    }
  }
  return result + '"';
}

/// At most four decimals, no trailing zeros.
std::string short_number(double number) {
  std::string text = fmt::format("{:.4f}", number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

class StateNames {
 public:
  StateNames(const Problem& problem, Detail detail)
      : problem_(problem), line_width_(detail == Detail::Everything ? 24 : 11) {}

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

std::string header(Detail detail) {
  std::string text =
      "digraph H {\n"
      "  graph [rankdir=TB, bgcolor=white, margin=0.2, outputorder=edgesfirst";
  text += detail == Detail::Everything ? ", nodesep=0.45, ranksep=0.75"
          : detail == Detail::States   ? ", nodesep=0.2, ranksep=1.1"
                                       : ", layout=nop2";
  text += "]\n";
  text += detail == Detail::Shape
              ? "  node [shape=circle, label=\"\", width=0.1, fixedsize=true, style=filled, "
                "color=\"#57606a\", fillcolor=\"#8c959f\"]\n"
                "  edge [color=\"#8c959f60\", arrowhead=none, penwidth=0.5]\n"
              : "  node [shape=box, style=\"rounded,filled\", color=\"#8c959f\", "
                "fillcolor=\"#f6f8fa\", fontname=\"Helvetica\", fontsize=12, margin=\"0.12,0.06\", "
                "height=0.3]\n"
                "  edge [color=\"#8c959f\", fontcolor=\"#57606a\", fontname=\"Helvetica\", "
                "fontsize=10, arrowsize=0.7]\n";
  return text;
}

// ------------------------------------------------------------------------------------------------
// Running dot

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

[[noreturn]] void fail(std::string_view what, int error) {
  throw InputError(
      fmt::format("cannot draw: {}: {}", what, std::generic_category().message(error)));
}

/// A file without a name, gone when it is closed. Files, not pipes: no reader and writer that wait
/// for each other, and no signal if `dot` stops reading.
File scratch_file() {
  File file(std::tmpfile());
  if (!file) fail("no temporary file", errno);
  fcntl(fileno(file.get()), F_SETFD, FD_CLOEXEC);
  return file;
}

std::string contents(std::FILE* file) {
  std::string text;
  std::rewind(file);
  char piece[1 << 16];
  while (const std::size_t length = std::fread(piece, 1, sizeof piece, file))
    text.append(piece, length);
  return text;
}

/// Starts `dot -Tsvg` with the three files as its standard streams. @returns 0 or the error.
int spawn_dot(std::FILE* input, std::FILE* output, std::FILE* errors, pid_t& process) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(input), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(output), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(errors), STDERR_FILENO);

  // The caller may have blocked or ignored signals; the child gets the usual ones.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t signals;
  sigemptyset(&signals);
  posix_spawnattr_setsigmask(&attributes, &signals);
  sigaddset(&signals, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

  char name[] = "dot";
  char option[] = "-Tsvg";
  char* const arguments[] = {name, option, nullptr};
  const int error = posix_spawnp(&process, name, &actions, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

/// @returns the status of waitpid.
int wait_for(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) fail("waiting for dot", errno);
  }
  return status;
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
                            std::span<const ConnectionIndex> highlighted_path) {
  if (graph.num_states() > kMaxDotStates) {
    throw InputError(
        fmt::format("H has {} states, and its text in the DOT language is written up to {}",
                    graph.num_states(), kMaxDotStates));
  }
  const Problem& problem = graph.system().problem();
  const Path path = path_of(graph, highlighted_path);
  const Detail detail = detail_for(graph.num_states());
  const StateNames names(problem, detail);
  const std::optional<StateId> goal = graph.goal();

  std::optional<LayeredLayout> layout;
  if (detail == Detail::Shape) layout.emplace(graph);

  std::string text = header(detail);
  for (StateId s = 0; s < graph.num_states(); ++s) {
    const SetView open = graph.state(s);
    const bool dead_end = graph.begin(s) == graph.end(s) && s != goal;
    text += fmt::format("  s{} [", s);
    if (detail != Detail::Shape) text += fmt::format("label={}, ", dot_string(names.brief(open)));
    if (layout) text += fmt::format("pos=\"{:.1f},{:.1f}\", ", layout->x(s), layout->y(s));
    text += fmt::format("tooltip={}", dot_string(names.full(open)));
    if (path.states.contains(s)) text += R"(, color="#1a7f37", fillcolor="#dafbe1", penwidth=2)";
    if (path.states.contains(s) && detail == Detail::Shape)
      text += R"(, fillcolor="#1a7f37", width=0.2)";
    if (dead_end) text += R"(, color="#cf222e", fillcolor="#ffebe9")";
    text += "]\n";
  }
  for (StateId s = 0; s < graph.num_states(); ++s) {
    for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
      const std::string label = fmt::format(" {}  {} ", problem.connection_id(graph.connection(a)),
                                            short_number(graph.reward(a)));
      text += fmt::format("  s{} -> s{} [{}={}", s, graph.successor(a),
                          detail == Detail::Everything ? "label" : "tooltip", dot_string(label));
      if (path.actions.contains(a))
        text += fmt::format(R"(, color="#1a7f37", fontcolor="#1a7f37", penwidth={})",
                            detail == Detail::Shape ? 2 : 2.4);
      text += "]\n";
    }
  }
  return text + "}\n";
}

std::string assembly_dot(const Problem& problem) {
  std::string text =
      "graph G {\n"
      "  graph [bgcolor=white, margin=0.2, layout=neato, overlap=false, splines=true]\n"
      "  node [shape=circle, style=filled, color=\"#57606a\", fillcolor=\"#ddf4ff\", "
      "fontname=\"Helvetica\", "
      "fontsize=12, margin=0.04]\n"
      "  edge [color=\"#57606a\", fontcolor=\"#57606a\", fontname=\"Helvetica\", fontsize=9, "
      "penwidth=1.4]\n";
  for (PartIndex part = 0; part < problem.num_parts(); ++part) {
    const Part& spec = problem.parts()[part];
    text += fmt::format("  p{} [label={}, tooltip={}]\n", part, dot_string(spec.id),
                        dot_string(spec.name.empty() ? spec.id : spec.name));
  }
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const auto& [first, second] = problem.ends(c);
    text += fmt::format("  p{} -- p{} [tooltip={}]\n", first, second,
                        dot_string(problem.connection_id(c)));
  }
  return text + "}\n";
}

std::string svg_text(std::string_view dot) {
  const File input = scratch_file();
  const File output = scratch_file();
  const File errors = scratch_file();
  if (std::fwrite(dot.data(), 1, dot.size(), input.get()) != dot.size() ||
      std::fflush(input.get()) != 0)
    fail("no room for a temporary file", errno);
  std::rewind(input.get());

  pid_t process = 0;
  const int error = spawn_dot(input.get(), output.get(), errors.get(), process);
  if (error == ENOENT)
    throw InputError(
        "cannot draw: the program dot is missing; it is in the Debian package graphviz");
  if (error != 0) fail("dot does not start", error);
  const int status = wait_for(process);
  if (WIFSIGNALED(status))
    throw InputError(fmt::format("cannot draw: dot was ended by signal {}", WTERMSIG(status)));
  if (WEXITSTATUS(status) != 0) {
    std::string message = contents(errors.get());
    message.erase(std::min(message.find('\n'), message.size()));
    throw InputError(fmt::format("cannot draw: dot failed with exit code {}{}{}",
                                 WEXITSTATUS(status), message.empty() ? "" : ": ", message));
  }
  return contents(output.get());
}

void write_svg(std::string_view dot, const std::filesystem::path& file) {
  write_file(file, svg_text(dot));
}

}  // namespace orasp
