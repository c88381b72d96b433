#include "orasp/bounds/wide_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/bounds/cover_prices.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/tolerance.h"

namespace orasp {

namespace {

constexpr std::uint32_t kNoPlace = std::numeric_limits<std::uint32_t>::max();

double metres(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// The objective without the terms that look back; nothing where no other is left.
std::optional<Objective> without_look_back(const Objective& objective) {
  if (objective_row(objective.type)->looks_back) return std::nullopt;
  const auto* const sum = std::get_if<WeightedSum>(&objective.parameters);
  if (sum == nullptr) return objective;
  WeightedSum kept;
  for (const WeightedObjective& term : sum->terms) {
    if (auto rest = without_look_back(term.objective))
      kept.terms.push_back({term.weight, std::move(*rest)});
  }
  if (kept.terms.empty()) return std::nullopt;
  return Objective{"sum", kept};
}

}  // namespace

/// A changeover term.
struct WideBound::Changes {
  std::uint64_t stride = 1;
  std::uint64_t radix = 1;
  std::vector<std::vector<std::uint64_t>> with;  ///< by value: the connections that have it
  /// By value that must come, and by that in force (0 for none): the least cost to come to it.
  double least_of_all = 0;  ///< the least that a change costs; below 0 where one earns
  /// By the set of values that must come and the one in force: the least cost to come to them all.
  std::vector<double> by_set;
  std::vector<double> way_in;  ///< by value: the least cost to come to it; where by_set is empty
  bool first_is_free = false;
  double weight = 1;
};

/// A route term.
struct WideBound::Way {
  double cost = 0;  ///< of a metre
  std::optional<Vector3> start;
  std::uint64_t stride = 1;
  double farthest = 0;
  std::vector<double> price;  ///< m, by number of place; of 0 that of the start
};

WideBound::WideBound(const TransitionSystem& system) : system_(system) {
  const detail::Rules& rules = system.rules();
  by_part_ = rules.by_part;
  may_stop_ = rules.may_stop;
  must_.assign(system.open_words(), ~std::uint64_t{0});
  if (rules.has_goal) {
    must_ = rules.goal;
    // What has to go before what the goal asks for.
    for (bool growing = true; growing;) {
      growing = false;
      for (const PrecedenceClause& clause : system.problem().precedence()) {
        if (!contains(must_, clause.connection)) continue;
        for (const ConnectionIndex c : clause.after) {
          if (contains(must_, c)) continue;
          must_[c / 64] |= std::uint64_t{1} << (c % 64);
          growing = true;
        }
      }
    }
  }
  set_steps(system);
  if (known_) set_terms(system);
}

WideBound::~WideBound() = default;

void WideBound::set_steps(const TransitionSystem& system) {
  const detail::Rules& rules = system.rules();
  const Problem& problem = system.problem();
  std::optional<Objective> plain = without_look_back(problem.objective());
  if (!plain) plain = Objective("completion", CompletionObjective{0, 0, 0});
  ProblemSpec spec = problem.spec();
  spec.objective = *plain;
  if (!rules.has_goal && !by_part_) {
    plain_problem_ = std::make_unique<const Problem>(std::move(spec));
    plain_system_ = std::make_unique<const TransitionSystem>(*plain_problem_, system.situation());
    plain_bound_ = make_bound(*plain_system_, BoundKind::Best);
    known_ = plain_bound_->known();
    return;
  }
  // Ranges of single terms, which know nothing of goals and of what a step takes.
  const std::size_t connections = system.num_connections();
  const bool assembly = problem.direction() == Direction::Assembly;
  const ConnectionSet there = system.present(system.start().view());
  for (ConnectionIndex c = 0; c < connections; ++c) {
    const double duration = problem.connections()[c].duration;
    if (there.contains(c) == assembly) seconds_of_start_ += duration;
    if (system.start().contains(c)) all_seconds_ += duration;
  }
  std::vector<unsigned char> along_line(rules.terms.size(), 0);
  for (std::size_t i = 0; i < rules.terms.size() && !by_part_; ++i)
    along_line[i] = add_line_of_seconds(rules.terms[i]) ? 1 : 0;
  for (ConnectionIndex c = 0; c < by_second_.size(); ++c) {
    if (by_second_[c] < 0) falling_.push_back(c);
  }
  std::ranges::stable_sort(falling_, {}, [&](ConnectionIndex c) {
    const double duration = problem.connections()[c].duration;
    return duration > 0 ? by_second_[c] / duration : -kInfinity;
  });
  last_surplus_ = connections == 0 ? 0.0 : -kInfinity;
  for (ConnectionIndex c = 0; c < connections; ++c) {
    RewardRange inside{0, 0};
    RewardRange last{0, 0};
    for (std::size_t i = 0; i < rules.terms.size(); ++i) {
      const WeightedTerm& addend = rules.terms[i];
      if (addend.weight == 0 || addend.term->sees.looks_back || along_line[i] != 0) continue;
      RangeQuestion question{.connection = c,
                             .duration = problem.connections()[c].duration,
                             .most_before = static_cast<double>(connections),
                             .completes = false};
      const auto add = [&](RewardRange& sum) {
        const RewardRange range = range_of(addend, question);
        sum.greatest += addend.weight * (addend.weight > 0 ? range.greatest : range.least);
      };
      add(inside);
      question.completes = true;
      add(last);
    }
    greatest_.push_back(inside.greatest);
    known_ = known_ && std::isfinite(inside.greatest) && std::isfinite(last.greatest);
    last_surplus_ = std::max(last_surplus_, last.greatest - inside.greatest);
  }
  if (!by_part_) return;
  // A step takes several connections. Whatever it takes, it lasts as long as all of them, which is
  // counted by connection; all else is counted by step.
  most_of_step_ = -kInfinity;
  std::ranges::fill(greatest_, 0.0);
  double completing = 0;
  double most = 0;
  for (const WeightedTerm& addend : rules.terms) {
    if (addend.weight == 0 || addend.term->sees.looks_back) continue;
    const double inside = most_inside(addend);
    most += inside;
    if (const SizeCosts* const costs = addend.term->size_costs()) {
      completing += addend.weight * costs->last[1] - inside;
      continue;
    }
    completing +=
        greatest_of(addend, {.most_before = static_cast<double>(connections), .completes = true}) -
        inside;
    for (ConnectionIndex c = 0; c < connections; ++c)
      greatest_[c] += addend.weight * addend.term->by_second() * problem.connections()[c].duration;
  }
  known_ = std::isfinite(most) && std::isfinite(completing);
  most_of_step_ = most;
  last_surplus_ = completing;
  if (known_ && (rules.max_moved_parts == 1 || rules.grounded)) set_single_moves();
}

// Prices what each step takes, where that is a single part, if no part earns by its move.
void WideBound::set_single_moves() {
  const detail::Rules& rules = system_.rules();
  const Problem& problem = system_.problem();
  std::vector<double> cost(problem.num_parts());
  for (PartIndex part = 0; part < problem.num_parts(); ++part) {
    cost[part] = problem.in_base(part) ? kInfinity : 0.0 - most_of_moving(part);
    if (cost[part] < 0) return;
  }
  if (rules.grounded && !rules.has_goal && rules.num_kept == 0) {
    // Nothing but the base is left alone by others.
    cost_of_move_ = std::move(cost);
    return;
  }
  std::vector<ConnectionIndex> connections;
  std::vector<std::array<PartIndex, 2>> edges;
  for_each_connection(system_.start().view(), [&](ConnectionIndex c) {
    if (!contains(must_, c)) return;
    connections.push_back(c);
    edges.push_back({problem.ends(c)[0], problem.ends(c)[1]});
  });
  price_.assign(problem.num_connections(), 0.0);
  const std::vector<double> prices = cover_prices(cost, edges);
  for (std::size_t i = 0; i < edges.size(); ++i) price_[connections[i]] = prices[i];
}

// The most that a step earns which moves `part` alone, beyond what it earns by the second.
double WideBound::most_of_moving(PartIndex part) const {
  const detail::Rules& rules = system_.rules();
  const Problem& problem = system_.problem();
  const std::array<PartIndex, 1> moved{part};
  double sum = 0;
  for (const WeightedTerm& addend : rules.terms) {
    const ObjectiveTerm& term = *addend.term;
    if (addend.weight == 0 || term.sees.looks_back) continue;
    const double inside = most_inside(addend);
    if (!term.sees.piece_only || term.size_costs() != nullptr) {
      sum += inside;
      continue;
    }
    detail::StepPieces pieces{.totals = rules.totals, .a = {{moved, {}}}, .b = {}};
    // What the connections earn by themselves, which is more than their seconds only if it is
    // counted here.
    double own = 0;
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      detail::StepFacts facts;
      facts.connection = c;
      const double rest = addend.weight * (term.reward(facts, {}, pieces) -
                                           term.by_second() * problem.connections()[c].duration);
      own += std::max(0.0, rest);
    }
    sum += std::min(inside, own + term.greatest_gain_of_moving(addend.weight, pieces));
  }
  return sum;
}

double WideBound::greatest_of(const WeightedTerm& addend, const RangeQuestion& question) const {
  const RewardRange range = range_of(addend, question);
  return addend.weight * (addend.weight > 0 ? range.greatest : range.least);
}

// The most that a step of several connections earns by a term that does not complete, beyond what
// it earns by the second.
double WideBound::most_inside(const WeightedTerm& addend) const {
  if (const SizeCosts* const costs = addend.term->size_costs()) {
    // A step may leave more than two pieces.
    double pieces = 0;
    for (const double cost : costs->costs) pieces = std::max(pieces, 0.0 - addend.weight * cost);
    return 0.0 - addend.weight * costs->base +
           pieces * static_cast<double>(system_.problem().num_parts());
  }
  return greatest_of(addend, {.most_before = static_cast<double>(system_.num_connections())});
}

// What a step earns by a term: its range, or, of a formula, what that yields whatever else holds.
RewardRange WideBound::range_of(const WeightedTerm& addend, const RangeQuestion& question) const {
  const RewardRange range = addend.term->range(question);
  if (std::isfinite(addend.weight > 0 ? range.greatest : range.least)) return range;
  const auto connections = static_cast<double>(system_.num_connections());
  PlaceQuestion asked;
  asked.connection = question.connection;
  asked.several = by_part_;
  asked.duration = {question.duration, by_part_ ? all_seconds_ : question.duration};
  asked.before = {{0, connections}, {0, 0}};
  asked.after = {{0, connections}, {0, 0}};
  asked.elapsed = {{seconds_of_start_, seconds_of_start_ + all_seconds_}, {0, 0}};
  asked.completes = question.completes;
  RewardRange all{kInfinity, -kInfinity};
  for (const bool separates : {false, true}) {
    asked.separates = separates;
    const Interval one = addend.term->reward_over(asked).at;
    all = {std::min(all.least, one.least), std::max(all.greatest, one.greatest)};
  }
  return all;
}

// Adds the term to at_ and by_second_, if its reward lies below lines in the time that has passed.
bool WideBound::add_line_of_seconds(const WeightedTerm& addend) {
  const TermSight& sees = addend.term->sees;
  if (addend.weight == 0 || sees.looks_back || !sees.elapsed || sees.by_place) return false;
  const Problem& problem = system_.problem();
  const auto connections = static_cast<double>(problem.num_connections());
  std::vector<double> at(problem.num_connections(), -kInfinity);
  std::vector<double> slope(problem.num_connections(), 0);
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const double duration = problem.connections()[c].duration;
    PlaceQuestion asked;
    asked.connection = c;
    asked.duration = {duration, duration};
    asked.before = {{0, connections}, {0, 0}};
    asked.after = {{0, connections}, {0, 0}};
    asked.elapsed = {{0, 0}, {1, 1}};
    asked.time = {seconds_of_start_, seconds_of_start_ + all_seconds_};
    for (const bool separates : {false, true}) {
      for (const bool completes : {false, true}) {
        asked.separates = separates;
        asked.completes = completes;
        const FormulaLine line = addend.term->reward_over(asked);
        if (line.slope.least != line.slope.greatest) return false;
        const double mine = addend.weight * line.slope.least;
        if (at[c] != -kInfinity && mine != slope[c]) return false;
        slope[c] = mine;
        at[c] =
            std::max(at[c], addend.weight * (addend.weight > 0 ? line.at.greatest : line.at.least));
      }
    }
    if (!std::isfinite(at[c]) || !std::isfinite(slope[c])) return false;
  }
  at_.resize(at.size(), 0.0);
  by_second_.resize(at.size(), 0.0);
  for (std::size_t c = 0; c < at.size(); ++c) {
    at_[c] += at[c];
    by_second_[c] += slope[c];
  }
  return true;
}

