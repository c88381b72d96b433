#include "orasp/io/atomic_file.h"

#include <csignal>
#include <filesystem>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/fault.h"
#include "tests/files.h"

namespace orasp {
namespace {

namespace fs = std::filesystem;

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::string fault_of_writing(const fs::path& file, const std::string& bytes = "x") {
  return fault_of([&] {
    write_file(file, bytes);
    return 0;
  });
}

TEST(WriteFile, WritesAllBytesAndLeavesNothingElse) {
  const TemporaryFolder folder;
  const std::string bytes("a\0b\n", 4);
  write_file(folder.path() / "plan.json", bytes);
  EXPECT_EQ(bytes_of(folder.path() / "plan.json"), bytes);
  EXPECT_EQ(entries(folder.path()), 1U);
}

TEST(WriteFile, ReplacesAFileAndKeepsItsMode) {
  const TemporaryFolder folder;
  const fs::path file = folder.file("plan.json", "a long old text");
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  write_file(file, "new");
  EXPECT_EQ(bytes_of(file), "new");
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(entries(folder.path()), 1U);
}

TEST(WriteFile, FollowsALink) {
  const TemporaryFolder folder;
  const fs::path file = folder.file("target.json", "old");
  fs::create_symlink("target.json", folder.path() / "link.json");
  write_file(folder.path() / "link.json", "new");
  EXPECT_TRUE(fs::is_symlink(folder.path() / "link.json"));
  EXPECT_EQ(bytes_of(file), "new");
  fs::create_symlink("later.json", folder.path() / "dangling.json");
  write_file(folder.path() / "dangling.json", "new");
  EXPECT_EQ(bytes_of(folder.path() / "later.json"), "new");
}

TEST(WriteFile, WritesADeviceDirectly) {
  write_file("/dev/null", "x");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(WriteFile, NamesTheFileAndTheReason) {
  const TemporaryFolder folder;
  const fs::path missing = folder.path() / "missing" / "plan.json";
  EXPECT_EQ(fault_of_writing(missing),
            "cannot write " + missing.string() + ": No such file or directory");
  EXPECT_EQ(fault_of_writing(folder.path()),
            "cannot write " + folder.path().string() + ": Is a directory");
  EXPECT_EQ(fault_of_writing(""), "cannot write : No such file or directory");
}

TEST(WriteFile,
     KeepsTheOldFileWhenTheDiskIsFull) {  // a limit on the size of files stands in for a full disk
  const TemporaryFolder folder;
  const fs::path file = folder.file("plan.json", "old");
  const ::pid_t child = ::fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const ::rlimit limit{1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const std::string fault = fault_of_writing(file, std::string(2000, 'x'));
    ::_exit(fault == "cannot write " + file.string() + ": File too large" ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(bytes_of(file), "old");
  EXPECT_EQ(entries(folder.path()), 1U);
}

}  // namespace
}  // namespace orasp
