#include "orasp/fleet/fleet_mip.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "orasp/fleet/fleet_validate.h"
#include "orasp/mip/mip_solver.h"
#include "orasp/model/error.h"
#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

enum class Aim {
  Plan,      ///< any plan within the steps
  Makespan,  ///< the fewest steps
  Travel,
};

/// The program of one problem. States are 0 to `steps`, step t leads from state t - 1 to state t.
/// In the last state all parts are in the depot. Names count parts, connections and directions from
/// 1.
class FleetProgramBuilder {
 public:
  FleetProgramBuilder(const FleetProblem& fleet, Aim goal, std::size_t steps)
      : fleet_(fleet), problem_(fleet.problem()), goal_(goal), steps_(steps) {
    find_pieces();
    require_size();
  }

  MipModel build() {
    add_remarks();
    add_places();
    add_connections();
    for (std::size_t t = 1; t <= steps_; ++t) {
      add_motions(t);
      add_cuts(t);
      add_robots(t);
      add_blocking(t);
      add_moved_limits(t);
    }
    for (std::size_t t = 0; t < steps_; ++t) add_sites(t);
    add_precedence();
    if (goal_ == Aim::Travel) add_travel();
    if (goal_ == Aim::Makespan) add_makespan();
    return std::move(model_);
  }

  /// The plan that these values are, without steps in which nothing happens.
  [[nodiscard]] FleetPlan plan(const std::vector<double>& values) const {
    const auto value = [&](const MipSum& sum) {
      double total = sum.constant;
      for (const MipTerm& term : sum.terms) total += term.value * values[term.column];
      return total;
    };
    const auto places_in = [&](std::size_t t) {
      std::vector<PlaceIndex> places(parts(), kDepot);
      for (PartIndex i = 0; i < parts(); ++i) {
        for (PlaceIndex p = 0; p < fleet_.num_places(); ++p) {
          if (value(at(i, p, t)) > 0.5) places[i] = p;
        }
      }
      return places;
    };
    FleetPlan found;
    found.start = places_in(0);
    FleetState state = fleet_start(fleet_, found.start);
    for (std::size_t t = 1; t <= steps_; ++t) {
      std::vector<Motion> motions(parts(), kStay);
      for (PartIndex i = 0; i < parts(); ++i) {
        for (Motion d = 0; d <= directions(); ++d) {
          if (state.places[i] != kDepot && value(go(i, d, t)) > 0.5) motions[i] = d;
        }
      }
      const std::vector<PlaceIndex> places = places_in(t);
      if (places == state.places &&
          std::ranges::all_of(motions, [](Motion d) { return d == kStay; }))
        continue;
      found.steps.push_back(fleet_step(fleet_, state, motions, places));
    }
    return found;
  }

 private:
  [[nodiscard]] std::size_t parts() const { return problem_.num_parts(); }
  [[nodiscard]] std::size_t directions() const { return 2 * fleet_.dimensions(); }
  [[nodiscard]] std::size_t connections() const { return problem_.num_connections(); }

  // -----------------------------------------------------------------------------------------------
  // The structure.

  void find_pieces() {
    piece_.resize(parts());
    around_.resize(parts());
    for (PartIndex i = 0; i < parts(); ++i) piece_[i] = i;
    for (ConnectionIndex c = 0; c < connections(); ++c) {
      const auto [u, v] = problem_.ends(c);
      around_[u].push_back(c);
      around_[v].push_back(c);
      if (piece_[u] == piece_[v]) {
        cycles_ = true;
        continue;
      }
      const PartIndex first = std::min(piece_[u], piece_[v]);
      const PartIndex other = std::max(piece_[u], piece_[v]);
      std::ranges::replace(piece_, other, first);
    }
    for (PartIndex i = 0; i < parts(); ++i) {
      if (!around_[i].empty()) joined_.push_back(i);
    }
  }

  void require_size() const {
    const std::uint64_t places = fleet_.num_places();
    const std::uint64_t state = joined_.size() * (2 * places + directions() + 2) +
                                connections() * (3 * places + 1) +
                                (goal_ == Aim::Travel ? joined_.size() * places * places : 0);
    const std::uint64_t columns = state * steps_;
    if (columns <= kFleetMipMaxColumns) return;
    throw Refusal("mip", "needs an integer program of " + std::to_string(steps_) +
                             " steps with up to " + std::to_string(columns) + " columns (at most " +
                             std::to_string(kFleetMipMaxColumns) +
                             "; fewer steps make it smaller)");
  }

