#include "orasp/report/detail/report_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "orasp/io/detail/json_text.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"
#include "orasp/model/transition_system.h"
#include "orasp/report/embedded_page.h"
#include "orasp/report/report.h"

namespace orasp::detail {
namespace {

using nlohmann::ordered_json;

std::string_view objective_meaning(std::string_view type) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 11> kMeanings = {{
      {"piece_cost", "each separation costs by the sizes of its two pieces"},
      {"cubesat", "propellant of CubeSats that carry pieces away, without a construction zone"},
      {"cubesat_zone", "propellant of CubeSats that carry pieces away, with a construction zone"},
      {"custom", "the paper's own costs by the sizes of the two pieces"},
      {"indexed", "rewards by the position of the connection in the file"},
      {"time", "minus the seconds that handling and carrying take"},
      {"travel", "minus the squared distance that pieces are carried"},
      {"fuel", "minus the kilograms of propellant of a tug that carries pieces away"},
      {"completion", "a bonus for each separation and for the end, less a cost for each step"},
      {"expression", "a formula of the problem's own"},
      {"sum", "a weighted sum of objectives"},
  }};
  for (const auto& [name, meaning] : kMeanings) {
    if (name == type) return meaning;
  }
  return "a function of the program that wrote this report";
}

template <class Indices>
std::string quoted_ids(const Problem& problem, const Indices& indices) {
  std::string text;
  for (const ConnectionIndex c : indices)
    text += (text.empty() ? "" : ", ") + in_quotes(problem.connection_id(c));
  return text;
}

ordered_json constraints_json(const Problem& problem) {
  const bool assembly = problem.direction() == Direction::Assembly;
  ordered_json list = ordered_json::array();
  const auto add = [&](Constraint kind, std::string where, std::string text) {
    list.push_back({constraint_name(kind), std::move(where), std::move(text)});
  };
  for (const PrecedenceClause& clause : problem.precedence()) {
    const std::string where = fmt::format("precedence[{}]", clause.entry);
    const std::string id = in_quotes(problem.connection_id(clause.connection));
    if (!clause.after.empty())
      add(Constraint::Precedence, where,
          id + (assembly ? " is made before " : " comes off only after ") +
              quoted_ids(problem, clause.after));
    if (!clause.after_any.empty())
      add(Constraint::PrecedenceAny, where,
          id +
              (assembly ? " is made before at least one of "
                        : " comes off only after at least one of ") +
              quoted_ids(problem, clause.after_any));
    if (!clause.made_after_any.empty())
      add(Constraint::PrecedenceMadeAny, where,
          id +
              (assembly ? " is made only after at least one of "
                        : " comes off while one is there of ") +
              quoted_ids(problem, clause.made_after_any));
  }
  const Limits& limits = problem.limits();
  if (limits.max_subassemblies)
    add(Constraint::MaxSubassemblies, "limits.max_subassemblies",
        "at most " + counted(*limits.max_subassemblies, "piece") +
            " of two or more parts after every removal");
  if (limits.max_moved_parts)
    add(Constraint::MaxMovedParts, "limits.max_moved_parts",
        "a piece that moves has at most " + counted(*limits.max_moved_parts, "part"));
  if (limits.max_moved_mass)
    add(Constraint::MaxMovedMass, "limits.max_moved_mass",
        fmt::format("a piece that moves weighs at most {} kg",
                    page_number(*limits.max_moved_mass)));
  if (limits.grounded)
    add(Constraint::Grounded, "limits.grounded",
        "each subassembly holds a base part: " + detail::quoted_list(problem.spec().base, "or"));
  if (const auto& blocking = problem.spec().blocking) {
    for (std::size_t i = 0; i < blocking->blocked.size(); ++i) {
      const Blocked& entry = blocking->blocked[i];
      add(Constraint::Blocking, fmt::format("blocking.blocked[{}]", i),
          fmt::format("{} cannot leave {} along {}", in_quotes(entry.part), in_quotes(entry.by),
                      fmt::join(entry.directions, ", ")));
    }
  }
  return list;
}

std::string_view page_file(std::string_view name) {
  for (const detail::EmbeddedFile& file : detail::embedded_page()) {
    if (file.name == name) return file.text;
  }
  return {};
}

/// Text as data of an HTML page.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '"': result += "&quot;"; break;
      default: result += c;
    }
  }
  return result;
}

/// RFC 4648.
std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

}  // namespace

