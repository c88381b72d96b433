#include <bit>
#include <cmath>

#include "orasp/model/random.h"
#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// The cuts of a plan as trees: joints in the opposite order put its pieces together two at a time.
/// Empty where a cut of it is none that the search knows as legal.
template <std::size_t kWords>
auto AndOrSearch<kWords>::trees_of(std::span<const ConnectionIndex> plan) -> std::vector<CutNode> {
  std::vector<CutNode> nodes;
  std::vector<std::uint32_t> node_of_part(problem_.num_parts());
  for (std::size_t part = 0; part < node_of_part.size(); ++part) {
    Set leaf;
    leaf.insert(part);
    nodes.push_back({.piece = bounded(leaf)});
    node_of_part[part] = static_cast<std::uint32_t>(part);
  }
  for (std::size_t i = plan.size(); i-- > 0;) {
    const auto [u, v] = problem_.ends(plan[i]);
    const std::uint32_t a = node_of_part[u];
    const std::uint32_t b = node_of_part[v];
    if (a == b) continue;
    CutNode joint{
        .piece = bounded(nodes[a].piece.set | nodes[b].piece.set), .first = a, .second = b};
    const std::optional<double> loss = loss_of_cut(joint.piece, nodes[a].piece, nodes[b].piece);
    if (!loss) return {};
    joint.loss = *loss;
    joint.piece.set.for_each(
        [&](std::size_t part) { node_of_part[part] = static_cast<std::uint32_t>(nodes.size()); });
    nodes.push_back(joint);
  }
  return nodes;
}

/// By how much a cut alone stays below the bound of the piece; empty where it cannot be legal.
template <std::size_t kWords>
std::optional<double> AndOrSearch<kWords>::loss_of_cut(const BoundedSet& piece,
                                                       const BoundedSet& side,
                                                       const BoundedSet& rest) {
  if (std::min(side.set.size(), rest.set.size()) > gains_.most_moved()) return std::nullopt;
  ++looks_;
  const std::optional<double> gain = lister_.gain_of_any(piece.set, side.set, rest.set);
  if (!gain) return std::nullopt;
  const double loss = piece.bound - *gain - side.bound - rest.bound;
  return std::isfinite(loss) ? std::optional(loss) : std::nullopt;
}

/// A way down a plan's trees, to a cut: one that loses something, the more the likelier, from some
/// pieces above it, or any one.
template <std::size_t kWords>
auto AndOrSearch<kWords>::draw_path(const std::vector<CutNode>& nodes,
                                    const std::vector<std::uint32_t>& roots, SplitMix64& random)
    -> std::vector<std::uint32_t> {
  constexpr std::uint64_t kMostAbove = 5;
  double lost = 0;
  for (const CutNode& node : nodes) lost += std::max(node.loss, 0.0);
  if (!bounded_ || lost <= slack(scale_) || random.below(3) == 0)
    return {roots[random.below(roots.size())]};
  std::vector<std::uint32_t> above(nodes.size(), kNone);
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].first == kNone) continue;
    above[nodes[i].first] = i;
    above[nodes[i].second] = i;
  }
  double draw = random.uniform() * lost;
  std::uint32_t at = roots.back();
  for (std::uint32_t i = 0; i < nodes.size() && draw >= 0; ++i) {
    if (nodes[i].loss <= 0) continue;
    at = i;
    draw -= nodes[i].loss;
  }
  std::vector<std::uint32_t> path = {at};
  for (std::uint64_t up = random.below(kMostAbove + 1); up > 0 && above[path.back()] != kNone; --up)
    path.push_back(above[path.back()]);
  std::ranges::reverse(path);
  return path;
}

/// The first piece of `path` with at most `most_atoms` pieces below it, those at the end of the
/// path and others at random.
template <std::size_t kWords>
auto AndOrSearch<kWords>::open_window(const std::vector<CutNode>& nodes,
                                      const std::vector<std::uint32_t>& path,
                                      std::size_t most_atoms, SplitMix64& random) -> Window {
  Window window{.atoms = {path.front()}, .inner = {}, .loss = 0};
  std::vector<std::size_t> open;  // places of the atoms that are cut further
  while (window.atoms.size() < most_atoms) {
    open.clear();
    for (std::size_t i = 0; i < window.atoms.size(); ++i) {
      if (nodes[window.atoms[i]].first != kNone) open.push_back(i);
    }
    if (open.empty()) break;
    const std::size_t depth = window.inner.size();
    const std::size_t place =
        depth < path.size()
            ? static_cast<std::size_t>(std::ranges::find(window.atoms, path[depth]) -
                                       window.atoms.begin())
            : open[random.below(open.size())];
    const std::uint32_t opened = window.atoms[place];
    window.loss += nodes[opened].loss;
    window.inner.push_back(opened);
    window.atoms[place] = nodes[opened].first;
    window.atoms.push_back(nodes[opened].second);
  }
  return window;
}

