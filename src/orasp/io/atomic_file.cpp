#include "orasp/io/atomic_file.h"

#include <cerrno>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "orasp/model/error.h"

namespace orasp {
namespace {

namespace fs = std::filesystem;

/// A file descriptor that is closed at the end of its scope.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

[[noreturn]] void fail(const fs::path& file, int error) {
  throw InputError(
      fmt::format("cannot write {}: {}", file.string(), std::generic_category().message(error)));
}

/// Writes everything; 0 or the error.
int write_all(const Descriptor& descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ::ssize_t written = ::write(descriptor.number(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

void write_directly(const fs::path& file, std::string_view bytes) {
  const Descriptor descriptor(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  if (!descriptor.is_open()) fail(file, errno);
  if (const int error = write_all(descriptor, bytes); error != 0) fail(file, error);
}

/// A name in `directory` that no other process and no other call uses.
fs::path temporary_name(const fs::path& directory, unsigned attempt) {
  return directory / fmt::format(".orasp-{}-{}.tmp", ::getpid(), attempt);
}

/// Writes everything to disk, with the permissions of the file that it replaces, if any; 0 or the
/// error.
int fill(const Descriptor& descriptor, std::string_view bytes, const struct ::stat* replaced) {
  if (const int error = write_all(descriptor, bytes); error != 0) return error;
  if (replaced != nullptr && ::fchmod(descriptor.number(), replaced->st_mode & 07777U) != 0)
    return errno;
  return ::fsync(descriptor.number()) != 0 ? errno : 0;
}

[[noreturn]] void give_up(const fs::path& temporary, const fs::path& file, int reason) {
  ::unlink(temporary.c_str());
  fail(file, reason);
}

/// Gives a file without a name the name `temporary` and then that of `target`, in whose place it
/// comes at once; 0 or the error, EEXIST where `temporary` is another one's. It calls nothing but
/// the kernel.
int take_place(const char* unnamed, const char* temporary, const char* target) {
  if (::linkat(AT_FDCWD, unnamed, AT_FDCWD, temporary, AT_SYMLINK_FOLLOW) != 0) return errno;
  if (::rename(temporary, target) == 0) return 0;
  const int error = errno;
  ::unlink(temporary);
  return error;
}

/// The same, by a process of its own, which goes on where this one is killed between the two steps:
/// else the first name would stay behind.
int take_place_whatever_happens(const char* unnamed, const char* temporary, const char* target) {
  volatile int error = -1;  // the child has the memory of its parent, which waits for it
  const ::pid_t child = ::vfork();
  if (child == 0) {
    error = take_place(unnamed, temporary, target);
    ::_exit(error);
  }
  if (child < 0) return take_place(unnamed, temporary, target);
  int status = 0;
  ::pid_t ended = 0;
  do {
    ended = ::waitpid(child, &status, 0);
  } while (ended < 0 && errno == EINTR);
  const bool known = ended == child && WIFEXITED(status);
  if (error >= 0) return error;
  return known ? WEXITSTATUS(status) : ECHILD;
}

/// Writes a file without a name and names it when it is whole, so that nothing stays behind if the
/// process is killed meanwhile. False, and nothing done, where the file system or the machine knows
/// no such files.
bool written_unnamed(const fs::path& directory, const fs::path& target, std::string_view bytes,
                     const struct ::stat* replaced, const fs::path& file) {
  const Descriptor descriptor(::open(directory.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666));
  if (!descriptor.is_open()) return false;
  const std::string unnamed = fmt::format("/proc/self/fd/{}", descriptor.number());
  if (::access(unnamed.c_str(), F_OK) != 0) return false;
  if (const int reason = fill(descriptor, bytes, replaced); reason != 0) fail(file, reason);
  if (replaced == nullptr) {
    if (::linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, target.c_str(), AT_SYMLINK_FOLLOW) == 0)
      return true;
    if (errno != EEXIST) return false;
  }
  // A link never replaces a file: it gets a name beside it and takes its place at once.
  for (unsigned attempt = 0; attempt <= 1000; ++attempt) {
    const fs::path temporary = temporary_name(directory, attempt);
    const int error =
        take_place_whatever_happens(unnamed.c_str(), temporary.c_str(), target.c_str());
    if (error == 0) return true;
    if (error != EEXIST) return false;
  }
  return false;
}

}  // namespace

void write_file(const fs::path& file, std::string_view bytes) {
  std::error_code error;
  fs::path target = fs::canonical(file, error);  // follows links; fails where nothing is there yet
  if (error) {
    target =
        fs::is_symlink(file, error) ? file.parent_path() / fs::read_symlink(file, error) : file;
  }
  struct ::stat status {};
  const bool exists = ::stat(target.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) fail(file, EISDIR);
  if (exists && !S_ISREG(status.st_mode)) return write_directly(target, bytes);
  if (exists && ::access(target.c_str(), W_OK) != 0) fail(file, errno);
  if (!target.has_filename()) fail(file, file.empty() ? ENOENT : EISDIR);

  const fs::path directory = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (written_unnamed(directory, target, bytes, exists ? &status : nullptr, file)) return;
  for (unsigned attempt = 0;; ++attempt) {
    const fs::path temporary = temporary_name(directory, attempt);
    int reason = 0;
    {
      const Descriptor descriptor(
          ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
      if (!descriptor.is_open()) {
        if (errno == EEXIST && attempt < 1000) continue;
        fail(file, errno);
      }
      reason = fill(descriptor, bytes, exists ? &status : nullptr);
    }
    if (reason == 0 && ::rename(temporary.c_str(), target.c_str()) != 0) reason = errno;
    if (reason == 0) return;
    give_up(temporary, file, reason);
  }
}

}  // namespace orasp
