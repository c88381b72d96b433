// CBC: the whole of the module orasp_cbc.so, and the only file that includes it. One function is
// found by name: orasp_make_mip_solver_1. It uses headers of the library, none of its code.

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <CbcEventHandler.hpp>
#include <CbcModel.hpp>
#include <CbcSolver.hpp>
#include <ClpEventHandler.hpp>
#include <ClpSimplex.hpp>
#include <CoinPackedMatrix.hpp>
#include <OsiClpSolverInterface.hpp>
#include <link.h>
#include <sys/mman.h>
#include <unistd.h>

#include "orasp/mip/mip_solver.h"

namespace orasp {

namespace {

/// Where the greatest term of the objective is outside of these, the objective is scaled by a power
/// of two until it is between 1 and 2: CBC's tolerances are absolute.
constexpr double kLeastObjective = 0.5;
constexpr double kGreatestObjective = 1000;
/// A solution counts as better if it is so by this part of the greatest term.
constexpr double kIncrement = 1e-7;

// CBC and Clp take SIGINT for themselves each time that they begin a tree or a linear program. An
// interrupt then ends whatever they are at, nobody else hears of it, and a linear program that was
// ended so passes for infeasible: the solution at hand for proved best. They cannot be told not to.
// So the calls of signal() in their libraries lead here; who wants to stop has the watcher.
using SignalHandler = void (*)(int);

SignalHandler leave_signals_alone(int signal, SignalHandler handler) {
  static_cast<void>(signal);
  static_cast<void>(handler);
  return SIG_DFL;
}

#if defined(__linux__) && __ELF_NATIVE_CLASS == 64

/// Lets the place of a library where the address of a function stands lead to leave_signals_alone.
/// It may be read-only since the library was loaded.
void redirect(ElfW(Addr) place) {
  const auto page_size = static_cast<ElfW(Addr)>(sysconf(_SC_PAGESIZE));
  void* const page = reinterpret_cast<void*>(place & ~(page_size - 1));
  if (mprotect(page, page_size, PROT_READ | PROT_WRITE) != 0) return;
  *reinterpret_cast<SignalHandler (**)(int, SignalHandler)>(place) = &leave_signals_alone;
}

/// Redirects what a loaded library calls signal(), if it is one of the solver's. Reference: the
/// System V ABI, "Dynamic Linking".
int redirect_signals_of(dl_phdr_info* library, std::size_t size, void* data) {
  static_cast<void>(size);
  static_cast<void>(data);
  const std::string_view name = library->dlpi_name;
  const std::string_view file = name.substr(name.rfind('/') + 1);
  if (!file.starts_with("libClp.") && !file.starts_with("libCbc")) return 0;
  const ElfW(Dyn)* entry = nullptr;
  for (std::size_t i = 0; i < library->dlpi_phnum; ++i) {
    if (library->dlpi_phdr[i].p_type == PT_DYNAMIC)
      entry =
          reinterpret_cast<const ElfW(Dyn)*>(library->dlpi_addr + library->dlpi_phdr[i].p_vaddr);
  }
  const char* names = nullptr;
  const ElfW(Sym)* symbols = nullptr;
  std::array<const ElfW(Rela)*, 2> tables{};
  std::array<std::size_t, 2> bytes{};
  for (; entry != nullptr && entry->d_tag != DT_NULL; ++entry) {
    const ElfW(Addr) address = entry->d_un.d_ptr;
    switch (entry->d_tag) {
      case DT_STRTAB: names = reinterpret_cast<const char*>(address); break;
      case DT_SYMTAB: symbols = reinterpret_cast<const ElfW(Sym)*>(address); break;
      case DT_JMPREL: tables[0] = reinterpret_cast<const ElfW(Rela)*>(address); break;
      case DT_PLTRELSZ: bytes[0] = entry->d_un.d_val; break;
      case DT_RELA: tables[1] = reinterpret_cast<const ElfW(Rela)*>(address); break;
      case DT_RELASZ: bytes[1] = entry->d_un.d_val; break;
      default: break;
    }
  }
  if (names == nullptr || symbols == nullptr) return 0;
  for (std::size_t t = 0; t < tables.size(); ++t) {
    const std::size_t count = tables[t] == nullptr ? 0 : bytes[t] / sizeof(ElfW(Rela));
    for (std::size_t i = 0; i < count; ++i) {
      const ElfW(Rela)& relocation = tables[t][i];
      const auto symbol = ELF64_R_SYM(relocation.r_info);
      if (symbol != 0 && std::string_view(names + symbols[symbol].st_name) == "signal")
        redirect(library->dlpi_addr + relocation.r_offset);
    }
  }
  return 0;
}

void keep_signals() {
  static const int kDone = dl_iterate_phdr(&redirect_signals_of, nullptr);
  static_cast<void>(kDone);
}

#else

void keep_signals() {}

#endif

/// What the event handlers share, whichever copy of the model they are at.
struct Watch {
  explicit Watch(const MipSettings& the_settings) : settings(the_settings) {}

