#pragma once

#include <functional>
#include <stop_token>
#include <string>

namespace orasp {

/// Does pieces of work in processes of their own: one that crashes, or is killed because memory is
/// short, takes nothing with it.
///
/// Idea.      A process that has joined other ranks, or has threads, is nothing to copy. So a
///            process that does nothing but wait is split off before (fork); whenever there is a
///            piece it splits off another one, which does the piece and writes what it made to a
///            socket. Where memory is short, Linux kills one of those first (oom_score_adj).
/// Guarantee. An answer is whole or there is none. Where the process that holds the workshop ends,
///            however that comes, all of the workshop ends.
/// Signals.   SIGINT and SIGTERM are blocked in the workshop: stops come from who asks for the
///            piece.
/// Cost.      Some 0.3 ms a piece, and the memory that the process had when it was split off is
///            shared with it.
class Workshop {
 public:
  /// Does a piece; throws where it cannot.
  using Work = std::function<std::string(const std::string& task, const std::stop_token& stop)>;

  /// To be called by the first thread of a process, before it has others. What `work` looks at is
  /// what it was then.
  /// @throws std::runtime_error where no process can be split off.
  explicit Workshop(const Work& work);
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;
  ~Workshop();

  /// What the work makes of `task`; one at a time, on any thread.
  /// @throws std::runtime_error with what the work threw, or "killed by signal 9 (Killed)".
  [[nodiscard]] std::string make(const std::string& task, const std::stop_token& stop);

 private:
  int to_ = -1;    ///< where tasks and stops are written
  int from_ = -1;  ///< where answers are read
  int process_ = -1;
};

}  // namespace orasp
