#pragma once

#include <cstddef>
#include <cstdio>
#include <string_view>

namespace orasp::cli {

/// The world outside a command: the result goes to standard output, everything else to standard
/// error.
class Context {
 public:
  explicit Context(bool quiet);

  /// Writes a result. A reader that has gone away (`| head -1`) is no error. @throws InputError if
  /// it cannot be written.
  void print(std::string_view text) const;
  /// `orasp: warning: ...` on standard error, unless --quiet.
  void warn(std::string_view sentence) const;

  /// A line on standard error, unless --quiet.
  void say(std::string_view line) const;

  /// Standard output is a terminal and NO_COLOR is not set (https://no-color.org).
  [[nodiscard]] bool colour() const { return colour_; }
  /// Columns of the terminal, 100 where standard output is none.
  [[nodiscard]] std::size_t width() const { return width_; }
  /// Standard error is a terminal and --quiet was not given.
  [[nodiscard]] bool shows_progress() const { return shows_progress_; }

 private:
  std::FILE* out_;
  bool quiet_;
  bool colour_;
  std::size_t width_;
  bool shows_progress_;
};

/// `orasp: ...` on standard error.
void print_error(std::string_view sentence);

}  // namespace orasp::cli