  const MipSettings& settings;
  double scale = 1;  ///< of the objective that CBC sees
  double constant = 0;
  MipProgress progress;
  Stop stop = Stop::None;
  std::chrono::steady_clock::time_point asked{};

  /// Whether to stop. Asks the watcher where `now`, or where that is a while ago.
  bool over(bool now) {
    if (stop != Stop::None || !settings.watcher) return stop != Stop::None;
    const auto time = std::chrono::steady_clock::now();
    if (!now && time - asked < std::chrono::milliseconds(50)) return false;
    asked = time;
    stop = settings.watcher(progress);
    return stop != Stop::None;
  }
  [[nodiscard]] double outside(double value) const { return value / scale + constant; }
};

class SearchEvents final : public CbcEventHandler {
 public:
  explicit SearchEvents(Watch& watch) : watch_(&watch) {}
  [[nodiscard]] CbcEventHandler* clone() const override { return new SearchEvents(*this); }

  CbcAction event(CbcEvent which) override {
    bool better = false;
    // The models of CBC's own heuristics are smaller problems: their values say nothing of the
    // whole.
    if (model_ != nullptr && model_->parentModel() == nullptr) {
      MipProgress& progress = watch_->progress;
      progress.nodes = std::max(progress.nodes, static_cast<std::uint64_t>(model_->getNodeCount()));
      const double best = model_->getObjValue();
      if ((which == solution || which == heuristicSolution) && std::abs(best) < 1e40) {
        better = watch_->outside(best) < progress.best;
        progress.best = std::min(progress.best, watch_->outside(best));
      }
      // A linear program that was ended looks infeasible, and so no bound counts from then on.
      const double bound = model_->getBestPossibleObjValue();
      if (which == node && std::abs(bound) < 1e40 && !watch_->over(true))
        progress.bound = std::max(progress.bound, watch_->outside(bound));
    }
    return watch_->over(better) ? stop : noAction;
  }

 private:
  Watch* watch_;
};

class SimplexEvents final : public ClpEventHandler {
 public:
  explicit SimplexEvents(Watch& watch) : watch_(&watch) {}
  [[nodiscard]] ClpEventHandler* clone() const override { return new SimplexEvents(*this); }

  int event(Event which) override {
    if (which != endOfIteration && which != endOfFactorization) return -1;
    return watch_->over(false) ? 5 : -1;
  }

