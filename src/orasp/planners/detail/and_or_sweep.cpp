#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <utility>

#include "orasp/containers/parallel.h"
#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// What sweep() has to know of a piece to look at it, and what it has found then. The first half is
/// a copy: the tables that it comes from move while other pieces come in.
template <std::size_t kWords>
struct AndOrSearch<kWords>::Swept {
  std::uint32_t number;
  Set piece;
  double bound;
  double loss;  ///< what is known of it; raised by a look
  double left;  ///< what it may lose at most
  bool has_list;
  bool looked_at;

  bool listed = false;
  bool complete = false;
  double skipped = kInfinity;
  std::uint64_t looks = 0;
  std::size_t cuts_end = 0;
};

/// Some pieces of a layer, one after the other, and the cuts of those that were listed.
template <std::size_t kWords>
struct AndOrSearch<kWords>::Batch {
  std::vector<typename CutLister<kWords>::Found> cuts;
  std::vector<std::uint64_t> hashes;
  std::exception_ptr error;
  std::atomic<bool> ready = false;
};

/// As search_stored(), for a whole piece of the problem: instead of one piece after the other, all
/// that can be reached within the limit, the largest first, and then back from the smallest.
///
/// Idea.       Every piece is cut from a larger one. So once all pieces of more than n parts are
///             done, it is known what each piece of n parts may lose at most, in whatever way it is
///             reached, and which of them are reached at all. Their cuts do not depend on each
///             other: threads list them, a batch of pieces each. One thread takes the cuts in, in
///             the order of the pieces, so that the answer is the same with any number of threads.
///             Back from the smallest piece, the loss of each is the least over its cuts.
/// Reference.  Breadth-first search within a bound on the cost: Zhou and Hansen (2006),
///             Breadth-first heuristic search, Artificial Intelligence 170(4-5), 385-408. The way
///             back is the cost revision of AO*: Nilsson (1980), Principles of Artificial
///             Intelligence, ch. 3.
/// Guarantee.  As search_stored(). Both sides of a cut are looked at at once, where search_stored()
///             leaves one out if the other loses too much; in turn no piece is looked at again with
///             a higher limit.
template <std::size_t kWords>
double AndOrSearch<kWords>::sweep(std::uint32_t root, double limit) {
  if (exact_[root] != 0 || loss_[root] > limit) return loss_[root];
  const std::size_t parts = set_of(root).size();
  const Unfinished before = std::exchange(unfinished_, {});
  std::size_t layer = parts;
  if (before.root == root && limit <= before.limit) {
    // What a piece may lose is the limit less what is lost on the way to it.
    for (double& left : left_) left -= before.limit - limit;
    left_.resize(memo_.size(), -kInfinity);
    layer = before.layer;
  } else {
    left_.assign(memo_.size(), -kInfinity);
    layers_.resize(std::max(layers_.size(), parts + 1));
    for (auto& pieces : layers_) pieces.clear();
    left_[root] = limit;
    layers_[parts].push_back(root);
  }
  for (; layer >= 2; --layer) {
    sweep_layer(layer);
    if (!sweeps_) return loss_[root];
    if (must_stop()) {
      unfinished_ = {root, limit, layer};
      return loss_[root];
    }
  }
  for (std::size_t n = 2; n <= parts; ++n) {
    const std::vector<std::uint32_t>& pieces = layers_[n];
    constexpr std::size_t kWorthThreads = 1024;
    const std::size_t threads = pieces.size() < kWorthThreads ? 1 : std::max(1U, budget_.threads);
    run_parallel(threads, [&](std::size_t thread) {
      const Share share = share_of(pieces.size(), threads, thread);
      for (std::size_t i = share.begin; i < share.end; ++i) settle_swept(pieces[i]);
    });
  }
  return loss_[root];
}

