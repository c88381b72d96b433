#include "orasp/mip/mip.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "orasp/mip/mip_solver.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

namespace {

/// One objective of those that a weighted sum adds up, with its weight. An objective that is no sum
/// is a leaf of weight 1.
struct Leaf {
  double weight;
  Objective objective;
};

void add_leaves(const Objective& objective, double weight, std::vector<Leaf>& leaves) {
  if (const auto* sum = std::get_if<WeightedSum>(&objective.parameters)) {
    for (const WeightedObjective& term : sum->terms)
      add_leaves(term.objective, weight * term.weight, leaves);
  } else if (weight != 0) {
    leaves.push_back({weight, objective});
  }
}

std::vector<Leaf> leaves_of(const Objective& objective) {
  std::vector<Leaf> leaves;
  add_leaves(objective, 1, leaves);
  return leaves;
}

/// Builds the integer program of one problem. Steps are those of disassembly, t = 1 to n. Step t
/// leads from state t - 1 to state t; state 0 is the first. The names of rows and columns count
/// from 1.
class ProgramBuilder {
 public:
  explicit ProgramBuilder(const TransitionSystem& system)
      : system_(system),
        problem_(system.problem()),
        assembly_(problem_.direction() == Direction::Assembly),
        n_(system.num_steps()) {
    find_connections();
    find_pieces();
  }

  /// The model; afterwards step_columns() may be asked.
  MipModel build() {
    find_rewards();
    add_steps();
    add_precedence();
    if (looks_at_pieces()) {
      add_labels();
      add_paths();
      add_sizes();
      add_sides();
    }
    return std::move(model_);
  }

  /// The connections in the order in which these values remove them.
  [[nodiscard]] std::vector<ConnectionIndex> order(const std::vector<double>& values) const {
    std::vector<ConnectionIndex> found;
    for (std::size_t t = 1; t <= n_; ++t) {
      for (const ConnectionIndex c : removable_) {
        double chosen = 0;
        for (const MipTerm& term : removal(c, t).terms) chosen += values[term.column];
        if (chosen > 0.5) found.push_back(c);
      }
    }
    return found;
  }

 private:
  static constexpr std::size_t kNoPiece = static_cast<std::size_t>(-1);

  // -----------------------------------------------------------------------------------------------
  // The structure: what is there at the start and at the end, and which removals can or must
  // separate.

  void find_connections() {
    const ConnectionSet none(problem_.num_connections());
    const ConnectionSet start = system_.start();
    const ConnectionSet at_start = system_.present(start.view());
    const ConnectionSet at_goal = system_.present(none.view());
    const ConnectionSet& first = assembly_ ? at_goal : at_start;
    const ConnectionSet& last = assembly_ ? at_start : at_goal;
    cut_.assign(problem_.num_connections(), {});
    keep_.assign(problem_.num_connections(), {});
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      if (!first.contains(c)) continue;
      present_.push_back(c);
      if (last.contains(c)) {
        staying_.push_back(c);
      } else {
        removable_.push_back(c);
        cut_[c].resize(n_ + 1);
        keep_[c].resize(n_ + 1);
      }
    }
    goal_pieces_ = labels(last);
    start_pieces_ = labels(first);
    for (const ConnectionIndex c : removable_) {
      const auto& [u, v] = problem_.ends(c);
      ConnectionSet without = first;
      without.erase(c);
      if (goal_pieces_[u] == goal_pieces_[v]) {
        never_cuts_.push_back(c);
      } else if (const std::vector<PartIndex> apart = labels(without); apart[u] != apart[v]) {
        always_cuts_.push_back(c);
      }
    }
  }

