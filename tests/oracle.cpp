#include "tests/oracle.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

namespace orasp::oracle {
namespace {

constexpr double kSame =
    1e-9;  // numbers that differ by less, relatively, are the same number to a user

bool same(double x, double y) {
  return std::abs(x - y) <= kSame * std::max(std::abs(x), std::abs(y));
}
bool less(double x, double y) {
  return x < y && !same(x, y);
}

template <class Item>
std::size_t position(const std::vector<Item>& items, const std::string& id) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].id == id) return i;
  }
  throw std::logic_error("oracle: no " + id);
}

std::string opposite_of(const std::string& direction) {
  const std::string rest = direction.substr(1);
  if (direction[0] == '+') return "-" + rest;
  if (direction[0] != '-') return "-" + direction;
  return rest == "x" || rest == "y" || rest == "z" ? "+" + rest : rest;
}

std::size_t number_of(const State& set) {
  return static_cast<std::size_t>(std::count(set.begin(), set.end(), true));
}

State inverse(State set) {
  set.flip();
  return set;
}

Parts together(const Parts& a, const Parts& b) {
  Parts both = a;
  both.insert(b.begin(), b.end());
  return both;
}

/// A recursive-descent evaluator.
class Evaluator {
 public:
  Evaluator(const std::string& text, const std::map<std::string, double>& names)
      : text_(text), names_(names) {}

  double whole() {
    const double value = sum();
    if (peek() != '\0') throw std::logic_error("oracle: cannot read formula " + text_);
    return value;
  }

 private:
  char peek() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  double sum() {
    double value = product();
    while (peek() == '+' || peek() == '-') {
      const char sign = text_[at_++];
      const double next = product();
      value = sign == '+' ? value + next : value - next;
    }
    return value;
  }
  double product() {
    double value = factor();
    while (peek() == '*' || peek() == '/') {
      const char sign = text_[at_++];
      const double next = factor();
      value = sign == '*' ? value * next : value / next;
    }
    return value;
  }
  double factor() {
    const char next = peek();
    if (next == '-') {
      ++at_;
      return -factor();
    }
    if (next == '(') {
      ++at_;
      const double value = sum();
      if (peek() != ')') throw std::logic_error("oracle: cannot read formula " + text_);
      ++at_;
      return value;
    }
    std::size_t end = at_;
    if (std::isdigit(static_cast<unsigned char>(next)) != 0) {
      const double value = std::stod(text_.substr(at_), &end);
      at_ += end;
      return value;
    }
    while (end < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[end])) != 0 || text_[end] == '_'))
      ++end;
    const std::string name = text_.substr(at_, end - at_);
    at_ = end;
    return names_.at(name);
  }

  const std::string& text_;
  const std::map<std::string, double>& names_;
  std::size_t at_ = 0;
};

}  // namespace

double formula_value(const std::string& text, const std::map<std::string, double>& names) {
  return Evaluator(text, names).whole();
}

World::World(const ProblemSpec& spec) : spec_(spec) {
  touching_.resize(spec_.parts.size());
  given_up_.assign(spec_.connections.size(), false);
  for (Connection& connection : spec_.connections) {
    if (connection.id.empty()) connection.id = connection.parts[0] + "-" + connection.parts[1];
    const std::size_t first = position(spec_.parts, connection.parts[0]);
    const std::size_t second = position(spec_.parts, connection.parts[1]);
    touching_[first].push_back(ends_.size());
    touching_[second].push_back(ends_.size());
    ends_.emplace_back(first, second);
  }
  for (const Precedence& entry : spec_.precedence) {
    Clause clause{position(spec_.connections, entry.connection), {}, {}, {}};
    for (const std::string& id : entry.after) clause.after.insert(position(spec_.connections, id));
    for (const std::string& id : entry.after_any)
      clause.after_any.insert(position(spec_.connections, id));
    for (const std::string& id : entry.made_after_any)
      clause.made_after_any.insert(position(spec_.connections, id));
    for (const std::string& id : entry.made_after)
      clauses_.push_back({position(spec_.connections, id), {clause.connection}, {}, {}});
    clauses_.push_back(std::move(clause));
  }
  if (spec_.blocking) {
    for (const BlockingDirection& direction : spec_.blocking->directions) {
      blocks_[direction.id];
      blocks_[opposite_of(direction.id)];
    }
    for (const Blocked& blocked : spec_.blocking->blocked) {
      const std::size_t part = position(spec_.parts, blocked.part);
      const std::size_t by = position(spec_.parts, blocked.by);
      for (const std::string& direction : blocked.directions) {
        blocks_[direction].emplace(part, by);
        blocks_[opposite_of(direction)].emplace(by, part);
      }
    }
  }
}

Parts World::piece_of(std::size_t part, const State& present) const {
  Parts piece{part};
  std::vector<std::size_t> frontier{part};
  while (!frontier.empty()) {
    const std::size_t here = frontier.back();
    frontier.pop_back();
    for (const std::size_t c : touching_[here]) {
      if (!present[c]) continue;
      for (const std::size_t end : {ends_[c].first, ends_[c].second}) {
        if (piece.insert(end).second) frontier.push_back(end);
      }
    }
  }
  return piece;
}

std::size_t World::subassemblies(const State& present) const {
  std::size_t number = 0;
  std::vector<bool> seen(spec_.parts.size(), false);
  for (std::size_t part = 0; part < spec_.parts.size(); ++part) {
    if (seen[part]) continue;
    const Parts piece = piece_of(part, present);
    for (const std::size_t member : piece) seen[member] = true;
    if (piece.size() >= 2) ++number;
  }
  return number;
}

double World::mass_of(const Parts& piece) const {
  double mass = 0;
  for (const std::size_t part : piece) mass += spec_.parts[part].mass;
  return mass;
}

/// The one with fewer parts; on a tie the lighter; on a tie the one that does not hold the earliest
/// listed part.
bool World::first_moves(const Parts& a, const Parts& b) const {
  if (a.size() != b.size()) return a.size() < b.size();
  if (!same(mass_of(a), mass_of(b))) return mass_of(a) < mass_of(b);
  return !a.contains(*together(a, b).begin());
}

bool World::start_infeasible() const {
  return spec_.limits.max_subassemblies && subassemblies(start()) > *spec_.limits.max_subassemblies;
}

namespace {

bool any_in(const std::set<std::size_t>& list, const State& set) {
  return std::any_of(list.begin(), list.end(), [&](std::size_t c) { return bool{set[c]}; });
}
bool all_in(const std::set<std::size_t>& list, const State& set) {
  return !list.empty() &&
         std::all_of(list.begin(), list.end(), [&](std::size_t c) { return bool{set[c]}; });
}

/// Takes members of `candidates` into `set`, as long as there is one that may(c) come.
template <class May>
void take_in(const State& candidates, State& set, May&& may) {
  for (bool moving = true; moving;) {
    moving = false;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      if (!candidates[c] || set[c] || !may(c)) continue;
      set[c] = true;
      moving = true;
    }
  }
}

}  // namespace

State World::can_be_put_on(const State& present) const {
  State on = given_up_;  // in disassembly: what stays
  const auto may = [&](std::size_t c) {
    for (const Clause& clause : clauses_) {
      // What is removed after c is made before it.
      if (clause.after.contains(c) && present[clause.connection] && !on[clause.connection])
        return false;
      if (clause.connection == c && !clause.made_after_any.empty() &&
          !any_in(clause.made_after_any, on))
        return false;
    }
    return true;
  };
  take_in(present, on, may);
  return on;
}

State World::can_be_taken_off(const State& missing, const State& never) const {
  State off = never;
  const auto may = [&](std::size_t c) {
    const State there = inverse(off);
    for (const Clause& clause : clauses_) {
      if (clause.connection == c &&
          (any_in(clause.after, there) || all_in(clause.after_any, there)))
        return false;
    }
    return true;
  };
  take_in(missing, off, may);
  return off;
}

void World::judge_removal(const State& present, Facts& facts) const {
  State left = present;
  left[facts.connection] = false;
  const State on = can_be_put_on(left);
  for (const Clause& clause : clauses_) {
    if (clause.connection == facts.connection) {
      if (any_in(clause.after, present)) facts.broken.insert(Rule::Precedence);
      if (all_in(clause.after_any, present)) facts.broken.insert(Rule::PrecedenceAny);
    }
    if (!clause.made_after_any.contains(facts.connection) || !left[clause.connection]) continue;
    State others = left;
    others[clause.connection] = false;
    const bool shut = given_up_[clause.connection]
                          ? !any_in(clause.made_after_any, others)
                          : !on[clause.connection] && !any_in(clause.made_after_any, on);
    if (shut) facts.broken.insert(Rule::PrecedenceMadeAny);
  }
}

void World::judge_making(const State& open, Facts& facts) const {
  State missing = open;
  for (std::size_t c = 0; c < open.size(); ++c) {
    if (given_up_[c]) missing[c] = false;
  }
  const State to_make = missing;
  missing[facts.connection] = false;
  const State off = can_be_taken_off(missing, given_up_);
  State made = inverse(open);
  std::set<Rule> late;
  for (const Clause& clause : clauses_) {
    if (clause.after.contains(facts.connection) && to_make[clause.connection])
      facts.broken.insert(Rule::Precedence);
    if (clause.after_any.contains(facts.connection) && missing[clause.connection] &&
        !off[clause.connection] && !any_in(clause.after_any, off))
      facts.broken.insert(Rule::PrecedenceAny);
    if (clause.connection != facts.connection) continue;
    if (!clause.made_after_any.empty() && !any_in(clause.made_after_any, made))
      facts.broken.insert(Rule::PrecedenceMadeAny);
    if (any_in(clause.after, made)) late.insert(Rule::Precedence);
    State with = made;
    with[facts.connection] = true;
    if (all_in(clause.after_any, with)) late.insert(Rule::PrecedenceAny);
  }
  for (const Rule rule : late) {
    if (facts.broken.insert(rule).second) facts.too_late.insert(rule);
  }
}

void World::judge_precedence(const State& open, Facts& facts) const {
  if (clauses_.empty()) return;
  if (spec_.direction == Direction::Assembly) {
    judge_making(open, facts);
  } else {
    judge_removal(open, facts);
  }
}

std::set<Rule> World::broken_at_start(const State& open) const {
  std::set<Rule> broken;
  const State made = inverse(open);
  for (const Clause& clause : clauses_) {
    const std::size_t c = clause.connection;
    if (!open[c]) continue;
    if (spec_.direction == Direction::Assembly) {
      if (given_up_[c]) continue;
      if (any_in(clause.after, made)) broken.insert(Rule::Precedence);
      State with = made;
      with[c] = true;
      if (all_in(clause.after_any, with)) broken.insert(Rule::PrecedenceAny);
    } else if (!clause.made_after_any.empty()) {
      State others = open;
      others[c] = false;
      if (!any_in(clause.made_after_any, others)) broken.insert(Rule::PrecedenceMadeAny);
    }
  }
  return broken;
}

/// What judges cuts speaks of a removal, after which the connections `smaller` are there.
void World::judge_cut(const State& smaller, Facts& facts) const {
  std::set<Rule>& broken = facts.broken;
  if (!facts.separates) return;  // bound by precedence alone
  const Limits& limits = spec_.limits;
  if (limits.max_subassemblies && subassemblies(smaller) > *limits.max_subassemblies) {
    broken.insert(Rule::MaxSubassemblies);
  }
  if (limits.max_moved_parts && facts.moved.size() > *limits.max_moved_parts)
    broken.insert(Rule::MaxMovedParts);
  if (limits.max_moved_mass && less(*limits.max_moved_mass, facts.moved_mass))
    broken.insert(Rule::MaxMovedMass);
  if (spec_.blocking) {
    for (const auto& [direction, blocks] : blocks_) {
      const auto in_the_way = [&](const Parts& moved, const Parts& kept) {
        return std::any_of(blocks.begin(), blocks.end(), [&](const Block& block) {
          return moved.contains(block.first) && kept.contains(block.second);
        });
      };
      const bool a_moves = facts.moved == facts.a;
      if (!in_the_way(a_moves ? facts.a : facts.b, a_moves ? facts.b : facts.a))
        facts.free_directions.insert(direction);
    }
    if (facts.free_directions.empty()) broken.insert(Rule::Blocking);
  }
}

Facts World::facts(const State& open, std::size_t connection, std::size_t kept) const {
  State rest = open;
  rest[connection] = false;
  const bool assembly = spec_.direction == Direction::Assembly;
  const State present = assembly ? inverse(open) : open;
  const State present_after = assembly ? inverse(rest) : rest;
  const State& smaller = assembly ? present : present_after;

  Facts facts;
  facts.connection = connection;
  facts.before = number_of(present);
  facts.after = number_of(present_after);
  facts.completes = number_of(rest) == kept;
  facts.subassemblies = subassemblies(present_after);
  const Parts a = piece_of(ends_[connection].first, smaller);
  if (!a.contains(ends_[connection].second)) {
    const Parts b = piece_of(ends_[connection].second, smaller);
    facts.separates = true;
    facts.a = a;
    facts.b = b;
    facts.moved = first_moves(a, b) ? a : b;
    facts.moved_mass = mass_of(facts.moved);
    facts.kept_mass = mass_of(first_moves(a, b) ? b : a);
  }
  judge_precedence(open, facts);
  judge_cut(smaller, facts);
  facts.reward = reward(spec_.objective, facts);
  return facts;
}

std::vector<Facts> World::legal_facts(const State& open) const {
  std::vector<Facts> legal;
  for (std::size_t c = 0; c < num_connections(); ++c) {
    if (!open[c]) continue;
    Facts before;
    before.connection = c;
    judge_precedence(open, before);
    if (!before.legal()) continue;  // saves time in wide problems
    Facts one = facts(open, c);
    if (one.legal()) legal.push_back(std::move(one));
  }
  return legal;
}

bool World::positions_known(const Parts& piece) const {
  return std::all_of(piece.begin(), piece.end(),
                     [&](std::size_t part) { return spec_.parts[part].position.has_value(); });
}

double World::distance(const Parts& piece, const Vector3& depot) const {
  double squares = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double sum = 0;
    for (const std::size_t part : piece) sum += (*spec_.parts[part].position)[axis];
    const double offset = sum / static_cast<double>(piece.size()) - depot[axis];
    squares += offset * offset;
  }
  return std::sqrt(squares);
}

double World::reward(const Objective& objective, const Facts& facts) const {
  const std::size_t a = facts.a.size();
  const std::size_t b = facts.b.size();
  const auto by_size = [&](double operation, const std::map<std::size_t, double>& pieces,
                           double completion) {
    if (facts.completes) return completion;
    if (!facts.separates) return -operation;
    double cost = operation;
    for (const std::size_t size : {a, b}) cost += pieces.contains(size) ? pieces.at(size) : 0.0;
    return -cost;
  };

  if (objective.type == "cubesat") return by_size(0, {{1, 0.0967}, {2, 0.1248}, {3, 0.1368}}, 1);
  if (objective.type == "custom") return by_size(0.1, {{1, 1.0}, {2, 1.5}, {3, 1.75}}, 1);
  if (objective.type == "piece_cost") {
    const auto& p = std::get<PieceCost>(objective.parameters);
    return by_size(p.operation, p.pieces, p.completion);
  }
  if (objective.type == "cubesat_zone") {
    if (facts.completes) return 1;
    if (!facts.separates) return 0;
    const Parts whole = together(facts.a, facts.b);
    const bool far = whole.size() >= 4 || whole == piece_of(*whole.begin(), start());
    double cost = 0;
    for (const std::size_t size : {a, b}) {
      if (size == 1) cost += far ? 0.0967 : 0.0823;
      if (size == 2) cost += 0.0722;
      if (size == 3) cost += 0.0782;
    }
    return -cost;
  }
  if (objective.type == "indexed") {
    const auto n = static_cast<double>(facts.before);
    const auto i = static_cast<double>(facts.connection);
    return i < n - 1 ? n - i : -1;
  }
  if (objective.type == "time") {
    const auto& p = std::get<TimeObjective>(objective.parameters);
    double seconds = spec_.connections[facts.connection].duration;
    if (facts.separates) {
      seconds +=
          positions_known(facts.moved) ? 2 * distance(facts.moved, p.depot) / p.speed : p.transfer;
    }
    return -seconds;
  }
  if (objective.type == "travel") {
    if (!facts.separates) return 0;
    const double far = distance(facts.moved, std::get<Travel>(objective.parameters).depot);
    return -static_cast<double>(facts.moved.size()) * far * far;
  }
  if (objective.type == "fuel") {
    if (!facts.separates) return 0;
    const auto& p = std::get<Fuel>(objective.parameters);
    const double factor = std::exp(p.delta_v / (p.isp * 9.80665)) - 1;
    return -(p.dry_mass * factor + (p.dry_mass + facts.moved_mass) * factor);
  }
  if (objective.type == "completion") {
    const auto& p = std::get<CompletionObjective>(objective.parameters);
    return (facts.separates ? p.join : 0) - p.step + (facts.completes ? p.bonus : 0);
  }
  if (objective.type == "expression") {
    const auto& p = std::get<Expression>(objective.parameters);
    std::map<std::string, double> names = p.constants;
    names["before"] = static_cast<double>(facts.before);
    names["after"] = static_cast<double>(facts.after);
    names["separates"] = facts.separates ? 1 : 0;
    names["completes"] = facts.completes ? 1 : 0;
    names["moved_parts"] = static_cast<double>(facts.moved.size());
    names["kept_parts"] = static_cast<double>(a + b - facts.moved.size());
    names["moved_mass"] = facts.moved_mass;
    names["kept_mass"] = facts.kept_mass;
    names["subassemblies"] = static_cast<double>(facts.subassemblies);
    names["duration"] = spec_.connections[facts.connection].duration;
    names["index"] = static_cast<double>(facts.connection);
    names["distance"] =
        facts.separates && positions_known(facts.moved) ? distance(facts.moved, p.depot) : 0;
    return formula_value(p.formula, names);
  }
  if (objective.type == "callable") {
    Step step;
    step.connection = static_cast<ConnectionIndex>(facts.connection);
    step.before = facts.before;
    step.after = facts.after;
    step.separates = facts.separates;
    step.completes = facts.completes;
    step.a_moves = facts.separates && facts.moved == facts.a;
    step.a.assign(facts.a.begin(), facts.a.end());
    step.b.assign(facts.b.begin(), facts.b.end());
    step.moved_mass = facts.moved_mass;
    step.kept_mass = facts.kept_mass;
    step.subassemblies = facts.subassemblies;
    return std::get<Callable>(objective.parameters).reward(step);
  }
  if (objective.type == "sum") {
    double total = 0;
    for (const WeightedObjective& term : std::get<WeightedSum>(objective.parameters).terms) {
      total += term.weight * reward(term.objective, facts);
    }
    return total;
  }
  throw std::logic_error("oracle: no objective " + objective.type);
}

namespace {

struct Node {
  bool reaches = false;
  double best = -std::numeric_limits<double>::infinity();
  double worst = std::numeric_limits<double>::infinity();
  std::uint64_t nodes = 1;
  std::uint64_t sequences = 0;
  std::vector<std::pair<std::size_t, double>> actions;  ///< connection and reward; only in visit()
};

Node goal_node() {
  return {true, 0, 0, 1, 1, {}};
}

void add_branch(Node& node, double reward, const Node& below) {
  node.nodes += below.nodes;
  node.sequences += below.sequences;
  if (!below.reaches) return;
  node.reaches = true;
  node.best = std::max(node.best, reward + below.best);
  node.worst = std::min(node.worst, reward + below.worst);
}

const Node& visit(const World& world, const State& open, std::map<State, Node>& known,
                  OracleResult& result) {
  if (const auto found = known.find(open); found != known.end()) return found->second;
  const std::size_t layer = world.num_connections() - number_of(open);
  if (result.layers.size() <= layer) result.layers.resize(layer + 1);
  ++result.states;
  ++result.layers[layer].first;
  Node node;
  if (number_of(open) == 0) {
    node = goal_node();
  } else {
    const std::vector<Facts> legal = world.legal_facts(open);
    if (legal.empty()) ++result.dead_ends;
    for (const Facts& action : legal) {
      ++result.actions;
      ++result.layers[layer].second;
      node.actions.emplace_back(action.connection, action.reward);
      State next = open;
      next[action.connection] = false;
      add_branch(node, action.reward, visit(world, next, known, result));
    }
  }
  result.best_to_go[open] = node.best;
  return known.emplace(open, node).first->second;
}

Node visit_tree(const World& world, const State& open, OracleResult& result) {
  if (number_of(open) == 0) return goal_node();
  Node node;
  for (const Facts& action : world.legal_facts(open)) {
    State next = open;
    next[action.connection] = false;
    add_branch(node, action.reward, visit_tree(world, next, result));
  }
  return node;
}

void take_over(const World& world, const Node& root, OracleResult& result) {
  result.feasible = root.reaches && !world.start_infeasible();
  if (result.feasible) {
    result.best = root.best;
    result.worst = root.worst;
  }
  result.tree_nodes = root.nodes;
  result.sequences = root.sequences;
}

}  // namespace

OracleResult brute_force(const ProblemSpec& spec) {
  const World world(spec);
  OracleResult result;
  std::map<State, Node> known;
  take_over(world, visit(world, world.start(), known, result), result);

  // Forward: the best reward from the start, states with more open connections first.
  std::vector<State> order;
  for (const auto& [state, node] : known) order.push_back(state);
  std::stable_sort(order.begin(), order.end(),
                   [](const State& x, const State& y) { return number_of(x) > number_of(y); });
  result.best_from_start[world.start()] = 0;
  for (const State& open : order) {
    const double here = result.best_from_start.at(open);
    for (const auto& [connection, reward] : known.at(open).actions) {
      State next = open;
      next[connection] = false;
      const auto [at, is_new] = result.best_from_start.emplace(next, here + reward);
      if (!is_new) at->second = std::max(at->second, here + reward);
    }
  }
  return result;
}

OracleResult enumerate(const ProblemSpec& spec) {
  const World world(spec);
  OracleResult result;
  take_over(world, visit_tree(world, world.start(), result), result);
  return result;
}

OracleReplay replay(const ProblemSpec& spec, const std::vector<ConnectionIndex>& sequence) {
  const World world(spec);
  OracleReplay result;
  result.valid = !world.start_infeasible();
  State open = world.start();
  for (const ConnectionIndex c : sequence) {
    if (c >= open.size() || !open[c]) {
      result.valid = false;
      return result;
    }
    result.steps.push_back(world.facts(open, c));
    if (!result.steps.back().legal()) result.valid = false;
    result.reward += result.steps.back().reward;
    open[c] = false;
  }
  if (number_of(open) != 0) result.valid = false;
  return result;
}

}  // namespace orasp::oracle
