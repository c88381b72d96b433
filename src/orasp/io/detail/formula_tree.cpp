#include "orasp/io/detail/formula_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <utility>

#include "orasp/model/tolerance.h"

namespace orasp::detail {

namespace {

using Kind = FormulaTree::Kind;
using Node = FormulaTree::Node;

constexpr Interval kAnything{-kInfinity, kInfinity};

bool is_point(const Interval& x) {
  return x.least == x.greatest;
}

Interval sound(double least, double greatest) {
  if (std::isnan(least) || std::isnan(greatest)) return kAnything;
  return {least, greatest};
}
Interval hull(const Interval& a, const Interval& b) {
  return {std::min(a.least, b.least), std::max(a.greatest, b.greatest)};
}
Interval operator+(const Interval& a, const Interval& b) {
  return sound(a.least + b.least, a.greatest + b.greatest);
}
Interval operator-(const Interval& a) {
  return {0.0 - a.greatest, 0.0 - a.least};
}
Interval operator-(const Interval& a, const Interval& b) {
  return sound(a.least - b.greatest, a.greatest - b.least);
}
/// From the least to the greatest of what `f` makes of the ends.
template <class Function>
Interval of_ends(const Interval& a, const Interval& b, Function&& f) {
  Interval all{kInfinity, -kInfinity};
  for (const double x : {a.least, a.greatest}) {
    for (const double y : {b.least, b.greatest}) {
      const double value = f(x, y);
      if (std::isnan(value)) return kAnything;
      all = hull(all, {value, value});
    }
  }
  return all;
}
Interval operator*(const Interval& a, const Interval& b) {
  constexpr Interval kZero{0, 0};
  if (is_point(a) && a.least == 0) return kZero;
  if (is_point(b) && b.least == 0) return kZero;
  return of_ends(a, b, [](double x, double y) { return x * y; });
}
Interval operator/(const Interval& a, const Interval& b) {
  if (b.least <= 0 && b.greatest >= 0) return kAnything;
  return of_ends(a, b, [](double x, double y) { return x / y; });
}

Interval power(const Interval& x, const Interval& y) {
  const auto pow = [](double base, double exponent) { return std::pow(base, exponent); };
  if (is_point(x) && is_point(y)) return sound(pow(x.least, y.least), pow(x.least, y.least));
  // Above 0 it is monotone in the base and in the exponent.
  if (x.least > 0 || (x.least == 0 && y.least > 0)) return of_ends(x, y, pow);
  if (!is_point(y) || y.least != std::floor(y.least) || y.least < 0 || y.least > 64)
    return kAnything;
  Interval ends = of_ends(x, y, pow);
  const bool even = std::fmod(y.least, 2) == 0;
  if (even && x.least < 0 && x.greatest > 0)
    ends.least = std::min(ends.least, y.least == 0 ? 1.0 : 0.0);
  return ends;
}

Interval truth(bool may_be_false, bool may_be_true) {
  return {may_be_false ? 0.0 : 1.0, may_be_true ? 1.0 : 0.0};
}
bool may_be_zero(const Interval& x) {
  return x.least <= 0 && x.greatest >= 0;
}
bool may_be_other(const Interval& x) {
  return x.least != 0 || x.greatest != 0;
}

Interval compared(Kind kind, const Interval& a, const Interval& b) {
  const bool apart = a.greatest < b.least || b.greatest < a.least;
  const bool same = is_point(a) && is_point(b) && a.least == b.least;
  switch (kind) {
    case Kind::Less: return truth(a.greatest >= b.least, a.least < b.greatest);
    case Kind::LessOrEqual: return truth(a.greatest > b.least, a.least <= b.greatest);
    case Kind::Greater: return truth(b.greatest >= a.least, b.least < a.greatest);
    case Kind::GreaterOrEqual: return truth(b.greatest > a.least, b.least <= a.greatest);
    case Kind::Equal: return truth(!same, !apart);
    default: return truth(!apart, !same);
  }
}

// The functions of muParser, by what is known of them.

enum class Shape { Rises, Even, Wave, Reciprocal, Several };

struct Function {
  std::string_view name;
  Shape shape;
  double (*of)(double) = nullptr;
  double least = -kInfinity;  ///< of the numbers that it takes
  double greatest = kInfinity;
};

double sign_of(double x) {
  return x < 0 ? -1 : x > 0 ? 1 : 0;
}
double rounded(double x) {
  return std::floor(x + 0.5);
}

constexpr std::array<Function, 26> kFunctions = {{
    {"abs", Shape::Even, [](double x) { return std::abs(x); }},
    {"cosh", Shape::Even, [](double x) { return std::cosh(x); }},
    {"acosh", Shape::Rises, [](double x) { return std::acosh(x); }, 1},
    {"asin", Shape::Rises, [](double x) { return std::asin(x); }, -1, 1},
    {"asinh", Shape::Rises, [](double x) { return std::asinh(x); }},
    {"atan", Shape::Rises, [](double x) { return std::atan(x); }},
    {"atanh", Shape::Rises, [](double x) { return std::atanh(x); }, -1, 1},
    {"exp", Shape::Rises, [](double x) { return std::exp(x); }},
    {"ln", Shape::Rises, [](double x) { return std::log(x); }, 0},
    {"log", Shape::Rises, [](double x) { return std::log(x); }, 0},
    {"log10", Shape::Rises, [](double x) { return std::log10(x); }, 0},
    {"log2", Shape::Rises, [](double x) { return std::log2(x); }, 0},
    {"rint", Shape::Rises, rounded},
    {"sign", Shape::Rises, sign_of},
    {"sinh", Shape::Rises, [](double x) { return std::sinh(x); }},
    {"sqrt", Shape::Rises, [](double x) { return std::sqrt(x); }, 0},
    {"tanh", Shape::Rises, [](double x) { return std::tanh(x); }},
    {"acos", Shape::Reciprocal, [](double x) { return std::acos(x); }, -1, 1},
    {"cos", Shape::Wave, [](double x) { return std::cos(x); }},
    {"sin", Shape::Wave, [](double x) { return std::sin(x); }},
    {"tan", Shape::Several, [](double x) { return std::tan(x); }},
    {"atan2", Shape::Several},
    {"avg", Shape::Several},
    {"max", Shape::Several},
    {"min", Shape::Several},
    {"sum", Shape::Several},
}};

Interval of_one(const Function& function, const Interval& x) {
  if (x.least < function.least || x.greatest > function.greatest) return kAnything;
  const double low = function.of(x.least);
  const double high = function.of(x.greatest);
  if (is_point(x)) return sound(low, low);
  switch (function.shape) {
    case Shape::Rises: return sound(low, high);
    case Shape::Reciprocal: return sound(high, low);
    case Shape::Even:
      if (x.least < 0 && x.greatest > 0) return sound(function.of(0), std::max(low, high));
      return sound(std::min(low, high), std::max(low, high));
    case Shape::Wave: return {-1, 1};
    default: return kAnything;
  }
}

/// Reads a text by descent through the ranks of its operators.
class Reader {
 public:
  Reader(const std::string& text, const std::map<std::string, double>& constants,
         const std::vector<std::string>& own)
      : text_(text), constants_(constants), own_(own) {}

