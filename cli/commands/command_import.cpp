#include "cli/commands/command_import.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/problem_source.h"
#include "cli/output/import_report.h"
#include "cli/output/json_output.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "orasp/io/import_files.h"
#include "orasp/io/model_files.h"

namespace orasp::cli {
namespace {

/// How long each stage takes, and a line that says which one it is: the stages tell when they
/// begin, and a thread of its own shows the line while one is at work.
class Stages {
 public:
  Stages(const Context& context, std::string title) : line_(context, std::move(title)) {
    if (context.shows_progress())
      shower_ = std::jthread([this](const std::stop_token& stop) { show_until(stop); });
  }
  ~Stages() { stop_showing(); }
  Stages(const Stages&) = delete;
  Stages& operator=(const Stages&) = delete;

  void tell(const Progress& progress) {
    const std::scoped_lock lock(mutex_);
    done_ = progress.done;
    total_ = progress.total;
    if (progress.phase != stage_) begin(std::string(progress.phase));
  }
  /// The seconds of all stages; nothing is shown any more.
  std::vector<std::pair<std::string, double>> end() {
    stop_showing();
    begin({});
    return std::move(seconds_);
  }

 private:
  void begin(std::string stage) {
    const double now = watch_.seconds();
    if (!stage_.empty()) {
      const auto known =
          std::ranges::find(seconds_, stage_, &std::pair<std::string, double>::first);
      if (known != seconds_.end()) {
        known->second += now - since_;
      } else {
        seconds_.emplace_back(stage_, now - since_);
      }
    }
    stage_ = std::move(stage);
    since_ = now;
  }
  void show_until(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!wake_.wait_for(lock, stop, std::chrono::milliseconds(100), [] { return false; })) {
      if (stop.stop_requested()) return;
      if (!stage_.empty()) line_.show({.phase = stage_, .done = done_, .total = total_});
    }
  }
  void stop_showing() {
    if (!shower_.joinable()) return;
    shower_.request_stop();
    shower_.join();
  }