  void add_remarks() {
    for (PartIndex i = 0; i < parts(); ++i)
      model_.add_remark("part " + std::to_string(i + 1) + " is " + problem_.part_id(i));
    for (ConnectionIndex c = 0; c < connections(); ++c)
      model_.add_remark("connection " + std::to_string(c + 1) + " is " + problem_.connection_id(c));
    for (std::size_t d = 0; d < directions(); ++d)
      model_.add_remark("motion " + std::to_string(d + 1) + " is " + kDirectionNames[d]);
    model_.add_remark("motion 0 stays; place 0 is the depot");
  }

  // -----------------------------------------------------------------------------------------------
  // Columns, as sums: what is known in advance is a constant.

  /// 1 if part i is at place p in state t.
  [[nodiscard]] MipSum at(PartIndex i, PlaceIndex p, std::size_t t) const {
    MipSum sum;
    const bool in_depot = t == steps_ || around_[i].empty();
    if (in_depot) return sum.add(p == kDepot ? 1 : 0);
    const auto column = at_.find({t == 0 ? piece_[i] : i, p, t});
    if (column != at_.end()) sum.add(column->second, 1);
    return sum;
  }
  [[nodiscard]] MipSum there(ConnectionIndex c, std::size_t t) const {
    MipSum sum;
    if (t == 0) return sum.add(steps_ > 0 ? 1 : 0);
    if (t == steps_) return sum;
    return sum.add(there_.at({c, t}), 1);
  }
  [[nodiscard]] MipSum go(PartIndex i, Motion d, std::size_t t) const {
    MipSum sum;
    if (around_[i].empty()) return sum.add(d == kStay ? 1 : 0);
    return sum.add(go_.at({i, d, t}), 1);
  }

  /// Each part is at one place; at the start what hangs together is at one site.
  void add_places() {
    for (std::size_t t = 0; t < steps_; ++t) {
      std::size_t site = 0;  // of the next piece of the start
      for (const PartIndex i : joined_) {
        if (t == 0 && piece_[i] != i) continue;
        ++site;
        MipSum one;
        for (PlaceIndex p = 0; p < fleet_.num_places(); ++p) {
          // Where only steps count, sites are alike: the pieces of the start stand on the first.
          if (t == 0 && (p == kDepot || (goal_ != Aim::Travel && p != site))) continue;
          one.add(at_[{i, p, t}] = model_.add_binary(mip_name("at", i + 1, p, t)), 1);
        }
        model_.add_row(mip_name("one_place", i + 1, t), one, MipSense::Equal, 1);
      }
    }
    for (std::size_t t = 1; t <= steps_; ++t) {
      for (const PartIndex i : joined_) {
        MipSum leaves = at(i, kDepot, t - 1);
        leaves.add(at(i, kDepot, t), -1);
        model_.add_row(mip_name("stored", i + 1, t), leaves, MipSense::AtMost, 0);
      }
    }
  }

  /// A connection is there where both its parts are at one site, and never returns; a part without
  /// one is in the depot.
  void add_connections() {
    for (std::size_t t = 1; t < steps_; ++t) {
      for (ConnectionIndex c = 0; c < connections(); ++c) {
        there_[{c, t}] = model_.add_continuous(mip_name("there", c + 1, t), 1);
        const auto [u, v] = problem_.ends(c);
        MipSum sites = MipSum().add(there(c, t), -1);
        for (PlaceIndex p = 1; p < fleet_.num_places(); ++p) {
          const MipColumn both = both_[{c, p, t}] =
              model_.add_binary(mip_name("both", c + 1, p, t));
          sites.add(both, 1);
          for (const PartIndex i : {u, v}) {
            MipSum only = at(i, p, t);
            model_.add_row(mip_name("both_by", c + 1, i + 1, p, t),
                           MipSum().add(both, 1).add(only, -1), MipSense::AtMost, 0);
          }
          model_.add_row(mip_name("both_is", c + 1, p, t),
                         at(u, p, t).add(at(v, p, t), 1).add(both, -1), MipSense::AtMost, 1);
        }
        model_.add_row(mip_name("somewhere", c + 1, t), sites, MipSense::Equal, 0);
        model_.add_row(mip_name("no_return", c + 1, t), there(c, t).add(there(c, t - 1), -1),
                       MipSense::AtMost, 0);
      }
      for (const PartIndex i : joined_) {
        for (PlaceIndex p = 1; p < fleet_.num_places(); ++p) {
          MipSum alone = at(i, p, t);
          for (const ConnectionIndex c : around_[i]) alone.add(both_.at({c, p, t}), -1);
          model_.add_row(mip_name("not_alone", i + 1, p, t), alone, MipSense::AtMost, 0);
        }
      }
    }
  }