std::string page_number(double number) {
  if (number < 0) {
    const std::string size = page_number(-number);
    return size == "0" ? size : "\u2212" + size;
  }
  if (number != 0 && (number < 1e-4 || number >= 1e15)) return fmt::format("{:.6g}", number);
  std::string text = fmt::format("{:.6f}", number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string counted(std::uint64_t number, std::string_view noun) {
  std::string digits = std::to_string(number);
  for (std::size_t at = digits.size(); at > 3;) {
    at -= 3;
    digits.insert(at, ",");
  }
  return fmt::format("{} {}{}", digits, noun, number == 1 ? "" : "s");
}

std::string stop_sentence(Stop stop) {
  if (stop == Stop::None) return {};
  if (stop == Stop::Cancelled) return " The search was interrupted.";
  return fmt::format(" The {} stopped the search.", stop_name(stop));
}

nlohmann::ordered_json proved_facts(const Result& best, std::string sentence,
                                    std::string_view remark, const std::string& effort,
                                    const std::vector<std::string>& conflict) {
  if (best.status == Status::Infeasible) sentence = "No plan exists, proved.";
  if (best.status == Status::Unknown)
    sentence = "Neither a plan was found nor a proof that there is none.";
  sentence += stop_sentence(best.stop);
  sentence += remark;
  const std::optional<double> bound = best.shown_bound();
  return {{"status", status_name(best.status)},
          {"method", best.method},
          {"sentence", sentence},
          {"bound", bound ? number_or_null(*bound) : nlohmann::ordered_json()},
          {"effort", effort},
          {"notes", best.notes},
          {"conflict", conflict}};
}

ordered_json report_problem(const Problem& problem) {
  ordered_json parts = ordered_json::array();
  for (const Part& part : problem.parts()) {
    ordered_json entry = {part.id, part.name, number_or_null(part.mass)};
    if (part.position) {
      ordered_json position = ordered_json::array();
      for (const double x : *part.position) position.push_back(number_or_null(x));
      entry.push_back(std::move(position));
    }
    if (!part.product.empty()) {
      if (!part.position) entry.push_back(nullptr);
      entry.push_back(part.product);
    }
    parts.push_back(std::move(entry));
  }
  ordered_json connections = ordered_json::array();
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c)
    connections.push_back({problem.connection_id(c), problem.ends(c)[0], problem.ends(c)[1]});
  const ProblemSpec& spec = problem.spec();
  return {{"name", spec.name},
          {"note", spec.note},
          {"source", spec.source},
          {"digest", problem_digest(problem)},
          {"direction", spec.direction == Direction::Assembly ? "assembly" : "disassembly"},
          {"objective", {objective_text(spec.objective), objective_meaning(spec.objective.type)}},
          {"parts", std::move(parts)},
          {"connections", std::move(connections)},
          {"constraints", constraints_json(problem)}};
}

bool has_positions(const Problem& problem) {
  return problem.num_parts() > 0 && std::ranges::all_of(problem.parts(), [](const Part& part) {
           return part.position.has_value();
         });
}

std::string script_text(const ordered_json& document) {
  const std::string json = document.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  std::string text;
  text.reserve(json.size() + json.size() / 64);
  for (const char c : json) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

std::string report_page(std::string_view title, std::string_view data, bool space,
                        std::string_view shapes) {
  const std::string three_script =
      space ? "<script>" + std::string(page_file("report-3d.js")) + "</script>" : "";
  const std::string parts = shapes.empty()
                                ? ""
                                : "<script type=\"application/octet-stream\" id=\"shapes\">" +
                                      base64(shapes) + "</script>";
  const std::string heading = escaped(title);
  const std::string_view style = page_file("report.css");
  const std::string_view script = page_file("report.js");
  const std::array<std::pair<std::string_view, std::string_view>, 6> places = {{
      {"<!--orasp:title-->", heading},
      {"/*orasp:style*/", style},
      {"<!--orasp:data-->", data},
      {"<!--orasp:shapes-->", parts},
      {"<!--orasp:3d-->", three_script},
      {"/*orasp:script*/", script},
  }};
  std::string_view page = page_file("report");
  std::string html;
  for (const auto& [mark, text] : places) {  // in the order in which they stand in the page
    const std::size_t at = page.find(mark);
    html += page.substr(0, at);
    html += text;
    page.remove_prefix(at + mark.size());
  }
  html += page;
  const std::size_t size = html.size() - parts.size();
  if (size > kMaxReportBytes) {
    throw InputError(fmt::format(
        "the report would take {:.1f} MB and may take {:.1f}: the problem is too large, or there "
        "are "
        "too many plans",
        static_cast<double>(size) / 1e6, static_cast<double>(kMaxReportBytes) / 1e6));
  }
  return html;
}

}  // namespace orasp::detail