  ProgressLine line_;
  Stopwatch watch_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::string stage_;
  std::uint64_t done_ = 0;
  std::uint64_t total_ = 0;
  double since_ = 0;
  std::vector<std::pair<std::string, double>> seconds_;
  std::jthread shower_;
};

double millimetres_of(const std::string& unit) {
  constexpr std::array<std::pair<std::string_view, double>, 8> kUnits = {{{"um", 1e-3},
                                                                          {"mm", 1},
                                                                          {"cm", 10},
                                                                          {"dm", 100},
                                                                          {"m", 1000},
                                                                          {"inch", 25.4},
                                                                          {"in", 25.4},
                                                                          {"foot", 304.8}}};
  for (const auto& [name, millimetres] : kUnits) {
    if (unit == name) return millimetres;
  }
  throw InputError(
      fmt::format("--unit: {} is not a unit of length; those are um, mm, cm, dm, m, inch and foot",
                  in_quotes(unit)));
}

/// "2700", "Plate=2700" or several with commas between them.
Densities densities_of(const std::string& text) {
  Densities densities;
  for (const std::string& piece : comma_separated(text)) {
    const std::size_t sign = piece.rfind('=');
    const double density = number(
        "--density", sign == std::string::npos ? piece : piece.substr(sign + 1), Sign::Positive);
    if (sign == std::string::npos) {
      densities.others = density;
    } else {
      densities.by_part.emplace_back(piece.substr(0, sign), density);
    }
  }
  return densities;
}

void set_durations(const std::string& text, std::array<double, 3>& durations) {
  constexpr std::array<std::string_view, 3> kKinds = {"contact", "fit", "fastener"};
  for (const std::string& piece : comma_separated(text)) {
    const std::size_t sign = piece.find('=');
    const std::string kind = piece.substr(0, sign);
    const auto known = std::ranges::find(kKinds, kind);
    if (sign == std::string::npos || known == kKinds.end()) {
      throw InputError(
          fmt::format("--duration: {} is not KIND=SECONDS; kinds are contact, fit and fastener",
                      in_quotes(piece)));
    }
    durations[static_cast<std::size_t>(known - kKinds.begin())] =
        number("--duration", piece.substr(sign + 1), Sign::NotNegative);
  }
}

/// What the command does once it knows all: reads, finds, writes.
ImportedAssembly imported(const ImportOptions& options, const Budget& budget, Stages& stages,
                          double& tolerance) {
  const auto tell = [&stages](const Progress& progress) { stages.tell(progress); };
  const CadReadSettings reading{.tolerance = options.tolerance,
                                .millimetres_per_unit = options.millimetres_per_unit,
                                .solids = options.solids,
                                .threads = budget.threads,
                                .stop = budget.stop,
                                .progress = tell};
  ModelFiles files;
  files.models.assign(options.models.begin(), options.models.end());
  files.poses = options.poses;
  CadModel model = read_model(files, reading);
  ImportSettings settings = options.settings;
  tolerance = settings.tolerance = model.tolerance;
  settings.threads = budget.threads;
  settings.stop = budget.stop;
  settings.progress = tell;
  return assembly_from_cad(std::move(model), settings);
}

void require_sense(const ImportOptions& options) {
  if (options.output.empty())
    throw InputError("-o FILE is missing, the problem to write (-o - prints it)");
  if (options.output == "-" && options.json)
    throw InputError("only one of --json and -o - can be on standard output");
  if (options.models.empty()) throw InputError("MODEL is missing, a file or a folder");
  const std::filesystem::path shapes =
      std::filesystem::path(options.output).replace_extension(".glb");
  for (const std::string& model : options.models) {
    std::error_code ignored;
    if (std::filesystem::equivalent(model, shapes, ignored))
      throw InputError(fmt::format(
          "the shapes would be written over {}; give -o another name or folder", in_quotes(model)));
  }
}

}  // namespace

int run(const ImportOptions& options, const Context& context) {
  require_sense(options);
  LimitOptions limits;
  limits.threads = options.threads;
  const Budget budget = make_budget(limits);
  ImportFacts facts;
  ImportedAssembly assembly;
  try {
    Stages stages(context, options.models.front());
    assembly = imported(options, budget, stages, facts.tolerance);
    if (budget.stop.stop_requested()) throw Interrupted();
    stages.tell({.phase = "writing"});
    if (options.output != "-") {
      facts.shapes_file = write_import(assembly, options.output).string();
      facts.problem_file = options.output;
      std::error_code ignored;
      facts.shapes_bytes = std::filesystem::file_size(facts.shapes_file, ignored);
    }
    facts.seconds = stages.end();
  } catch (const Interrupted&) {
    context.say("orasp: interrupted, nothing was written");
    return kStopped;
  }
  for (const std::string& warning : assembly.warnings) context.warn(printable(warning));
  if (options.output == "-") {
    context.print(imported_problem_text(assembly, ""));
  } else if (options.json) {
    context.print(json_text(import_json(assembly, facts)));
  } else {
    context.print(import_summary(assembly, facts, context));
  }
  return kSolved;
}

