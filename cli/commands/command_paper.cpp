#include "cli/commands/command_paper.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"
#include "cli/output/json_output.h"
#include "cli/output/text.h"
#include "cli/paper/paper_page.h"
#include "orasp/drawing/graphviz.h"
#include "orasp/io/atomic_file.h"

namespace orasp::cli {
namespace {

constexpr const char* kFigures = "figures";

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  std::error_code ignored;
  if (std::filesystem::is_directory(folder, ignored)) return;
  throw InputError(fmt::format(
      "cannot make the folder {}: {}", in_quotes(folder.string()),
      std::filesystem::exists(folder, ignored) ? "there is a file of that name" : error.message()));
}

/// Says before minutes of work what would fail after them.
void require_drawing_programs() {
  static_cast<void>(svg_text("graph {}"));
  static_cast<void>(distribution_svg({std::vector<double>{0}, {}}));
}

int interrupted() {
  print_error("interrupted; nothing was written");
  return kStopped;
}

std::string own_program() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) throw InputError("cannot find this program's own file: " + error.message());
  return program.string();
}

}  // namespace

int run(const PaperOptions& options, const Context& context) {
  const std::filesystem::path folder = options.folder;
  make_folder(folder);
  make_folder(folder / kFigures);
  require_drawing_programs();
  const Budget budget = make_budget({});
  const std::optional<Paper> paper = computed_paper(
      options.effort, own_program(), budget, [&](std::string_view piece) { context.say(piece); });
  if (!paper) return interrupted();
  context.say("figures");
  std::optional<Document> page;
  try {
    page = paper_page(*paper);
  } catch (const InputError&) {
    if (!budget.stop.stop_requested()) throw;  // else the signal ended a drawing program too
  }
  if (!page || budget.stop.stop_requested()) return interrupted();
  for (const DocumentFigure* const figure : page->pictures())
    write_file(folder / kFigures / figure->name, figure->svg);
  const std::string json = json_text(paper_json(*paper));
  write_file(folder / "paper.json", json);
  write_file(folder / "paper.md", page->markdown(kFigures));
  write_file(folder / "paper.html", page->html());
  context.print(
      options.json
          ? json
          : fmt::format("{}, paper.md, paper.json and {} in {}\n", (folder / "paper.html").string(),
                        counted(page->pictures().size(), "figure"), (folder / kFigures).string()));
  return kSolved;
}

CommandWork paper_command(CommandLine& line) {
  const auto chosen = std::make_shared<PaperOptions>();
  PaperOptions& options = *chosen;
  line.about(
      "Computes everything of the paper again that can be computed, beside the\n"
      "printed numbers: DIR/paper.html, paper.md, paper.json, figures/*.svg.");
  line.text("-o,--output", "DIR",
            "Write into this folder, which is made if it is missing (default: orasp-paper).",
            options.folder);
  line.flag("--quick", options.effort.quick,
            "Fewer repeats, smaller growth, training of a second or two (default: a few minutes).");
  line.turn_off("--no-learning", options.effort.learning,
                "Leave the learned plans out (default: train them).");
  line.flag("--json", options.json, "Print the numbers as JSON (default: what was written).");
  line.quiet_flag("No progress on standard error (default: what comes next).");
  line.footer(
      "\nExamples:\n"
      "  orasp paper -o paper\n"
      "  orasp paper --quick -o /tmp/paper\n"
      "\n"
      "Exit codes: 0 written, 20 Ctrl-C stopped it (nothing is written), 30 wrong input, or\n"
      "Graphviz or gnuplot is missing.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