  // -----------------------------------------------------------------------------------------------
  // Steps.

  void add_motions(std::size_t t) {
    for (const PartIndex i : joined_) {
      MipSum one;
      for (Motion d = 0; d <= directions(); ++d)
        one.add(
            go_[{i, d, t}] = model_.add_binary(mip_name("go", i + 1, static_cast<unsigned>(d), t)),
            1);
      model_.add_row(mip_name("one_motion", i + 1, t), one, MipSense::Equal, 1);
      // In the depot it does not matter: it stays.
      model_.add_row(mip_name("rests", i + 1, t), at(i, kDepot, t - 1).add(go(i, kStay, t), -1),
                     MipSense::AtMost, 0);
      // A part that stays goes to no other site.
      for (PlaceIndex p = 1; p < fleet_.num_places(); ++p) {
        model_.add_row(mip_name("same_site", i + 1, p, t),
                       at(i, p, t).add(at(i, p, t - 1), -1).add(go(i, kStay, t), 1),
                       MipSense::AtMost, 1);
      }
    }
  }

  /// What is kept moves alike; what is cut is pulled apart along its axis.
  void add_cuts(std::size_t t) {
    for (ConnectionIndex c = 0; c < connections(); ++c) {
      const auto [u, v] = problem_.ends(c);
      if (t < steps_) {
        for (Motion d = 0; d <= directions(); ++d) {
          for (const auto& [i, j] : {std::pair{u, v}, std::pair{v, u}}) {
            model_.add_row(mip_name("alike", c + 1, i + 1, static_cast<unsigned>(d), t),
                           go(i, d, t).add(go(j, d, t), -1).add(there(c, t), 1), MipSense::AtMost,
                           1);
          }
        }
      }
      const Motion away = motion_along(fleet_.axis(c));
      const Motion back = motion_along(opposite(fleet_.axis(c)));
      MipSum cut = there(c, t - 1);
      cut.add(there(c, t), -1);
      const auto demand = [&](std::size_t number, const MipSum& motions) {
        model_.add_row(mip_name("pulled", c + 1, number, t), MipSum().add(cut, 1).add(motions, -1),
                       MipSense::AtMost, 0);
      };
      demand(1, go(u, away, t).add(go(u, kStay, t), 1));
      demand(2, go(v, back, t).add(go(v, kStay, t), 1));
      demand(3, go(u, away, t).add(go(v, back, t), 1));
    }
  }

  /// A part that moves or leaves for the depot is held by a robot of its own.
  void add_robots(std::size_t t) {
    MipSum robots;
    for (const PartIndex i : joined_) {
      const MipColumn held = held_[{i, t}] = model_.add_continuous(mip_name("held", i + 1, t), 1);
      robots.add(held, 1);
      MipSum moves = MipSum().add(1);
      moves.add(go(i, kStay, t), -1).add(held, -1);
      model_.add_row(mip_name("held_to_move", i + 1, t), moves, MipSense::AtMost, 0);
      MipSum leaves = at(i, kDepot, t);
      leaves.add(at(i, kDepot, t - 1), -1).add(held, -1);
      model_.add_row(mip_name("held_to_leave", i + 1, t), leaves, MipSense::AtMost, 0);
    }
    model_.add_row(mip_name("robots", t), robots, MipSense::AtMost,
                   static_cast<double>(fleet_.robots()));
  }

