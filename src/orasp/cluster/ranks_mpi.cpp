// The module with MPI, the only place that sees it: loaded when several processes are to share the
// work (ranks.cpp). Written for MPI 3.0 and its C functions.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <limits>
#include <list>
#include <stdexcept>
#include <thread>
#include <utility>

#include <mpi.h>

#include "orasp/cluster/ranks.h"

namespace orasp {

namespace {

constexpr int kStream = 1;
constexpr int kLetters = 2;

void check(int code) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw std::runtime_error("MPI: " + std::string(text, static_cast<std::size_t>(length)));
}

int whole(std::size_t number) {
  if (number > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::runtime_error("MPI: a message of more than 2 GiB");
  return static_cast<int>(number);
}

/// Waits for a request: looks again and again, leaving the core to others between two looks, and
/// after some milliseconds only now and then, so that a rank that has long nothing to do takes
/// nothing from those that work.
void wait_for(MPI_Request& request) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kPatience{2};
  constexpr std::chrono::microseconds kNap{100};
  constexpr int kLooksBetweenTimes = 64;
  std::optional<Clock::time_point> begin;
  int done = 0;
  for (int looks = 0;; ++looks) {
    check(MPI_Test(&request, &done, MPI_STATUS_IGNORE));
    if (done != 0) return;
    if (looks % kLooksBetweenTimes == kLooksBetweenTimes - 1) {
      const Clock::time_point now = Clock::now();
      if (!begin) begin = now;
      if (now - *begin > kPatience) {
        std::this_thread::sleep_for(kNap);
        looks -= 1;
        continue;
      }
    }
    std::this_thread::yield();
  }
}

/// Where all ranks run on this machine, has Open MPI look for no network between machines, unless
/// the user says what it is to use: half of the time that it takes to start goes by with that.
void use_shared_memory_alone() {
  const char* const all = std::getenv("OMPI_COMM_WORLD_SIZE");
  const char* const near = std::getenv("OMPI_COMM_WORLD_LOCAL_SIZE");
  if (all == nullptr || near == nullptr || std::strcmp(all, near) != 0) return;
  setenv("OMPI_MCA_pml", "ob1", 0);
}

/// Texts of all ranks one behind the other, as MPI wants them described.
struct Runs {
  std::vector<int> sizes;
  std::vector<int> begins;
  std::size_t total = 0;

  explicit Runs(std::vector<int> sizes_of_all) : sizes(std::move(sizes_of_all)) {
    for (const int size : sizes) {
      begins.push_back(whole(total));
      total += static_cast<std::size_t>(size);
    }
  }
  explicit Runs(const std::vector<std::string>& texts) : Runs(sizes_of(texts)) {}

  [[nodiscard]] std::string text_of(const std::string& all, std::size_t rank) const {
    return all.substr(static_cast<std::size_t>(begins[rank]),
                      static_cast<std::size_t>(sizes[rank]));
  }

