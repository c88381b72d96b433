#include "cli/signals.h"

#include <chrono>
#include <csignal>
#include <string_view>
#include <thread>

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

namespace orasp::cli {
namespace {

bool is_ignored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// What timeout(1) and a terminal send is one request, though it may arrive twice: once for the
/// process and once for its group.
constexpr std::chrono::milliseconds kOneRequest{300};

void wait_for_signals(const sigset_t& signals, const std::stop_source& stop) {
  int signal = 0;
  if (sigwait(&signals, &signal) != 0) return;
  const auto first = std::chrono::steady_clock::now();
  stop.request_stop();
  if (isatty(STDERR_FILENO) == 1) {
    constexpr std::string_view kNote = "\r\x1b[Korasp: stopping; once more to end at once\n";
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kNote.data(), kNote.size());
  }
  do {
    if (sigwait(&signals, &signal) != 0) return;
  } while (std::chrono::steady_clock::now() - first < kOneRequest);
  std::signal(signal, SIG_DFL);
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  kill(getpid(), signal);
}

}  // namespace

void prepare_streams() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file larger than ulimit -f allows
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    // Open for reading alone, so that writing a result to a closed standard output still fails.
    if (fcntl(descriptor, F_GETFD) == -1)
      open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

std::stop_token stop_on_signals() {
  const std::stop_source stop;
  sigset_t signals;
  sigemptyset(&signals);
  bool any = false;
  for (const int signal : {SIGINT, SIGTERM}) {
    if (!is_ignored(signal)) {
      sigaddset(&signals, signal);
      any = true;
    }
  }
  if (any && pthread_sigmask(SIG_BLOCK, &signals, nullptr) == 0)
    std::thread([signals, stop] { wait_for_signals(signals, stop); }).detach();
  return stop.get_token();
}

}  // namespace orasp::cli