/// The pieces of `parts` parts that are reached and may not lose too much, for all that is known
/// without prices of their own.
template <std::size_t kWords>
auto AndOrSearch<kWords>::reached_pieces(std::size_t parts, bool priced) -> std::vector<Swept> {
  std::vector<Swept> pieces;
  for (const std::uint32_t number : layers_[parts]) {
    const double left = left_[number];
    if (exact_[number] != 0 || loss_[number] > left) continue;
    StoredCuts& list = lists_[number];
    const Set piece = set_of(number);
    if (!list.looked_at) {
      const double first = loss_by_shape(piece, parts, upper_[number], false);
      loss_[number] = std::max(loss_[number], first);
      list.looked_at = !priced;
    }
    if (loss_[number] > left) continue;
    const bool has_list = list.kept && list.limit >= left;
    pieces.push_back(
        {number, piece, upper_[number], loss_[number], left, has_list, list.looked_at});
  }
  return pieces;
}

/// Looks at the pieces of `parts` parts that are reached: what they lose at least, their cuts, and
/// what the sides of those may lose. Pieces that lose too much are left out of the layer.
template <std::size_t kWords>
void AndOrSearch<kWords>::sweep_layer(std::size_t parts) {
  constexpr std::size_t kBatch = 4;
  const bool priced = has_own_prices(parts);
  std::vector<Swept> pieces = reached_pieces(parts, priced);
  const std::vector<std::uint32_t> reached = std::exchange(layers_[parts], {});
  if (pieces.empty()) return;
  const std::size_t batches = (pieces.size() + kBatch - 1) / kBatch;
  const std::size_t threads =
      std::min<std::size_t>(std::max(1U, budget_.threads), (batches + 3) / 4);
  const std::size_t most_waiting = 4 * threads;  // batches that wait to be taken in
  while (sweepers_.size() < threads) sweepers_.push_back(std::make_unique<Sweeper>(shared_));
  std::vector<Batch> ring(std::min(batches, most_waiting));
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> taken = 0;
  std::atomic<bool> stopping = false;
  const auto share = [&](std::size_t batch) {
    return std::span(pieces).subspan(batch * kBatch,
                                     std::min(kBatch, pieces.size() - batch * kBatch));
  };
  const auto look = [&](std::size_t batch, Sweeper& sweeper, auto&& stop) {
    Batch& into = ring[batch % most_waiting];
    try {
      look_at_batch(share(batch), priced, sweeper, into, stop);
    } catch (...) {
      into.error = std::current_exception();
    }
    into.ready.store(true, std::memory_order_release);
    into.ready.notify_one();
  };
  run_parallel(threads, [&](std::size_t thread) {
    Sweeper& sweeper = *sweepers_[thread];
    if (thread > 0) {
      while (true) {
        const std::size_t batch = next.fetch_add(1);
        if (batch >= batches) return;
        for (std::size_t done = taken.load(); batch >= done + most_waiting; done = taken.load())
          taken.wait(done);
        if (stopping.load()) return;
        look(batch, sweeper, [&] { return stopping.load(std::memory_order_relaxed); });
      }
    }
    const auto stop = [&] {
      if (++visits_ % 64 == 0) poll();
      return must_stop();
    };
    // Whatever ends this thread's work must let the others go on to their end.
    struct Release {
      std::atomic<std::size_t>& taken;
      std::atomic<bool>& stopping;
      ~Release() {
        stopping = true;
        taken = std::numeric_limits<std::size_t>::max() / 2;
        taken.notify_all();
      }
    } release{taken, stopping};
    for (std::size_t batch = 0; batch < batches && !must_stop() && sweeps_;) {
      Batch& ready = ring[batch % most_waiting];
      if (ready.ready.load(std::memory_order_acquire)) {
        if (ready.error) std::rethrow_exception(ready.error);
        take_batch(parts, share(batch), ready);
        ready.ready.store(false, std::memory_order_relaxed);
        taken.store(++batch);
        taken.notify_all();
        continue;
      }
      std::size_t other = next.load();
      if (other < std::min(batches, batch + most_waiting)) {
        if (next.compare_exchange_strong(other, other + 1)) look(other, sweeper, stop);
        continue;
      }
      ready.ready.wait(false, std::memory_order_acquire);
    }
  });
  if (must_stop()) layers_[parts] = reached;  // looked at again from its beginning
}

