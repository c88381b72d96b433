#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace orasp {

/// What started this process, as its environment tells: how many processes share the work, and
/// which of them this is. One where nothing like mpirun did.
struct Launch {
  std::size_t size = 1;
  std::size_t rank = 0;
};
/// Reads the variables that Open MPI, MPICH and Slurm set for the processes they start; opens no
/// library. Under Slurm only where it was told to prepare MPI (srun --mpi), since every job has its
/// variables.
[[nodiscard]] Launch launch_of_environment();

/// The processes of one job, called ranks, that share the work on one problem, and how they talk to
/// each other. They stand for an MPI communicator, and live in a module of their own, so that
/// neither the library nor the program needs MPI to start.
///
/// Threads.    One thread of a process calls it (MPI_THREAD_FUNNELED).
/// Order.      What one rank sends to another arrives in the order in which it was sent.
/// Failure.    Where MPI reports an error std::runtime_error is thrown. A rank that dies takes the
///             others with it: so mpirun and srun do.
class Ranks {
 public:
  Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  /// Ends the use of MPI; every rank must come here, or call abort().
  virtual ~Ranks() = default;

  [[nodiscard]] virtual std::size_t rank() const = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// How many of the ranks run on the machine of this one, itself included: they share its memory.
  [[nodiscard]] virtual std::size_t on_this_machine() const = 0;
  [[nodiscard]] virtual std::string machine() const = 0;

  /// Starts to send; the bytes must stay as they are until finish_sends(). They are counted.
  virtual void send(std::size_t to, std::span<const std::byte> bytes) = 0;
  /// Waits until all that was sent is out.
  virtual void finish_sends() = 0;
  [[nodiscard]] virtual std::uint64_t bytes_sent() const = 0;

  /// A receipt that was started.
  using Ticket = std::size_t;
  /// Starts to receive what `from` sends next that no other ticket waits for.
  [[nodiscard]] virtual Ticket receive(std::size_t from, std::span<std::byte> bytes) = 0;
  /// Waits until it is here. Each ticket is waited for or cancelled, once.
  virtual void wait(Ticket ticket) = 0;
  /// Gives a receipt up that nobody sends anything for.
  virtual void cancel(Ticket ticket) = 0;

  /// Starts to unite the flags (bit by bit) of all ranks; one union at a time. All ranks do.
  virtual void start_union(std::uint64_t flags) = 0;
  [[nodiscard]] virtual std::uint64_t finish_union() = 0;

  /// Replaces each number by the greatest, or the sum, of what the ranks have there.
  virtual void take_greatest(std::span<double> numbers) = 0;
  virtual void take_sums(std::span<std::uint64_t> numbers) = 0;
  /// What `from` has, on every rank.
  [[nodiscard]] virtual std::string broadcast(std::string text, std::size_t from) = 0;
  /// What each has, by rank, at rank 0; elsewhere empty.
  [[nodiscard]] virtual std::vector<std::string> gather(const std::string& text) = 0;
  /// What each has, by rank, on every rank. Its bytes are counted as sent, to each other rank.
  [[nodiscard]] virtual std::vector<std::string> gather_everywhere(const std::string& text) = 0;
  /// Gives each rank the text that stands for it in `texts`, and returns what each, by rank, has
  /// for this one. What goes to other ranks is counted as sent.
  [[nodiscard]] virtual std::vector<std::string> exchange(std::vector<std::string> texts) = 0;

  /// A text from one rank to another, apart from the stream of send().
  struct Letter {
    std::size_t from = 0;
    std::string text;
  };
  virtual void post(std::size_t to, std::string text) = 0;
  /// A letter that has arrived, if any has; does not wait.
  [[nodiscard]] virtual std::optional<Letter> next_letter() = 0;

  /// Ends all ranks at once with this exit code.
  [[noreturn]] virtual void abort(int code) = 0;
};

/// Joins the other ranks; once in a process. `program` is compared over all of them.
/// @throws InputError on every rank, with one sentence, where the module is missing or cannot be
/// loaded, where not so many processes came together as the environment says, or where a rank has
/// another `program` (its version and arguments).
[[nodiscard]] std::unique_ptr<Ranks> join_ranks(const std::string& program);

/// Why ranks cannot be joined here: a clause that says how to get what is missing; empty where they
/// can.
[[nodiscard]] std::optional<std::string> ranks_obstacle();

}  // namespace orasp
