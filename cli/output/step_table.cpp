#include "cli/output/step_table.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <fmt/format.h>

#include "cli/output/text.h"

namespace orasp::cli {
namespace {

constexpr std::size_t kLeastPieceWidth = 20;
/// What a step takes is shortened beyond this width.
constexpr std::size_t kMostTakenWidth = 60;

std::string moved_piece(const Problem& problem, const Step& step, std::size_t width) {
  if (!step.separates) return "-";
  // Several parts of one product are counted where the first of them stands.
  struct Kind {
    PartIndex first;
    std::size_t count;
  };
  std::vector<Kind> kinds;
  std::unordered_map<std::string_view, std::size_t> by_product;
  for (const PartIndex part : step.moved()) {
    const std::string& product = problem.parts()[part].product;
    if (!product.empty()) {
      const auto [kind, is_new] = by_product.emplace(product, kinds.size());
      if (!is_new) {
        ++kinds[kind->second].count;
        continue;
      }
    }
    kinds.push_back({part, 1});
  }
  std::vector<std::string> names;
  for (const Kind& kind : kinds) {
    names.push_back(kind.count == 1
                        ? problem.part_id(kind.first)
                        : fmt::format("{} x {}", kind.count, problem.parts()[kind.first].product));
  }
  return capped_list(names, width);
}

/// The way that the moved piece goes: off in disassembly, on in assembly.
std::string way(const Problem& problem, const Step& step) {
  if (!step.direction) return "-";
  const bool assembly = problem.direction() == Direction::Assembly;
  return problem.direction_name(assembly ? opposite(*step.direction) : *step.direction);
}

}  // namespace

std::string connections_text(const Problem& problem, const Step& step) {
  std::string text;
  for (const ConnectionIndex c : step.connections)
    text += (text.empty() ? "" : " + ") + problem.connection_id(c);
  return text;
}

namespace {

/// The same for a column: the first, and how many more.
std::string taken_in_short(const Problem& problem, const Step& step) {
  std::string text = connections_text(problem, step);
  if (step.connections.size() < 2 || display_width(text) <= kMostTakenWidth) return text;
  return fmt::format("{} + {} more", problem.connection_id(step.connections.front()),
                     step.connections.size() - 1);
}

}  // namespace

std::string step_table(const Problem& problem, std::span<const Step> steps,
                       const Context& context) {
  std::vector<double> rewards;
  std::vector<double> totals;
  std::size_t id_width = std::string_view("connection").size();
  double total = 0;
  for (const Step& step : steps) {
    total += step.reward;
    rewards.push_back(step.reward);
    totals.push_back(total);
    id_width = std::max(id_width, display_width(taken_in_short(problem, step)));
  }
  const std::vector<std::string> reward_texts = aligned_numbers(rewards);
  const std::vector<std::string> total_texts = aligned_numbers(totals);

  std::size_t number_width = 0;
  for (const auto* texts : {&reward_texts, &total_texts}) {
    std::size_t widest = 0;
    for (const std::string& text : *texts) widest = std::max(widest, text.size());
    number_width += std::max<std::size_t>(widest, 6) + 2;
  }
  const bool assembly = problem.direction() == Direction::Assembly;
  const bool directed = !problem.directions().empty();
  const std::string_view direction_title = assembly ? "arrives along" : "leaves along";
  std::size_t direction_width = directed ? direction_title.size() + 2 : 0;
  std::vector<std::string> directions;
  for (const Step& step : steps) {
    directions.push_back(way(problem, step));
    if (directed) direction_width = std::max(direction_width, display_width(directions.back()) + 2);
  }
  const std::size_t others =
      std::string_view("step  ").size() + id_width + 2 + direction_width + number_width;
  const std::size_t piece_width =
      context.width() > others + kLeastPieceWidth ? context.width() - others : kLeastPieceWidth;

  TextTable table;
  table.add_column("step", TextTable::Align::Right);
  table.add_column("connection", TextTable::Align::Left);
  table.add_column(assembly ? "joins on" : "separates", TextTable::Align::Left);
  if (directed) table.add_column(std::string(direction_title), TextTable::Align::Left);
  table.add_column("reward", TextTable::Align::Right);
  table.add_column("total", TextTable::Align::Right);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    std::vector<std::string> row = {fmt::to_string(i + 1), taken_in_short(problem, steps[i]),
                                    moved_piece(problem, steps[i], piece_width)};
    if (directed) row.push_back(directions[i]);
    row.push_back(reward_texts[i]);
    row.push_back(total_texts[i]);
    table.add_row(std::move(row));
  }
  return table.text(context.colour());
}

}  // namespace orasp::cli
