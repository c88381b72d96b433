#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/tolerance.h"

namespace orasp {

/// A variable of a MipModel.
using MipColumn = std::uint32_t;

struct MipTerm {
  MipColumn column;
  double value;
};

enum class MipSense { AtMost, Equal, AtLeast };

/// An expression: a constant and terms. A column may come up several times.
///
///     MipSum sum;
///     sum.add(x, 1).add(y, -1).add(2);       // x - y + 2
struct MipSum {
  std::vector<MipTerm> terms;
  double constant = 0;

  MipSum& add(double value) {
    constant += value;
    return *this;
  }
  MipSum& add(MipColumn column, double value) {
    terms.push_back({column, value});
    return *this;
  }
  MipSum& add(const MipSum& other, double factor) {
    for (const MipTerm& term : other.terms) terms.push_back({term.column, factor * term.value});
    constant += factor * other.constant;
    return *this;
  }
};

/// A mixed integer program, whoever solves it: minimise `objective` plus a constant over columns
/// between bounds, some of them whole numbers, under linear rows. Sparse: rows stand one after
/// another in compressed form.
///
/// Names are letters, digits and '_', begin with a letter other than e, and are unique where their
/// makers make them so: such names are legal in both file formats (io/mip_file.h). A value; owns
/// all it holds.
class MipModel {
 public:
  struct Column {
    std::string name;
    double objective = 0;
    double lower = 0;
    double upper = kInfinity;
    bool integer = false;
  };
  struct Row {
    std::string name;
    MipSense sense = MipSense::AtMost;
    double right = 0;  ///< right-hand side
  };

  /// Columns that are 0 or 1, and those between 0 and `upper`.
  MipColumn add_binary(std::string name, double objective = 0);
  MipColumn add_continuous(std::string name, double upper, double objective = 0);
  MipColumn add_column(Column column);
  void add_objective(MipColumn column, double value) { columns_[column].objective += value; }
  void add_constant(double value) { constant_ += value; }
  void fix(MipColumn column, double value);

  /// Demands sum <, = or > right. Terms of the same column are added up, those of 0 left out. A row
  /// without terms that is true is not kept; one that is false makes the model infeasible.
  void add_row(std::string name, const MipSum& sum, MipSense sense, double right);

  [[nodiscard]] std::size_t num_columns() const { return columns_.size(); }
  [[nodiscard]] std::size_t num_rows() const { return rows_.size(); }
  [[nodiscard]] std::size_t num_terms() const { return columns_of_.size(); }
  [[nodiscard]] std::size_t num_integers() const;
  [[nodiscard]] double constant() const { return constant_; }
  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
  /// Compressed rows: row r has the terms begins()[r] to begins()[r + 1] of columns_of() and
  /// values(), by ascending column.
  [[nodiscard]] const std::vector<std::size_t>& begins() const { return begins_; }
  [[nodiscard]] const std::vector<MipColumn>& columns_of() const { return columns_of_; }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }

  /// Remarks for whoever reads the model in a file: what a name stands for. A line each.
  void add_remark(std::string line) { remarks_.push_back(std::move(line)); }
  [[nodiscard]] const std::vector<std::string>& remarks() const { return remarks_; }

  /// Bytes held, about.
  [[nodiscard]] std::uint64_t bytes() const;
  /// The objective of these values of all columns.
  [[nodiscard]] double objective_of(std::span<const double> values) const;
  /// The first row, bound or whole number that these values break by more than `tolerance`; empty
  /// if none is broken.
  [[nodiscard]] std::string broken_by(std::span<const double> values, double tolerance) const;

 private:
  std::vector<Column> columns_;
  std::vector<Row> rows_;
  std::vector<std::size_t> begins_{0};
  std::vector<MipColumn> columns_of_;
  std::vector<double> values_;
  std::vector<std::string> remarks_;
  std::vector<MipTerm> scratch_;
  double constant_ = 0;
};

/// "x_3_12": a family and what it is indexed by.
template <class... Indices>
[[nodiscard]] std::string mip_name(std::string_view family, Indices... indices) {
  std::string name(family);
  ((name += '_', name += std::to_string(indices)), ...);
  return name;
}

}  // namespace orasp