/// Whether some atoms, by their bits, hang together. `beside` has the neighbours of each.
inline bool hang_together(std::uint32_t group, const std::vector<std::uint32_t>& beside) {
  std::uint32_t reached = group & (0 - group);
  for (std::uint32_t front = reached; front != 0;) {
    std::uint32_t next = 0;
    for (; front != 0; front &= front - 1)
      next |= beside[static_cast<std::size_t>(std::countr_zero(front))];
    front = next & group & ~reached;
    reached |= front;
  }
  return reached == group;
}

/// How each group of a window's atoms, by their bits, is best cut down to these; with `any_way` in
/// any way. Groups that lose more than the window did may be left out, and larger ones where the
/// budget is spent on the way.
template <std::size_t kWords>
auto AndOrSearch<kWords>::cut_groups(const std::vector<CutNode>& nodes, const Window& window,
                                     bool any_way, SplitMix64& random) -> std::vector<Group> {
  const std::size_t atoms = window.atoms.size();
  std::vector<Group> groups(std::size_t{1} << atoms);
  std::vector<std::uint32_t> beside(atoms);
  for (std::size_t i = 0; i < atoms; ++i) {
    const BoundedSet& piece = nodes[window.atoms[i]].piece;
    groups[std::size_t{1} << i] = {.piece = piece, .loss = 0};
    Set around;
    piece.set.for_each([&](std::size_t part) { around = around | links_.neighbours[part]; });
    for (std::size_t k = 0; k < atoms; ++k) {
      if (k != i && !(around & nodes[window.atoms[k]].piece.set).empty()) beside[i] |= 1U << k;
    }
  }
  // No cut loses less than nothing where there is a bound.
  const double same = slack(scale_);
  const bool prunes = bounded_ && !any_way;
  const double most = prunes ? window.loss + same : kInfinity;
  for (std::uint32_t group = 1; group < groups.size(); ++group) {
    if (std::has_single_bit(group)) continue;
    if (result_.stop != Stop::None) break;
    Group& whole = groups[group];
    const std::uint32_t lowest = group & (0 - group);
    whole.piece.set = groups[lowest].piece.set | groups[group ^ lowest].piece.set;
    if (!hang_together(group, beside)) continue;
    whole.piece = bounded(whole.piece.set);
    std::uint64_t as_good = 0;
    for (std::uint32_t rest = (group - 1) & group; rest != 0; rest = (rest - 1) & group) {
      if ((rest & lowest) != 0) continue;
      const std::uint32_t side = group ^ rest;
      const double allowed = any_way ? kInfinity : std::min(most, whole.loss + same);
      const double below = groups[side].loss + groups[rest].loss;
      if (below == kInfinity || (prunes && below > allowed)) continue;
      const auto own = loss_of_cut(whole.piece, groups[side].piece, groups[rest].piece);
      if (looks_ % 4096 == 0) poll();
      if (!own || *own + below > allowed) continue;
      as_good = !any_way && *own + below < whole.loss - same ? 1 : as_good + 1;
      if (as_good > 1 && random.below(as_good) != 0) continue;
      whole.loss = *own + below;
      whole.side = side;
    }
  }
  return groups;
}