void WideBound::set_terms(const TransitionSystem& system) {
  const detail::Rules& rules = system.rules();
  for (const WeightedTerm& addend : rules.terms) {
    if (addend.weight == 0 || !addend.term->sees.looks_back) continue;
    const std::optional<LookBackCosts> costs = addend.term->look_back_costs();
    if (!costs) {
      known_ = false;
      return;
    }
    if (!costs->change) {
      Way way;
      way.cost = addend.weight * costs->per_metre;
      way.start = costs->start;
      way.stride = rules.context.place_stride;
      RangeQuestion question;
      const RewardRange range = addend.term->range(question);
      way.farthest = std::max(std::abs(range.least), std::abs(range.greatest));
      set_prices(way);
      ways_.push_back(std::move(way));
      continue;
    }
    Changes changes;
    const detail::AttributeValues& attribute = rules.totals.attributes[costs->attribute];
    const std::size_t values = attribute.values.size();
    changes.weight = addend.weight;
    changes.stride = rules.context.stride[costs->attribute];
    changes.radix = rules.context.radix[costs->attribute];
    changes.with.assign(values + 1, std::vector<std::uint64_t>(system.open_words(), 0));
    for (ConnectionIndex c = 0; c < attribute.of_connection.size(); ++c) {
      std::vector<std::uint64_t>& with = changes.with[attribute.of_connection[c]];
      with[c / 64] |= std::uint64_t{1} << (c % 64);
    }
    // The cheapest way from one value to another, over others that no step asks for.
    std::vector<std::vector<double>> cost(values + 1, std::vector<double>(values + 1, 0));
    for (std::size_t from = 0; from <= values; ++from) {
      for (std::size_t to = 1; to <= values; ++to) {
        cost[from][to] = addend.weight * costs->change(from, to);
        changes.least_of_all = std::min(changes.least_of_all, cost[from][to]);
      }
    }
    const bool earns = changes.least_of_all < 0;
    if (!earns && !attribute.of_connection.empty() && !by_part_) {
      for (std::size_t by = 1; by <= values; ++by) {
        for (std::size_t from = 0; from <= values; ++from) {
          for (std::size_t to = 1; to <= values; ++to)
            cost[from][to] = std::min(cost[from][to], cost[from][by] + cost[by][to]);
        }
      }
      if (values <= kMostValues) {
        // Least cost from `last` to all of `set`, by sets of growing size: they contain the smaller
        // ones as numbers.
        const std::size_t sets = std::size_t{1} << values;
        changes.by_set.assign(sets * (values + 1), 0);
        for (std::size_t set = 1; set < sets; ++set) {
          for (std::size_t last = 0; last <= values; ++last) {
            const bool in_force = last > 0 && (set >> (last - 1) & 1U) != 0;
            double least = kInfinity;
            if (in_force) {
              least = changes.by_set[(set ^ (std::size_t{1} << (last - 1))) * (values + 1) + last];
            } else {
              for (std::size_t to = 1; to <= values; ++to) {
                if ((set >> (to - 1) & 1U) == 0) continue;
                const std::size_t rest = set ^ (std::size_t{1} << (to - 1));
                least = std::min(least, cost[last][to] + changes.by_set[rest * (values + 1) + to]);
              }
            }
            changes.by_set[set * (values + 1) + last] = least;
          }
        }
      } else {
        changes.way_in.assign(values + 1, kInfinity);
        for (std::size_t to = 1; to <= values; ++to) {
          for (std::size_t from = 1; from <= values; ++from) {
            if (from != to) changes.way_in[to] = std::min(changes.way_in[to], cost[from][to]);
          }
        }
        changes.first_is_free = true;
      }
    }
    changes_.push_back(std::move(changes));
  }
}

double WideBound::of_steps(SetView open) {
  if (plain_bound_) return (*plain_bound_)(open);
  double sum = 0;
  bool any_must = false;
  const Problem& problem = system_.problem();
  // Along falling lines it is now at the earliest; along others at the end, at best.
  double now = seconds_of_start_;
  if (!at_.empty()) {
    for_each_connection(system_.start().view(), [&](ConnectionIndex c) {
      if (!contains(open, c)) now += problem.connections()[c].duration;
    });
  }
  for_each_connection(open, [&](ConnectionIndex c) {
    const bool must = contains(must_, c);
    any_must = any_must || must;
    double most = greatest_[c];
    if (!at_.empty()) {
      const double slope = by_second_[c];
      most += at_[c];
      if (slope > 0) {
        most += slope * (seconds_of_start_ + all_seconds_ - problem.connections()[c].duration);
      } else if (!must) {
        most += slope * now;
      }
    }
    sum += must && !by_part_ ? most : std::max(0.0, most);
    if (must && by_part_) sum += std::min(0.0, most);
  });
  for (const ConnectionIndex c : falling_) {
    if (!contains(open, c) || !contains(must_, c)) continue;
    sum += by_second_[c] * now;
    now += problem.connections()[c].duration;
  }
  if (by_part_) {
    // At least one step, if any, and no more than there are pieces to come.
    const detail::Rules& rules = system_.rules();
    std::size_t pieces = 0;
    const ConnectionSet there = system_.present(open);
    rules.graph.for_each_piece(there.view(), [&](std::span<const PartIndex>) { ++pieces; });
    const std::size_t parts = system_.problem().num_parts();
    const auto steps =
        static_cast<double>(rules.making ? (pieces > 0 ? pieces - 1 : 0) : parts - pieces);
    const double least_steps = any_must ? 1 : 0;
    if (!cost_of_move_.empty() || !price_.empty()) {
      priced_moves_ = least_of_moves(open);
      sum -= priced_moves_;
    } else {
      sum += most_of_step_ > 0 ? most_of_step_ * std::max(steps, least_steps)
                               : most_of_step_ * least_steps;
    }
  }
  return sum + (may_stop_ ? std::max(0.0, last_surplus_) : last_surplus_);
}

// What the single parts that must still move cost at least.
double WideBound::least_of_moves(SetView open) {
  const Problem& problem = system_.problem();
  double sum = 0;
  if (cost_of_move_.empty()) {
    for_each_connection(open, [&](ConnectionIndex c) { sum += price_[c]; });
    return sum;
  }
  // Each part that is not the base's moves: away, while something still holds it, or here, while
  // nothing does.
  moves_.assign(problem.num_parts(), 0);
  const auto mark = [&](SetView connections, unsigned char value) {
    for_each_connection(connections, [&](ConnectionIndex c) {
      for (const PartIndex part : problem.ends(c)) moves_[part] = value;
    });
  };
  mark(open, 1);
  if (system_.rules().making) mark(system_.present(open).view(), 0);
  for (PartIndex part = 0; part < problem.num_parts(); ++part) {
    if (moves_[part] != 0 && !problem.in_base(part)) sum += cost_of_move_[part];
  }
  return sum;
}

double WideBound::of_changes(const Changes& changes, SetView state) const {
  const SetView open = system_.open(state);
  if (changes.least_of_all < 0)
    return 0.0 - changes.least_of_all * static_cast<double>(count(open));
  if (changes.by_set.empty() && changes.way_in.empty()) return 0;
  const std::size_t values = changes.with.size() - 1;
  const auto last =
      static_cast<std::size_t>(state[system_.open_words()] / changes.stride % changes.radix);
  const auto must_come = [&](std::size_t value) {
    for (std::size_t w = 0; w < open.size(); ++w) {
      if ((changes.with[value][w] & open[w] & must_[w]) != 0) return true;
    }
    return false;
  };
  if (!changes.by_set.empty()) {
    std::size_t set = 0;
    for (std::size_t value = 1; value <= values; ++value) {
      if (must_come(value)) set |= std::size_t{1} << (value - 1);
    }
    return 0.0 - changes.by_set[set * (values + 1) + last];
  }
  double sum = 0;
  double dearest = 0;
  for (std::size_t value = 1; value <= values; ++value) {
    if (value == last || !must_come(value)) continue;
    sum += changes.way_in[value];
    dearest = std::max(dearest, changes.way_in[value]);
  }
  return 0.0 - (last == 0 ? sum - dearest : sum);
}

// Collects in places_ what a state must still visit, by number, and returns whether there is any.
bool WideBound::collect_places(SetView open) {
  const detail::ContextLayout& context = system_.rules().context;
  wanted_.assign(context.places.size() + 1, 0);
  places_.clear();
  for_each_connection(open, [&](ConnectionIndex c) {
    const std::uint32_t place = context.place_of[c];
    if (!contains(must_, c) || wanted_[place] != 0) return;
    wanted_[place] = 1;
    places_.push_back(place);
  });
  return !places_.empty();
}

// The shortest tree that joins places_ and the place of number `from` (0: the start of the way,
// none where that is not stated), by lengths to which the prices of both ends are added. Counts in
// degree_, by number, how many of its edges end at each place. Prim's method.
double WideBound::tree(const Way& way, std::uint32_t from) {
  const detail::ContextLayout& context = system_.rules().context;
  const auto point = [&](std::uint32_t place) -> const Vector3& {
    return place == 0 ? *way.start : context.places[place - 1];
  };
  std::size_t left = places_.size();
  distance_.assign(left, kInfinity);
  nearest_.assign(left, from);
  std::uint32_t newest = from;
  if (from == kNoPlace) {
    // The tree begins at one of the places.
    newest = places_.back();
    --left;
  }
  double sum = 0;
  while (left > 0) {
    std::size_t next = 0;
    const Vector3& at = point(newest);
    for (std::size_t i = 0; i < left; ++i) {
      const double length =
          metres(at, point(places_[i])) + way.price[newest] + way.price[places_[i]];
      if (length < distance_[i]) {
        distance_[i] = length;
        nearest_[i] = newest;
      }
      if (distance_[i] < distance_[next]) next = i;
    }
    sum += distance_[next];
    newest = places_[next];
    ++degree_[newest];
    ++degree_[nearest_[next]];
    --left;
    std::swap(places_[next], places_[left]);
    distance_[next] = distance_[left];
    nearest_[next] = nearest_[left];
  }
  return sum;
}

