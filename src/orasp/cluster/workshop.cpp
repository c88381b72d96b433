#include "orasp/cluster/workshop.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace orasp {

namespace {

// What goes through the channels: a letter, the length of a text in 8 bytes, the text.
constexpr char kTask = 't';
constexpr char kStop = 's';
constexpr char kMade = '+';
constexpr char kFailed = '-';

struct Message {
  char kind = kFailed;
  std::string text;
};

bool write_all(int to, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = send(to, data, size, MSG_NOSIGNAL);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

bool read_all(int from, char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t got = read(from, data, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    data += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

bool write_message(int to, char kind, const std::string& text) {
  std::string bytes(1 + sizeof(std::uint64_t), kind);
  const std::uint64_t size = text.size();
  std::memcpy(bytes.data() + 1, &size, sizeof size);
  bytes += text;
  return write_all(to, bytes.data(), bytes.size());
}

/// Nothing where the stream ends before the message does.
std::optional<Message> read_message(int from) {
  Message message;
  std::uint64_t size = 0;
  std::array<char, sizeof size> length{};
  if (!read_all(from, &message.kind, 1) || !read_all(from, length.data(), length.size()))
    return std::nullopt;
  std::memcpy(&size, length.data(), sizeof size);
  message.text.resize(size);
  if (!read_all(from, message.text.data(), size)) return std::nullopt;
  return message;
}

/// A pipe, but that to write where nobody reads is an error instead of a signal.
struct Channel {
  int out = -1;
  int in = -1;
};

std::optional<Channel> make_channel() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) return std::nullopt;
  return Channel{.out = ends[0], .in = ends[1]};
}

/// From here on this process is killed when its parent ends. @returns false where it has already.
bool end_with(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  return getppid() == parent;
}

/// The process that does one piece. A byte on `stops`, or its end, asks it to stop.
[[noreturn]] void do_piece(const Workshop::Work& work, const std::string& task, int stops,
                           int answer) {
  const int score = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (score >= 0) {
    constexpr const char* kFirst = "500";
    [[maybe_unused]] const ssize_t written = write(score, kFirst, 3);
    close(score);
  }
  Message message;
  try {
    const std::stop_source stop;
    std::thread([stops, stop] {
      char byte = 0;
      static_cast<void>(read_all(stops, &byte, 1));
      stop.request_stop();
    }).detach();
    message.text = work(task, stop.get_token());
    message.kind = kMade;
  } catch (const std::bad_alloc&) {
    message.text = "out of memory";
  } catch (const std::exception& error) {
    message.text = error.what();
  }
  const bool written = write_message(answer, message.kind, message.text);
  _exit(written ? 0 : 1);
}

/// Why there is no answer of a process that ended with `status`.
std::string ending(int status) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return "killed by signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
  }
  return "ended with exit code " + std::to_string(WEXITSTATUS(status));
}

/// Has one piece done, and passes on what is asked of it meanwhile.
Message have_done(const Workshop::Work& work, const std::string& task, int from) {
  const auto stops = make_channel();
  const auto answer = make_channel();
  const pid_t self = getpid();
  const pid_t process = stops && answer ? fork() : -1;
  if (process < 0) return {kFailed, std::string("no process can be started: ") + strerror(errno)};
  if (process == 0) {
    if (!end_with(self)) _exit(1);
    close(from);
    close(stops->in);
    close(answer->out);
    do_piece(work, task, stops->out, answer->in);
  }
  close(stops->out);
  close(answer->in);
  std::optional<Message> made;
  while (true) {
    std::array<pollfd, 2> both{pollfd{.fd = answer->out, .events = POLLIN, .revents = 0},
                               pollfd{.fd = from, .events = POLLIN, .revents = 0}};
    if (poll(both.data(), both.size(), -1) < 0) continue;
    if (both[1].revents != 0) {
      // A stop, or nobody asks any more.
      const auto message = read_message(from);
      if (!message) _exit(0);
      if (message->kind == kStop) static_cast<void>(write_all(stops->in, &kStop, 1));
    }
    if (both[0].revents != 0) {
      made = read_message(answer->out);
      break;
    }
  }
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) continue;
  close(stops->in);
  close(answer->out);
  return made ? *made : Message{kFailed, ending(status)};
}

[[noreturn]] void wait_for_tasks(const Workshop::Work& work, int from, int to) {
  while (const auto message = read_message(from)) {
    if (message->kind != kTask) continue;  // a stop that came too late
    const Message made = have_done(work, message->text, from);
    if (!write_message(to, made.kind, made.text)) break;
  }
  _exit(0);
}

}  // namespace

Workshop::Workshop(const Work& work) {
  const auto tasks = make_channel();
  const auto answers = make_channel();
  const pid_t self = getpid();
  sigset_t all;
  sigset_t before;
  sigemptyset(&all);
  sigaddset(&all, SIGINT);
  sigaddset(&all, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  process_ = tasks && answers ? fork() : -1;
  if (process_ == 0) {
    if (!end_with(self)) _exit(1);
    close(tasks->in);
    close(answers->out);
    wait_for_tasks(work, tasks->out, answers->in);
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (process_ < 0)
    throw std::runtime_error(std::string("no process can be started: ") + strerror(errno));
  close(tasks->out);
  close(answers->in);
  to_ = tasks->in;
  from_ = answers->out;
}

Workshop::~Workshop() {
  close(to_);
  close(from_);
  while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) continue;
}

std::string Workshop::make(const std::string& task, const std::stop_token& stop) {
  std::optional<Message> made;
  if (write_message(to_, kTask, task)) {
    const std::stop_callback passed_on(stop, [this] { write_message(to_, kStop, {}); });
    made = read_message(from_);
  }
  if (!made) throw std::runtime_error("the process that starts the others was killed");
  if (made->kind != kMade) throw std::runtime_error(made->text);
  return std::move(made->text);
}

}  // namespace orasp
