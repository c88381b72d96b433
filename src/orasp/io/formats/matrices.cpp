#include "orasp/io/formats/matrices.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/formats/detail/csv_text.h"
#include "orasp/io/formats/detail/text_checks.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using detail::CsvRow;
using detail::in_quotes;

struct Matrix {
  std::string name;  ///< "contact", "+x"
  std::size_t line = 0;
  /// By the order of the parts of the first matrix.
  std::vector<std::vector<bool>> cells;
  std::vector<std::size_t> lines;  ///< of the rows
};

class MatrixReader {
 public:
  explicit MatrixReader(std::string_view text)
      : rows_(detail::csv_rows(detail::checked_text(text))) {
    std::erase_if(rows_, [](const CsvRow& row) { return row.blank(); });
    for (CsvRow& row : rows_) {
      while (row.cells.size() > 1 && row.cells.back().empty()) row.cells.pop_back();
    }
  }

  Converted read() {
    while (next_ < rows_.size()) read_matrix();
    if (!matrices_.contains("contact"))
      throw InputError("there is no matrix \"contact\", which says what is connected");
    Converted converted;
    for (const std::string& id : ids_) converted.problem.parts.push_back({.id = id});
    add_connections(converted.problem);
    add_blocking(converted);
    return converted;
  }

 private:
  static bool is_direction(std::string_view name) {
    return std::ranges::find(kDirectionNames, name) != kDirectionNames.end();
  }

  void read_matrix() {
    const CsvRow& head = rows_[next_++];
    Matrix matrix{.name = head.cells.front(), .line = head.line, .cells = {}, .lines = {}};
    if (matrix.name.empty() && matrices_.empty()) matrix.name = "contact";
    if (matrix.name != "contact" && !is_direction(matrix.name)) {
      throw InputError(
          fmt::format("line {}: {} is not the name of a matrix; those are contact, +x, "
                      "-x, +y, -y, +z and -z",
                      head.line, in_quotes(matrix.name)));
    }
    if (const auto known = matrices_.find(matrix.name); known != matrices_.end()) {
      throw InputError(fmt::format("line {}: the matrix {} is there already, at line {}", head.line,
                                   in_quotes(matrix.name), known->second.line));
    }
    const std::vector<std::size_t> columns = columns_of(head);
    matrix.cells.assign(ids_.size(), std::vector<bool>(ids_.size(), false));
    matrix.lines.assign(ids_.size(), 0);
    for (std::size_t i = 0; i < ids_.size(); ++i) read_row(matrix, columns);
    matrices_.emplace(matrix.name, std::move(matrix));
  }

  /// Which part each column is of.
  std::vector<std::size_t> columns_of(const CsvRow& head) {
    const std::vector<std::string> names(head.cells.begin() + 1, head.cells.end());
    if (names.empty())
      throw InputError(
          fmt::format("line {}: there are no parts; their ids stand behind the name of "
                      "the matrix",
                      head.line));
    if (ids_.empty()) {
      if (names.size() > kMaxParts) {
        throw InputError(fmt::format(
            "line {}: more than {} parts, the most that a problem may have", head.line, kMaxParts));
      }
      ids_ = names;
      for (std::size_t i = 0; i < ids_.size(); ++i) {
        if (const auto fault = detail::id_fault(ids_[i]))
          throw InputError(fmt::format("line {}: column {}: the id {}", head.line, i + 2, *fault));
        if (!part_by_id_.emplace(ids_[i], i).second) {
          throw InputError(fmt::format("line {}: column {}: the part {} is there already",
                                       head.line, i + 2, in_quotes(ids_[i])));
        }
      }
    }
    if (names.size() != ids_.size()) {
      throw InputError(fmt::format("line {}: {} parts, and the first matrix has {}", head.line,
                                   names.size(), ids_.size()));
    }
    std::vector<std::size_t> columns;
    std::vector<bool> seen(ids_.size(), false);
    for (const std::string& name : names) {
      columns.push_back(part(name, head.line));
      if (seen[columns.back()]) {
        throw InputError(
            fmt::format("line {}: the part {} is there twice", head.line, in_quotes(name)));
      }
      seen[columns.back()] = true;
    }
    return columns;
  }

  [[nodiscard]] std::size_t part(const std::string& id, std::size_t line) const {
    const auto found = part_by_id_.find(id);
    if (found == part_by_id_.end()) {
      throw InputError(
          fmt::format("line {}: the first matrix has no part {}", line, in_quotes(id)));
    }
    return found->second;
  }

