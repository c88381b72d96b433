// Runs a fuzz target: replays files and makes new inputs from them.
//
//     fuzz_problem [--runs N] [--seconds S] [--seed K] FILE_OR_FOLDER...
//
// Every file is run first, those of a folder in the order of their names. Then up to N inputs are
// made, for at most S seconds (0 of both: none): a file, cut, doubled, joined with another one,
// with bytes flipped and with hostile tokens in the place of others. The same seed makes the same
// inputs on every machine. An input that ends the process, by a sanitizer's finding too, is written
// to a file `finding-TARGET` in the working folder.
#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/property.h"

#if defined(__SANITIZE_ADDRESS__)
extern "C" void __sanitizer_set_death_callback(void (*callback)());
#endif

namespace {

std::string finding_file = "finding";
std::string input;

void keep_input() {
  std::FILE* file = std::fopen(finding_file.c_str(), "wb");
  if (file == nullptr) return;
  std::fwrite(input.data(), 1, input.size(), file);
  std::fclose(file);
  std::fprintf(stderr, "fuzz: the input was written to %s\n", finding_file.c_str());
}

extern "C" void on_signal(int signal) {
  keep_input();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void run(std::string bytes) {
  input = std::move(bytes);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

/// What stands in hostile files: ends of ranges, tokens of JSON, ids, keys of the formats.
constexpr std::array<std::string_view, 60> kTokens = {"0",
                                                      "-1",
                                                      "1e308",
                                                      "1e-320",
                                                      "-0.0",
                                                      "1e999",
                                                      "0.1",
                                                      "4294967296",
                                                      "18446744073709551616",
                                                      "2147483647",
                                                      "NaN",
                                                      "Infinity",
                                                      "null",
                                                      "true",
                                                      "\"\"",
                                                      "\"1\"",
                                                      "\"1-2\"",
                                                      "\"\\u0000\"",
                                                      "\"\\ud800\"",
                                                      "[",
                                                      "]",
                                                      "{",
                                                      "}",
                                                      ",",
                                                      ":",
                                                      "\"",
                                                      "\\",
                                                      "\n",
                                                      "[[[[[[[[",
                                                      "\xff",
                                                      "\xef\xbb\xbf",
                                                      "\"id\":",
                                                      "\"parts\":",
                                                      "\"connections\":",
                                                      "\"mass\":",
                                                      "\"position\":[0,0,0]",
                                                      "\"precedence\":",
                                                      "\"after\":",
                                                      "\"after_any\":",
                                                      "\"made_after\":",
                                                      "\"made_after_any\":",
                                                      "\"limits\":",
                                                      "\"max_moved_parts\":",
                                                      "\"max_subassemblies\":",
                                                      "\"blocking\":",
                                                      "\"directions\":[\"+x\",\"-x\"]",
                                                      "{\"id\":\"slant\",\"vector\":[0,3,4]}",
                                                      "\"direction\":\"-slant\"",
                                                      "\"objective\":",
                                                      "\"type\":\"sum\"",
                                                      "\"type\":\"travel\"",
                                                      "\"direction\":\"assembly\"",
                                                      "\"fleet\":",
                                                      "\"success\":0.5",
                                                      "\"on_failure\":",
                                                      "\"abort\":",
                                                      "\"steps\":",
                                                      "(",
                                                      ")",
                                                      "max("};

class Mutator {
 public:
  Mutator(const std::vector<std::string>& files, std::uint64_t seed)
      : files_(files), random_(seed) {}

  std::string next() {
    std::string bytes = files_[below(files_.size())];
    for (std::size_t changes = 1 + below(4); changes > 0; --changes) change(bytes);
    constexpr std::size_t kLargest = 1U << 16U;
    if (bytes.size() > kLargest) bytes.resize(kLargest);
    return bytes;
  }

 private:
  std::size_t below(std::size_t limit) {
    return limit == 0 ? 0 : static_cast<std::size_t>(random_() % limit);
  }

  void change(std::string& bytes) {
    const std::size_t at = below(bytes.size() + 1);
    const std::size_t length = std::min(bytes.size() - at, 1 + below(16));
    switch (below(8)) {
      case 0:
        if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1: bytes.erase(at, length); break;
      case 2: bytes.insert(at, bytes.substr(at, length)); break;
      case 3: bytes.insert(at, kTokens[below(kTokens.size())]); break;
      case 4: bytes.replace(at, length, kTokens[below(kTokens.size())]); break;
      case 5: {
        const std::string& other = files_[below(files_.size())];
        bytes.replace(at, std::string::npos, other.substr(below(other.size() + 1)));
        break;
      }
      case 6: change_number(bytes, at); break;
      default: exchange(bytes, at, length);
    }
  }

  /// Puts another number in the place of the next one.
  void change_number(std::string& bytes, std::size_t at) {
    const std::size_t begin = bytes.find_first_of("0123456789", at);
    if (begin == std::string::npos) return;
    const std::size_t end = bytes.find_first_not_of("0123456789.eE+-", begin);
    const std::size_t size = end == std::string::npos ? bytes.size() - begin : end - begin;
    bytes.replace(begin, size,
                  below(2) == 0 ? std::string(kTokens[below(10)]) : std::to_string(below(12)));
  }

  /// Lets two stretches of the text change places.
  void exchange(std::string& bytes, std::size_t at, std::size_t length) {
    const std::string taken = bytes.substr(at, length);
    bytes.erase(at, length);
    bytes.insert(below(bytes.size() + 1), taken);
  }

  const std::vector<std::string>& files_;
  std::mt19937_64 random_;
};

std::vector<std::string> read_all(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::filesystem::path> names;
  for (const std::filesystem::path& path : paths) {
    if (std::filesystem::is_directory(path)) {
      for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
        if (entry.is_regular_file()) names.push_back(entry.path());
      }
    } else {
      names.push_back(path);
    }
  }
  std::sort(names.begin(), names.end());
  std::vector<std::string> files;
  for (const std::filesystem::path& name : names) {
    std::ifstream stream(name, std::ios::binary);
    if (!stream) {
      std::fprintf(stderr, "fuzz: %s cannot be read\n", name.c_str());
      std::exit(2);
    }
    files.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return files;
}

}  // namespace

int main(int argc, char** argv) try {
  std::uint64_t runs = 0;
  double seconds = 0;
  std::uint64_t seed = 1;
  std::vector<std::filesystem::path> paths;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    const bool has_value = i + 1 < argc;
    if (argument == "--runs" && has_value) {
      runs = std::stoull(argv[++i]);
    } else if (argument == "--seconds" && has_value) {
      seconds = std::stod(argv[++i]);
    } else if (argument == "--seed" && has_value) {
      seed = std::stoull(argv[++i]);
    } else {
      paths.emplace_back(argument);
    }
  }
  finding_file = "finding-" + std::filesystem::path(argv[0]).filename().string();
  std::set_terminate([] { std::abort(); });
  for (const int signal : {SIGABRT, SIGFPE, SIGILL}) std::signal(signal, on_signal);
#if defined(__SANITIZE_ADDRESS__)
  __sanitizer_set_death_callback(keep_input);
#else
  std::signal(SIGSEGV, on_signal);
#endif

  const std::vector<std::string> files = read_all(paths);
  if (files.empty()) {
    std::fprintf(stderr, "usage: %s [--runs N] [--seconds S] [--seed K] FILE_OR_FOLDER...\n",
                 argv[0]);
    return 2;
  }
  for (const std::string& file : files) run(file);

  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  const auto spent = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  Mutator mutator(files, seed);
  std::uint64_t made = 0;
  const auto goes_on = [&] {
    if (runs == 0 && seconds == 0) return false;
    return (runs == 0 || made < runs) && (seconds == 0 || spent() < seconds);
  };
  for (; goes_on(); ++made) run(mutator.next());
  std::printf("%zu files replayed, %llu inputs made, no finding\n", files.size(),
              static_cast<unsigned long long>(made));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "fuzz: %s\n", error.what());
  keep_input();
  return 1;
}
