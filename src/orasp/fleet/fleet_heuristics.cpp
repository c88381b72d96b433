#include "orasp/fleet/fleet_heuristics.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "orasp/fleet/fleet_validate.h"

namespace orasp {
namespace {

constexpr PartIndex kNone = std::numeric_limits<PartIndex>::max();

struct Neighbour {
  PartIndex part;
  ConnectionIndex by;
};

/// The product as it stands: its open connections and pieces.
class Forest {
 public:
  /// @throws InputError where a connection closes a cycle.
  Forest(const FleetProblem& fleet, std::string_view method) : neighbours_(fleet.num_parts()) {
    std::vector<PartIndex> piece(fleet.num_parts());
    std::iota(piece.begin(), piece.end(), PartIndex{0});
    const auto root = [&](PartIndex part) {
      while (piece[part] != part) part = piece[part] = piece[piece[part]];
      return part;
    };
    const Problem& problem = fleet.problem();
    for (ConnectionIndex c = 0; c < fleet.num_connections(); ++c) {
      const auto [a, b] = problem.ends(c);
      if (root(a) == root(b)) {
        throw Refusal(method,
                      "plans for products whose connections form no cycle, and connection \"" +
                          problem.connection_id(c) + "\" closes one");
      }
      piece[root(a)] = root(b);
      neighbours_[a].push_back({b, c});
      neighbours_[b].push_back({a, c});
    }
  }

  [[nodiscard]] const std::vector<Neighbour>& neighbours(PartIndex part) const {
    return neighbours_[part];
  }

  /// Pieces of two or more parts, each ascending, by their first part.
  [[nodiscard]] std::vector<std::vector<PartIndex>> pieces() const {
    std::vector<std::vector<PartIndex>> found;
    std::vector<bool> seen(neighbours_.size(), false);
    for (PartIndex first = 0; first < neighbours_.size(); ++first) {
      if (seen[first] || neighbours_[first].empty()) continue;
      std::vector<PartIndex> piece = {first};
      seen[first] = true;
      for (std::size_t next = 0; next < piece.size(); ++next) {
        for (const Neighbour& neighbour : neighbours_[piece[next]]) {
          if (seen[neighbour.part]) continue;
          seen[neighbour.part] = true;
          piece.push_back(neighbour.part);
        }
      }
      std::ranges::sort(piece);
      found.push_back(std::move(piece));
    }
    return found;
  }

  void cut(PartIndex a, PartIndex b) {
    std::erase_if(neighbours_[a], [b](const Neighbour& neighbour) { return neighbour.part == b; });
    std::erase_if(neighbours_[b], [a](const Neighbour& neighbour) { return neighbour.part == a; });
  }

 private:
  std::vector<std::vector<Neighbour>> neighbours_;
};

/// What the labelling says of a part.
struct Label {
  PartIndex parent = kNone;  ///< of the root: none
  std::size_t weight = 1;
  std::size_t layer = 1;
  std::size_t rank = 0;  ///< among the children of its parent
  std::vector<PartIndex> children;
};

/// The labels of one piece, from its leaves inwards.
class Labels {
 public:
  Labels(const Forest& forest, const std::vector<PartIndex>& piece, std::vector<Label>& labels)
      : labels_(labels) {
    std::deque<PartIndex> peelable;
    // Neighbours of each part, by its place in `piece`.
    std::vector<std::pair<PartIndex, std::size_t>> unpeeled;
    const auto place_of = [&piece](PartIndex part) {
      return static_cast<std::size_t>(std::ranges::lower_bound(piece, part) - piece.begin());
    };
    for (const PartIndex part : piece) {
      labels_[part] = Label{};
      unpeeled.emplace_back(part, forest.neighbours(part).size());
      if (unpeeled.back().second <= 1) peelable.push_back(part);
    }
    std::vector<PartIndex> order;
    std::vector<bool> peeled(piece.size(), false);
    while (!peelable.empty()) {
      const PartIndex part = peelable.front();
      peelable.pop_front();
      peeled[place_of(part)] = true;
      order.push_back(part);
      for (const Neighbour& neighbour : forest.neighbours(part)) {
        const std::size_t place = place_of(neighbour.part);
        if (peeled[place]) continue;
        labels_[part].parent = neighbour.part;
        labels_[neighbour.part].children.push_back(part);
        if (--unpeeled[place].second == 1) peelable.push_back(neighbour.part);
      }
    }
    root_ = order.back();
    for (const PartIndex part : order) {
      Label& label = labels_[part];
      std::ranges::sort(label.children);
      std::size_t heaviest = 0;
      for (std::size_t i = 0; i < label.children.size(); ++i) {
        labels_[label.children[i]].rank = i;
        label.weight += labels_[label.children[i]].weight;
        heaviest = std::max(heaviest, labels_[label.children[i]].weight);
      }
      if (part == root_) label.weight -= heaviest;
    }
    for (auto part = order.rbegin() + 1; part != order.rend(); ++part)
      labels_[*part].layer = labels_[labels_[*part].parent].layer + 1;
  }