/// Looks at some pieces of a layer, on whatever thread.
template <std::size_t kWords>
template <class Stop>
void AndOrSearch<kWords>::look_at_batch(std::span<Swept> pieces, bool priced, Sweeper& sweeper,
                                        Batch& into, Stop&& stop) const {
  into.cuts.clear();
  into.hashes.clear();
  for (Swept& swept : pieces) {
    if (stop()) return;
    if (priced && !swept.looked_at) {
      list_parts(swept.piece, sweeper.parts);
      const double above =
          above_prices(sweeper.parts, swept.bound, sweeper.lister.tree(swept.piece));
      // What loses more than that is of no use in any later sweep either.
      const double enough = std::max(swept.left, most_loss_) - above;
      raised_->fit(raised_->none(), sweeper.parts, enough, sweeper.raise);
      swept.loss = std::max(swept.loss, above + sweeper.raise.sum());
    }
    if (swept.loss > swept.left || swept.has_list) {
      swept.cuts_end = into.cuts.size();
      continue;
    }
    sweeper.lister.list(swept.piece, swept.bound, std::max(swept.left, most_loss_), sweeper.listed,
                        stop);
    swept.listed = true;
    swept.complete = sweeper.listed.complete;
    swept.skipped = sweeper.listed.skipped;
    swept.looks = sweeper.listed.looks;
    into.cuts.insert(into.cuts.end(), sweeper.listed.cuts.begin(), sweeper.listed.cuts.end());
    add_hashes(sweeper.listed.cuts, into.hashes);
    swept.cuts_end = into.cuts.size();
  }
}

/// Takes in what was found of some pieces.
template <std::size_t kWords>
void AndOrSearch<kWords>::take_batch(std::size_t parts, std::span<const Swept> pieces,
                                     const Batch& batch) {
  std::size_t begin = 0;
  for (const Swept& swept : pieces) {
    const std::span cuts = std::span(batch.cuts).subspan(begin, swept.cuts_end - begin);
    const std::span hashes = std::span(batch.hashes).subspan(2 * begin, 2 * cuts.size());
    begin = swept.cuts_end;
    loss_[swept.number] = swept.loss;
    lists_[swept.number].looked_at = true;
    if (swept.loss > swept.left) continue;
    if (++visits_ % 4096 == 0) poll();
    if (swept.listed) {
      count_listed(swept.looks);
      if (must_stop()) return;
      if (!keep_cuts(swept.number, std::max(swept.left, most_loss_), cuts, hashes, swept.skipped,
                     swept.complete)) {
        sweeps_ = false;
        return;
      }
      left_.resize(memo_.size(), -kInfinity);
    }
    layers_[parts].push_back(swept.number);
    for_each_kept(lists_[swept.number], [&](std::uint64_t i) {
      const StoredCut& cut = stored_[i];
      const double left = swept.left - estimate(cut);
      if (left < 0) return;
      ++result_.statistics.generated;
      for (const std::uint32_t side : {cut.side, cut.rest}) {
        if (exact_[side] != 0) continue;
        if (left_[side] == -kInfinity) layers_[set_of(side).size()].push_back(side);
        left_[side] = std::max(left_[side], left + loss_[side]);
      }
    });
  }
}

/// The loss of a piece from those of the sides of its cuts, all within what it may lose.
template <std::size_t kWords>
void AndOrSearch<kWords>::settle_swept(std::uint32_t number) {
  const StoredCuts& list = lists_[number];
  double best = kInfinity;
  double next = list.skipped;
  for_each_kept(list, [&](std::uint64_t i) {
    double& least = solved(stored_[i]) ? best : next;
    least = std::min(least, estimate(stored_[i]));
  });
  const double left = left_[number];
  const bool is_best = best <= left || best <= next + slack(scale_);
  static_cast<void>(settled_loss(number, left, is_best ? best : kInfinity, next));
}

template double AndOrSearch<1>::sweep(std::uint32_t, double);
template double AndOrSearch<2>::sweep(std::uint32_t, double);
template double AndOrSearch<4>::sweep(std::uint32_t, double);
template double AndOrSearch<8>::sweep(std::uint32_t, double);
template double AndOrSearch<16>::sweep(std::uint32_t, double);

}  // namespace orasp::detail