  /// A part moves along a direction only if what blocks it there, in its subassembly, moves with
  /// it.
  void add_blocking(std::size_t t) {
    for (const PartIndex i : joined_) {
      for (const Blocker& blocker : problem_.blockers()[i]) {
        const PartIndex j = blocker.by;
        if (piece_[j] != piece_[i]) continue;
        for (std::size_t d = 0; d < directions(); ++d) {
          if ((blocker.directions >> d & 1U) == 0) continue;
          MipSum apart = go(i, motion_along(d), t);
          apart.add(go(j, motion_along(d), t), -1);
          if (t == 1) {
            model_.add_row(mip_name("blocked", i + 1, j + 1, d + 1, t), apart, MipSense::AtMost, 0);
            continue;
          }
          for (PlaceIndex p = 1; p < fleet_.num_places(); ++p) {
            model_.add_row(mip_name("blocked", i + 1, j + 1, d + 1, p, t),
                           MipSum().add(apart, 1).add(at(i, p, t - 1), 1).add(at(j, p, t - 1), 1),
                           MipSense::AtMost, 2);
          }
        }
      }
    }
  }

  /// A subassembly that moves has at most so many parts, so much mass. Single parts are looked at
  /// on their own.
  void add_moved_limits(std::size_t t) {
    const Limits& limits = problem_.limits();
    if (!limits.max_moved_parts && !limits.max_moved_mass) return;
    if (t == 1) {
      for (const PartIndex i : joined_) {
        const bool too_many = limits.max_moved_parts && *limits.max_moved_parts < 1;
        const bool too_heavy =
            limits.max_moved_mass && problem_.parts()[i].mass > *limits.max_moved_mass;
        if (too_many || too_heavy)
          model_.add_row(mip_name("cannot_leave", i + 1), MipSum().add(1), MipSense::AtMost, 0);
      }
    }
    if (t == steps_) return;
    for (PlaceIndex p = 1; p < fleet_.num_places(); ++p) {
      const MipColumn moves = model_.add_binary(mip_name("moves", p, t));
      MipSum size;
      MipSum mass;
      double total_mass = 0;
      for (const PartIndex i : joined_) {
        MipSum moving = at(i, p, t);
        moving.add(go(i, kStay, t), -1).add(moves, -1);
        model_.add_row(mip_name("moves_by", i + 1, p, t), moving, MipSense::AtMost, 0);
        size.add(at(i, p, t), 1);
        mass.add(at(i, p, t), problem_.parts()[i].mass);
        total_mass += problem_.parts()[i].mass;
      }
      const auto limit = [&](const char* name, MipSum sum, double most, double all) {
        if (all <= most) return;
        model_.add_row(mip_name(name, p, t), sum.add(moves, all - most), MipSense::AtMost, all);
      };
      if (limits.max_moved_parts)
        limit("moved_parts", size, static_cast<double>(*limits.max_moved_parts),
              static_cast<double>(joined_.size()));
      if (limits.max_moved_mass) limit("moved_mass", mass, *limits.max_moved_mass, total_mass);
    }
  }

  // -----------------------------------------------------------------------------------------------
  // Sites: what is at one hangs together, so that two subassemblies never share it.

  void add_sites(std::size_t t) {
    MipSum subassemblies;
    for (PlaceIndex p = 1; p < fleet_.num_places(); ++p) {
      const MipColumn used = model_.add_binary(mip_name("used", p, t));
      subassemblies.add(used, 1);
      if (t == 0) {  // a piece of the start is one subassembly
        MipSum pieces = MipSum().add(used, -1);
        for (const PartIndex i : joined_) {
          if (piece_[i] == i) pieces.add(at(i, p, 0), 1);
        }
        model_.add_row(mip_name("used_by_one", p, t), pieces, MipSense::AtMost, 0);
        continue;
      }
      MipSum tree = MipSum().add(used, -1);  // parts - connections <= 1
      for (const PartIndex i : joined_) {
        model_.add_row(mip_name("used_by", i + 1, p, t), at(i, p, t).add(used, -1),
                       MipSense::AtMost, 0);
        tree.add(at(i, p, t), 1);
      }
      for (ConnectionIndex c = 0; c < connections(); ++c) tree.add(both_.at({c, p, t}), -1);
      model_.add_row(mip_name("tree", p, t), tree, cycles_ ? MipSense::AtMost : MipSense::Equal, 0);
      if (cycles_) add_flow(p, used, t);
    }
    if (const auto& most = problem_.limits().max_subassemblies)
      model_.add_row(mip_name("subassemblies", t), subassemblies, MipSense::AtMost,
                     static_cast<double>(*most));
  }