  [[nodiscard]] PartIndex root() const { return root_; }
  [[nodiscard]] const Label& operator[](PartIndex part) const { return labels_[part]; }

  /// The part and everything below it.
  [[nodiscard]] std::vector<PartIndex> below(PartIndex top) const {
    std::vector<PartIndex> parts = {top};
    for (std::size_t next = 0; next < parts.size(); ++next) {
      const std::vector<PartIndex>& children = labels_[parts[next]].children;
      parts.insert(parts.end(), children.begin(), children.end());
    }
    return parts;
  }

 private:
  std::vector<Label>& labels_;
  PartIndex root_ = kNone;
};

/// What becomes of one piece in a step. Everything else of it stays.
struct Parting {
  std::vector<PartIndex> piece;
  std::vector<PartIndex> singles;  ///< leave for the depot
  /// Of subassemblies that are carried off: each with all below it.
  std::vector<PartIndex> tops;
};

/// The heuristics at work: one step after the other.
class Work {
 public:
  Work(const FleetProblem& fleet, std::string_view method, bool fast)
      : fleet_(fleet),
        forest_(fleet, method),
        fast_(fast),
        labels_(fleet.num_parts()),
        places_(fleet.num_parts(), kDepot) {
    PlaceIndex site = 0;
    for (const std::vector<PartIndex>& piece : forest_.pieces()) {
      ++site;
      for (const PartIndex part : piece) places_[part] = site;
    }
    plan_.start = places_;
    state_ = fleet_start(fleet, places_);
  }

  [[nodiscard]] bool done() const { return state_.open.empty(); }
  [[nodiscard]] FleetPlan& plan() { return plan_; }

  /// Makes a step. False where it would change nothing.
  bool step() {
    std::vector<std::vector<PartIndex>> pieces = forest_.pieces();
    if (fast_) std::ranges::stable_sort(pieces, {}, &std::vector<PartIndex>::size);
    if (!fast_) pieces.resize(1);
    robots_ = 0;
    subassemblies_ = fast_ ? pieces.size() : fleet_.num_sites();
    std::vector<Motion> motions(fleet_.num_parts(), kStay);
    std::vector<std::vector<PartIndex>> carried;
    std::vector<PartIndex> freed;
    for (const std::vector<PartIndex>& piece : pieces) {
      const Labels labels(forest_, piece, labels_);
      const Parting parting = parted(piece, labels);
      for (const PartIndex part : parting.singles) {
        if (part != labels.root()) motions[part] = away(part, labels[part].parent);
        freed.push_back(part);
      }
      for (const PartIndex top : parting.tops) {
        carried.push_back(labels.below(top));
        const Motion motion = away(top, labels[top].parent);
        for (const PartIndex part : carried.back()) motions[part] = motion;
      }
    }
    if (freed.empty() && carried.empty()) return false;

    const std::vector<PlaceIndex> before = places_;
    for (const PartIndex part : freed) places_[part] = kDepot;
    for (const auto& parts : carried) {
      for (const PartIndex part : parts) places_[part] = kDepot;
    }
    std::vector<bool> used(fleet_.num_places(), false);
    for (PartIndex part = 0; part < places_.size(); ++part) used[places_[part]] = true;
    for (const auto& parts : carried) {
      const PlaceIndex site = nearest_free(before[parts.front()], used);
      used[site] = true;
      for (const PartIndex part : parts) places_[part] = site;
    }
    plan_.steps.push_back(fleet_step(fleet_, state_, motions, places_));
    for (const ConnectionIndex c : plan_.steps.back().cut) {
      const auto [a, b] = fleet_.problem().ends(c);
      forest_.cut(a, b);
    }
    return true;
  }

