#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "orasp/cluster/ranks.h"
#include "orasp/model/error.h"

namespace orasp {

/// Ranks that are threads of one process and pass messages by its memory: what the ranks of MPI
/// promise, for tests of hundreds of problems without mpirun.
class ThreadRanks final : public Ranks {
 public:
  /// What they share.
  struct Hub {
    explicit Hub(std::size_t count) : size(count) {}
    struct Gathering {
      std::vector<std::string> texts;
      std::size_t count = 0;
    };
    std::size_t size;
    std::mutex mutex;
    std::condition_variable changed;
    std::map<std::pair<std::size_t, std::size_t>, std::deque<std::vector<std::byte>>> streams;
    std::map<std::size_t, std::deque<Letter>> letters;
    std::map<std::uint64_t, Gathering> gatherings;
  };

  ThreadRanks(Hub& hub, std::size_t rank) : hub_(hub), rank_(rank), posted_(hub.size) {}

  [[nodiscard]] std::size_t rank() const override { return rank_; }
  [[nodiscard]] std::size_t size() const override { return hub_.size; }
  [[nodiscard]] std::size_t on_this_machine() const override { return 1; }
  [[nodiscard]] std::string machine() const override { return "here"; }

  void send(std::size_t to, std::span<const std::byte> bytes) override {
    const std::lock_guard lock(hub_.mutex);
    hub_.streams[{rank_, to}].emplace_back(bytes.begin(), bytes.end());
    bytes_sent_ += bytes.size();
    hub_.changed.notify_all();
  }
  void finish_sends() override {}
  [[nodiscard]] std::uint64_t bytes_sent() const override { return bytes_sent_; }

  [[nodiscard]] Ticket receive(std::size_t from, std::span<std::byte> bytes) override {
    tickets_[++last_] = {from, bytes, false};
    posted_[from].push_back(last_);
    return last_;
  }
  void wait(Ticket ticket) override {
    const std::size_t from = tickets_.at(ticket).from;
    std::unique_lock lock(hub_.mutex);
    while (!tickets_.at(ticket).here) {
      auto& stream = hub_.streams[{from, rank_}];
      hub_.changed.wait(lock, [&] { return !stream.empty(); });
      Receipt& first = tickets_.at(posted_[from].front());
      if (first.bytes.size() != stream.front().size())
        throw std::logic_error("a message of another size than was waited for");
      std::ranges::copy(stream.front(), first.bytes.begin());
      first.here = true;
      stream.pop_front();
      posted_[from].pop_front();
    }
    tickets_.erase(ticket);
  }
  void cancel(Ticket ticket) override {
    const Receipt& receipt = tickets_.at(ticket);
    if (receipt.here) throw std::logic_error("what was given up had arrived");
    std::erase(posted_[receipt.from], ticket);
    tickets_.erase(ticket);
  }

  void start_union(std::uint64_t flags) override {
    union_ = next_gathering_++;
    tell(union_, std::string(reinterpret_cast<const char*>(&flags), sizeof flags));
  }
  [[nodiscard]] std::uint64_t finish_union() override {
    std::uint64_t united = 0;
    for (const std::string& text : told(union_)) {
      std::uint64_t flags = 0;
      std::memcpy(&flags, text.data(), sizeof flags);
      united |= flags;
    }
    return united;
  }
  void take_greatest(std::span<double> numbers) override {
    fold(numbers, [](double a, double b) { return std::max(a, b); });
  }
  void take_sums(std::span<std::uint64_t> numbers) override {
    fold(numbers, [](std::uint64_t a, std::uint64_t b) { return a + b; });
  }
  [[nodiscard]] std::string broadcast(std::string text, std::size_t from) override {
    return all(text)[from];
  }
  [[nodiscard]] std::vector<std::string> gather(const std::string& text) override {
    std::vector<std::string> texts = all(text);
    return rank_ == 0 ? texts : std::vector<std::string>();
  }
  [[nodiscard]] std::vector<std::string> gather_everywhere(const std::string& text) override {
    bytes_sent_ += text.size() * (hub_.size - 1);
    return all(text);
  }
  [[nodiscard]] std::vector<std::string> exchange(std::vector<std::string> texts) override {
    // All texts go to all, each behind its length.
    std::string mine;
    for (std::size_t to = 0; to < texts.size(); ++to) {
      const std::size_t length = texts[to].size();
      if (to != rank_) bytes_sent_ += length;
      mine.append(reinterpret_cast<const char*>(&length), sizeof length).append(texts[to]);
    }
    std::vector<std::string> for_me;
    for (const std::string& of : all(mine)) {
      std::size_t at = 0;
      for (std::size_t to = 0;; ++to) {
        std::size_t length = 0;
        std::memcpy(&length, of.data() + at, sizeof length);
        at += sizeof length;
        if (to == rank_) {
          for_me.push_back(of.substr(at, length));
          break;
        }
        at += length;
      }
    }
    return for_me;
  }
  void post(std::size_t to, std::string text) override {
    const std::lock_guard lock(hub_.mutex);
    hub_.letters[to].push_back({rank_, std::move(text)});
  }
  [[nodiscard]] std::optional<Letter> next_letter() override {
    const std::lock_guard lock(hub_.mutex);
    std::deque<Letter>& mine = hub_.letters[rank_];
    if (mine.empty()) return std::nullopt;
    Letter letter = std::move(mine.front());
    mine.pop_front();
    return letter;
  }
  [[noreturn]] void abort(int) override { throw std::logic_error("a rank gave up"); }

