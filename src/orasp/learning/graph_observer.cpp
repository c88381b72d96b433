#include "orasp/learning/graph_observer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace orasp {

namespace {

constexpr std::size_t kPart = GraphState::kPartFeatures;
constexpr std::size_t kAction = GraphState::kActionFeatures;
constexpr double kLeastLoss = 1e-6;  // beyond rounding

GraphState::Edges edges_of(std::size_t parts,
                           const std::vector<std::array<std::uint32_t, 2>>& pairs) {
  GraphState::Edges edges;
  edges.begin.assign(parts + 1, 0);
  for (const auto& [a, b] : pairs) {
    ++edges.begin[a + 1];
    ++edges.begin[b + 1];
  }
  for (std::size_t p = 0; p < parts; ++p) edges.begin[p + 1] += edges.begin[p];
  edges.to.resize(2 * pairs.size());
  std::vector<std::uint32_t> next(edges.begin.begin(), edges.begin.end() - 1);
  for (const auto& [a, b] : pairs) {
    edges.to[next[a]++] = b;
    edges.to[next[b]++] = a;
  }
  return edges;
}

/// The pieces of a graph, and where in its piece each part stands between two far ends.
struct Pieces {
  std::vector<std::uint32_t> piece;
  std::vector<std::uint32_t> size;  // of each part's piece
  /// From 0 (one end) to 1 (the other), by distance from the one less that from the other.
  std::vector<float> rank;
};

/// Visits the piece of `from` in breadth; writes distances. @returns the parts in that order.
std::vector<std::uint32_t> breadth_first(const GraphState::Edges& edges, std::uint32_t from,
                                         std::vector<std::int32_t>& distance) {
  std::vector<std::uint32_t> order = {from};
  distance[from] = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint32_t p = order[i];
    for (std::size_t e = edges.begin[p]; e < edges.begin[p + 1]; ++e) {
      const std::uint32_t q = edges.to[e];
      if (distance[q] >= 0) continue;
      distance[q] = distance[p] + 1;
      order.push_back(q);
    }
  }
  return order;
}

Pieces pieces_of(const GraphState::Edges& edges) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const std::size_t parts = edges.begin.size() - 1;
  Pieces pieces;
  pieces.piece.assign(parts, kNone);
  pieces.size.assign(parts, 0);
  pieces.rank.assign(parts, 0.5F);
  std::vector<std::int32_t> any(parts, -1);
  std::vector<std::int32_t> one(parts, -1);
  std::vector<std::int32_t> other(parts, -1);
  for (std::uint32_t p = 0; p < parts; ++p) {
    if (pieces.piece[p] != kNone) continue;
    std::vector<std::uint32_t> order = breadth_first(edges, p, any);
    const std::uint32_t end = breadth_first(edges, order.back(), one).back();
    static_cast<void>(breadth_first(edges, end, other));
    for (const std::uint32_t q : order) {
      pieces.piece[q] = p;
      pieces.size[q] = static_cast<std::uint32_t>(order.size());
    }
    std::ranges::stable_sort(order, {},
                             [&](std::uint32_t q) { return std::pair(one[q] - other[q], q); });
    for (std::size_t i = 0; i < order.size(); ++i)
      pieces.rank[order[i]] = (static_cast<float>(i) + 0.5F) / static_cast<float>(order.size());
  }
  return pieces;
}

float ratio(double part, double whole) {
  return whole > 0 ? static_cast<float>(part / whole) : 0.0F;
}
float ratio(std::size_t part, std::size_t whole) {
  return ratio(static_cast<double>(part), static_cast<double>(whole));
}

}  // namespace

GraphObserver::GraphObserver(const TransitionSystem& system)
    : system_(system),
      expander_(system),
      outlook_(system),
      bound_(system, PieceBound::Kind::Both),
      cuts_(system, bound_.gains()),
      degrees_(system.problem().num_parts()) {
  const Problem& problem = system.problem();
  for (const Part& part : problem.parts()) total_mass_ += part.mass;
  for (std::size_t c = 0; c < problem.num_connections(); ++c) {
    for (const PartIndex p : problem.ends(static_cast<ConnectionIndex>(c))) ++degrees_[p];
  }
  for (const Action& action : expander_.legal_actions(system.start().view()))
    scale_ = std::max(scale_, std::abs(action.reward));
  if (outlook_.known()) {
    unit_ = outlook_.unit();
  } else if (bound_.known() && system.num_steps() > 0) {
    const double most = std::abs(bound_(system.start().view()));
    if (most > 0 && std::isfinite(most)) unit_ = most / static_cast<double>(system.num_steps());
  }
}

std::vector<CutOutlook::Step> GraphObserver::cuts_of(SetView open,
                                                     std::span<const Action> actions) {
  std::vector<CutOutlook::Step> cuts(actions.size());
  // Where there are quick plans they say more.
  if (!outlook_.known()) std::ranges::copy(cuts_.look(open, actions), cuts.begin());
  return cuts;
}