 private:
  /// The motion that takes `part` off its neighbour `other`.
  [[nodiscard]] Motion away(PartIndex part, PartIndex other) const {
    const auto& neighbours = forest_.neighbours(part);
    const ConnectionIndex c = std::ranges::find(neighbours, other, &Neighbour::part)->by;
    const std::size_t axis = fleet_.axis(c);
    return motion_along(fleet_.problem().ends(c)[0] == part ? axis : opposite(axis));
  }

  [[nodiscard]] double distance(PlaceIndex a, PlaceIndex b) const {
    return std::sqrt(fleet_.squared_distance(a, b));
  }

  /// The depot where none is free: the checker says what is wrong with that.
  [[nodiscard]] PlaceIndex nearest_free(PlaceIndex from, const std::vector<bool>& used) const {
    PlaceIndex best = kDepot;
    double least = 0;
    for (PlaceIndex site = 1; site < fleet_.num_places(); ++site) {
      if (used[site]) continue;
      const double length = distance(from, site) + distance(site, kDepot);
      if (best != kDepot && length >= least) continue;
      best = site;
      least = length;
    }
    return best;
  }

  Parting parted(const std::vector<PartIndex>& piece, const Labels& labels) {
    Parting parting{.piece = piece, .singles = leaves(piece, labels), .tops = {}};
    if (fast_) grow(parting, labels);

    // A single part that is left would have to wait at its site: a neighbour stays with it.
    std::size_t carried = 0;
    for (const PartIndex top : parting.tops) carried += labels[top].weight;
    if (parting.singles.size() + carried + 1 != piece.size()) return parting;
    std::vector<bool> goes(fleet_.num_parts(), false);
    for (const PartIndex part : parting.singles) goes[part] = true;
    for (const PartIndex top : parting.tops) {
      for (const PartIndex part : labels.below(top)) goes[part] = true;
    }
    const PartIndex lone =
        *std::ranges::find_if(piece, [&](PartIndex part) { return !goes[part]; });
    const auto touches = [&](PartIndex part) {
      return labels[part].parent == lone || labels[lone].parent == part;
    };
    const auto single = std::find_if(parting.singles.rbegin(), parting.singles.rend(), touches);
    if (single != parting.singles.rend()) {
      parting.singles.erase(std::next(single).base());
      --robots_;
    } else if (!parting.tops.empty()) {
      robots_ -= labels[parting.tops.back()].weight;
      --subassemblies_;
      parting.tops.pop_back();
    }
    return parting;
  }

  /// The leaves that come off, those near the root first; takes their robots.
  std::vector<PartIndex> leaves(const std::vector<PartIndex>& piece, const Labels& labels) {
    std::vector<PartIndex> order = piece;
    std::ranges::stable_sort(order, {}, [&](PartIndex part) {
      return std::pair(labels[part].layer, labels[part].rank);
    });
    std::vector<PartIndex> chosen;
    bool root_chosen = false;
    for (const PartIndex part : order) {
      if (labels[part].weight != 1 || robots_ >= fleet_.robots()) continue;
      chosen.push_back(part);
      root_chosen = root_chosen || part == labels.root();
      ++robots_;
    }
    const bool star = labels[labels.root()].children.size() + 1 == piece.size();
    if (star && !root_chosen && robots_ < fleet_.robots()) {
      chosen.push_back(labels.root());
      ++robots_;
    }
    return chosen;
  }

