#include "orasp/certificate/detail/piece_proof.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

#include "orasp/certificate/detail/outward.h"
#include "orasp/certificate/detail/piece_bound.h"
#include "orasp/certificate/detail/piece_cuts.h"
#include "orasp/certificate/detail/piece_values.h"
#include "orasp/model/tolerance.h"

namespace orasp::detail {

namespace {

using Side = PieceCuts::Side;

/// Sums of a thousand numbers lose less, relatively.
constexpr double kMargin = 1e-12;

class PieceProver {
 public:
  PieceProver(const Problem& problem, const SizeRewards& rewards, const std::vector<double>& sizes,
              const std::function<bool()>& stop)
      : problem_(problem),
        rewards_(rewards),
        sizes_(sizes),
        stop_(stop),
        cuts_(problem),
        values_(problem, rewards, sizes) {}

  PieceProof run(double wanted) {
    PieceProof proof;
    lose_what_is_missing(wanted);
    if (!given_up_) write(proof.pieces);
    if (given_up_) {
      proof.pieces.clear();
      proof.reason = stopped_ ? "it was stopped"
                              : "pieces have more than " + std::to_string(kMostCertifiedCuts) +
                                    " cuts to look at";
    }
    return proof;
  }

 private:
  struct Known {
    Side parts;
    std::size_t allowed;
    double loss;
    bool exact;
  };
  struct Cut {
    double own;  ///< what it loses itself
    Side a;
    Side b;
  };

  // Each way in which a plan can go, as sets of pieces that are to lose together what is missing.
  void lose_what_is_missing(double wanted) {
    for (const PieceGroup& group : piece_groups(problem_, rewards_, values_, cuts_)) {
      double missing = group.bound - wanted;
      if (!(missing > 0)) continue;  // what is -infinity is proved
      // A little more, since every sum of the proof is rounded up.
      if (std::isfinite(missing)) missing += kMargin * (1 + std::abs(group.bound));
      for (const auto& [parts, allowed] : group.pieces) {
        if (!(missing > 0) || given_up_) break;
        missing -= least_loss(parts, allowed, missing);
      }
    }
  }

  /// The least loss of a piece, or `limit` where that is no more.
  double least_loss(const Side& piece, std::size_t allowed, double limit) {
    const std::size_t parts = piece.size();
    if (parts < 2) return 0;
    if (sizes_[parts] == -kInfinity || (values_.limited() && allowed == 0)) return limit;
    const PieceValues::Key key = values_.key(piece, allowed);
    if (const auto found = known_.find(key); found != known_.end()) {
      const Known& known = all_[found->second];
      if (known.exact || known.loss >= limit) return std::min(known.loss, limit);
    }
    std::vector<Cut> cuts;
    std::vector<bool> wanted(parts / 2 + 1, false);
    for (std::size_t a = 1; a <= parts / 2; ++a) wanted[a] = own_loss(a, parts - a) < limit;
    const bool all =
        cuts_.for_each(piece, wanted, kMostCertifiedCuts, [&](const Side& a, const Side& b) {
          cuts.push_back({own_loss(a.size(), b.size(), values_.cut(a, b)), a, b});
          return !(cuts.size() % 1024 == 0 && stop_());
        });
    if (!all) give_up();
    std::ranges::stable_sort(cuts, {}, &Cut::own);
    double best = limit;
    for (const Cut& cut : cuts) {
      if (given_up_ || cut.own >= best) break;
      for (const auto& half : values_.halves(cut.a.size(), cut.b.size(), allowed)) {
        double loss = cut.own + least_loss(cut.a, half.a, best - cut.own);
        if (loss < best) loss += least_loss(cut.b, half.b, best - loss);
        best = std::min(best, loss);
      }
    }
    if (given_up_) return 0;
    const auto [found, is_new] = known_.emplace(key, all_.size());
    if (is_new) all_.push_back({piece, values_.useful(allowed, parts), 0, false});
    all_[found->second].loss = best;
    all_[found->second].exact = best < limit;
    if (all_.size() > kMostCertifiedPieces || (all_.size() % 256 == 0 && stop_())) give_up();
    return best;
  }