  [[nodiscard]] std::optional<std::vector<Node>> read() {
    const auto whole = choice(0);
    skip();
    if (!whole || at_ != text_.size()) return std::nullopt;
    return std::move(nodes_);
  }

 private:
  using Found = std::optional<std::size_t>;

  void skip() {
    while (at_ < text_.size() &&
           std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos)
      ++at_;
  }
  bool takes(std::string_view token) {
    skip();
    if (text_.compare(at_, token.size(), token) != 0) return false;
    at_ += token.size();
    return true;
  }
  std::size_t add(Node node) {
    nodes_.push_back(std::move(node));
    return nodes_.size() - 1;
  }
  std::size_t add(Kind kind, std::vector<std::size_t> children) {
    return add(Node{.kind = kind, .children = std::move(children)});
  }

  Found choice(int deep) {
    if (deep > FormulaTree::kMostDeep) return std::nullopt;
    const Found condition = chain(0, deep);
    if (!condition || !takes("?")) return condition;
    const Found yes = choice(deep + 1);
    if (!yes || !takes(":")) return std::nullopt;
    const Found no = choice(deep + 1);
    if (!no) return std::nullopt;
    return add(Kind::Choose, {*condition, *yes, *no});
  }

  struct Operator {
    std::string_view token;
    Kind kind;
  };
  /// The operators of each rank, the loosest first; longer tokens before those that begin them.
  static const std::vector<std::vector<Operator>>& ranks() {
    static const std::vector<std::vector<Operator>> kRanks = {
        {{"||", Kind::Or}},
        {{"&&", Kind::And}},
        {{"<=", Kind::LessOrEqual},
         {">=", Kind::GreaterOrEqual},
         {"==", Kind::Equal},
         {"!=", Kind::NotEqual},
         {"<", Kind::Less},
         {">", Kind::Greater}},
        {{"+", Kind::Add}, {"-", Kind::Subtract}},
        {{"*", Kind::Multiply}, {"/", Kind::Divide}},
    };
    return kRanks;
  }
  Found chain(std::size_t rank, int deep) {
    if (rank == ranks().size()) return with_sign(deep);
    Found left = chain(rank + 1, deep);
    while (left) {
      const auto& operators = ranks()[rank];
      const auto found =
          std::ranges::find_if(operators, [&](const Operator& one) { return takes(one.token); });
      if (found == operators.end()) break;
      const Found right = chain(rank + 1, deep);
      if (!right) return std::nullopt;
      left = add(found->kind, {*left, *right});
    }
    return left;
  }
  Found with_sign(int deep) {
    if (takes("+")) return raised(deep);
    if (!takes("-")) return raised(deep);
    const Found inner = raised(deep);
    if (!inner) return std::nullopt;
    return add(Kind::Minus, {*inner});
  }
  Found raised(int deep) {
    if (deep > FormulaTree::kMostDeep) return std::nullopt;
    const Found base = single(deep);
    if (!base || !takes("^")) return base;
    const Found exponent = with_sign(deep + 1);
    if (!exponent) return std::nullopt;
    return add(Kind::Power, {*base, *exponent});
  }
  Found single(int deep) {
    if (takes("(")) {
      const Found inner = choice(deep + 1);
      return inner && takes(")") ? inner : std::nullopt;
    }
    skip();
    if (at_ >= text_.size()) return std::nullopt;
    const char first = text_[at_];
    if ((first >= '0' && first <= '9') || first == '.') return number();
    std::size_t end = at_;
    const auto in_name = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    };
    while (end < text_.size() && in_name(text_[end])) ++end;
    const std::string name = text_.substr(at_, end - at_);
    if (name.empty()) return std::nullopt;
    at_ = end;
    if (takes("(")) return call(name, deep);
    for (std::size_t i = 0; i < kFormulaVariables.size(); ++i) {
      if (kFormulaVariables[i].name == name) return add(Node{.kind = Kind::Variable, .which = i});
    }
    const auto own = std::ranges::find(own_, name);
    if (own != own_.end())
      return add(Node{.kind = Kind::Own, .which = static_cast<std::size_t>(own - own_.begin())});
    const auto constant = constants_.find(name);
    if (constant != constants_.end()) return add(Node{.number = constant->second});
    return std::nullopt;
  }
  Found number() {
    const char* const begin = text_.c_str() + at_;
    char* end = nullptr;
    const double value = std::strtod(begin, &end);
    const std::string_view token(begin, static_cast<std::size_t>(end - begin));
    if (token.empty() || token.find_first_of("xXpPnN") != std::string_view::npos)
      return std::nullopt;
    at_ += token.size();
    return add(Node{.number = value});
  }
  Found call(const std::string& name, int deep) {
    const auto function = std::ranges::find(kFunctions, name, &Function::name);
    if (function == kFunctions.end()) return std::nullopt;
    Node node{.kind = Kind::Call, .which = static_cast<std::size_t>(function - kFunctions.begin())};
    do {
      const Found argument = choice(deep + 1);
      if (!argument) return std::nullopt;
      node.children.push_back(*argument);
    } while (takes(","));
    if (!takes(")")) return std::nullopt;
    const bool fits = function->of != nullptr ? node.children.size() == 1
                      : name == "atan2"       ? node.children.size() == 2
                                              : !node.children.empty();
    return fits ? Found(add(std::move(node))) : std::nullopt;
  }