  /// By part, the first part of its piece.
  [[nodiscard]] std::vector<PartIndex> labels(const ConnectionSet& there) const {
    std::vector<PartIndex> label(problem_.num_parts());
    for (PartIndex p = 0; p < label.size(); ++p) label[p] = p;
    for (bool changed = true; changed;) {
      changed = false;
      for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
        if (!there.contains(c)) continue;
        const auto& [u, v] = problem_.ends(c);
        if (label[u] == label[v]) continue;
        label[u] = label[v] = std::min(label[u], label[v]);
        changed = true;
      }
    }
    return label;
  }

  void find_pieces() {
    for (PartIndex p = 0; p < problem_.num_parts(); ++p) pieces_[start_pieces_[p]].push_back(p);
    std::erase_if(pieces_, [](const auto& piece) { return piece.second.size() < 2; });
    for (const auto& [label, parts] : pieces_) greatest_ = std::max(greatest_, parts.size());
  }

  [[nodiscard]] bool can_cut(ConnectionIndex c) const {
    return std::ranges::find(never_cuts_, c) == never_cuts_.end();
  }
  [[nodiscard]] bool can_keep(ConnectionIndex c) const {
    return std::ranges::find(always_cuts_, c) == always_cuts_.end();
  }

  // -----------------------------------------------------------------------------------------------
  // Rewards, as the rules give them.

  [[nodiscard]] std::size_t completing_step() const { return assembly_ ? 1 : n_; }

  void find_rewards() {
    own_.assign(problem_.num_connections(), std::vector<double>(n_ + 1, 0));
    gain_.assign(greatest_ + 1, std::vector<double>(greatest_ + 1, 0));
    for (const Leaf& leaf : leaves_of(problem_.objective())) {
      const Problem alone = problem_.with_objective(leaf.objective);
      const TransitionSystem rules(alone, situation());
      Expander expander(rules);
      for (const ConnectionIndex c : removable_) {
        for (std::size_t t = 1; t <= n_; ++t) {
          double reward = 0;
          if (t == completing_step()) {
            ConnectionSet last(problem_.num_connections());
            last.insert(c);
            reward = expander.step(last.view(), c).reward;
          } else if (rules.sees_order_only()) {
            reward = expander.step(some_state(c, assembly_ ? t : n_ - t + 1).view(), c).reward;
          } else {
            reward = expander.own_reward(c);
          }
          own_[c][t] += leaf.weight * reward;
        }
      }
      if (rules.sees_order_only()) continue;
      for (std::size_t a = 1; a <= greatest_; ++a) {
        for (std::size_t b = a; a + b <= greatest_; ++b)
          gain_[a][b] += leaf.weight * finite_gain(expander, a, b);
      }
    }
  }

  /// What a cut into a and b parts earns, beyond what its connection does.
  [[nodiscard]] static double finite_gain(Expander& expander, std::size_t a, std::size_t b) {
    const double gain = expander.greatest_gain(a, b);
    if (std::isfinite(gain)) return gain;
    throw InputError("objective: the reward of a cut into " + std::to_string(a) + " and " +
                     std::to_string(b) +
                     " parts is not finite, and mip needs all rewards in advance");
  }

  [[nodiscard]] Situation situation() const {
    Situation now = Situation::whole(problem_.num_connections());
    now.open = system_.start();
    for_each_connection(system_.kept().view(), [&](ConnectionIndex c) {
      now.open.insert(c);
      now.inaccessible.insert(c);
    });
    return now;
  }

  /// Some state with c and so many open connections.
  [[nodiscard]] ConnectionSet some_state(ConnectionIndex c, std::size_t open) const {
    ConnectionSet state(problem_.num_connections());
    state.insert(c);
    for (const ConnectionIndex other : removable_) {
      if (state.size() < open) state.insert(other);
    }
    return state;
  }

  /// Whether rewards or constraints ask what hangs together.
  [[nodiscard]] bool looks_at_pieces() const {
    const Limits& limits = problem_.limits();
    const bool gains = std::ranges::any_of(gain_, [](const std::vector<double>& row) {
      return std::ranges::any_of(row, [](double gain) { return gain != 0; });
    });
    return greatest_ > 0 && (gains || blocking() || limits.max_subassemblies ||
                             limits.max_moved_parts || limits.max_moved_mass);
  }
  [[nodiscard]] bool blocking() const {
    return std::ranges::any_of(problem_.blockers(), [](const auto& list) { return !list.empty(); });
  }

  // -----------------------------------------------------------------------------------------------
  // Steps: each connection once, one in each step.

  void add_steps() {
    for (const ConnectionIndex c : removable_) {
      model_.add_remark("connection " + std::to_string(c + 1) + " is " + problem_.connection_id(c));
    }
    for (std::size_t t = 1; t <= n_; ++t) {
      for (const ConnectionIndex c : removable_) {
        const double cost = 0.0 - own_[c][t];
        // Where nobody asks what hangs together, one column says that c goes.
        if (!looks_at_pieces() || can_keep(c))
          keep_[c][t] = model_.add_binary(mip_name("keep", c + 1, t), cost);
        if (looks_at_pieces() && can_cut(c))
          cut_[c][t] = model_.add_binary(mip_name("cut", c + 1, t), cost);
      }
    }
    for (const ConnectionIndex c : removable_) {
      model_.add_row(mip_name("once", c + 1), removed_by(c, n_), MipSense::Equal, 1);
    }
    for (std::size_t t = 1; t <= n_; ++t) {
      MipSum step;
      for (const ConnectionIndex c : removable_) step.add(removal(c, t), 1);
      model_.add_row(mip_name("step", t), step, MipSense::Equal, 1);
    }
  }

  [[nodiscard]] MipSum optional_column(const std::optional<MipColumn>& column) const {
    MipSum sum;
    if (column) sum.add(*column, 1);
    return sum;
  }
  [[nodiscard]] MipSum cut(ConnectionIndex c, std::size_t t) const {
    return optional_column(cut_[c][t]);
  }
  [[nodiscard]] MipSum keep(ConnectionIndex c, std::size_t t) const {
    return optional_column(keep_[c][t]);
  }
  [[nodiscard]] MipSum removal(ConnectionIndex c, std::size_t t) const {
    MipSum sum = cut(c, t);
    return sum.add(keep(c, t), 1);
  }
  /// 1 if c is gone in state t; 0 for what stays.
  [[nodiscard]] MipSum removed_by(ConnectionIndex c, std::size_t t) const {
    MipSum sum;
    for (std::size_t s = 1; s <= t && s < cut_[c].size(); ++s) sum.add(removal(c, s), 1);
    return sum;
  }
  [[nodiscard]] MipSum cut_by(ConnectionIndex c, std::size_t t) const {
    MipSum sum;
    for (std::size_t s = 1; s <= t; ++s) sum.add(cut(c, s), 1);
    return sum;
  }
  /// 1 if step t separates.
  [[nodiscard]] MipSum separates(std::size_t t) const {
    MipSum sum;
    for (const ConnectionIndex c : removable_) sum.add(cut(c, t), 1);
    return sum;
  }

  [[nodiscard]] bool is_present(ConnectionIndex c) const {
    return std::ranges::find(present_, c) != present_.end();
  }

  void add_precedence() {
    std::size_t number = 0;
    for (const PrecedenceClause& clause : problem_.precedence()) {
      const ConnectionIndex c = clause.connection;
      add_need_of_one(clause, number);
      if (cut_[c].empty()) continue;  // it is not removed
      for (const ConnectionIndex other : clause.after) {
        ++number;
        if (!is_present(other)) continue;  // gone before the start
        for (std::size_t t = 1; t <= n_; ++t) {
          MipSum sum = removed_by(c, t);
          sum.add(removed_by(other, t - 1), -1);
          model_.add_row(mip_name("after", number, t), sum, MipSense::AtMost, 0);
        }
      }
      if (clause.after_any.empty() ||
          std::ranges::any_of(clause.after_any,
                              [&](ConnectionIndex other) { return !is_present(other); }))
        continue;
      ++number;
      for (std::size_t t = 1; t <= n_; ++t) {
        MipSum sum = removed_by(c, t);
        for (const ConnectionIndex other : clause.after_any) sum.add(removed_by(other, t - 1), -1);
        model_.add_row(mip_name("after_any", number, t), sum, MipSense::AtMost, 0);
      }
    }
  }

  /// As long as the connection is there, one of made_after_any is.
  void add_need_of_one(const PrecedenceClause& clause, std::size_t& number) {
    const ConnectionIndex c = clause.connection;
    if (clause.made_after_any.empty() || !is_present(c)) return;
    if (assembly_ && cut_[c].empty()) return;  // it is made already
    std::vector<ConnectionIndex> others;
    for (const ConnectionIndex other : clause.made_after_any) {
      if (other != c && is_present(other)) others.push_back(other);
    }
    ++number;
    for (std::size_t t = 0; t <= n_; ++t) {
      MipSum sum;
      for (const ConnectionIndex other : others) sum.add(removed_by(other, t), 1);
      sum.add(removed_by(c, t), -1);
      model_.add_row(mip_name("made_after_any", number, t), sum, MipSense::AtMost,
                     static_cast<double>(others.size()) - 1);
    }
  }

  // -----------------------------------------------------------------------------------------------
  // Labels: the piece of each part in each state, by the first part of the piece.

  /// Whether l may label the piece of i.
  [[nodiscard]] bool may_label(PartIndex l, PartIndex i) const {
    return l <= i && start_pieces_[l] == start_pieces_[i];
  }
  /// 1 if i is in the piece of first part l in state t.
  [[nodiscard]] MipSum in(PartIndex l, PartIndex i, std::size_t t) const {
    MipSum sum;
    if (!may_label(l, i)) return sum;
    if (t == 0) return sum.add(start_pieces_[i] == l ? 1 : 0);
    if (t == n_) return sum.add(goal_pieces_[i] == l ? 1 : 0);
    return sum.add(in_.at({l, i, t}), 1);
  }

  template <class Visit>
  void for_each_part(Visit&& visit) const {
    for (const auto& [label, parts] : pieces_) {
      for (const PartIndex part : parts) visit(part, parts);
    }
  }

  void add_labels() {
    std::size_t start_pieces = pieces_.size();
    for (std::size_t t = 1; t < n_; ++t) {
      for_each_part([&](PartIndex i, const std::vector<PartIndex>& parts) {
        for (const PartIndex l : parts) {
          if (may_label(l, i)) in_[{l, i, t}] = model_.add_binary(mip_name("in", l + 1, i + 1, t));
        }
      });
    }
    for (std::size_t t = 1; t <= n_; ++t) {
      MipSum count;
      for_each_part([&](PartIndex i, const std::vector<PartIndex>& parts) {
        MipSum one;
        for (const PartIndex l : parts) {
          if (!may_label(l, i)) continue;
          one.add(in(l, i, t), 1);
          MipSum rooted = in(l, i, t);
          rooted.add(in(l, l, t), -1);
          if (l != i)
            model_.add_row(mip_name("rooted", l + 1, i + 1, t), rooted, MipSense::AtMost, 0);
        }
        model_.add_row(mip_name("labelled", i + 1, t), one, MipSense::Equal, 1);
        count.add(in(i, i, t), 1);
        // The first part of a piece is first in what is left of it.
        MipSum stays = in(i, i, t - 1);
        stays.add(in(i, i, t), -1);
        model_.add_row(mip_name("stays_first", i + 1, t), stays, MipSense::AtMost, 0);
      });
      for (std::size_t s = 1; s <= t; ++s) count.add(separates(s), -1);
      model_.add_row(mip_name("pieces", t), count, MipSense::Equal,
                     static_cast<double>(start_pieces));
      for (const ConnectionIndex c : present_) add_ties(c, t);
    }
  }

  /// A connection that is there ties the labels of its parts; one that cut has them apart for ever.
  void add_ties(ConnectionIndex c, std::size_t t) {
    const auto& [u, v] = problem_.ends(c);
    if (u == v) return;
    for (const PartIndex l : pieces_.at(start_pieces_[u])) {
      if (l > std::max(u, v)) break;
      for (const auto& [i, j] : {std::pair{u, v}, std::pair{v, u}}) {
        MipSum tie = in(l, i, t);
        tie.add(in(l, j, t), -1).add(removed_by(c, t), -1);
        model_.add_row(mip_name("tied", c + 1, l + 1, i + 1, t), tie, MipSense::AtMost, 0);
      }
      if (cut_[c].empty() || !can_cut(c)) continue;
      MipSum apart = cut_by(c, t);
      apart.add(in(l, u, t), 1).add(in(l, v, t), 1);
      model_.add_row(mip_name("apart", c + 1, l + 1, t), apart, MipSense::AtMost, 2);
    }
  }

  /// A removal that separates nothing must leave another path between its two parts. The rows say
  /// so by a flow: one unit flows from the first part to the second over the connections that are
  /// there.
  void add_paths() {
    std::vector<ConnectionIndex> without_cut;
    for (const ConnectionIndex c : removable_) {
      if (can_keep(c) && problem_.ends(c)[0] != problem_.ends(c)[1]) without_cut.push_back(c);
    }
    if (without_cut.empty()) return;
    for (std::size_t t = 1; t <= n_; ++t) {
      // For each part, what flows out of it less what flows in and what begins there.
      std::map<PartIndex, MipSum> surplus;
      for (const ConnectionIndex c : present_) {
        const auto& [u, v] = problem_.ends(c);
        // A connection whose removal always separates lies on no other path.
        if (u == v || !can_keep(c)) continue;
        const MipColumn along = model_.add_continuous(mip_name("flow", c + 1, 1, t), 1);
        const MipColumn back = model_.add_continuous(mip_name("flow", c + 1, 2, t), 1);
        surplus[u].add(along, 1).add(back, -1);
        surplus[v].add(along, -1).add(back, 1);
        MipSum there = removed_by(c, t);
        there.add(along, 1).add(back, 1);
        model_.add_row(mip_name("way", c + 1, t), there, MipSense::AtMost, 1);
      }
      for (const ConnectionIndex c : without_cut) {
        surplus[problem_.ends(c)[0]].add(keep(c, t), -1);
        surplus[problem_.ends(c)[1]].add(keep(c, t), 1);
      }
      for (const auto& [part, sum] : surplus)
        model_.add_row(mip_name("path", part + 1, t), sum, MipSense::Equal, 0);
    }
  }

  // -----------------------------------------------------------------------------------------------
  // Sizes: how many pieces of k parts there are, and what each step splits.

  [[nodiscard]] bool may_split(std::size_t a, const std::vector<double>& masses) const {
    const Limits& limits = problem_.limits();
    if (limits.max_moved_parts && a > *limits.max_moved_parts) return false;
    if (!limits.max_moved_mass) return true;
    // The lightest that a parts can be; where masses differ add_sides() looks closer.
    double lightest = 0;
    for (std::size_t i = 0; i < a; ++i) lightest += masses[i];
    return lightest <= greatest_mass();
  }
  [[nodiscard]] double greatest_mass() const {
    const double limit = *problem_.limits().max_moved_mass;
    return limit + kRelativeTolerance * std::abs(limit);
  }
  [[nodiscard]] std::vector<double> sorted_masses() const {
    std::vector<double> masses;
    for (const Part& part : problem_.parts()) masses.push_back(part.mass);
    std::ranges::sort(masses);
    return masses;
  }

  /// The number of pieces of k parts in state t, of those that were parts of a subassembly at the
  /// start.
  [[nodiscard]] MipSum number_of(std::size_t k, std::size_t t) const {
    MipSum sum;
    if (t == 0 || t == n_) {
      const std::vector<PartIndex>& label = t == 0 ? start_pieces_ : goal_pieces_;
      for_each_part([&](PartIndex l, const std::vector<PartIndex>&) {
        if (label[l] != l) return;
        if (static_cast<std::size_t>(std::ranges::count(label, l)) == k) sum.add(1);
      });
      return sum;
    }
    for_each_part([&](PartIndex l, const std::vector<PartIndex>&) {
      const auto column = size_.find({l, k, t});
      if (column != size_.end()) sum.add(column->second, 1);
    });
    return sum;
  }

  void add_sizes() {
    for (std::size_t t = 1; t < n_; ++t) {
      for_each_part([&](PartIndex l, const std::vector<PartIndex>& parts) {
        MipSum one = in(l, l, t);
        MipSum size;
        std::size_t most = 0;
        for (const PartIndex i : parts) {
          if (!may_label(l, i)) continue;
          ++most;
          size.add(in(l, i, t), 1);
        }
        one = MipSum().add(one, -1);
        for (std::size_t k = 1; k <= most; ++k) {
          const MipColumn column = size_[{l, k, t}] =
              model_.add_binary(mip_name("size", l + 1, k, t));
          one.add(column, 1);
          size.add(column, -static_cast<double>(k));
        }
        model_.add_row(mip_name("one_size", l + 1, t), one, MipSense::Equal, 0);
        model_.add_row(mip_name("size_is", l + 1, t), size, MipSense::Equal, 0);
      });
    }
    const std::vector<double> masses = sorted_masses();
    for (std::size_t t = 1; t <= n_; ++t) {
      std::vector<MipSum> change(greatest_ + 1);
      MipSum splits = MipSum().add(separates(t), -1);
      for (std::size_t a = 1; a <= greatest_; ++a) {
        for (std::size_t b = a; a + b <= greatest_; ++b) {
          if (!may_split(a, masses)) continue;
          const double cost = t == completing_step() ? 0 : 0.0 - gain_[a][b];
          const MipColumn column = split_[{a, b, t}] =
              model_.add_binary(mip_name("split", a, b, t), cost);
          splits.add(column, 1);
          change[a].add(column, 1);
          change[b].add(column, 1);
          change[a + b].add(column, -1);
        }
      }
      model_.add_row(mip_name("splits", t), splits, MipSense::Equal, 0);
      for (std::size_t k = 1; k <= greatest_; ++k) {
        change[k].add(number_of(k, t - 1), 1).add(number_of(k, t), -1);
        model_.add_row(mip_name("balance", k, t), change[k], MipSense::Equal, 0);
      }
    }
    if (!problem_.limits().max_subassemblies) return;
    for (std::size_t t = 0; t <= n_; ++t) {
      MipSum count;
      for (std::size_t k = 2; k <= greatest_; ++k) count.add(number_of(k, t), 1);
      model_.add_row(mip_name("subassemblies", t), count, MipSense::AtMost,
                     static_cast<double>(*problem_.limits().max_subassemblies));
    }
  }

  // -----------------------------------------------------------------------------------------------
  // Sides: which parts a cut has on the side of its connection's first part and on that of its
  // second.

  void add_sides() {
    const bool uniform = std::ranges::all_of(problem_.parts(), [&](const Part& part) {
      return part.mass == problem_.parts().front().mass;
    });
    const bool weighs = problem_.limits().max_moved_mass && !uniform;
    if (!blocking() && !weighs) return;
    for (std::size_t t = 1; t <= n_; ++t) {
      std::array<std::map<PartIndex, MipColumn>, 2> roots;
      for (std::size_t side = 0; side < 2; ++side) {
        MipSum one = MipSum().add(separates(t), -1);
        for_each_part([&](PartIndex l, const std::vector<PartIndex>&) {
          one.add(roots[side][l] = model_.add_binary(mip_name("side", side + 1, l + 1, t)), 1);
        });
        model_.add_row(mip_name("one_side", side + 1, t), one, MipSense::Equal, 0);
        for (const ConnectionIndex c : removable_) {
          if (!can_cut(c)) continue;
          const PartIndex end = problem_.ends(c)[side];
          for (const PartIndex l : pieces_.at(start_pieces_[end])) {
            if (!may_label(l, end)) continue;
            MipSum labelled = in(l, end, t);
            labelled.add(cut(c, t), 1).add(roots[side][l], -1);
            model_.add_row(mip_name("side_of", side + 1, c + 1, l + 1, t), labelled,
                           MipSense::AtMost, 1);
          }
        }
      }
      if (blocking()) add_blocking(roots, t);
      if (weighs) add_mass(roots, t);
    }
  }

  /// A column that is 1 if part i is in the piece that `roots` chose; it may be 1 elsewhere too.
  MipColumn add_member(const std::string& name, const std::map<PartIndex, MipColumn>& roots,
                       PartIndex i, std::size_t t) {
    const MipColumn member = model_.add_binary(name);
    for (const PartIndex l : pieces_.at(start_pieces_[i])) {
      if (!may_label(l, i)) continue;
      MipSum chosen = in(l, i, t);
      chosen.add(roots.at(l), 1).add(member, -1);
      model_.add_row(name + mip_name("_by", l + 1), chosen, MipSense::AtMost, 1);
    }
    return member;
  }

  /// A step that separates has a direction in which no part of the first side is blocked by one of
  /// the second.
  void add_blocking(const std::array<std::map<PartIndex, MipColumn>, 2>& roots, std::size_t t) {
    std::array<std::map<PartIndex, MipColumn>, 2> member;
    const auto is_on = [&](std::size_t side, PartIndex i) {
      const auto found = member[side].find(i);
      if (found != member[side].end()) return found->second;
      return member[side][i] =
                 add_member(mip_name(side == 0 ? "first" : "second", i + 1, t), roots[side], i, t);
    };
    std::map<DirectionIndex, MipColumn> free;
    for (const DirectionIndex d : problem_.directions()) free[d];
    MipSum some = MipSum().add(separates(t), -1);
    for (auto& [d, column] : free) {
      column = model_.add_binary(mip_name("free", d + 1, t));
      some.add(column, 1);
    }
    model_.add_row(mip_name("some_free", t), some, MipSense::AtLeast, 0);
    for (PartIndex i = 0; i < problem_.num_parts(); ++i) {
      for (const Blocker& blocker : problem_.blockers()[i]) {
        // Parts of different starting pieces are never on two sides of a cut.
        if (!pieces_.contains(start_pieces_[i]) || start_pieces_[i] != start_pieces_[blocker.by])
          continue;
        for (const auto& [d, column] : free) {
          if (!problem_.blocks(blocker, d)) continue;
          MipSum blocked;
          blocked.add(is_on(0, i), 1).add(is_on(1, blocker.by), 1).add(column, 1);
          model_.add_row(mip_name("blocked", i + 1, blocker.by + 1, d + 1, t), blocked,
                         MipSense::AtMost, 2);
        }
      }
    }
  }

  /// One of the sides is moved: one with the fewer parts. On a tie either may be, so the lighter
  /// where that is needed.
  void add_mass(const std::array<std::map<PartIndex, MipColumn>, 2>& roots, std::size_t t) {
    std::map<PartIndex, MipColumn> moved;
    MipSum one = MipSum().add(separates(t), -1);
    for (const auto& [l, column] : roots[0]) {
      moved[l] = model_.add_binary(mip_name("moves", l + 1, t));
      one.add(moved[l], 1);
      MipSum chosen;
      chosen.add(moved[l], 1).add(column, -1).add(roots[1].at(l), -1);
      model_.add_row(mip_name("moves_side", l + 1, t), chosen, MipSense::AtMost, 0);
    }
    model_.add_row(mip_name("moves_one", t), one, MipSense::Equal, 0);
    MipSum parts;
    MipSum mass;
    for_each_part([&](PartIndex i, const std::vector<PartIndex>&) {
      const MipColumn member = add_member(mip_name("moved", i + 1, t), moved, i, t);
      parts.add(member, 1);
      mass.add(member, problem_.parts()[i].mass);
    });
    for (const auto& [split, column] : split_) {
      if (std::get<2>(split) == t) parts.add(column, -static_cast<double>(std::get<0>(split)));
    }
    model_.add_row(mip_name("moved_parts", t), parts, MipSense::Equal, 0);
    model_.add_row(mip_name("moved_mass", t), mass, MipSense::AtMost, greatest_mass());
  }

  const TransitionSystem& system_;
  const Problem& problem_;
  bool assembly_;
  std::size_t n_;  ///< steps
  MipModel model_;
  std::vector<ConnectionIndex> present_;      ///< in state 0
  std::vector<ConnectionIndex> removable_;    ///< of these, what goes
  std::vector<ConnectionIndex> staying_;      ///< and what stays
  std::vector<ConnectionIndex> never_cuts_;   ///< its parts are still together at the end
  std::vector<ConnectionIndex> always_cuts_;  ///< it lies on no cycle
  std::vector<PartIndex> start_pieces_;       ///< by part, the first part of its piece in state 0
  std::vector<PartIndex> goal_pieces_;        ///< and in state n
  std::map<PartIndex, std::vector<PartIndex>> pieces_;  ///< subassemblies of state 0, by first part
  std::size_t greatest_ = 0;                            ///< parts of the greatest of them
  std::vector<std::vector<double>> own_;                ///< by connection and step
  std::vector<std::vector<double>> gain_;  ///< by the sizes of the pieces that come of a cut
  std::vector<std::vector<std::optional<MipColumn>>> cut_;  ///< by connection and step
  std::vector<std::vector<std::optional<MipColumn>>> keep_;
  std::map<std::tuple<PartIndex, PartIndex, std::size_t>, MipColumn> in_;
  std::map<std::tuple<PartIndex, std::size_t, std::size_t>, MipColumn> size_;
  std::map<std::tuple<std::size_t, std::size_t, std::size_t>, MipColumn> split_;
};

