#include "orasp/learning/cut_outlook.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "orasp/model/detail/rules.h"
#include "orasp/model/tolerance.h"

namespace orasp {

CutOutlook::CutOutlook(const TransitionSystem& system, std::shared_ptr<const PieceGains> gains)
    : system_(system), gains_(std::move(gains)), expander_(system) {
  known_ = !system.wide() && system.takes_apart() && system.sees_piece_only() && gains_->known() &&
           (gains_->sizes_known() || gains_->parts_known()) && !gains_->has_units() &&
           system.kept().empty();
  mark_.resize(system.problem().num_parts());
}

double CutOutlook::bound_of(std::span<const PartIndex> piece) const {
  if (piece.size() < 2) return 0;
  double bound = kInfinity;
  if (gains_->sizes_known()) bound = gains_->by_size(piece.size());
  if (gains_->parts_known()) bound = std::min(bound, gains_->by_parts(piece));
  return bound;
}

std::span<const CutOutlook::Step> CutOutlook::look(SetView open, std::span<const Action> actions) {
  steps_.assign(actions.size(), {});
  if (!known_) return steps_;
  present_ = system_.present(open);
  const auto& most = system_.problem().limits().max_subassemblies;
  const std::size_t pieces = system_.subassemblies(present_.view());
  may_part_ = !most ? std::numeric_limits<std::size_t>::max()
                    : static_cast<std::size_t>(*most) - std::min<std::size_t>(*most, pieces);
  by_connection_.assign(system_.num_connections(), {});
  std::vector<std::vector<PartIndex>> all;
  system_.rules().graph.for_each_piece(present_.view(), [&](std::span<const PartIndex> piece) {
    if (piece.size() > 1) all.emplace_back(piece.begin(), piece.end());
  });
  for (const std::vector<PartIndex>& piece : all) look_at_piece(piece);
  for (std::size_t i = 0; i < actions.size(); ++i)
    steps_[i] = by_connection_[actions[i].connection];
  return steps_;
}

void CutOutlook::look_at_piece(std::span<const PartIndex> piece) {
  const auto& graph = system_.rules().graph;
  cuts_.clear();
  held_.clear();
  of_piece_ = bound_of(piece);
  slack_ = kRewardTolerance * std::max(1.0, std::abs(of_piece_));
  std::vector<PartIndex> near;
  const auto neighbours = [&](PartIndex p) {
    near.clear();
    for (const auto& half : graph.around(p)) {
      // Two parts may have several connections, and a part one to itself.
      if (half.other != p && contains(present_.view(), half.connection) &&
          std::ranges::find(near, half.other) == near.end())
        near.push_back(half.other);
    }
  };
  const auto joined = [&](PartIndex p, PartIndex q) {
    return std::ranges::any_of(graph.around(p), [&](const auto& half) {
      return half.other == q && contains(present_.view(), half.connection);
    });
  };
  for (const PartIndex p : piece) {
    look_at_set(piece, std::array{p});
    neighbours(p);
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (p < near[i]) look_at_set(piece, std::array{p, near[i]});
      for (std::size_t j = 0; j < i; ++j) {
        if (joined(near[i], near[j]) && (near[i] < p || near[j] < p)) continue;
        look_at_set(piece, std::array{p, near[i], near[j]});
      }
    }
  }
  const Cut* best = nullptr;
  const auto before = [&](double loss, std::size_t left, double other, std::size_t other_left) {
    if (std::abs(loss - other) > slack_) return loss < other;
    return left < other_left;
  };
  for (const Cut& cut : cuts_) {
    if (best == nullptr || before(cut.loss, cut.left, best->loss, best->left)) best = &cut;
    for (std::size_t k = 0; k < cut.left; ++k) {
      Step& step = by_connection_[held_[cut.first_held + k]];
      if (step.known && !before(cut.loss, cut.left, step.loss, step.left)) continue;
      step = {true, cut.loss, cut.left, false};
    }
  }
  if (best == nullptr) return;
  for (std::size_t k = 0; k < best->left; ++k)
    by_connection_[held_[best->first_held + k]].holds_best = true;
}

void CutOutlook::look_at_set(std::span<const PartIndex> piece, std::span<const PartIndex> set) {
  if (set.size() >= piece.size()) return;
  if (set.size() > 1 && piece.size() - set.size() > 1 && may_part_ == 0) return;
  const auto& graph = system_.rules().graph;
  const auto in_set = [&](PartIndex p) { return std::ranges::find(set, p) != set.end(); };
  // What holds it, and whether the rest hangs together.
  const std::size_t first_held = held_.size();
  round_ += 1;
  for (const PartIndex p : set) mark_[p] = round_;
  order_.clear();
  for (const PartIndex p : set) {
    for (const auto& half : graph.around(p)) {
      if (!contains(present_.view(), half.connection) || in_set(half.other)) continue;
      held_.push_back(half.connection);
      if (order_.empty()) {
        order_.push_back(half.other);
        mark_[half.other] = round_;
      }
    }
  }
  for (std::size_t i = 0; i < order_.size(); ++i) {
    for (const auto& half : graph.around(order_[i])) {
      if (mark_[half.other] == round_ || !contains(present_.view(), half.connection)) continue;
      mark_[half.other] = round_;
      order_.push_back(half.other);
    }
  }
  std::optional<double> gain;
  if (order_.size() + set.size() == piece.size()) {
    const ConnectionIndex last = held_.back();
    const bool in_order = in_set(system_.problem().ends(last)[0]);
    gain = in_order ? expander_.cut_gain(set, order_, last) : expander_.cut_gain(order_, set, last);
  }
  if (!gain) {
    held_.resize(first_held);
    return;
  }
  const double loss = of_piece_ - *gain - bound_of(set) - bound_of(order_);
  cuts_.push_back({std::max(loss, 0.0), held_.size() - first_held, first_held});
}

}  // namespace orasp
