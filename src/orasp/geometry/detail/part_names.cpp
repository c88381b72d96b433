#include "orasp/geometry/detail/part_names.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace orasp::detail {
namespace {

bool is_lower(char c) {
  return c >= 'a' && c <= 'z';
}
bool is_upper(char c) {
  return c >= 'A' && c <= 'Z';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// The words of a name in small letters: runs of letters and digits, cut where a capital follows a
// small letter. A point stays in a number.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    const bool point =
        c == '.' && i > 0 && i + 1 < name.size() && is_digit(name[i - 1]) && is_digit(name[i + 1]);
    if (!is_lower(c) && !is_upper(c) && !is_digit(c) && !point) {
      if (!words.back().empty()) words.emplace_back();
      continue;
    }
    if (is_upper(c) && i > 0 && is_lower(name[i - 1])) words.emplace_back();
    words.back() += is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c;
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

template <std::size_t kSize>
bool among(const std::array<std::string_view, kSize>& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

bool is_fastener_word(std::string_view word) {
  constexpr std::array<std::string_view, 20> kWords = {
      "screw",   "bolt",   "nut",  "washer",    "rivet",    "pin",     "stud",
      "dowel",   "shcs",   "bhcs", "fhcs",      "setscrew", "grub",    "circlip",
      "locknut", "hexnut", "tnut", "grubscrew", "capscrew", "fastener"};
  if (among(kWords, word)) return true;
  return word.size() > 1 && word.back() == 's' && among(kWords, word.substr(0, word.size() - 1));
}

// m3, m2.5, m3x12, m3x0.5x12
bool is_thread(std::string_view word) {
  if (word.size() < 2 || word[0] != 'm' || !is_digit(word[1])) return false;
  return std::all_of(word.begin() + 1, word.end(),
                     [](char c) { return is_digit(c) || c == '.' || c == 'x'; });
}

bool is_number(std::string_view word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), is_digit);
}

}  // namespace

bool names_fastener(std::string_view name) {
  constexpr std::array<std::string_view, 4> kDrives = {"lead", "ball", "acme", "jack"};
  constexpr std::array<std::string_view, 4> kStandards = {"iso", "din", "ansi", "en"};
  constexpr std::array<std::string_view, 16> kHolders = {
      "block", "housing", "bracket", "plate",    "holder", "mount",  "header", "adapter",
      "cover", "spacer",  "bearing", "standoff", "shim",   "driver", "trap",   "connector"};
  const std::vector<std::string> words = words_of(name);
  for (std::size_t i = words.size(); i-- > 0;) {
    if (is_number(words[i]) || is_thread(words[i])) continue;
    if (among(kHolders, words[i])) return false;
    if (words[i].find_first_of("0123456789") == std::string::npos) break;
  }
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "leadscrew" || word == "ballscrew") return false;
    if (is_fastener_word(word) || is_thread(word)) {
      return i == 0 || !among(kDrives, words[i - 1]);
    }
    for (const std::string_view standard : kStandards) {
      if (word == standard && i + 1 < words.size() && is_number(words[i + 1])) return true;
      if (word.size() > standard.size() && word.starts_with(standard) &&
          is_number(std::string_view(word).substr(standard.size()))) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace orasp::detail
