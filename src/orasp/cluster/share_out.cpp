#include "orasp/cluster/share_out.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <deque>
#include <exception>
#include <future>
#include <iterator>
#include <new>
#include <thread>
#include <utility>

namespace orasp {

namespace {

using Work = std::function<std::string(std::size_t, const std::stop_token&)>;
using Failed = std::function<std::string(std::size_t, const std::string&)>;

constexpr std::ptrdiff_t kMostTries = 2;

// Letters: from rank 0 "do 7", "stop" and "end"; to it "+7 ANSWER", "-7 WHY NOT" and "stop".
constexpr const char* kStop = "stop";
constexpr const char* kEnd = "end";
constexpr std::chrono::milliseconds kNap{1};

/// What came of a piece.
struct Outcome {
  std::size_t piece = 0;
  bool done = false;
  std::string text;  ///< the answer, or why there is none

  [[nodiscard]] std::string letter() const {
    return (done ? "+" : "-") + std::to_string(piece) + " " + text;
  }
  static Outcome of_letter(const std::string& letter) {
    Outcome outcome;
    outcome.done = letter.front() == '+';
    const std::size_t gap = letter.find(' ');
    std::from_chars(letter.data() + 1, letter.data() + gap, outcome.piece);
    outcome.text = letter.substr(gap + 1);
    return outcome;
  }
};

/// Where a rank does its pieces, one at a time.
class Desk {
 public:
  Desk(const Work& work, std::stop_token stop) : work_(work), stop_(std::move(stop)) {}

  [[nodiscard]] bool busy() const { return running_.valid(); }
  void begin(std::size_t piece) {
    running_ = std::async(std::launch::async, [this, piece] {
      Outcome outcome{.piece = piece, .done = false, .text = {}};
      try {
        outcome.text = work_(piece, stop_);
        outcome.done = true;
      } catch (const std::bad_alloc&) {
        outcome.text = "out of memory";
      } catch (const std::exception& error) {
        outcome.text = error.what();
      }
      return outcome;
    });
  }
  /// What came of the piece, once it is over.
  [[nodiscard]] std::optional<Outcome> take() {
    if (!busy() || running_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
      return std::nullopt;
    return running_.get();
  }

 private:
  const Work& work_;
  const std::stop_token stop_;
  std::future<Outcome> running_;
};

void serve(Ranks& ranks, const Work& work, const std::stop_token& stop) {
  std::stop_source stopping;
  Desk desk(work, stopping.get_token());
  bool told = false;
  while (true) {
    if (stop.stop_requested() && !told) {
      told = true;
      stopping.request_stop();
      ranks.post(0, kStop);
    }
    if (const auto outcome = desk.take()) ranks.post(0, outcome->letter());
    if (const auto letter = ranks.next_letter()) {
      if (letter->text == kEnd) return;
      if (letter->text == kStop) {
        stopping.request_stop();
      } else {
        desk.begin(std::stoul(letter->text.substr(letter->text.find(' '))));
      }
    } else {
      std::this_thread::sleep_for(kNap);
    }
  }
}

/// What rank 0 does.
class HandingOut {
 public:
  HandingOut(Ranks& ranks, std::size_t pieces, const Work& work, const Failed& failed)
      : ranks_(ranks),
        failed_(failed),
        desk_(work, stopping_.get_token()),
        answers_(pieces),
        tried_(pieces, std::vector<bool>(ranks.size())),
        busy_(ranks.size()) {
    for (std::size_t piece = 0; piece < pieces; ++piece) waiting_.push_back(piece);
  }

  std::vector<std::optional<std::string>> run(const std::stop_token& stop) {
    while (true) {
      if (stop.stop_requested()) stop_all();
      hand_out();
      if (std::ranges::find(busy_, true) == busy_.end()) break;
      bool idle = true;
      if (const auto outcome = desk_.take()) {
        note(0, *outcome);
        idle = false;
      }
      if (const auto letter = ranks_.next_letter()) {
        if (letter->text == kStop) {
          stop_all();
        } else {
          note(letter->from, Outcome::of_letter(letter->text));
        }
        idle = false;
      }
      if (idle) std::this_thread::sleep_for(kNap);
    }
    for (std::size_t rank = 1; rank < ranks_.size(); ++rank) ranks_.post(rank, kEnd);
    return std::move(answers_);
  }

 private:
  void hand_out() {
    for (std::size_t rank = 0; rank < busy_.size(); ++rank) {
      if (busy_[rank]) continue;
      const auto next =
          std::ranges::find_if(waiting_, [&](std::size_t piece) { return !tried_[piece][rank]; });
      if (next == waiting_.end()) continue;
      const std::size_t piece = *next;
      waiting_.erase(next);
      busy_[rank] = true;
      tried_[piece][rank] = true;
      if (rank == 0) {
        desk_.begin(piece);
      } else {
        ranks_.post(rank, "do " + std::to_string(piece));
      }
    }
  }
  void note(std::size_t rank, const Outcome& outcome) {
    busy_[rank] = false;
    if (outcome.done) {
      answers_[outcome.piece] = outcome.text;
    } else if (!stopped_) {
      const std::vector<bool>& tried = tried_[outcome.piece];
      const auto tries = std::ranges::count(tried, true);
      if (tries < kMostTries && tries < std::ssize(tried)) {
        waiting_.push_front(outcome.piece);
      } else {
        answers_[outcome.piece] = failed_(outcome.piece, outcome.text);
      }
    }
  }
  void stop_all() {
    if (stopped_) return;
    stopped_ = true;
    waiting_.clear();
    stopping_.request_stop();
    for (std::size_t rank = 1; rank < ranks_.size(); ++rank) ranks_.post(rank, kStop);
  }

  Ranks& ranks_;
  const Failed& failed_;
  std::stop_source stopping_;
  Desk desk_;
  std::vector<std::optional<std::string>> answers_;
  std::deque<std::size_t> waiting_;
  /// By piece and rank.
  std::vector<std::vector<bool>> tried_;
  std::vector<bool> busy_;
  bool stopped_ = false;
};

}  // namespace

std::vector<std::optional<std::string>> share_out(Ranks& ranks, std::size_t pieces,
                                                  const Work& work, const Failed& failed,
                                                  const std::stop_token& stop) {
  if (ranks.rank() == 0) return HandingOut(ranks, pieces, work, failed).run(stop);
  serve(ranks, work, stop);
  return {};
}

}  // namespace orasp
