#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace orasp {

/// How a program ended that was run.
struct ProgramRun {
  int exit_code = 0;
  int signal = 0;  ///< that ended it; 0 if it ended by itself
  std::string output;
  std::string errors;
  double seconds = 0;  ///< wall time, from before it was started to after it had ended
};

/// Runs a program in a process of its own, without a shell: `program` is a path, or a name that is
/// looked up in PATH; each argument reaches it as it is. Waits for its end. Empty if there is no
/// such program. Its three standard streams are files without a name, not pipes: no reader and
/// writer that wait for each other, and no signal if it stops reading. Signals that this process
/// blocks or ignores are not blocked or ignored there, and SIGINT and SIGTERM are blocked: who asks
/// a group of processes to stop asks the caller, who decides what becomes of the work.
/// @throws InputError if there is no room for temporary files, or the program cannot be started for
/// another reason.
[[nodiscard]] std::optional<ProgramRun> run_program(const std::string& program,
                                                    std::span<const std::string> arguments,
                                                    std::string_view input = {});

/// What a drawing program makes of `input`. @throws InputError "cannot draw: ..." if it is missing
/// (the sentence names the Debian package that holds it) or fails (with the first line of what it
/// complains about).
[[nodiscard]] std::string drawn_by(const std::string& program, const std::string& debian_package,
                                   std::span<const std::string> arguments, std::string_view input);

}  // namespace orasp
