#include "cli/output/progress.h"

#include <cmath>
#include <cstdio>
#include <utility>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "cli/output/text.h"

namespace orasp::cli {
namespace {

constexpr const char* kClearLine = "\r\x1b[K";

std::size_t terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string line(const std::string& title, const Progress& progress, double seconds) {
  std::string text = fmt::format("{}: {}", title, progress.phase);
  if (progress.total > 0) {
    const double share = static_cast<double>(progress.done) / static_cast<double>(progress.total);
    text += fmt::format(" {:.0f} %", 100 * share);
  } else if (progress.done > 0) {
    text += ' ' + grouped(progress.done);
  }
  if (progress.states > 0) text += ", " + counted(progress.states, "state");
  if (std::isfinite(progress.best)) text += ", best " + number_text(progress.best);
  return text + fmt::format(", {:.0f} s", seconds);
}

}  // namespace

ProgressLine::ProgressLine(const Context& context, std::string title)
    : enabled_(context.shows_progress()), title_(std::move(title)) {}

ProgressLine::~ProgressLine() {
  if (visible_) std::fputs(kClearLine, stderr);
}

void ProgressLine::attach_to(Budget& budget) {
  if (enabled_) budget.progress = [this](const Progress& progress) { show(progress); };
}

void ProgressLine::show(const Progress& progress) {
  const auto now = Budget::Clock::now();
  if (!enabled_ || now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  visible_ = true;
  std::string text = line(title_, progress, std::chrono::duration<double>(now - start_).count());
  const std::size_t width = terminal_width();
  if (text.size() >= width) text.resize(width - 1);
  std::fputs((kClearLine + text).c_str(), stderr);
}

}  // namespace orasp::cli