  [[nodiscard]] double own_loss(std::size_t a, std::size_t b) const {
    return own_loss(a, b, values_.cut(a, b));
  }
  // What rounding makes of a cut that loses nothing is nothing.
  [[nodiscard]] double own_loss(std::size_t a, std::size_t b, double gain) const {
    const double loss = sizes_[a + b] - gain - sizes_[a] - sizes_[b];
    const double scale =
        std::abs(sizes_[a + b]) + std::abs(gain) + std::abs(sizes_[a]) + std::abs(sizes_[b]);
    return loss < 1e-14 * scale ? 0 : loss;
  }

  void give_up() {
    given_up_ = true;
    stopped_ = stopped_ || stop_();
  }

  // The value of each piece that loses something, from the smallest to the largest: what its cuts
  // are worth by the values of their sides, every sum rounded up. Then those that the proof of the
  // product refers to.
  void write(std::vector<Certificate::Piece>& pieces) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (all_[i].loss > 0) order.push_back(i);
    }
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return all_[i].parts.size(); });
    // A new count of what is looked at.
    PieceCuts cuts(problem_);
    std::unordered_map<PieceValues::Key, std::size_t> places;
    std::vector<double> value(all_.size(), kInfinity);
    std::vector<std::vector<std::size_t>> uses(all_.size());
    for (const std::size_t i : order) {
      const Known& known = all_[i];
      const double by_size = sizes_[known.parts.size()];
      // As much as was proved, and no less: what is lower asks for more.
      double most = by_size - known.loss;
      if (std::isfinite(most)) most += 1e-14 * (std::abs(by_size) + std::abs(known.loss));
      const auto above = values_.sizes_above(known.parts.size(), most);
      const auto use = [&](const Side& side, std::size_t allowed) {
        if (side.size() < 2) return;
        if (const auto found = places.find(values_.key(side, allowed)); found != places.end())
          uses[i].push_back(found->second);
      };
      const bool all =
          cuts.for_each(known.parts, above, kMostCertifiedCuts, [&](const Side& a, const Side& b) {
            most = std::max(most, add_up(values_.cut(a, b), values_.of_both(a, b, known.allowed)));
            for (const auto& half : values_.halves(a.size(), b.size(), known.allowed)) {
              use(a, half.a);
              use(b, half.b);
            }
            return true;
          });
      if (!all) return give_up();
      if (most >= by_size) continue;
      value[i] = most;
      values_.list(known.parts, known.allowed, most);
      places.emplace(values_.key(known.parts, known.allowed), i);
    }
    std::vector<bool> used(all_.size(), false);
    std::vector<std::size_t> queue;
    const auto meet = [&](std::size_t i) {
      if (used[i]) return;
      used[i] = true;
      queue.push_back(i);
    };
    for (const PieceGroup& group : piece_groups(problem_, rewards_, values_, cuts)) {
      for (const auto& [parts, allowed] : group.pieces) {
        if (parts.size() < 2) continue;
        if (const auto found = places.find(values_.key(parts, allowed)); found != places.end())
          meet(found->second);
      }
    }
    for (std::size_t k = 0; k < queue.size(); ++k) {
      for (const std::size_t i : uses[queue[k]]) meet(i);
    }
    for (const std::size_t i : order) {
      if (used[i]) pieces.push_back({all_[i].parts, all_[i].allowed, value[i]});
    }
  }

  const Problem& problem_;
  const SizeRewards& rewards_;
  const std::vector<double>& sizes_;
  const std::function<bool()>& stop_;
  PieceCuts cuts_;
  PieceValues values_;
  std::vector<Known> all_;
  std::unordered_map<PieceValues::Key, std::size_t> known_;
  bool given_up_ = false;
  bool stopped_ = false;
};

}  // namespace

PieceProof prove_by_pieces(const Problem& problem, const SizeRewards& rewards,
                           const std::vector<double>& sizes, double wanted,
                           const std::function<bool()>& stop) {
  return PieceProver(problem, rewards, sizes, stop).run(wanted);
}

}  // namespace orasp::detail
