#include "orasp/mip/mip_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace orasp {

MipColumn MipModel::add_binary(std::string name, double objective) {
  return add_column({std::move(name), objective, 0, 1, true});
}

MipColumn MipModel::add_continuous(std::string name, double upper, double objective) {
  return add_column({std::move(name), objective, 0, upper, false});
}

MipColumn MipModel::add_column(Column column) {
  columns_.push_back(std::move(column));
  return static_cast<MipColumn>(columns_.size() - 1);
}

void MipModel::fix(MipColumn column, double value) {
  columns_[column].lower = columns_[column].upper = value;
}

void MipModel::add_row(std::string name, const MipSum& sum, MipSense sense, double right) {
  scratch_ = sum.terms;
  std::ranges::stable_sort(scratch_, {}, &MipTerm::column);
  const std::size_t begin = columns_of_.size();
  for (std::size_t i = 0; i < scratch_.size();) {
    const MipColumn column = scratch_[i].column;
    double value = 0;
    for (; i < scratch_.size() && scratch_[i].column == column; ++i) value += scratch_[i].value;
    if (value == 0) continue;
    columns_of_.push_back(column);
    values_.push_back(value);
  }
  const double rest = right - sum.constant;
  if (columns_of_.size() == begin) {
    const bool holds = sense == MipSense::AtMost  ? 0 <= rest
                       : sense == MipSense::Equal ? rest == 0
                                                  : 0 >= rest;
    if (holds) return;
    // A column that must be 0 and 1 at once says it in every format.
    columns_of_.push_back(add_column({name + "_never", 0, 0, 0, false}));
    values_.push_back(1);
    rows_.push_back({std::move(name), MipSense::AtLeast, 1});
  } else {
    rows_.push_back({std::move(name), sense, rest});
  }
  begins_.push_back(columns_of_.size());
}

std::size_t MipModel::num_integers() const {
  return static_cast<std::size_t>(std::ranges::count_if(columns_, &Column::integer));
}

std::uint64_t MipModel::bytes() const {
  constexpr std::uint64_t kName = 16;  // beyond what a short string holds within itself
  return columns_.size() * (sizeof(Column) + kName) +
         rows_.size() * (sizeof(Row) + kName + sizeof(std::size_t)) +
         columns_of_.size() * (sizeof(MipColumn) + sizeof(double));
}

double MipModel::objective_of(std::span<const double> values) const {
  double sum = constant_;
  for (std::size_t c = 0; c < columns_.size(); ++c) sum += columns_[c].objective * values[c];
  return sum;
}

std::string MipModel::broken_by(std::span<const double> values, double tolerance) const {
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const Column& column = columns_[c];
    const bool inside =
        values[c] >= column.lower - tolerance && values[c] <= column.upper + tolerance;
    const bool whole = !column.integer || std::abs(values[c] - std::round(values[c])) <= tolerance;
    if (!inside || !whole) return column.name;
  }
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    double sum = -rows_[r].right;
    for (std::size_t i = begins_[r]; i < begins_[r + 1]; ++i)
      sum += values_[i] * values[columns_of_[i]];
    const bool holds = rows_[r].sense == MipSense::AtMost  ? sum <= tolerance
                       : rows_[r].sense == MipSense::Equal ? std::abs(sum) <= tolerance
                                                           : sum >= -tolerance;
    if (!holds) return rows_[r].name;
  }
  return {};
}

}  // namespace orasp