 private:
  Watch* watch_;
};

std::string number_text(double number) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

int no_callback(CbcModel*, int) {
  return 0;
}

void load(const MipModel& model, const Watch& watch, OsiClpSolverInterface& solver) {
  const double infinity = solver.getInfinity();
  const auto bounded = [infinity](double value) { return std::clamp(value, -infinity, infinity); };
  std::vector<double> lower;
  std::vector<double> upper;
  std::vector<double> objective;
  for (const MipModel::Column& column : model.columns()) {
    lower.push_back(bounded(column.lower));
    upper.push_back(bounded(column.upper));
    objective.push_back(column.objective * watch.scale);
  }
  std::vector<double> row_lower;
  std::vector<double> row_upper;
  for (const MipModel::Row& row : model.rows()) {
    row_lower.push_back(row.sense == MipSense::AtMost ? -infinity : row.right);
    row_upper.push_back(row.sense == MipSense::AtLeast ? infinity : row.right);
  }
  std::vector<CoinBigIndex> begins(model.begins().begin(), model.begins().end());
  std::vector<int> columns(model.columns_of().begin(), model.columns_of().end());
  const CoinPackedMatrix by_rows(false, static_cast<int>(model.num_columns()),
                                 static_cast<int>(model.num_rows()),
                                 static_cast<CoinBigIndex>(model.num_terms()),
                                 model.values().data(), columns.data(), begins.data(), nullptr);
  solver.loadProblem(by_rows, lower.data(), upper.data(), objective.data(), row_lower.data(),
                     row_upper.data());
  for (std::size_t c = 0; c < model.num_columns(); ++c) {
    if (model.columns()[c].integer) solver.setInteger(static_cast<int>(c));
  }
}

class CbcMipSolver final : public MipSolver {
 public:
  MipSolution solve(const MipModel& model, const MipSettings& settings) override {
    MipSolution answer;
    Watch watch(settings);
    watch.constant = model.constant();
    double greatest = 0;
    for (const MipModel::Column& column : model.columns())
      greatest = std::max(greatest, std::abs(column.objective));
    if (greatest > 0 && (greatest < kLeastObjective || greatest > kGreatestObjective))
      watch.scale = std::ldexp(1.0, -std::ilogb(greatest));
    const double increment = kIncrement * watch.scale * greatest;
    // CBC's solver program keeps words of its command line in variables that all threads share.
    static std::timed_mutex one_at_a_time;
    std::unique_lock turn(one_at_a_time, std::defer_lock);
    bool over = watch.over(true);
    while (!over && !turn.try_lock_for(std::chrono::milliseconds(50))) over = watch.over(true);
    if (over) {
      answer.stop = watch.stop;
      return answer;
    }

    OsiClpSolverInterface solver;
    solver.messageHandler()->setLogLevel(0);  // before anything else: CBC prints while it reads
    solver.getModelPtr()->setLogLevel(0);
    keep_signals();
    load(model, watch, solver);
    const SimplexEvents simplex_events(watch);
    solver.getModelPtr()->passInEventHandler(&simplex_events);
    CbcModel search(solver);
    search.setLogLevel(0);
    SearchEvents search_events(watch);
    search.passInEventHandler(&search_events);
    search.setUseElapsedTime(true);
    run(search, settings, increment);

    answer.nodes = std::max<std::uint64_t>(
        static_cast<std::uint64_t>(std::max(0, search.getNodeCount())), watch.progress.nodes);
    // CBC ends linear programs by its own limit of time as well.
    static_cast<void>(watch.over(true));
    answer.stop = watch.stop;
    answer.bound = watch.progress.bound;
    const double bound = search.getBestPossibleObjValue();
    if (ended(search, watch) && std::abs(bound) < 1e40)
      answer.bound = std::max(watch.outside(bound), answer.bound);
    if (const double* const values = search.bestSolution(); values != nullptr) {
      answer.values.assign(values, values + model.num_columns());
      answer.objective = model.constant();
      for (std::size_t c = 0; c < answer.values.size(); ++c) {
        const MipModel::Column& column = model.columns()[c];
        if (column.integer) answer.values[c] = std::round(answer.values[c]);
        answer.objective += column.objective * answer.values[c];
      }
    }
    judge(search, watch, answer);
    return answer;
  }

 private:
  /// CBC's solver program, with its presolve, cuts and heuristics: a bare CbcModel is quicker by
  /// milliseconds on the smallest models and by far slower on all others.
  static void run(CbcModel& search, const MipSettings& settings, double increment) {
    CbcSolverUsefulData data;
    data.useSignalHandler_ = false;
    data.noPrinting_ = true;
    CbcMain0(search, data);
    search.setLogLevel(0);
    std::vector<std::string> words = {"orasp", "-log", "0", "-timeMode", "elapsed"};
    if (increment > 0) words.insert(words.end(), {"-increment", number_text(increment)});
    if (settings.seconds) words.insert(words.end(), {"-seconds", number_text(*settings.seconds)});
    words.insert(words.end(), {"-solve", "-quit"});
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    CbcMain1(static_cast<int>(arguments.size()), arguments.data(), search, no_callback, data);
  }

  static bool ended(const CbcModel& search, const Watch& watch) {
    return watch.stop == Stop::None && search.status() == 0;
  }

  /// What CBC's two status words mean. After a stop nothing is taken for proved: a simplex that was
  /// interrupted looks infeasible.
  static void judge(const CbcModel& search, const Watch& watch, MipSolution& answer) {
    using Status = MipSolution::Status;
    const bool has_solution = !answer.values.empty();
    const bool ended = CbcMipSolver::ended(search, watch);
    if (ended && search.isContinuousUnbounded()) {
      answer.status = Status::Unbounded;
      answer.values.clear();
    } else if (ended && has_solution && search.secondaryStatus() <= 1 && search.isProvenOptimal()) {
      answer.status = Status::Optimal;
      answer.bound = answer.objective;
    } else if (ended && !has_solution && search.isProvenInfeasible()) {
      answer.status = Status::Infeasible;
    } else {
      answer.status = has_solution ? Status::Feasible : Status::Unknown;
      if (watch.stop == Stop::None && !ended) answer.stop = Stop::TimeLimit;
    }
    if (has_solution) answer.bound = std::min(answer.bound, answer.objective);
  }
};

}  // namespace

}  // namespace orasp

extern "C" __attribute__((visibility("default"))) orasp::MipSolver* orasp_make_mip_solver_1() {
  return new orasp::CbcMipSolver();
}