namespace {

void add_model_options(CommandLine& line, ImportOptions& options) {
  line.group("Model");
  line.real("--tolerance", "MM",
            "Nearer is contact, and what is narrower than twice this blocks nothing; surfaces are "
            "meshed to half of it (default: 0.1, less for products below 20 mm and more for those "
            "beyond 2 m).",
            options.tolerance, Sign::Positive);
  line.value("--unit", "UNIT",
             "What the file is in: um, mm, cm, dm, m, inch or foot (default: what the file says, "
             "else mm).",
             [&options](const std::string& given) {
               options.millimetres_per_unit = millimetres_of(given);
             });
  line.words({"um", "mm", "cm", "dm", "m", "inch", "foot"});
  line.flag("--solids", options.solids,
            "Take every solid for a part, even where a product holds several (default: a product "
            "is a part, and solids are where the file is a single product).");
  line.text("--pose", "FILE",
            "Where the parts of a mesh folder stand, as JSON (default: where they are drawn).",
            options.poses);
  line.value(
      "--density", "KG/M3",
      "Density of parts of which neither the file nor the name tells one, or of some: "
      "2700,Plate=7850 (default: 1200).",
      [&options](const std::string& given) { options.settings.densities = densities_of(given); });
}

void add_part_options(CommandLine& line, ImportOptions& options) {
  ImportSettings& settings = options.settings;
  line.group("Parts");
  line.text("--exclude", "PARTS",
            "Leave these parts out: ids or names with commas between them, * for any text "
            "(default: none).",
            settings.exclude);
  line.text("--flexible", "PARTS",
            "Parts such as belts and cables: they block nothing and nothing blocks them (default: "
            "none).",
            settings.flexible);
  line.text("--base", "PARTS",
            "Parts that are fixed and never move; none for none (default: where all else comes off "
            "it one by one, the part with most connections).",
            settings.base);
}

void add_plan_options(CommandLine& line, ImportOptions& options) {
  ImportSettings& settings = options.settings;
  line.group("Problem");
  line.value("--directions", "SET",
             "Directions in which pieces may leave: axes, or geometry for those too that the faces "
             "suggest (default: axes).",
             [&settings](const std::string& given) {
               if (given != "axes" && given != "geometry")
                 throw InputError(fmt::format("--directions: {} is neither axes nor geometry",
                                              in_quotes(given)));
               settings.directions =
                   given == "axes" ? ImportDirections::Axes : ImportDirections::Geometry;
             });
  line.words({"axes", "geometry"});
  line.value("--action", "STEP",
             "What one step takes: a part with all its contacts, or one connection (default: "
             "part).",
             [&settings](const std::string& given) {
               if (given != "part" && given != "connection")
                 throw InputError(
                     fmt::format("--action: {} is neither part nor connection", in_quotes(given)));
               settings.action = given == "part" ? StepKind::Part : StepKind::Connection;
             });
  line.words({"part", "connection"});
  line.value("--duration", "TIMES",
             "Seconds that it takes to open a connection, by its kind (default: "
             "contact=0,fit=5,fastener=10).",
             [&settings](const std::string& given) { set_durations(given, settings.durations); });
}

}  // namespace

CommandWork import_command(CommandLine& line) {
  const auto chosen = std::make_shared<ImportOptions>();
  ImportOptions& options = *chosen;
  line.about(
      "Makes a problem of a CAD model: parts with their masses, connections where they\n"
      "touch, and what blocks what along which direction. The shapes go into a file\n"
      "beside it. What was found, assumed and is to be answered is told.");
  line.positionals("MODEL...", options.models,
                   "a STEP file, a mesh file (OBJ, STL, PLY, glTF, 3MF), or a folder of mesh "
                   "files, one a part");
  line.group("Output");
  line.text("-o,--output", "FILE",
            "Write the problem to FILE and the shapes beside it, ending in .glb: both or neither; "
            "- prints the problem alone (default: none, one must be given).",
            options.output);
  line.flag("--json", options.json, "Print the report as JSON (default: for people).");
  line.quiet_flag("No progress and no warnings on standard error (default: both).");
  add_model_options(line, options);
  add_part_options(line, options);
  add_plan_options(line, options);
  line.group("Limits");
  line.whole("--threads", "N", "Threads (default: all of the machine's); the answer is the same.",
             options.threads, 1, 4096);
  line.footer(
      "\nExamples:\n"
      "  orasp import pump.step -o pump.json\n"
      "  orasp import gearbox.step -o gearbox.json --flexible \"*belt*\" --exclude dummy\n"
      "  orasp import parts/ --pose poses.json --unit cm -o product.json\n"
      "\n"
      "Exit codes: 0 written, 20 interrupted, nothing written, 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
