#include "orasp/io/mip_file.h"

#include <cmath>
#include <iterator>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/atomic_file.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

constexpr std::size_t kLineWidth = 200;  // readers of the LP format stop at 255 or 560 characters
constexpr const char* kConstant = "constant";

/// A comment: one line of printable ASCII, whatever ids the problem has.
std::string remark_line(std::string_view mark, std::string_view remark) {
  std::string line(mark);
  for (const char c : remark.substr(0, kLineWidth)) line += c >= ' ' && c <= '~' ? c : '?';
  return line + '\n';
}

/// Terms of the LP format, broken into lines.
class LpTerms {
 public:
  explicit LpTerms(std::string& text) : text_(text), line_(text.size() - (text.rfind('\n') + 1)) {}

  void add(double value, std::string_view name) {
    const std::string term = fmt::format(
        "{} {}{}",
        std::signbit(value) ? " -"
        : first_            ? ""
                            : " +",
        value == 1 || value == -1 ? std::string() : fmt::format("{} ", std::abs(value)), name);
    if (line_ + term.size() > kLineWidth) {
      text_ += "\n ";
      line_ = 1;
    }
    text_ += term;
    line_ += term.size();
    first_ = false;
  }
  [[nodiscard]] bool empty() const { return first_; }

 private:
  std::string& text_;
  std::size_t line_;
  bool first_ = true;
};

std::string_view sense_sign(MipSense sense) {
  switch (sense) {
    case MipSense::AtMost: return "<=";
    case MipSense::AtLeast: return ">=";
    case MipSense::Equal: break;
  }
  return "=";
}

/// Columns of no row: they would be unknown in the sections that follow.
std::vector<bool> columns_in_rows(const MipModel& model) {
  std::vector<bool> met(model.num_columns(), false);
  for (const MipColumn c : model.columns_of()) met[c] = true;
  return met;
}

bool is_binary(const MipModel::Column& column) {
  return column.integer && column.lower == 0 && column.upper == 1;
}

void add_lp_bounds(const MipModel::Column& column, std::string& text) {
  const auto out = std::back_inserter(text);
  const bool from_below = std::isfinite(column.lower);
  const bool from_above = std::isfinite(column.upper);
  if (column.lower == column.upper) {
    fmt::format_to(out, " {} = {}\n", column.name, column.lower);
  } else if (!from_below && !from_above) {
    fmt::format_to(out, " {} free\n", column.name);
  } else if (!from_below) {
    fmt::format_to(out, " -infinity <= {} <= {}\n", column.name, column.upper);
  } else if (from_above) {
    fmt::format_to(out, " {} <= {} <= {}\n", column.lower, column.name, column.upper);
  } else if (column.lower != 0) {
    fmt::format_to(out, " {} >= {}\n", column.name, column.lower);
  }
}

/// A section of names, some on a line.
template <class Wanted>
void add_lp_names(const MipModel& model, std::string_view section, std::string& text,
                  Wanted&& wanted) {
  std::size_t line = kLineWidth;
  bool begun = false;
  for (const MipModel::Column& column : model.columns()) {
    if (!wanted(column)) continue;
    if (!begun) text += section;
    begun = true;
    if (line + column.name.size() + 1 > kLineWidth) {
      text += '\n';
      line = 0;
    }
    text += ' ';
    text += column.name;
    line += column.name.size() + 1;
  }
  if (begun) text += '\n';
}

}  // namespace

std::string lp_text(const MipModel& model) {
  std::string text;
  for (const std::string& remark : model.remarks()) text += remark_line("\\ ", remark);
  text += "Minimize\n objective:";
  LpTerms objective(text);
  const std::vector<bool> in_rows = columns_in_rows(model);
  for (std::size_t c = 0; c < model.num_columns(); ++c) {
    const MipModel::Column& column = model.columns()[c];
    if (column.objective != 0 || !in_rows[c]) objective.add(column.objective, column.name);
  }
  const bool has_constant = model.constant() != 0 || objective.empty();
  if (has_constant) objective.add(model.constant(), kConstant);
  text += "\nSubject To\n";
  for (std::size_t r = 0; r < model.num_rows(); ++r) {
    const MipModel::Row& row = model.rows()[r];
    text += ' ' + row.name + ':';
    LpTerms terms(text);
    for (std::size_t i = model.begins()[r]; i < model.begins()[r + 1]; ++i)
      terms.add(model.values()[i], model.columns()[model.columns_of()[i]].name);
    fmt::format_to(std::back_inserter(text), " {} {}\n", sense_sign(row.sense), row.right + 0.0);
  }
  text += "Bounds\n";
  for (const MipModel::Column& column : model.columns()) {
    if (!is_binary(column)) add_lp_bounds(column, text);
  }
  if (has_constant) fmt::format_to(std::back_inserter(text), " {} = 1\n", kConstant);
  add_lp_names(model, "Binaries", text, is_binary);
  add_lp_names(model, "Generals", text,
               [](const MipModel::Column& column) { return column.integer && !is_binary(column); });
  return text + "End\n";
}