  /// One unit for each part at site p, from a root there, along connections that are there.
  void add_flow(PlaceIndex p, MipColumn used, std::size_t t) {
    const auto n = static_cast<double>(joined_.size());
    MipSum one = MipSum().add(used, -1);
    std::map<PartIndex, MipSum> balance;
    for (const PartIndex i : joined_) {
      const MipColumn root = model_.add_binary(mip_name("root", i + 1, p, t));
      const MipColumn supply = model_.add_continuous(mip_name("supply", i + 1, p, t), n);
      one.add(root, 1);
      model_.add_row(mip_name("root_at", i + 1, p, t), MipSum().add(root, 1).add(at(i, p, t), -1),
                     MipSense::AtMost, 0);
      model_.add_row(mip_name("supplied", i + 1, p, t), MipSum().add(supply, 1).add(root, -n),
                     MipSense::AtMost, 0);
      balance[i].add(supply, 1).add(at(i, p, t), -1);
    }
    model_.add_row(mip_name("one_root", p, t), one, MipSense::AtMost, 0);
    for (ConnectionIndex c = 0; c < connections(); ++c) {
      const auto [u, v] = problem_.ends(c);
      const MipColumn along = model_.add_continuous(mip_name("flow", c + 1, 1, p, t), n);
      const MipColumn back = model_.add_continuous(mip_name("flow", c + 1, 2, p, t), n);
      model_.add_row(mip_name("way", c + 1, p, t),
                     MipSum().add(along, 1).add(back, 1).add(both_.at({c, p, t}), 1 - n),
                     MipSense::AtMost, 0);
      balance[u].add(along, -1).add(back, 1);
      balance[v].add(along, 1).add(back, -1);
    }
    for (const auto& [i, sum] : balance)
      model_.add_row(mip_name("reached", i + 1, p, t), sum, MipSense::Equal, 0);
  }

  // -----------------------------------------------------------------------------------------------
  // Precedence and objectives.

  /// What a connection comes after is cut in an earlier step than it.
  void add_precedence() {
    std::size_t number = 0;
    for (const PrecedenceClause& clause : problem_.precedence()) {
      for (std::size_t t = 1; t <= steps_; ++t) {
        for (const ConnectionIndex early : clause.after) {
          MipSum sum = there(early, t - 1);
          sum.add(there(clause.connection, t), -1);
          model_.add_row(mip_name("after", ++number, t), sum, MipSense::AtMost, 0);
        }
        if (clause.after_any.empty()) continue;
        MipSum any = MipSum().add(1).add(there(clause.connection, t), -1);
        for (const ConnectionIndex early : clause.after_any)
          any.add(-1).add(there(early, t - 1), 1);
        model_.add_row(mip_name("after_any", ++number, t), any, MipSense::AtMost, 0);
      }
    }
  }

  /// move_i_p_q_t: part i goes from place p to place q in step t. A path through the places of each
  /// part.
  void add_travel() {
    for (std::size_t t = 1; t <= steps_; ++t) {
      for (const PartIndex i : joined_) {
        std::vector<MipSum> from(fleet_.num_places());
        std::vector<MipSum> to(fleet_.num_places());
        MipSum carried;
        for (PlaceIndex p = 0; p < fleet_.num_places(); ++p) {
          for (PlaceIndex q = 0; q < fleet_.num_places(); ++q) {
            const bool possible = (t > 1 || p != kDepot) && (t < steps_ || q == kDepot) &&
                                  (p != kDepot || q == kDepot);
            if (!possible) continue;
            const MipColumn move = model_.add_continuous(mip_name("move", i + 1, p, q, t), 1,
                                                         fleet_.squared_distance(p, q));
            from[p].add(move, 1);
            to[q].add(move, 1);
            if (p != q) carried.add(move, 1);
          }
        }
        for (PlaceIndex p = 0; p < fleet_.num_places(); ++p) {
          model_.add_row(mip_name("move_from", i + 1, p, t), from[p].add(at(i, p, t - 1), -1),
                         MipSense::Equal, 0);
          model_.add_row(mip_name("move_to", i + 1, p, t), to[p].add(at(i, p, t), -1),
                         MipSense::Equal, 0);
        }
        model_.add_row(mip_name("carried", i + 1, t), carried.add(held_.at({i, t}), -1),
                       MipSense::AtMost, 0);
      }
    }
  }