void require_applicable(const TransitionSystem& system) {
  if (const auto obstacle = mip_obstacle(system)) throw Refusal("mip", *obstacle);
}

/// The plan of a solution, judged by the rules.
void take_plan(const TransitionSystem& system, const ProgramBuilder& builder,
               const MipSolution& solution, Result& result) {
  std::vector<ConnectionIndex> order = builder.order(solution.values);
  if (system.problem().direction() == Direction::Assembly) std::ranges::reverse(order);
  Expander expander(system);
  ConnectionSet open = system.start();
  for (const ConnectionIndex c : order) {
    if (!expander.legal(open.view(), c)) {
      result.notes.push_back("the solver's answer breaks a rule at \"" +
                             system.problem().connection_id(c) +
                             "\" by less than its tolerance, so there is no plan");
      return;
    }
    open.erase(c);
  }
  if (!open.empty()) return;
  result.reward = detail::reward_of(system, order);
  result.sequence = std::move(order);
  const bool optimal = solution.status == MipSolution::Status::Optimal;
  result.status = optimal ? Status::Optimal : Status::Feasible;
  if (optimal) {
    result.bound = result.reward;
  } else if (std::isfinite(solution.bound)) {
    result.bound = std::max(result.reward, 0.0 - solution.bound);
  }
}

}  // namespace

