#include "cli/context.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "cli/on_ranks.h"
#include "orasp/model/error.h"

namespace orasp::cli {
namespace {

void write_to_stderr(std::string_view text) {
  // Nothing can be done, or said, if this fails.
  [[maybe_unused]] const std::size_t written = std::fwrite(text.data(), 1, text.size(), stderr);
}

bool wants_colour() {
  const char* const no_colour = std::getenv("NO_COLOR");
  const char* const terminal = std::getenv("TERM");
  const bool dumb = terminal != nullptr && std::string_view(terminal) == "dumb";
  // mpirun hands every process a terminal, whatever its own output is.
  return !among_ranks() && isatty(STDOUT_FILENO) == 1 &&
         (no_colour == nullptr || *no_colour == '\0') && !dumb;
}

std::size_t terminal_width() {
  constexpr std::size_t kDefault = 100;
  constexpr std::size_t kLeast = 40;
  winsize size{};
  const bool known =
      !among_ranks() && isatty(STDOUT_FILENO) == 1 && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0;
  return known && size.ws_col >= kLeast ? size.ws_col : kDefault;
}

}  // namespace

Context::Context(bool quiet)
    : out_(stdout),
      quiet_(quiet),
      colour_(wants_colour()),
      width_(terminal_width()),
      shows_progress_(!quiet && isatty(STDERR_FILENO) == 1) {}

void Context::print(std::string_view text) const {
  const bool written =
      std::fwrite(text.data(), 1, text.size(), out_) == text.size() && std::fflush(out_) == 0;
  if (!written && errno != EPIPE)
    throw InputError(
        fmt::format("cannot write to standard output: {}", std::generic_category().message(errno)));
}

void Context::warn(std::string_view sentence) const {
  if (!quiet_) write_to_stderr(fmt::format("orasp: warning: {}\n", sentence));
}

void Context::say(std::string_view line) const {
  if (!quiet_) write_to_stderr(fmt::format("{}\n", line));
}

void print_error(std::string_view sentence) {
  write_to_stderr(fmt::format("orasp: {}\n", sentence));
}

}  // namespace orasp::cli