/// Cuts a window of a plan anew in the best way there is, of several that are as good any, or in
/// any way. Returns how much less is lost.
template <std::size_t kWords>
double AndOrSearch<kWords>::recut_window(std::vector<CutNode>& nodes, const Window& window,
                                         bool any_way, SplitMix64& random) {
  if (window.atoms.size() < 3) return 0;
  const std::vector<Group> groups = cut_groups(nodes, window, any_way, random);
  const double loss = groups.back().loss;
  if (loss == kInfinity || (!any_way && loss > window.loss + slack(scale_))) return 0;
  std::size_t used = 1;
  const auto all = static_cast<std::uint32_t>(groups.size() - 1);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> waiting = {{all, window.inner.front()}};
  while (!waiting.empty()) {
    const auto [group, number] = waiting.back();
    waiting.pop_back();
    const auto node_of_group = [&](std::uint32_t part) {
      if (std::has_single_bit(part))
        return window.atoms[static_cast<std::size_t>(std::countr_zero(part))];
      waiting.emplace_back(part, window.inner[used]);
      return window.inner[used++];
    };
    const std::uint32_t side = groups[group].side;
    const std::uint32_t rest = group ^ side;
    const double own = groups[group].loss - groups[side].loss - groups[rest].loss;
    const std::uint32_t first = node_of_group(side);
    const std::uint32_t second = node_of_group(rest);
    nodes[number] = {.piece = groups[group].piece, .first = first, .second = second, .loss = own};
  }
  return window.loss - loss;
}

template <std::size_t kWords>
bool AndOrSearch<kWords>::recut(std::span<const ConnectionIndex> plan, std::uint64_t most_looks,
                                std::uint64_t draw) {
  // Few pieces, where the best way is found at once, more often than many.
  constexpr std::size_t kFewAtoms = 6;
  constexpr std::size_t kMostAtoms = 12;
  constexpr std::uint64_t kMostDoublings = 6;
  // What a window takes beside its cuts.
  constexpr std::uint64_t kLooksOfWindow = 100;
  peeled_.clear();
  if (limited_) return false;
  lift_limits();
  find_pieces();
  scale_ = 0;
  for (const Set& piece : pieces_) scale_ = std::max(scale_, std::abs(upper(piece, piece.size())));
  std::vector<CutNode> nodes = trees_of(plan);
  std::vector<std::uint32_t> roots;
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].piece.set.size() > 2) roots.push_back(i);
  }
  if (roots.empty()) return false;
  SplitMix64 random(draw);
  const std::uint64_t end = looks_ + most_looks;
  const auto is_over = [&] { return looks_ >= end || result_.stop != Stop::None; };
  const auto window = [&](std::size_t most_atoms, bool any_way) {
    looks_ += kLooksOfWindow;
    poll();
    const Window drawn = open_window(nodes, draw_path(nodes, roots, random), most_atoms, random);
    return recut_window(nodes, drawn, any_way, random);
  };
  // Until as many windows in a row as there are pieces have brought nothing.
  const auto descend = [&] {
    constexpr std::size_t kRange = kMostAtoms - kFewAtoms + 1;
    double gained = 0;
    for (std::size_t idle = 0; idle < roots.size() && !is_over(); ++idle) {
      const std::size_t extra = std::min(random.below(kRange), random.below(kRange));
      const double less = window(kFewAtoms + extra, false);
      if (less > slack(scale_)) idle = 0;
      gained += less;
    }
    return gained;
  };
  double gained = descend();
  std::vector<CutNode> best = nodes;
  while (!is_over()) {
    double more = 0;
    const std::uint64_t windows = std::uint64_t{1} << random.below(kMostDoublings);
    for (std::uint64_t i = 0; i < windows && !is_over(); ++i) more += window(kFewAtoms, true);
    more += descend();
    if (more >= -slack(scale_)) {
      gained += more;
      best = nodes;
    } else {
      nodes = best;
    }
  }
  if (!(gained > slack(scale_))) return false;
  for (const CutNode& node : best) {
    if (node.first != kNone) peeled_.emplace_back(node.piece.set, best[node.first].piece.set);
  }
  return true;
}

template bool AndOrSearch<1>::recut(std::span<const ConnectionIndex>, std::uint64_t, std::uint64_t);
template bool AndOrSearch<2>::recut(std::span<const ConnectionIndex>, std::uint64_t, std::uint64_t);
template bool AndOrSearch<4>::recut(std::span<const ConnectionIndex>, std::uint64_t, std::uint64_t);
template bool AndOrSearch<8>::recut(std::span<const ConnectionIndex>, std::uint64_t, std::uint64_t);
template bool AndOrSearch<16>::recut(std::span<const ConnectionIndex>, std::uint64_t,
                                     std::uint64_t);

}  // namespace orasp::detail