  const std::string& text_;
  const std::map<std::string, double>& constants_;
  const std::vector<std::string>& own_;
  std::size_t at_ = 0;
  std::vector<Node> nodes_;
};

bool stands_still(const FormulaLine& line) {
  return line.slope.least == 0 && line.slope.greatest == 0;
}

}  // namespace

std::optional<FormulaTree> FormulaTree::read(const std::string& text,
                                             const std::map<std::string, double>& constants,
                                             const std::vector<std::string>& own) {
  auto nodes = Reader(text, constants, own).read();
  if (!nodes) return std::nullopt;
  FormulaTree tree;
  tree.nodes_ = std::move(*nodes);
  return tree;
}

FormulaLine FormulaTree::over(const FormulaRanges& ranges) const {
  std::vector<FormulaLine> found(nodes_.size());
  // All values that a line takes in the time there is.
  const auto flat = [&](const FormulaLine& line) {
    if (stands_still(line)) return line.at;
    return line.at + line.slope * ranges.time;
  };
  const auto still = [](const Interval& at) { return FormulaLine{at, {0, 0}}; };
  const auto choose = [&](const Node& node) -> FormulaLine {
    const Interval condition = flat(found[node.children[0]]);
    const FormulaLine& yes = found[node.children[1]];
    const FormulaLine& no = found[node.children[2]];
    if (!may_be_zero(condition)) return yes;
    if (!may_be_other(condition)) return no;
    // Where time does not choose, it is one of the two for all times.
    if (stands_still(found[node.children[0]]))
      return {hull(yes.at, no.at), hull(yes.slope, no.slope)};
    return still(hull(flat(yes), flat(no)));
  };
  const auto call = [&](const Node& node) -> FormulaLine {
    const Function& function = kFunctions[node.which];
    if (function.of != nullptr) return still(of_one(function, flat(found[node.children[0]])));
    if (function.name == "sum" || function.name == "avg") {
      FormulaLine sum;
      for (const std::size_t child : node.children) {
        sum.at = sum.at + found[child].at;
        sum.slope = sum.slope + found[child].slope;
      }
      if (function.name == "sum") return sum;
      const auto size = static_cast<double>(node.children.size());
      return {sum.at / Interval{size, size}, sum.slope / Interval{size, size}};
    }
    Interval all = flat(found[node.children[0]]);
    if (function.name == "atan2") {
      const Interval second = flat(found[node.children[1]]);
      if (!is_point(all) || !is_point(second)) return still({-4, 4});
      const double value = std::atan2(all.least, second.least);
      return still({value, value});
    }
    if (node.children.size() == 1) return found[node.children[0]];
    for (const std::size_t child : node.children) {
      const Interval one = flat(found[child]);
      all = function.name == "max"
                ? Interval{std::max(all.least, one.least), std::max(all.greatest, one.greatest)}
                : Interval{std::min(all.least, one.least), std::min(all.greatest, one.greatest)};
    }
    return still(all);
  };
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    const auto child = [&](std::size_t which) -> const FormulaLine& {
      return found[node.children[which]];
    };
    FormulaLine& line = found[i];
    switch (node.kind) {
      case Kind::Number: line = still({node.number, node.number}); break;
      case Kind::Variable: line = ranges.variables[node.which]; break;
      case Kind::Own: line = ranges.own[node.which]; break;
      case Kind::Minus: line = {-child(0).at, -child(0).slope}; break;
      case Kind::Add: line = {child(0).at + child(1).at, child(0).slope + child(1).slope}; break;
      case Kind::Subtract:
        line = {child(0).at - child(1).at, child(0).slope - child(1).slope};
        break;
      case Kind::Multiply:
        if (stands_still(child(0))) {
          line = {child(0).at * child(1).at, child(0).at * child(1).slope};
        } else if (stands_still(child(1))) {
          line = {child(0).at * child(1).at, child(0).slope * child(1).at};
        } else {
          line = still(flat(child(0)) * flat(child(1)));
        }
        break;
      case Kind::Divide:
        line = stands_still(child(1))
                   ? FormulaLine{child(0).at / child(1).at, stands_still(child(0))
                                                                ? Interval{0, 0}
                                                                : child(0).slope / child(1).at}
                   : still(flat(child(0)) / flat(child(1)));
        break;
      case Kind::Power: line = still(power(flat(child(0)), flat(child(1)))); break;
      case Kind::And:
      case Kind::Or: {
        const Interval a = flat(child(0));
        const Interval b = flat(child(1));
        line = still(
            node.kind == Kind::And
                ? truth(may_be_zero(a) || may_be_zero(b), may_be_other(a) && may_be_other(b))
                : truth(may_be_zero(a) && may_be_zero(b), may_be_other(a) || may_be_other(b)));
        break;
      }
      case Kind::Choose: line = choose(node); break;
      case Kind::Call: line = call(node); break;
      default: line = still(compared(node.kind, flat(child(0)), flat(child(1))));
    }
  }
  const FormulaLine& whole = found.back();
  const bool known = std::isfinite(whole.slope.least) && std::isfinite(whole.slope.greatest);
  return known ? whole : still(kAnything);
}

}  // namespace orasp::detail