std::string mps_text(const MipModel& model) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (const std::string& remark : model.remarks()) text += remark_line("* ", remark);
  text += "NAME orasp FREE\nROWS\n N objective\n";
  for (const MipModel::Row& row : model.rows()) {
    fmt::format_to(out, " {} {}\n",
                   row.sense == MipSense::AtMost  ? 'L'
                   : row.sense == MipSense::Equal ? 'E'
                                                  : 'G',
                   row.name);
  }
  // By columns: how many terms each has, where they begin, and then the rows in order.
  std::vector<std::size_t> begins(model.num_columns() + 1, 0);
  for (const MipColumn c : model.columns_of()) ++begins[c + 1];
  for (std::size_t c = 0; c < model.num_columns(); ++c) begins[c + 1] += begins[c];
  std::vector<std::size_t> next(begins.begin(), begins.end() - 1);
  std::vector<std::pair<std::size_t, double>> terms(model.num_terms());
  for (std::size_t r = 0; r < model.num_rows(); ++r) {
    for (std::size_t i = model.begins()[r]; i < model.begins()[r + 1]; ++i)
      terms[next[model.columns_of()[i]]++] = {r, model.values()[i]};
  }
  text += "COLUMNS\n";
  bool whole = false;
  std::size_t markers = 0;
  const auto switch_to = [&](bool integer) {
    if (integer == whole) return;
    fmt::format_to(out, " marker{} 'MARKER' '{}'\n", ++markers, integer ? "INTORG" : "INTEND");
    whole = integer;
  };
  for (std::size_t c = 0; c < model.num_columns(); ++c) {
    const MipModel::Column& column = model.columns()[c];
    switch_to(column.integer);
    if (column.objective != 0 || begins[c] == begins[c + 1])
      fmt::format_to(out, " {} objective {}\n", column.name, column.objective);
    for (std::size_t i = begins[c]; i < begins[c + 1]; ++i)
      fmt::format_to(out, " {} {} {}\n", column.name, model.rows()[terms[i].first].name,
                     terms[i].second);
  }
  switch_to(false);
  const bool has_constant = model.constant() != 0;
  if (has_constant) fmt::format_to(out, " {} objective {}\n", kConstant, model.constant());
  text += "RHS\n";
  for (const MipModel::Row& row : model.rows()) {
    if (row.right != 0) fmt::format_to(out, " rhs {} {}\n", row.name, row.right);
  }
  text += "BOUNDS\n";
  for (const MipModel::Column& column : model.columns()) {
    if (column.lower == column.upper) {
      fmt::format_to(out, " FX bounds {} {}\n", column.name, column.lower);
    } else if (is_binary(column)) {
      fmt::format_to(out, " BV bounds {}\n", column.name);
    } else if (!std::isfinite(column.lower) && !std::isfinite(column.upper)) {
      fmt::format_to(out, " FR bounds {}\n", column.name);
    } else {
      if (!std::isfinite(column.lower)) fmt::format_to(out, " MI bounds {}\n", column.name);
      if (std::isfinite(column.lower) && column.lower != 0)
        fmt::format_to(out, " LO bounds {} {}\n", column.name, column.lower);
      if (std::isfinite(column.upper)) {
        fmt::format_to(out, " UP bounds {} {}\n", column.name, column.upper);
      } else if (column.integer) {
        fmt::format_to(out, " PL bounds {}\n",
                       column.name);  // else some readers take whole columns for 0 or 1
      }
    }
  }
  if (has_constant) fmt::format_to(out, " FX bounds {} 1\n", kConstant);
  return text + "ENDATA\n";
}

void require_model_file(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  if (ending != ".lp" && ending != ".mps") {
    throw InputError(
        fmt::format("{}: a model is written as FILE.lp or FILE.mps, by the ending", file.string()));
  }
}

void write_model(const MipModel& model, const std::filesystem::path& file) {
  require_model_file(file);
  write_file(file, file.extension() == ".lp" ? lp_text(model) : mps_text(model));
}

}  // namespace orasp