 private:
  static std::vector<int> sizes_of(const std::vector<std::string>& texts) {
    std::vector<int> sizes;
    for (const std::string& text : texts) sizes.push_back(whole(text.size()));
    return sizes;
  }
};

class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    use_shared_memory_alone();
    int provided = 0;
    check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided));
    check(MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN));
    if (provided < MPI_THREAD_FUNNELED)
      throw std::runtime_error("this MPI cannot be used beside threads");
    int number = 0;
    check(MPI_Comm_rank(MPI_COMM_WORLD, &number));
    rank_ = static_cast<std::size_t>(number);
    check(MPI_Comm_size(MPI_COMM_WORLD, &number));
    size_ = static_cast<std::size_t>(number);
    MPI_Comm near = MPI_COMM_NULL;
    check(MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &near));
    check(MPI_Comm_size(near, &number));
    on_this_machine_ = static_cast<std::size_t>(number);
    check(MPI_Comm_free(&near));
    char name[MPI_MAX_PROCESSOR_NAME];
    check(MPI_Get_processor_name(name, &number));
    machine_.assign(name, static_cast<std::size_t>(number));
  }
  ~MpiRanks() override {
    try {
      finish_sends();
      for (Posted& letter : posted_) wait_for(letter.request);
    } catch (const std::exception&) {
      // Nothing is left to be done but to end.
    }
    MPI_Finalize();
  }

  [[nodiscard]] std::size_t rank() const override { return rank_; }
  [[nodiscard]] std::size_t size() const override { return size_; }
  [[nodiscard]] std::size_t on_this_machine() const override { return on_this_machine_; }
  [[nodiscard]] std::string machine() const override { return machine_; }

  void send(std::size_t to, std::span<const std::byte> bytes) override {
    // What is out is forgotten from the front: it went out in about this order.
    while (!sends_.empty()) {
      int done = 0;
      check(MPI_Test(&sends_.front(), &done, MPI_STATUS_IGNORE));
      if (done == 0) break;
      sends_.pop_front();
    }
    sends_.emplace_back();
    check(MPI_Isend(bytes.data(), whole(bytes.size()), MPI_BYTE, whole(to), kStream, MPI_COMM_WORLD,
                    &sends_.back()));
    bytes_sent_ += bytes.size();
  }
  void finish_sends() override {
    for (MPI_Request& request : sends_) wait_for(request);
    sends_.clear();
  }
  [[nodiscard]] std::uint64_t bytes_sent() const override { return bytes_sent_; }

  [[nodiscard]] Ticket receive(std::size_t from, std::span<std::byte> bytes) override {
    Ticket ticket = receipts_.size();
    if (free_.empty()) {
      receipts_.emplace_back();
    } else {
      ticket = free_.back();
      free_.pop_back();
    }
    check(MPI_Irecv(bytes.data(), whole(bytes.size()), MPI_BYTE, whole(from), kStream,
                    MPI_COMM_WORLD, &receipts_[ticket]));
    return ticket;
  }
  void wait(Ticket ticket) override {
    wait_for(receipts_[ticket]);
    free_.push_back(ticket);
  }
  void cancel(Ticket ticket) override {
    check(MPI_Cancel(&receipts_[ticket]));
    wait(ticket);
  }

  void start_union(std::uint64_t flags) override {
    mine_ = flags;
    check(MPI_Iallreduce(&mine_, &united_, 1, MPI_UINT64_T, MPI_BOR, MPI_COMM_WORLD, &union_));
  }
  [[nodiscard]] std::uint64_t finish_union() override {
    wait_for(union_);
    return united_;
  }

  void take_greatest(std::span<double> numbers) override {
    MPI_Request request = MPI_REQUEST_NULL;
    check(MPI_Iallreduce(MPI_IN_PLACE, numbers.data(), whole(numbers.size()), MPI_DOUBLE, MPI_MAX,
                         MPI_COMM_WORLD, &request));
    wait_for(request);
  }
  void take_sums(std::span<std::uint64_t> numbers) override {
    MPI_Request request = MPI_REQUEST_NULL;
    check(MPI_Iallreduce(MPI_IN_PLACE, numbers.data(), whole(numbers.size()), MPI_UINT64_T, MPI_SUM,
                         MPI_COMM_WORLD, &request));
    wait_for(request);
  }
  [[nodiscard]] std::string broadcast(std::string text, std::size_t from) override {
    std::uint64_t length = text.size();
    MPI_Request request = MPI_REQUEST_NULL;
    check(MPI_Ibcast(&length, 1, MPI_UINT64_T, whole(from), MPI_COMM_WORLD, &request));
    wait_for(request);
    text.resize(length);
    check(MPI_Ibcast(text.data(), whole(text.size()), MPI_BYTE, whole(from), MPI_COMM_WORLD,
                     &request));
    wait_for(request);
    return text;
  }
  [[nodiscard]] std::vector<std::string> gather(const std::string& text) override {
    std::vector<std::string> texts;
    for (std::size_t from = 0; from < size_; ++from) {
      std::string one = broadcast(from == rank_ ? text : std::string(), from);
      if (rank_ == 0) texts.push_back(std::move(one));
    }
    return texts;
  }

  [[nodiscard]] std::vector<std::string> gather_everywhere(const std::string& text) override {
    std::vector<int> sizes(size_);
    const int mine = whole(text.size());
    MPI_Request request = MPI_REQUEST_NULL;
    check(MPI_Iallgather(&mine, 1, MPI_INT, sizes.data(), 1, MPI_INT, MPI_COMM_WORLD, &request));
    wait_for(request);
    const Runs in(std::move(sizes));
    std::string all(in.total, '\0');
    check(MPI_Iallgatherv(text.data(), mine, MPI_BYTE, all.data(), in.sizes.data(),
                          in.begins.data(), MPI_BYTE, MPI_COMM_WORLD, &request));
    wait_for(request);
    bytes_sent_ += text.size() * (size_ - 1);
    std::vector<std::string> texts;
    for (std::size_t from = 0; from < size_; ++from) texts.push_back(in.text_of(all, from));
    return texts;
  }

  [[nodiscard]] std::vector<std::string> exchange(std::vector<std::string> texts) override {
    std::string own = std::move(texts[rank_]);
    texts[rank_].clear();
    const Runs out(texts);
    std::vector<int> sizes(size_);
    MPI_Request request = MPI_REQUEST_NULL;
    check(MPI_Ialltoall(out.sizes.data(), 1, MPI_INT, sizes.data(), 1, MPI_INT, MPI_COMM_WORLD,
                        &request));
    wait_for(request);
    std::string all_out;
    all_out.reserve(out.total);
    for (std::string& text : texts) {
      all_out += text;
      text = std::string();
    }
    const Runs in(std::move(sizes));
    std::string all_in(in.total, '\0');
    check(MPI_Ialltoallv(all_out.data(), out.sizes.data(), out.begins.data(), MPI_BYTE,
                         all_in.data(), in.sizes.data(), in.begins.data(), MPI_BYTE, MPI_COMM_WORLD,
                         &request));
    wait_for(request);
    bytes_sent_ += all_out.size();
    for (std::size_t from = 0; from < size_; ++from) texts[from] = in.text_of(all_in, from);
    texts[rank_] = std::move(own);
    return texts;
  }

  void post(std::size_t to, std::string text) override {
    posted_.remove_if([](Posted& letter) {
      int done = 0;
      check(MPI_Test(&letter.request, &done, MPI_STATUS_IGNORE));
      return done != 0;
    });
    Posted& letter = posted_.emplace_back();
    letter.text = std::move(text);
    check(MPI_Isend(letter.text.data(), whole(letter.text.size()), MPI_BYTE, whole(to), kLetters,
                    MPI_COMM_WORLD, &letter.request));
  }
  [[nodiscard]] std::optional<Letter> next_letter() override {
    int here = 0;
    MPI_Status status;
    check(MPI_Iprobe(MPI_ANY_SOURCE, kLetters, MPI_COMM_WORLD, &here, &status));
    if (here == 0) return std::nullopt;
    int length = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &length));
    Letter letter{.from = static_cast<std::size_t>(status.MPI_SOURCE), .text = {}};
    letter.text.resize(static_cast<std::size_t>(length));
    check(MPI_Recv(letter.text.data(), length, MPI_BYTE, status.MPI_SOURCE, kLetters,
                   MPI_COMM_WORLD, MPI_STATUS_IGNORE));
    return letter;
  }

  [[noreturn]] void abort(int code) override {
    MPI_Abort(MPI_COMM_WORLD, code);
    std::_Exit(code);
  }

 private:
  struct Posted {
    std::string text;
    MPI_Request request = MPI_REQUEST_NULL;
  };

  std::size_t rank_ = 0;
  std::size_t size_ = 1;
  std::size_t on_this_machine_ = 1;
  std::string machine_;
  std::deque<MPI_Request> sends_;
  std::uint64_t bytes_sent_ = 0;
  std::deque<MPI_Request> receipts_;
  std::vector<Ticket> free_;
  std::uint64_t mine_ = 0;
  std::uint64_t united_ = 0;
  MPI_Request union_ = MPI_REQUEST_NULL;
  std::list<Posted> posted_;
};

}  // namespace

}  // namespace orasp

extern "C" __attribute__((visibility("default"))) orasp::Ranks* orasp_join_ranks_3() {
  return new orasp::MpiRanks();
}