  /// Lets leaves, and the subassemblies that they became, grow to their parents.
  void grow(Parting& parting, const Labels& labels) {
    std::vector<bool> held(fleet_.num_parts(), false);
    std::size_t held_parts = parting.singles.size();
    for (const PartIndex part : parting.singles) held[part] = true;

    // What has grown to `parent` takes in all below it.
    const auto grows = [&](PartIndex parent, bool is_new) {
      const std::size_t size = parting.piece.size();
      if (parent == kNone || parent == labels.root() || size <= 3 || held_parts >= size)
        return false;
      if (is_new && subassemblies_ >= fleet_.num_sites()) return false;
      const std::vector<PartIndex> parts = labels.below(parent);
      const auto more = static_cast<std::size_t>(
          std::ranges::count_if(parts, [&](PartIndex part) { return !held[part]; }));
      if (robots_ + more > fleet_.robots()) return false;
      if (labels[parent].weight > size / (parting.singles.size() + parting.tops.size() + 1))
        return false;
      robots_ += more;
      held_parts += more;
      std::vector<bool> inside(fleet_.num_parts(), false);
      for (const PartIndex part : parts) held[part] = inside[part] = true;
      const std::size_t tops = parting.tops.size();
      const auto is_inside = [&](PartIndex part) { return inside[part]; };
      std::erase_if(parting.singles, is_inside);
      std::erase_if(parting.tops, is_inside);
      parting.tops.push_back(parent);
      subassemblies_ = subassemblies_ + parting.tops.size() - tops;
      return true;
    };
    for (bool changed = true; changed;) {
      changed = false;
      for (const PartIndex leaf : std::vector(parting.singles)) {
        if (std::ranges::find(parting.singles, leaf) != parting.singles.end() &&
            grows(labels[leaf].parent, true))
          changed = true;
      }
      for (const PartIndex top : std::vector(parting.tops)) {
        if (std::ranges::find(parting.tops, top) != parting.tops.end() &&
            grows(labels[top].parent, false))
          changed = true;
      }
    }
  }

  const FleetProblem& fleet_;
  Forest forest_;
  bool fast_;
  std::vector<Label> labels_;
  std::vector<PlaceIndex> places_;
  FleetState state_;
  FleetPlan plan_;
  std::size_t robots_ = 0;         ///< taken in this step
  std::size_t subassemblies_ = 0;  ///< pieces before this step and what is carried off in it
};

Result run(const FleetProblem& fleet, const FleetOptions& options, const Budget& budget,
           std::string_view method, bool fast) {
  const Stopwatch watch;
  Result result;
  result.method = method;
  Work work(fleet, method, fast);
  bool stuck = false;
  while (!work.done() && !stuck) {
    result.stop = budget.expired();
    if (result.stop != Stop::None) break;
    stuck = !work.step();
    ++result.statistics.expanded;
  }
  result.statistics.seconds = watch.seconds();
  if (result.stop != Stop::None) return result;
  if (stuck) {
    result.notes.emplace_back("no further step: " + std::to_string(fleet.robots()) +
                              (fleet.robots() == 1 ? " robot is" : " robots are") +
                              " too few for this heuristic");
    return result;
  }
  const FleetEvaluation evaluation = evaluate(fleet, work.plan());
  const std::size_t steps = work.plan().makespan();
  if (!evaluation.valid) {
    const FleetViolation& first = evaluation.violations.front();
    result.notes.push_back("the heuristic's plan of " + std::to_string(steps) +
                           " steps breaks a rule that it does not look at: step " +
                           std::to_string(first.step) + ": " + first.message);
    return result;
  }
  if (options.steps && steps > *options.steps) {
    result.notes.push_back("the heuristic's plan takes " + std::to_string(steps) +
                           " steps, more than allowed");
    return result;
  }
  result.status = Status::Feasible;
  result.fleet_plan = std::move(work.plan());
  result.reward = fleet.reward(result.fleet_plan);
  result.notes.push_back("T = " + std::to_string(steps + 1) +
                         " states, as the published heuristics count: the start is one");
  return result;
}

}  // namespace

std::optional<std::string> fleet_heuristics_obstacle(const FleetProblem& fleet) {
  try {
    static_cast<void>(Forest(fleet, ""));
    return std::nullopt;
  } catch (const Refusal& refusal) {
    return refusal.reason();
  }
}

Result fleet_fast(const FleetProblem& fleet, const FleetOptions& options, const Budget& budget) {
  return run(fleet, options, budget, "fast", true);
}

Result fleet_greedy(const FleetProblem& fleet, const FleetOptions& options, const Budget& budget) {
  return run(fleet, options, budget, "greedy", false);
}

}  // namespace orasp