std::optional<std::string> mip_obstacle(const TransitionSystem& system) {
  const Problem& problem = system.problem();
  if (problem.num_connections() > kMipMaxConnections) {
    return "takes at most " + std::to_string(kMipMaxConnections) +
           " connections for its integer program; this problem has " +
           std::to_string(problem.num_connections());
  }
  if (system.ordered())
    return "plans where every open connection may be next, and here some are late or cannot be "
           "next";
  if (system.wide())
    return "knows neither goals nor costs between steps nor steps that take parts off";
  if (!problem.base().empty()) return "knows no base: of two pieces the smaller one moves";
  for (const Leaf& leaf : leaves_of(problem.objective())) {
    const Problem alone = problem.with_objective(leaf.objective);
    const TransitionSystem rules(alone);
    if (rules.sees_order_only() || (rules.sees_piece_only() && rules.gain_by_sizes())) continue;
    return "takes objectives that see a step's connection and how many parts are in A and B "
           "(piece_cost, cubesat, "
           "custom, completion, indexed, and others where masses are equal and positions are not "
           "used), and '" +
           leaf.objective.type + "' sees more in this problem";
  }
  return std::nullopt;
}

MipModel mip_model(const TransitionSystem& system) {
  require_applicable(system);
  return ProgramBuilder(system).build();
}

