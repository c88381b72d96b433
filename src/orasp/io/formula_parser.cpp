#include "orasp/io/formula_parser.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <muParser.h>

#include "orasp/io/detail/formula_tree.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"
#include "orasp/model/formula_range.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

constexpr std::size_t kLongestFormula = 10'000;  // bytes

/// A bare `=` assigns in muParser: a formula that stores something is not a function of the step.
void refuse_assignments(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
    } else if (i == 0 || std::string_view("<>!").find(text[i - 1]) == std::string_view::npos) {
      throw InputError(fmt::format("\"=\" at character {} assigns; write == to compare", i + 1));
    }
  }
}

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

/// What is wrong with a token that means nothing to muParser. `position` counts bytes from 0.
std::string unknown_token(const mu::ParserBase& parser, const std::string& text,
                          std::size_t position) {
  std::size_t end = position;
  while (end < text.size() && is_name_character(text[end])) ++end;
  const std::string name = text.substr(position, end - position);
  const std::size_t character = position + 1;
  if (name.empty()) {
    const auto length = static_cast<unsigned char>(text[position]) < 0x80 ? 1 : std::string::npos;
    return fmt::format("{} at character {} means nothing in a formula",
                       detail::in_quotes(text.substr(position, length)), character);
  }
  if (name[0] >= '0' && name[0] <= '9') {
    return fmt::format("{} at character {} is not a number", detail::in_quotes(name), character);
  }
  if (parser.GetFunDef().contains(name)) {
    return fmt::format("the function {} at character {} needs its arguments in parentheses",
                       detail::in_quotes(name), character);
  }
  const std::size_t next = text.find_first_not_of(" \t\r\n", end);
  const bool is_called = next != std::string::npos && text[next] == '(';
  std::vector<std::string_view> known;
  if (is_called) {
    for (const auto& function : parser.GetFunDef()) known.push_back(function.first);
  } else {
    for (const FormulaVariable& variable : kFormulaVariables) known.push_back(variable.name);
    for (const auto& variable : parser.GetVar()) {
      if (!is_formula_variable(variable.first)) known.push_back(variable.first);
    }
    for (const auto& constant : parser.GetConst()) known.push_back(constant.first);
  }
  return fmt::format("unknown {0} {1} at character {2}; known are {3}{4}",
                     is_called ? "function" : "name", detail::in_quotes(name), character,
                     detail::listed(known), detail::suggestion(name, known));
}

/// muParser's error said in a sentence of ours.
std::string explained(const mu::ParserBase& parser, const std::string& text,
                      const mu::ParserError& error) {
  const auto position = static_cast<std::size_t>(std::max(error.GetPos(), 0));
  switch (error.GetCode()) {
    case mu::ecUNASSIGNABLE_TOKEN:
      if (position < text.size()) return unknown_token(parser, text, position);
      break;
    case mu::ecUNEXPECTED_EOF: return "the formula ends too early";
    case mu::ecMISSING_PARENS: return "a closing parenthesis is missing";
    case mu::ecMISSING_ELSE_CLAUSE: return R"(a "?" has no ":")";
    case mu::ecMISPLACED_COLON: return R"(a ":" has no "?")";
    case mu::ecUNEXPECTED_CONDITIONAL: return R"(a "?" or ":" follows no value)";
    default: break;
  }
  std::string message = error.GetMsg();
  for (const std::string_view place : {" found at position", " found at expression position",
                                       " at expression position", " at position"}) {
    message.erase(std::min(message.find(place), message.size()));
  }
  while (!message.empty() &&
         std::string_view(".!\n ").find(message.back()) != std::string_view::npos) {
    message.pop_back();
  }
  if (!message.empty() && message[0] >= 'A' && message[0] <= 'Z') {
    message[0] = static_cast<char>(message[0] - 'A' + 'a');
  }
  return fmt::format("{} at character {}", message, position + 1);
}

class MuParserFormula final : public RangedFormula {
 public:
  MuParserFormula(const std::string& text, const std::map<std::string, double>& constants,
                  const std::vector<std::string>& own)
      : text_(text), own_names_(own), own_(own.size(), 0.0) {
    for (std::size_t i = 0; i < own.size(); ++i) parser_.DefineVar(own[i], &own_[i]);
    for (const FormulaVariable& variable : kFormulaVariables) {
      parser_.DefineVar(std::string(variable.name), &(variables_.*variable.value));
    }
    for (const auto& [name, value] : constants) {
      if (parser_.GetFunDef().contains(name) || parser_.GetConst().contains(name)) {
        throw InputError(
            fmt::format("the constant {} has the name of a function or constant of every formula",
                        detail::in_quotes(name)));
      }
      if (std::ranges::find(own, name) != own.end()) {
        throw InputError(
            fmt::format("the constant {} has the name of a number that parts or connections state",
                        detail::in_quotes(name)));
      }
      parser_.DefineConst(name, value);
    }
    parser_.SetExpr(text);
    try {
      (void)parser_.Eval();  // compiles
    } catch (const mu::ParserError& error) {
      throw InputError(explained(parser_, text, error));
    }
    if (parser_.GetNumResults() != 1) {
      throw InputError(
          "the formula has several results; a comma separates the arguments of a function");
    }
    for (const auto& used : parser_.GetUsedVar()) used_.insert(used.first);
  }

  [[nodiscard]] double value(const FormulaVariables& variables) override {
    variables_ = variables;
    std::ranges::copy(variables.own.first(std::min(own_.size(), variables.own.size())),
                      own_.begin());
    try {
      return parser_.Eval();
    } catch (const mu::ParserError& error) {
      throw InputError(error.GetMsg());
    }
  }
  [[nodiscard]] bool uses(std::string_view name) const override { return used_.contains(name); }
  [[nodiscard]] FormulaLine over(const FormulaRanges& ranges) override {
    if (!read_) {
      read_ = true;
      tree_ = detail::FormulaTree::read(
          text_, {parser_.GetConst().begin(), parser_.GetConst().end()}, own_names_);
      if (tree_ && !agrees(*tree_)) tree_.reset();
    }
    if (!tree_) return {{-kInfinity, kInfinity}, {0, 0}};
    return tree_->over(ranges);
  }

 private:
  /// Whether the tree is the formula that muParser read: both yield the same for numbers drawn by
  /// chance. Nothing is claimed of a formula otherwise.
  [[nodiscard]] bool agrees(const detail::FormulaTree& tree) {
    constexpr int kTrials = 64;
    SplitMix64 random(1);
    const auto draw = [&] {
      return random.below(2) == 0 ? static_cast<double>(random.below(4)) : 20 * random.uniform();
    };
    const auto still = [](double x) { return FormulaLine{{x, x}, {0, 0}}; };
    std::vector<double> own(own_names_.size());
    std::vector<FormulaLine> own_lines(own.size());
    for (int trial = 0; trial < kTrials; ++trial) {
      FormulaVariables variables;
      FormulaRanges ranges;
      for (std::size_t i = 0; i < kFormulaVariables.size(); ++i) {
        variables.*kFormulaVariables[i].value = draw();
        ranges.variables[i] = still(variables.*kFormulaVariables[i].value);
      }
      for (std::size_t i = 0; i < own.size(); ++i) {
        own[i] = draw();
        own_lines[i] = still(own[i]);
      }
      variables.own = own;
      ranges.own = own_lines;
      const double mine = tree.over(ranges).at.least;
      const double theirs = value(variables);
      if (std::isfinite(mine) && std::isfinite(theirs) &&
          std::abs(mine - theirs) > 1e-9 * std::max(1.0, std::abs(theirs)))
        return false;
    }
    return true;
  }

  std::string text_;
  std::vector<std::string> own_names_;
  /// What is known of its values; read when somebody asks.
  bool read_ = false;
  std::optional<detail::FormulaTree> tree_;
  std::set<std::string, std::less<>> used_;
  // The parser holds pointers into these two.
  FormulaVariables variables_;
  std::vector<double> own_;
  mu::Parser parser_;
};

}  // namespace

bool is_formula_builtin(const std::string& name) {
  static const mu::Parser parser;
  return parser.GetFunDef().contains(name) || parser.GetConst().contains(name);
}

std::unique_ptr<Formula> compile_formula(const std::string& text,
                                         const std::map<std::string, double>& constants,
                                         const std::vector<std::string>& own) {
  if (text.size() > kLongestFormula) {
    throw InputError(
        fmt::format("the formula has {} bytes; at most {} are read", text.size(), kLongestFormula));
  }
  refuse_assignments(text);
  try {
    return std::make_unique<MuParserFormula>(text, constants, own);
  } catch (const mu::ParserError& error) {
    throw InputError(error.GetMsg());
  }
}

}  // namespace orasp