  /// The number of states in which a part is out: that of the steps.
  void add_makespan() {
    for (std::size_t t = 0; t < steps_; ++t) {
      if (joined_.empty()) return;
      const MipColumn out = model_.add_binary(mip_name("out", t), 1);
      for (const PartIndex i : joined_) {
        MipSum is_out = MipSum().add(1);
        is_out.add(at(i, kDepot, t), -1).add(out, -1);
        model_.add_row(mip_name("out_by", i + 1, t), is_out, MipSense::AtMost, 0);
      }
    }
  }

  const FleetProblem& fleet_;
  const Problem& problem_;
  Aim goal_;
  std::size_t steps_;
  MipModel model_;
  bool cycles_ = false;
  std::vector<PartIndex> piece_;   ///< by part, the first part of its piece at the start
  std::vector<PartIndex> joined_;  ///< parts with connections
  std::vector<std::vector<ConnectionIndex>> around_;  ///< by part
  std::map<std::tuple<PartIndex, PlaceIndex, std::size_t>, MipColumn> at_;
  std::map<std::tuple<ConnectionIndex, PlaceIndex, std::size_t>, MipColumn> both_;
  std::map<std::pair<ConnectionIndex, std::size_t>, MipColumn> there_;
  std::map<std::tuple<PartIndex, Motion, std::size_t>, MipColumn> go_;
  std::map<std::pair<PartIndex, std::size_t>, MipColumn> held_;
};

std::size_t joined_parts(const FleetProblem& fleet) {
  std::vector<bool> joined(fleet.num_parts(), false);
  for (ConnectionIndex c = 0; c < fleet.num_connections(); ++c) {
    for (const PartIndex i : fleet.problem().ends(c)) joined[i] = true;
  }
  return static_cast<std::size_t>(std::ranges::count(joined, true));
}

std::string steps_text(std::size_t steps) {
  return std::to_string(steps) + (steps == 1 ? " step" : " steps");
}

/// A run of fleet_mip.
class Run {
 public:
  Run(const FleetProblem& fleet, const FleetOptions& options, const Budget& budget)
      : fleet_(fleet), options_(options), budget_(budget) {
    result_.method = "mip";
  }

  Result run() {
    if (const auto reason = fleet_.infeasibility()) return infeasible(*reason);
    solver_ = make_mip_solver();
    const bool wants_travel = fleet_.objective() == FleetObjective::Travel;
    if (joined_parts(fleet_) == 0) {
      result_.fleet_plan.start.assign(fleet_.num_parts(), kDepot);
      result_.status = Status::Optimal;
      result_.reward = 0;
      result_.bound = 0;
      if (wants_travel) result_.steps_allowed = options_.steps.value_or(0);
      return result_;
    }
    if (wants_travel && options_.steps) return travel(*options_.steps);
    makespan();
    if (!wants_travel || result_.status != Status::Optimal) {
      if (wants_travel && result_.status != Status::Infeasible) forget_bound_of_steps();
      return result_;
    }
    return travel(result_.fleet_plan.makespan());
  }

 private:
  Result infeasible(const std::string& why) {
    result_.status = Status::Infeasible;
    result_.stop = Stop::None;
    result_.bound = -kInfinity;
    result_.notes.push_back("no plan exists: " + why);
    return result_;
  }

  /// Stopped while it looked for the fewest steps: nothing is known of travel.
  void forget_bound_of_steps() { result_.bound.reset(); }

  MipSolution solve(const MipModel& model, bool tells_best) {
    MipSettings settings;
    if (budget_.deadline) {
      settings.seconds = std::max(
          0.0, std::chrono::duration<double>(*budget_.deadline - Budget::Clock::now()).count());
    }
    result_.statistics.peak_bytes = std::max(result_.statistics.peak_bytes, model.bytes());
    const std::uint64_t before = result_.statistics.expanded;
    settings.watcher = [&, before](const MipProgress& progress) {
      Progress state{.phase = "integer program", .done = before + progress.nodes};
      if (tells_best) state.best = 0.0 - progress.best;
      budget_.report(state);
      return budget_.expired(model.bytes(), before + progress.nodes);
    };
    MipSolution solution = solver_->solve(model, settings);
    result_.statistics.expanded += solution.nodes;
    return solution;
  }

  /// Takes the plan of a solution if the checker takes it.
  bool take(const FleetProgramBuilder& builder, const MipSolution& solution) {
    FleetPlan plan = builder.plan(solution.values);
    const FleetEvaluation evaluation = evaluate(fleet_, plan);
    if (!evaluation.valid) {
      result_.notes.push_back(
          "the solver's answer breaks a rule within its tolerance, so there is no plan: " +
          evaluation.violations.front().message);
      return false;
    }
    result_.fleet_plan = std::move(plan);
    return true;
  }

  void makespan() {
    const std::size_t horizon = fleet_mip_horizon(fleet_);
    const std::size_t allowed = std::min(options_.steps.value_or(horizon), horizon);
    const std::size_t parts = joined_parts(fleet_);
    for (std::size_t steps = (parts + fleet_.robots() - 1) / fleet_.robots(); steps <= allowed;
         ++steps) {
      result_.bound = 0.0 - static_cast<double>(steps);
      FleetProgramBuilder builder(fleet_, Aim::Plan, steps);
      const MipSolution solution = solve(builder.build(), false);
      if (solution.status == MipSolution::Status::Infeasible) continue;
      if (solution.values.empty()) {
        result_.stop = solution.stop;
        return;
      }
      if (!take(builder, solution)) return;
      // Fewer steps are proved impossible, and the plan has no more.
      result_.status = Status::Optimal;
      result_.reward = 0.0 - static_cast<double>(result_.fleet_plan.makespan());
      result_.bound = result_.reward;
      return;
    }
    infeasible(allowed < horizon ? "there is none of at most " + steps_text(allowed)
                                 : "every order of steps ends where no step can be made");
  }

  Result travel(std::size_t steps) {
    result_.steps_allowed = steps;
    FleetProgramBuilder builder(fleet_, Aim::Travel, steps);
    const bool has_plan = result_.has_plan();  // of the fewest steps
    const MipSolution solution = solve(builder.build(), true);
    result_.stop = solution.stop;
    result_.bound.reset();
    if (std::isfinite(solution.bound)) result_.bound = 0.0 - std::max(0.0, solution.bound);
    if (solution.status == MipSolution::Status::Infeasible)
      return infeasible("there is none of at most " + steps_text(steps));
    if (solution.values.empty() || !take(builder, solution)) {
      if (has_plan) {
        result_.status = Status::Feasible;
        result_.reward = 0.0 - result_.fleet_plan.travel();
      }
      return result_;
    }
    result_.reward = 0.0 - result_.fleet_plan.travel();
    if (solution.status == MipSolution::Status::Optimal) {
      result_.status = Status::Optimal;
      result_.bound = result_.reward;
    } else {
      result_.status = Status::Feasible;
      if (result_.bound) result_.bound = std::max(*result_.bound, result_.reward);
    }
    return result_;
  }

  const FleetProblem& fleet_;
  const FleetOptions& options_;
  const Budget& budget_;
  std::unique_ptr<MipSolver> solver_;
  Result result_;
};

}  // namespace

std::size_t fleet_mip_horizon(const FleetProblem& fleet) {
  return std::max<std::size_t>(joined_parts(fleet), 1);
}

MipModel fleet_mip_model(const FleetProblem& fleet, std::size_t steps) {
  const bool travel = fleet.objective() == FleetObjective::Travel;
  return FleetProgramBuilder(fleet, travel ? Aim::Travel : Aim::Makespan, steps).build();
}

Result fleet_mip(const FleetProblem& fleet, const FleetOptions& options, const Budget& budget) {
  const Stopwatch watch;
  Result result = Run(fleet, options, budget).run();
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