 private:
  struct Receipt {
    std::size_t from = 0;
    std::span<std::byte> bytes;
    bool here = false;
  };

  void tell(std::uint64_t gathering, std::string text) {
    const std::lock_guard lock(hub_.mutex);
    Hub::Gathering& of = hub_.gatherings[gathering];
    of.texts.resize(hub_.size);
    of.texts[rank_] = std::move(text);
    ++of.count;
    hub_.changed.notify_all();
  }
  std::vector<std::string> told(std::uint64_t gathering) {
    std::unique_lock lock(hub_.mutex);
    Hub::Gathering& of = hub_.gatherings[gathering];
    hub_.changed.wait(lock, [&] { return of.count == hub_.size; });
    return of.texts;
  }
  std::vector<std::string> all(const std::string& text) {
    const std::uint64_t gathering = next_gathering_++;
    tell(gathering, text);
    return told(gathering);
  }
  template <class Number, class Fold>
  void fold(std::span<Number> numbers, Fold both) {
    const auto texts =
        all(std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()));
    for (std::size_t r = 0; r < texts.size(); ++r) {
      if (texts[r].size() != numbers.size_bytes()) throw std::logic_error("ranks are not in step");
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        Number number;
        std::memcpy(&number, texts[r].data() + i * sizeof number, sizeof number);
        numbers[i] = r == 0 ? number : both(numbers[i], number);
      }
    }
  }

  Hub& hub_;
  std::size_t rank_;
  std::uint64_t bytes_sent_ = 0;
  std::vector<std::deque<Ticket>> posted_;
  std::map<Ticket, Receipt> tickets_;
  Ticket last_ = 0;
  std::uint64_t next_gathering_ = 0;
  std::uint64_t union_ = 0;
};

/// Runs `work` on so many ranks at the same time. @returns what each returned.
template <class Work>
auto on_thread_ranks(std::size_t count, Work work) {
  using Answer = decltype(work(std::declval<Ranks&>()));
  ThreadRanks::Hub hub(count);
  std::vector<Answer> answers(count);
  std::vector<std::exception_ptr> errors(count);
  {
    std::vector<std::jthread> threads;
    for (std::size_t rank = 0; rank < count; ++rank) {
      threads.emplace_back([&, rank] {
        try {
          ThreadRanks ranks(hub, rank);
          answers[rank] = work(static_cast<Ranks&>(ranks));
        } catch (...) {
          errors[rank] = std::current_exception();
        }
      });
    }
  }
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
  return answers;
}

/// What each rank says of wrong input that `work(ranks)` meets; empty where it meets none.
template <class Work>
std::vector<std::string> faults_on_thread_ranks(std::size_t count, Work work) {
  return on_thread_ranks(count, [&](Ranks& ranks) {
    try {
      static_cast<void>(work(ranks));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  });
}

}  // namespace orasp