Result mip(const TransitionSystem& system, const Budget& budget) {
  const Stopwatch watch;
  require_applicable(system);
  if (auto result = detail::infeasible_at_once(system, "mip")) return *result;
  Result result;
  result.method = "mip";
  if (system.num_steps() == 0) {
    result.status = Status::Optimal;
    result.reward = 0;
    result.bound = 0;
    return result;
  }
  const std::unique_ptr<MipSolver> solver = make_mip_solver();
  ProgramBuilder builder(system);
  const MipModel model = builder.build();
  result.statistics.peak_bytes = model.bytes();
  MipSettings settings;
  if (budget.deadline) {
    settings.seconds = std::max(
        0.0, std::chrono::duration<double>(*budget.deadline - Budget::Clock::now()).count());
  }
  settings.watcher = [&](const MipProgress& progress) {
    budget.report(
        {.phase = "integer program", .done = progress.nodes, .best = 0.0 - progress.best});
    return budget.expired(model.bytes(), progress.nodes);
  };
  const MipSolution solution = solver->solve(model, settings);
  result.stop = solution.stop;
  result.statistics.expanded = solution.nodes;
  if (solution.status == MipSolution::Status::Infeasible) {
    result.status = Status::Infeasible;
    result.notes.emplace_back("no plan exists: the integer program has no solution");
  } else if (!solution.values.empty()) {
    take_plan(system, builder, solution, result);
  }
  if (result.stop != Stop::None && !result.has_plan()) {
    const std::optional<double> bound =
        std::isfinite(solution.bound) ? std::optional(0.0 - solution.bound) : std::nullopt;
    result = detail::stopped_with_quick_plan(system, "mip", result.stop, result.statistics);
    if (bound && result.has_plan()) result.bound = std::max(*bound, result.reward);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp
