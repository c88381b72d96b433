#include "tests/symmetry/symmetric_problems.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "orasp/io/formula_parser.h"
#include "orasp/model/random.h"

namespace orasp {
namespace {

class Maker {
 public:
  explicit Maker(std::uint64_t seed) : random_(seed * 0x9e3779b97f4a7c15ULL + 7) {}

  ProblemSpec make() {
    spec_.direction = chance(0.5) ? Direction::Disassembly : Direction::Assembly;
    switch (below(6)) {
      case 0: hub(); break;
      case 1: copies(); break;
      case 2: ring(); break;
      case 3: grid(); break;
      case 4: nested(); break;
      default: side_by_side(); break;
    }
    limits();
    objective();
    if (chance(0.25)) spoil();
    shuffle_all();
    return std::move(spec_);
  }

 private:
  static constexpr std::array<const char*, 4> kQuarters = {"+x", "+y", "-x", "-y"};

  [[nodiscard]] std::size_t below(std::size_t n) {
    return static_cast<std::size_t>(random_.below(n));
  }
  [[nodiscard]] std::size_t between(std::size_t least, std::size_t most) {
    return least + below(most - least + 1);
  }
  [[nodiscard]] bool chance(double p) { return random_.uniform() < p; }

  std::string part(double mass) {
    Part part;
    part.id = "p" + std::to_string(spec_.parts.size());
    part.mass = mass;
    spec_.parts.push_back(part);
    return part.id;
  }
  std::string connect(const std::string& a, const std::string& b, double duration) {
    Connection connection;
    connection.id = "c" + std::to_string(spec_.connections.size());
    connection.parts = {a, b};
    connection.duration = duration;
    spec_.connections.push_back(connection);
    return connection.id;
  }
  void block(const std::string& part, const std::string& by, std::vector<std::string> directions) {
    if (!spec_.blocking) {
      spec_.blocking.emplace();
      spec_.blocking->directions = {"+x", "-x", "+y", "-y"};
    }
    spec_.blocking->blocked.push_back({part, by, std::move(directions), {}});
  }
  /// Turned by so many quarters: all that is not blocked in direction 0.
  static std::vector<std::string> all_but_one(std::size_t quarters) {
    std::vector<std::string> directions;
    for (std::size_t i = 1; i < 4; ++i) directions.push_back(kQuarters[(i + quarters) % 4]);
    return directions;
  }
  void precede(const std::string& what, const std::string& after) {
    Precedence clause;
    clause.connection = what;
    (chance(0.5) ? clause.after : clause.made_after).push_back(after);
    spec_.precedence.push_back(clause);
  }

  // Parts of one or two kinds around one.
  void hub() {
    const std::string middle = part(4);
    if (chance(0.3)) spec_.base.push_back(middle);
    std::vector<std::string> first;
    std::vector<std::string> kinds;
    for (std::size_t kind = 0, left = 8; kind < 2 && left > 1; ++kind) {
      const std::size_t many = between(2, std::min<std::size_t>(left, 5));
      left -= many;
      const bool blocked = chance(0.4);
      const bool turned = blocked && chance(0.5);
      for (std::size_t i = 0; i < many; ++i) {
        const std::string leaf = part(kind == 0 ? 1 : 2);
        const std::string c = connect(middle, leaf, kind == 0 ? 1 : 3);
        if (kind == 0) first.push_back(c);
        if (kind == 1) kinds.push_back(c);
        if (blocked)
          block(leaf, middle,
                turned      ? all_but_one(i)
                : kind == 0 ? std::vector<std::string>{"+x"}
                            : std::vector<std::string>{"-y", "+y"});
      }
    }
    if (chance(0.5) && !kinds.empty()) {
      Precedence clause;  // something of one kind only after all, or one, of the other
      for (const std::string& c : kinds) {
        clause = {};
        clause.connection = c;
        (chance(0.5) ? clause.after : clause.after_any) = first;
        if (one_kind_ == 0) one_kind_ = clause.after.empty() ? 2 : 1;
        clause.after = one_kind_ == 1 ? first : std::vector<std::string>{};
        clause.after_any = one_kind_ == 2 ? first : std::vector<std::string>{};
        spec_.precedence.push_back(clause);
      }
    }
  }

  // Copies of a small tree on one part, with precedence and blocking inside each.
  void copies() {
    const std::string middle = part(5);
    const bool base = chance(0.3);
    if (base) spec_.base.push_back(middle);
    const std::size_t size = between(1, 3);
    const std::size_t many = between(2, 9 / size > 4 ? 4 : 9 / size);
    std::vector<std::size_t> parent;
    for (std::size_t i = 0; i < size; ++i) parent.push_back(below(i + 1));
    const bool ordered = size > 1 && chance(0.4);
    const bool blocked = chance(0.4);
    const bool turned = blocked && chance(0.6);
    const bool made_any = size > 1 && chance(0.2);
    const bool second_link = size > 1 && many * (size + 1) <= 9 && chance(0.3);
    for (std::size_t copy = 0; copy < many; ++copy) {
      std::vector<std::string> here{middle};
      std::vector<std::string> links;
      for (std::size_t i = 0; i < size; ++i) {
        here.push_back(part(static_cast<double>(i % 2 + 1)));
        links.push_back(connect(here[parent[i]], here.back(), 1 + static_cast<double>(i)));
      }
      if (second_link) connect(here.back(), middle, 2);
      if (ordered) {
        Precedence clause;
        clause.connection = links.back();
        clause.after = {links.front()};
        spec_.precedence.push_back(clause);
      }
      if (made_any) {
        Precedence clause;
        clause.connection = links.front();
        clause.made_after_any = {links.back()};
        spec_.precedence.push_back(clause);
      }
      if (blocked)
        block(here.back(), middle,
              turned ? all_but_one(copy) : std::vector<std::string>{"+x", "-x"});
      if (turned && size > 1) block(here[1], here[2], {kQuarters[copy % 4]});
    }
  }

  void ring() {
    const std::size_t many = between(3, 6);
    const bool legs = many <= 4 && chance(0.5);
    std::vector<std::string> here;
    for (std::size_t i = 0; i < many; ++i) here.push_back(part(1));
    for (std::size_t i = 0; i < many; ++i) connect(here[i], here[(i + 1) % many], 1);
    if (legs) {
      for (std::size_t i = 0; i < many; ++i) connect(here[i], part(0.5), 2);
    }
    if (chance(0.3)) {
      for (std::size_t i = 0; i < many; ++i) block(here[i], here[(i + 1) % many], {"+x"});
    } else if (many == 4 && chance(0.7)) {
      for (std::size_t i = 0; i < many; ++i)
        block(here[i], here[(i + 1) % many], chance(0.9) ? all_but_one(i) : all_but_one(0));
    }
  }

  void grid() {
    const std::size_t wide = between(2, 3);
    const std::size_t high = 2;
    std::vector<std::string> here;
    for (std::size_t i = 0; i < wide * high; ++i) here.push_back(part(1));
    for (std::size_t y = 0; y < high; ++y) {
      for (std::size_t x = 0; x < wide; ++x) {
        if (x + 1 < wide) connect(here[y * wide + x], here[y * wide + x + 1], 1);
        if (y + 1 < high) connect(here[y * wide + x], here[(y + 1) * wide + x], 1);
      }
    }
    if (chance(0.3)) {
      for (std::size_t x = 0; x < wide; ++x) block(here[x], here[wide + x], {"+y"});
    }
  }

  // Equal parts with equal parts on them.
  void nested() {
    const bool apart = chance(0.3);
    const std::string middle = apart ? "" : part(9);
    const std::size_t outer = between(2, 3);
    const std::size_t inner = outer == 2 ? between(2, 3) : 2;
    for (std::size_t i = 0; i < outer; ++i) {
      const std::string body = part(3);
      if (!apart) connect(middle, body, 4);
      for (std::size_t j = 0; j < inner; ++j) connect(body, part(1), 1);
    }
  }

