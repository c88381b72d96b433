#include "cli/on_ranks.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <new>
#include <string>

#include <fmt/format.h>

#include "cli/context.h"
#include "cli/exit_codes.h"
#include "orasp/model/error.h"

namespace orasp::cli {
namespace {

/// The version, the size of the program's file, which tells builds apart, and the arguments.
std::string program_and_arguments() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string line((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  line.erase(0, line.find('\0'));  // the program's path may be another on another machine
  for (char& c : line) {
    if (c == '\0') c = ' ';
  }
  while (line.ends_with(' ')) line.pop_back();
  std::error_code error;
  const auto size = std::filesystem::file_size("/proc/self/exe", error);
  return fmt::format("orasp " ORASP_VERSION " ({} bytes){}", error ? 0 : size, line);
}

}  // namespace

bool among_ranks() {
  static const bool among = launch_of_environment().size > 1;
  return among;
}

bool speaks() {
  static const bool first = launch_of_environment().rank == 0;
  return first;
}

int on_ranks(const std::function<int(Ranks&)>& work) {
  if (const auto reason = ranks_obstacle()) throw InputError("the work " + *reason);
  std::unique_ptr<Ranks> ranks;
  std::string failure;
  try {
    ranks = join_ranks(program_and_arguments());
    const int code = work(*ranks);
    return ranks->rank() == 0 ? code : kSolved;
  } catch (const InputError&) {
    if (speaks()) throw;
    return kSolved;
  } catch (const std::bad_alloc&) {
    failure = "out of memory; --memory-limit stops a method before that";
  } catch (const std::exception& error) {
    failure = fmt::format("internal error: {}", error.what());
  }
  print_error(fmt::format("rank {}: {}", launch_of_environment().rank, failure));
  if (ranks) ranks->abort(kInternalError);
  std::_Exit(kInternalError);
}

std::string made_at_rank_0(Ranks& ranks, const std::function<std::string()>& make) {
  // The first byte says what follows: '+' what was made, '-' why it was not.
  std::string text;
  if (ranks.rank() == 0) {
    try {
      text = '+' + make();
    } catch (const InputError& error) {
      text = std::string("-") + error.what();
    }
  }
  text = ranks.broadcast(std::move(text), 0);
  if (text.front() == '-') throw InputError(text.substr(1));
  return text.substr(1);
}

void share_memory(std::size_t near, bool limited, Budget& budget) {
  if (!limited) budget.max_bytes /= near;
}

}  // namespace orasp::cli
