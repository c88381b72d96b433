#include "orasp/drawing/drawing_process.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "orasp/model/error.h"

namespace orasp {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

[[noreturn]] void fail(std::string_view what, int error) {
  throw InputError(fmt::format("{}: {}", what, std::generic_category().message(error)));
}

/// A file without a name, gone when it is closed.
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

struct Streams {
  File input = scratch_file();
  File output = scratch_file();
  File errors = scratch_file();
};

/// @returns 0 or the error.
int spawn(const std::string& program, std::span<const std::string> arguments,
          const Streams& streams, pid_t& process) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(streams.input.get()), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(streams.output.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(streams.errors.get()), STDERR_FILENO);

  // The caller may have blocked or ignored signals; the child gets the usual ones, but for those
  // that ask to stop. Ctrl-C and timeout(1) send them to a whole group of processes. They are for
  // the caller alone: dot would draw what it has from within its signal handler, and may wait there
  // for itself for ever. They are blocked from the child's first instruction on, so there is no
  // moment at which one of them ends it.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t blocked;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGINT);
  sigaddset(&blocked, SIGTERM);
  posix_spawnattr_setsigmask(&attributes, &blocked);
  sigset_t usual;
  sigemptyset(&usual);
  sigaddset(&usual, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &usual);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

  std::vector<std::string> words = {program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const int error =
      posix_spawnp(&process, program.c_str(), &actions, &attributes, pointers.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

/// @returns the status of waitpid.
int wait_for(pid_t process, const std::string& program) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) fail("waiting for " + program, errno);
  }
  return status;
}

}  // namespace

std::optional<ProgramRun> run_program(const std::string& program,
                                      std::span<const std::string> arguments,
                                      std::string_view input) {
  const Streams streams;
  const bool written = input.empty() || std::fwrite(input.data(), 1, input.size(),
                                                    streams.input.get()) == input.size();
  if (!written || std::fflush(streams.input.get()) != 0)
    fail("no room for a temporary file", errno);
  std::rewind(streams.input.get());

  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  pid_t process = 0;
  const int error = spawn(program, arguments, streams, process);
  if (error == ENOENT) return std::nullopt;
  if (error != 0) fail(program + " does not start", error);
  const int status = wait_for(process, program);

  ProgramRun run;
  run.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (WIFSIGNALED(status)) run.signal = WTERMSIG(status);
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  run.output = contents(streams.output.get());
  run.errors = contents(streams.errors.get());
  return run;
}

std::string drawn_by(const std::string& program, const std::string& debian_package,
                     std::span<const std::string> arguments, std::string_view input) {
  const std::optional<ProgramRun> run = run_program(program, arguments, input);
  if (!run) {
    throw InputError(
        fmt::format("cannot draw: the program {} is missing; it is in the Debian package {}",
                    program, debian_package));
  }
  if (run->signal != 0)
    throw InputError(fmt::format("cannot draw: {} was ended by signal {}", program, run->signal));
  if (run->exit_code != 0) {
    const std::size_t begin = std::min(run->errors.find_first_not_of(" \n"), run->errors.size());
    const std::string message = run->errors.substr(
        begin, std::min(run->errors.find('\n', begin), run->errors.size()) - begin);
    throw InputError(fmt::format("cannot draw: {} failed with exit code {}{}{}", program,
                                 run->exit_code, message.empty() ? "" : ": ", message));
  }
  return run->output;
}

}  // namespace orasp
