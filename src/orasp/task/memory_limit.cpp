#include "orasp/task/memory_limit.h"

#include <algorithm>
#include <fstream>

#include <unistd.h>

namespace orasp {

namespace {

std::uint64_t bytes_of_machine() {
  const auto pages = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PHYS_PAGES)));
  const auto page = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PAGESIZE)));
  return pages * page;
}

}  // namespace

std::uint64_t allowed_bytes(const Budget& budget) {
  return std::min(budget.max_bytes, bytes_of_machine() / 5 * 4);
}

std::uint64_t default_memory_limit() {
  std::uint64_t bytes = bytes_of_machine();
  // The file holds the word "max", which is no number, where the control group has no limit.
  std::uint64_t group_bytes = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> group_bytes)
    bytes = std::min(bytes, group_bytes);
  return bytes / 4 * 3;
}

}  // namespace orasp