  // Equal connections between the same two parts, and fasteners with two ends.
  void side_by_side() {
    const std::string one = part(2);
    const std::string other = part(chance(0.5) ? 2 : 3);
    const std::size_t many = between(2, 4);
    for (std::size_t i = 0; i < many; ++i) connect(one, other, 1);
    const std::size_t bolts = between(0, 2);
    for (std::size_t i = 0; i < bolts; ++i) {
      const std::string bolt = part(0.1);
      const std::string head = connect(bolt, one, 2);
      const std::string end = connect(bolt, other, 5);
      if (i == 0) order_bolts_ = chance(0.4);
      if (order_bolts_) precede(end, head);
    }
  }

  void limits() {
    if (chance(0.2)) spec_.limits.max_subassemblies = between(1, 3);
    if (chance(0.2)) spec_.limits.max_moved_parts = between(1, 3);
    if (chance(0.2)) spec_.limits.max_moved_mass = static_cast<double>(between(2, 8));
    if (!spec_.base.empty() && chance(0.3)) spec_.limits.grounded = true;
  }

  Objective plain() {
    switch (below(6)) {
      case 0: return Objective::named("cubesat");
      case 1: return Objective::named("cubesat_zone");
      case 2: return Objective::named("completion");
      case 3: return Objective::named("time");
      case 4: return Objective::named("fuel");
      default: {
        PieceCost cost{.operation = 0.3, .pieces = {}, .completion = 1};
        for (std::size_t size = 1; size < 6; ++size)
          cost.pieces[size] = static_cast<double>(below(7)) * 0.25 - 0.5;
        return {"piece_cost", cost};
      }
    }
  }
  void objective() {
    if (chance(0.6)) {
      spec_.objective = plain();
    } else if (chance(0.5)) {
      WeightedSum sum;
      for (std::size_t i = between(1, 3); i > 0; --i)
        sum.terms.push_back({static_cast<double>(below(5)) - 2, plain()});
      spec_.objective = {"sum", sum};
    } else {
      constexpr std::array<const char*, 6> kFormulas = {
          "-duration*before",
          "moved_parts*kept_parts - 0.5*subassemblies*duration",
          "separates*(before - 3) + completes*moved_parts",
          "duration/(1 + after) - separates*moved_parts*moved_parts",
          "0 - index*before",
          "moved_mass - kept_mass*duration"};
      spec_.objective = {"expression", Expression{.formula = kFormulas[below(kFormulas.size())],
                                                  .constants = {},
                                                  .depot = {},
                                                  .compiler = compile_formula}};
    }
  }

  // Tells some of what is equal apart, by one of the things that a problem may state.
  void spoil() {
    Part& part = spec_.parts[below(spec_.parts.size())];
    Connection& connection = spec_.connections[below(spec_.connections.size())];
    switch (below(9)) {
      case 0: part.mass += 1; break;
      case 1: part.numbers["weight"] = 2; break;
      case 2: connection.duration += 1; break;
      case 3: connection.numbers["force"] = 3; break;
      case 4: connection.attributes["tool"] = "key"; break;
      case 5: part.position = Vector3{1, 2, 3}; break;
      case 6:
        if (spec_.base.empty()) spec_.base.push_back(part.id);
        break;
      case 7: {
        const Connection& other = spec_.connections[below(spec_.connections.size())];
        if (other.id != connection.id) precede(connection.id, other.id);
        break;
      }
      default: {
        const Part& other = spec_.parts[below(spec_.parts.size())];
        if (other.id != part.id) block(part.id, other.id, {"+x", "+y"});
      }
    }
  }

  template <class Item>
  void shuffle(std::vector<Item>& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[below(i)]);
  }
  void shuffle_all() {
    shuffle(spec_.parts);
    shuffle(spec_.connections);
    shuffle(spec_.precedence);
    for (Connection& connection : spec_.connections) {
      if (chance(0.5)) std::swap(connection.parts[0], connection.parts[1]);
    }
    if (spec_.blocking) shuffle(spec_.blocking->blocked);
  }

  SplitMix64 random_;
  ProblemSpec spec_;
  int one_kind_ = 0;
  bool order_bolts_ = false;
};

}  // namespace

ProblemSpec symmetric_problem(std::uint64_t seed) {
  ProblemSpec spec = Maker(seed).make();
  spec.name = "symmetric " + std::to_string(seed);
  return spec;
}

}  // namespace orasp
