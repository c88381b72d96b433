#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "orasp/bounds/piece_bound.h"
#include "orasp/learning/cut_outlook.h"
#include "orasp/learning/piece_outlook.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// What the graph network sees of a state. Every feature is relative (to the whole, to the best
/// legal step), so that products of any size look alike.
struct GraphState {
  static constexpr std::size_t kPartFeatures = 11;
  static constexpr std::size_t kActionFeatures = 35;

  /// Shape [parts, kPartFeatures].
  std::vector<float> parts;
  /// Shape [actions, kActionFeatures].
  std::vector<float> actions;
  /// The two parts of each action's connection.
  std::vector<std::array<std::uint32_t, 2>> ends;
  /// Neighbours of part p: `to` from begin[p] to begin[p + 1].
  struct Edges {
    std::vector<std::uint32_t> begin;
    std::vector<std::uint32_t> to;
  };
  /// By connections that are there.
  Edges connected;
  /// By blocking, either way, between parts of one piece.
  Edges blocking;

  [[nodiscard]] std::size_t num_parts() const { return parts.size() / kPartFeatures; }
  [[nodiscard]] std::size_t num_actions() const { return ends.size(); }
};

/// Describes states of one problem to the network. Holds scratch memory: one for each thread.
class GraphObserver {
 public:
  /// The system must outlive it; it must not be wide().
  explicit GraphObserver(const TransitionSystem& system);
  explicit GraphObserver(const TransitionSystem&&) = delete;

  /// The state `open`, whose legal actions these are. What steps separate and what can be earned
  /// next comes from the Expander. O(actions * (parts + connections)).
  [[nodiscard]] GraphState observe(SetView open, std::span<const Action> actions);

 private:
  [[nodiscard]] std::vector<CutOutlook::Step> cuts_of(SetView open,
                                                      std::span<const Action> actions);

  const TransitionSystem& system_;
  Expander expander_;
  PieceOutlook outlook_;
  PieceBound bound_;
  CutOutlook cuts_;
  /// What losses are measured in: about what a step earns.
  double unit_ = 1;
  double total_mass_ = 0;
  double scale_ = 0;
  std::vector<float> degrees_;
  std::vector<std::uint64_t> free_;
};

}  // namespace orasp