  void read_row(Matrix& matrix, const std::vector<std::size_t>& columns) {
    if (next_ == rows_.size()) {
      throw InputError(fmt::format("the file ends inside of the matrix {}, which begins at line {}",
                                   in_quotes(matrix.name), matrix.line));
    }
    const CsvRow& row = rows_[next_++];
    const std::size_t i = part(row.cells.front(), row.line);
    if (matrix.lines[i] != 0) {
      throw InputError(fmt::format("line {}: the line of {} is there already, at line {}", row.line,
                                   in_quotes(row.cells.front()), matrix.lines[i]));
    }
    matrix.lines[i] = row.line;
    if (row.cells.size() != columns.size() + 1) {
      throw InputError(fmt::format("line {}: {} cells behind the id, and there are {} parts",
                                   row.line, row.cells.size() - 1, columns.size()));
    }
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const std::string& cell = row.cells[k + 1];
      const auto number = detail::number_in(cell);
      if (!number || (*number != 0 && *number != 1)) {
        throw InputError(fmt::format("line {}: column {}: {} is neither 0 nor 1", row.line, k + 2,
                                     in_quotes(cell)));
      }
      matrix.cells[i][columns[k]] = *number == 1;
    }
    if (matrix.cells[i][i]) {
      throw InputError(
          fmt::format("line {}: {} has a 1 with itself", row.line, in_quotes(ids_[i])));
    }
  }

  void add_connections(ProblemSpec& problem) const {
    const Matrix& contact = matrices_.at("contact");
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      for (std::size_t j = i + 1; j < ids_.size(); ++j) {
        if (contact.cells[i][j] != contact.cells[j][i]) {
          throw InputError(fmt::format(
              "line {}: contact is not symmetric: {} touches {} in one line and not in the other",
              contact.lines[j], in_quotes(ids_[i]), in_quotes(ids_[j])));
        }
        if (!contact.cells[i][j]) continue;
        if (problem.connections.size() == kMaxConnections) {
          throw InputError(
              fmt::format("more than {} contacts, the most connections that a problem may have",
                          kMaxConnections));
        }
        problem.connections.push_back({.parts = {ids_[i], ids_[j]}});
      }
    }
  }

  void add_blocking(Converted& converted) const {
    Blocking blocking;
    for (std::size_t axis = 0; axis < kDirectionNames.size(); axis += 2) {
      const bool stated = matrices_.contains(kDirectionNames[axis]) ||
                          matrices_.contains(kDirectionNames[axis + 1]);
      if (!stated) continue;
      blocking.directions.emplace_back(kDirectionNames[axis]);
      blocking.directions.emplace_back(kDirectionNames[axis + 1]);
      note_contradictions(axis, converted);
    }
    if (blocking.directions.empty()) return;
    std::vector<const Matrix*> stated;
    for (const char* name : kDirectionNames) {
      const auto found = matrices_.find(name);
      if (found != matrices_.end()) stated.push_back(&found->second);
    }
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      for (std::size_t j = 0; j < ids_.size(); ++j) {
        std::vector<std::string> directions;
        for (const Matrix* matrix : stated)
          if (matrix->cells[i][j]) directions.push_back(matrix->name);
        if (!directions.empty())
          blocking.blocked.push_back({ids_[i], ids_[j], std::move(directions)});
      }
    }
    converted.problem.blocking = std::move(blocking);
  }

  /// That i cannot move along +x past j is that j cannot move along -x past i.
  void note_contradictions(std::size_t axis, Converted& converted) const {
    const auto there = matrices_.find(kDirectionNames[axis]);
    const auto back = matrices_.find(kDirectionNames[axis + 1]);
    if (there == matrices_.end() || back == matrices_.end()) return;
    std::size_t count = 0;
    std::string first;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      for (std::size_t j = 0; j < ids_.size(); ++j) {
        if (there->second.cells[i][j] == back->second.cells[j][i]) continue;
        if (count++ == 0) first = fmt::format("{} and {}", in_quotes(ids_[i]), in_quotes(ids_[j]));
      }
    }
    if (count == 0) return;
    converted.notes.push_back(fmt::format(
        "the matrices {} and {} are not the transposes of each other ({} pair{}, such as {}); what "
        "either says to be blocked is blocked",
        kDirectionNames[axis], kDirectionNames[axis + 1], count, count == 1 ? "" : "s", first));
  }

  std::vector<CsvRow> rows_;
  std::size_t next_ = 0;
  std::vector<std::string> ids_;
  std::unordered_map<std::string, std::size_t> part_by_id_;
  std::map<std::string, Matrix, std::less<>> matrices_;
};

}  // namespace

Converted read_matrices(std::string_view text) {
  return MatrixReader(text).read();
}

}  // namespace orasp