GraphState GraphObserver::observe(SetView open, std::span<const Action> legal) {
  const Problem& problem = system_.problem();
  const std::size_t parts = problem.num_parts();
  const std::vector<Action> actions(legal.begin(), legal.end());
  GraphState state;

  // Taking apart works on what is there, putting together on what is missing.
  const ConnectionSet present = system_.present(open);
  std::vector<std::array<std::uint32_t, 2>> pairs;
  const auto note = [&](ConnectionIndex c) {
    const auto& [a, b] = problem.ends(c);
    pairs.push_back({static_cast<std::uint32_t>(static_cast<std::size_t>(a)),
                     static_cast<std::uint32_t>(static_cast<std::size_t>(b))});
  };
  for_each_connection(present.view(), note);
  state.connected = edges_of(parts, pairs);
  const Pieces there = pieces_of(state.connected);
  Pieces ranks = there;
  if (!system_.takes_apart()) {
    pairs.clear();
    for_each_connection(open, note);
    ranks = pieces_of(edges_of(parts, pairs));
  }
  pairs.clear();
  std::vector<float> blockers(parts, 0.0F);
  std::vector<float> blocks(parts, 0.0F);
  for (std::uint32_t p = 0; p < problem.blockers().size(); ++p) {
    for (const Blocker& blocker : problem.blockers()[p]) {
      const auto q = static_cast<std::uint32_t>(static_cast<std::size_t>(blocker.by));
      if (there.piece[p] != there.piece[q]) continue;
      blockers[p] += 0.25F;
      blocks[q] += 0.25F;
      if (p < q) pairs.push_back({p, q});
    }
  }
  state.blocking = edges_of(parts, pairs);

  // In how many directions each part could leave its piece alone.
  const auto directions = static_cast<float>(std::max<std::size_t>(1, problem.directions().size()));
  const auto free_share = [&](std::size_t p) {
    if (problem.blockers().empty()) return 1.0F;
    free_.assign(problem.direction_bits().begin(), problem.direction_bits().end());
    for (const Blocker& blocker : problem.blockers()[p]) {
      const auto q = static_cast<std::size_t>(blocker.by);
      if (there.piece[p] == there.piece[q] && !problem.take_out(blocker, free_)) return 0.0F;
    }
    int left = 0;
    for (const std::uint64_t word : free_) left += std::popcount(word);
    return problem.directions().empty() ? 1.0F : static_cast<float>(left) / directions;
  };

  state.parts.reserve(parts * kPart);
  for (std::size_t p = 0; p < parts; ++p) {
    const auto degree = static_cast<float>(state.connected.begin[p + 1] - state.connected.begin[p]);
    const float mass = ratio(problem.parts()[p].mass * static_cast<double>(parts), total_mass_);
    const float free = free_share(p);
    const bool base = problem.in_base(static_cast<PartIndex>(p));
    const std::array<float, kPart> features = {
        std::min(mass, 8.0F),
        0.25F * degree,
        degrees_[p] > 0 ? degree / degrees_[p] : 0.0F,
        base ? 1.0F : 0.0F,
        there.size[p] == 1 ? 1.0F : 0.0F,
        0.125F * static_cast<float>(std::log2(there.size[p])),
        std::abs(ranks.rank[p] - 0.5F),
        std::min(blockers[p], 4.0F),
        std::min(blocks[p], 4.0F),
        free,
        free > 0 ? 1.0F : 0.0F};
    state.parts.insert(state.parts.end(), features.begin(), features.end());
  }

  // What can be earned in the step after each: the rest of the work looks a step ahead.
  std::vector<std::uint64_t> successors;
  for (const Action& action : actions) {
    const std::size_t begin = successors.size();
    successors.insert(successors.end(), open.begin(), open.end());
    const std::size_t c = action.connection;
    successors[begin + c / 64] &= ~(std::uint64_t{1} << (c % 64));
  }
  const std::size_t num_open = count(open);
  std::vector<double> ahead(actions.size());
  std::vector<bool> dead(actions.size());
  expander_.for_each_expansion(successors, [&](std::size_t i, std::span<const Action> next) {
    double most = 0;
    if (!next.empty()) most = std::ranges::max(next, {}, &Action::reward).reward;
    dead[i] = next.empty() && num_open > 1;
    ahead[i] = actions[i].reward + most;
  });
  std::vector<double> rewards;
  rewards.reserve(actions.size());
  for (const Action& action : actions) rewards.push_back(action.reward);
  const auto relative = [](const std::vector<double>& all, double value) {
    const auto [least, most] = std::ranges::minmax(all);
    return most - least > 1e-12 ? static_cast<float>((value - most) / (most - least)) : 0.0F;
  };
  // Connections that wait for others.
  std::vector<float> waiting(problem.num_connections(), 0.0F);
  for (const PrecedenceClause& clause : problem.precedence()) {
    const std::size_t w = clause.connection;
    if (((open[w / 64] >> (w % 64)) & 1U) == 0) continue;
    for (const ConnectionIndex c : clause.after) waiting[c] += 0.25F;
  }

  // How even the most even cut of each piece is.
  std::vector<Step> steps;
  std::vector<std::size_t> most_even(parts);
  const auto small_of = [](const Step& step) { return std::min(step.a.size(), step.b.size()); };
  for (const Action& action : actions) {
    steps.push_back(expander_.step(open, action.connection));
    std::size_t& most = most_even[ranks.piece[problem.ends(action.connection)[0]]];
    most = std::max(most, small_of(steps.back()));
  }
  state.actions.reserve(actions.size() * kAction);
  std::vector<bool> beside(parts);
  const std::span<const PieceOutlook::Step> outlook = outlook_.look(open, actions);
  const std::vector<CutOutlook::Step> cuts = cuts_of(open, actions);
  double least_loss = kInfinity;
  for (const CutOutlook::Step& cut : cuts) {
    if (cut.known) least_loss = std::min(least_loss, cut.loss);
  }
  // What each step loses at least.
  std::vector<double> bounds;
  double here = 0;
  if (bound_.known()) {
    bounds.resize(actions.size());
    here = bound_(open);
    bound_.of_successors(open, here, actions, bounds);
  }
  const auto in_units = [&](double loss) {
    return static_cast<float>(std::min(loss / unit_, 4.0));
  };
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    const Step& step = steps[i];
    const auto p = static_cast<std::size_t>(problem.ends(c)[0]);
    const auto q = static_cast<std::size_t>(problem.ends(c)[1]);
    state.ends.push_back({static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(q)});
    const auto neighbours = [&](std::size_t part) {
      return std::span(state.connected.to)
          .subspan(state.connected.begin[part],
                   state.connected.begin[part + 1] - state.connected.begin[part]);
    };
    std::size_t triangles = 0;
    for (const std::uint32_t n : neighbours(p)) beside[n] = true;
    for (const std::uint32_t n : neighbours(q)) triangles += beside[n] ? 1U : 0U;
    for (const std::uint32_t n : neighbours(p)) beside[n] = false;
    const std::size_t small = small_of(step);
    const std::size_t most = most_even[ranks.piece[p]];
    const std::size_t large = std::max(step.a.size(), step.b.size());
    const float one = ranks.rank[p];
    const float other = ranks.rank[q];
    const double by_bound = bounds.empty() ? 0.0 : here - actions[i].reward - bounds[i];
    const float next = relative(ahead, ahead[i]);
    const float now = relative(rewards, actions[i].reward);
    const std::array<float, kAction> features = {
        now,
        now == 0 ? 1.0F : 0.0F,
        std::clamp(ratio(actions[i].reward, scale_), -4.0F, 4.0F),
        step.separates ? 1.0F : 0.0F,
        ratio(small, most),
        step.separates && small == most ? 1.0F : 0.0F,
        ratio(small, small + large),
        ratio(step.moved_mass, step.moved_mass + step.kept_mass),
        small == 1 ? 1.0F : 0.0F,
        0.125F * static_cast<float>(std::log2(ranks.size[p])),
        (one < 0.5F) != (other < 0.5F) ? 1.0F : 0.0F,
        std::abs(0.5F * (one + other) - 0.5F),
        ratio(num_open, problem.num_connections()),
        std::min(waiting[c], 4.0F),
        0.25F * static_cast<float>(std::min(neighbours(p).size(), neighbours(q).size())),
        step.completes ? 1.0F : 0.0F,
        0.25F * static_cast<float>(triangles),
        0.125F * static_cast<float>(std::log2(1 + large)),
        0.125F * static_cast<float>(std::log2(1 + small)),
        next,
        next == 0 ? 1.0F : 0.0F,
        dead[i] ? 1.0F : 0.0F,
        outlook[i].known ? 1.0F : 0.0F,
        in_units(std::max(by_bound, 0.0)),
        by_bound > kLeastLoss * unit_ ? 1.0F : 0.0F,
        in_units(outlook[i].loss),
        outlook[i].loss > kLeastLoss * unit_ ? 1.0F : 0.0F,
        std::isfinite(outlook[i].loss) ? 0.0F : 1.0F,
        outlook[i].at_bound ? 1.0F : 0.0F,
        cuts[i].known ? 1.0F : 0.0F,
        cuts[i].known ? in_units(cuts[i].loss) : 0.0F,
        cuts[i].known && cuts[i].loss <= kLeastLoss * unit_ ? 1.0F : 0.0F,
        cuts[i].known ? in_units(cuts[i].loss - least_loss) : 0.0F,
        cuts[i].known ? ratio(1, cuts[i].left) : 0.0F,
        cuts[i].holds_best ? 1.0F : 0.0F};
    state.actions.insert(state.actions.end(), features.begin(), features.end());
  }
  return state;
}

}  // namespace orasp