// A way that ends anywhere is a tour by way of a point that costs nothing to reach: the least tree,
// and two edges to that point, one from where the way begins. Each place lies on two edges of a
// tour, so that prices of places change the length of every tour alike, and that of trees not.
double WideBound::length_of_way(const Way& way, std::uint32_t from) {
  double sum = 0;
  double cheapest = kInfinity;
  double second = kInfinity;
  for (const std::uint32_t place : places_) {
    const double price = way.price[place];
    sum -= 2 * price;
    if (price < cheapest) {
      second = cheapest;
      cheapest = price;
      end_ = place;
    } else {
      second = std::min(second, price);
    }
  }
  if (from != kNoPlace) {
    sum += cheapest - way.price[from];
  } else {
    sum += places_.size() == 1 ? 2 * cheapest : cheapest + second;
  }
  return std::max(0.0, sum + tree(way, from));
}

// Prices under which the tree of the start is long: raised where a place lies on more than two
// edges, lowered where on one.
void WideBound::set_prices(Way& way) {
  const detail::ContextLayout& context = system_.rules().context;
  way.price.assign(context.places.size() + 1, 0);
  degree_.assign(context.places.size() + 1, 0);
  const SetView start = system_.start_state();
  if (by_part_ || way.cost <= 0 || system_.ends(start)) return;
  const std::uint32_t from = place_in_force(way, start);
  if (!collect_places(system_.open(start))) return;
  const double places = static_cast<double>(places_.size());
  const int rounds = static_cast<int>(std::clamp(2e8 / (places * places + 1), 10.0, 400.0));
  std::vector<double> best = way.price;
  double longest = length_of_way(way, from);
  double step = longest / (places + 1) / 2;
  for (int round = 0; round < rounds; ++round, step *= 0.985) {
    std::ranges::fill(degree_, 0);
    const double length = length_of_way(way, from);
    if (length > longest) {
      longest = length;
      best = way.price;
    }
    ++degree_[end_];
    if (from != kNoPlace) ++degree_[from];
    for (const std::uint32_t place : places_) way.price[place] += step * (degree_[place] - 2.0);
    if (from != kNoPlace) way.price[from] += step * (degree_[from] - 2.0);
  }
  way.price = std::move(best);
}

// The number of the place where a state's last step was done; 0 for the start of the way, kNoPlace
// where there is none.
std::uint32_t WideBound::place_in_force(const Way& way, SetView state) const {
  const std::uint64_t last = state[system_.open_words()] / way.stride;
  if (last != 0) return static_cast<std::uint32_t>(last);
  return way.start ? 0 : kNoPlace;
}

double WideBound::of_way(const Way& way, SetView state) {
  const SetView open = system_.open(state);
  if (way.cost < 0) return way.farthest * static_cast<double>(count(open));
  if (by_part_ || !collect_places(open)) return 0;
  const std::uint32_t from = place_in_force(way, state);
  if (from != kNoPlace && from != 0 && wanted_[from] != 0) {
    // Steps at this very place cost nothing.
    std::erase(places_, from);
    if (places_.empty()) return 0;
  }
  return 0.0 - way.cost * length_of_way(way, from);
}

double WideBound::operator()(SetView state) {
  if (!known_) return kInfinity;
  if (system_.ends(state)) return 0;
  double sum = of_steps(system_.open(state));
  for (const Changes& changes : changes_) sum += of_changes(changes, state);
  for (const Way& way : ways_) sum += of_way(way, state);
  return sum;
}

}  // namespace orasp
