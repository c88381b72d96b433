#include "cli/output/import_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/output/text.h"

namespace orasp::cli {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kShownRows = 20;

const char* kind_name(Contact::Kind kind) {
  constexpr std::array<const char*, 3> kNames = {"contact", "fit", "fastener"};
  return kNames[static_cast<std::size_t>(kind)];
}

const char* verdict_name(OverlapVerdict verdict) {
  constexpr std::array<const char*, 4> kNames = {"thread", "press fit", "a fault of the drawing",
                                                 "drawn inside each other"};
  return kNames[static_cast<std::size_t>(verdict)];
}

const char* source_name(DensitySource source) {
  constexpr std::array<const char*, 4> kNames = {"file", "given", "name", "default"};
  return kNames[static_cast<std::size_t>(source)];
}

/// Three significant digits.
std::string short_text(double number) {
  return number >= 100 && number < 1e6 ? fmt::format("{:.0f}", number)
                                       : fmt::format("{:.3g}", number);
}

std::string size_text(const Box& box) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i)
    text += fmt::format("{}{:.4g}", i == 0 ? "" : " x ", box.high[i] - box.low[i]);
  return text;
}

std::string rows_left(std::size_t all) {
  return all > kShownRows ? fmt::format("... {} in all; --json lists them\n", grouped(all))
                          : std::string();
}

/// The products with the positions of their parts.
std::vector<std::vector<std::size_t>> products_of(const ImportedAssembly& assembly) {
  std::map<std::size_t, std::vector<std::size_t>> by_first;
  for (std::size_t i = 0; i < assembly.parts.size(); ++i)
    by_first[assembly.parts[i].equal].push_back(i);
  std::vector<std::vector<std::size_t>> products;
  for (auto& [first, parts] : by_first) products.push_back(std::move(parts));
  return products;
}

double total_mass(const ImportedAssembly& assembly) {
  double mass = 0;
  for (const CadPartFacts& part : assembly.parts) mass += part.mass;
  return mass;
}

std::string id_of_opposite(const std::string& id) {
  return "-" + (id.starts_with('+') ? id.substr(1) : id);
}

/// Whether straight motions take the product apart.
std::string apart_text(const ImportedAssembly& assembly) {
  std::size_t stuck = 0;
  for (const auto& group : assembly.stuck) stuck += group.size();
  if (stuck > 0)
    return fmt::format("no order of straight motions: {} lock each other", counted(stuck, "part"));
  return assembly.moved == 1 ? "part by part, by straight motions"
                             : fmt::format("by straight motions of up to {} at once",
                                           counted(assembly.moved, "part"));
}

std::string head(const ImportedAssembly& assembly, const ImportFacts& facts) {
  std::array<std::size_t, 3> kinds{};
  for (const Contact& contact : assembly.contacts) ++kinds[static_cast<std::size_t>(contact.kind)];
  std::string text = fmt::format("{}: {}, {}, {}\n", printable(assembly.model.name),
                                 counted(assembly.parts.size(), "part"),
                                 counted(assembly.contacts.size(), "connection"),
                                 counted(2 * assembly.facts.size(), "blocking fact"));
  if (!facts.problem_file.empty())
    text += fmt::format("problem    {}\n", printable(facts.problem_file));
  if (!facts.shapes_file.empty())
    text += fmt::format("shapes     {}, {}\n", printable(facts.shapes_file),
                        bytes_text(facts.shapes_bytes));
  text +=
      fmt::format("measured   at a tolerance of {} mm, along {} directions; the file is in {}\n",
                  short_text(facts.tolerance), 2 * assembly.directions.size(),
                  assembly.model.unit.empty()
                      ? fmt::format("units of {} mm", assembly.model.millimetres_per_unit)
                      : assembly.model.unit);
  text += fmt::format("joined by  {}, {}, {}\n", counted(kinds[0], "contact"),
                      counted(kinds[1], "fit"), counted(kinds[2], "fastener"));
  text += fmt::format("mass       {} kg in all\n", short_text(total_mass(assembly)));
  text += fmt::format("apart      {}\n", apart_text(assembly));
  std::string stages;
  for (const auto& [stage, seconds] : facts.seconds)
    stages += fmt::format("{}{} {}", stages.empty() ? "" : ", ", stage, seconds_text(seconds));
  return text + fmt::format("effort     {}\n", stages);
}

std::string parts_table(const ImportedAssembly& assembly, const Context& context) {
  TextTable table;
  table.add_column("parts", TextTable::Align::Right);
  table.add_column("of", TextTable::Align::Left);
  table.add_column("size in mm", TextTable::Align::Left);
  table.add_column("kg each", TextTable::Align::Right);
  table.add_column("kg/m^3", TextTable::Align::Right);
  table.add_column("by", TextTable::Align::Left);
  const auto products = products_of(assembly);
  for (const auto& parts : std::span(products).first(std::min(products.size(), kShownRows))) {
    const CadPartFacts& part = assembly.parts[parts.front()];
    table.add_row({fmt::to_string(parts.size()), part.id, size_text(part.box),
                   short_text(part.mass), short_text(part.density),
                   part.material.empty()
                       ? source_name(part.source)
                       : fmt::format("{}: {}", source_name(part.source), part.material)});
  }
  return '\n' + table.text(context.colour()) + rows_left(products.size());
}

std::string overlaps_table(const ImportedAssembly& assembly, const Context& context) {
  if (assembly.overlaps.empty()) return {};
  TextTable table;
  table.add_column("drawn over each other", TextTable::Align::Left);
  table.add_column("and", TextTable::Align::Left);
  table.add_column("mm^3", TextTable::Align::Right);
  table.add_column("mm thick", TextTable::Align::Right);
  table.add_column("taken for", TextTable::Align::Left);
  std::vector<ImportedOverlap> overlaps = assembly.overlaps;
  // What needs a look comes first.
  std::ranges::stable_sort(overlaps, std::ranges::greater(), &ImportedOverlap::verdict);
  for (const ImportedOverlap& overlap :
       std::span(overlaps).first(std::min(overlaps.size(), kShownRows))) {
    const Contact& contact = assembly.contacts[overlap.contact];
    table.add_row({assembly.parts[contact.a].id, assembly.parts[contact.b].id,
                   short_text(contact.overlap->volume), short_text(contact.overlap->thickness),
                   verdict_name(overlap.verdict)});
  }
  return '\n' + table.text(context.colour()) + rows_left(overlaps.size());
}

std::string near_table(const ImportedAssembly& assembly, const Context& context) {
  if (assembly.near_facts.empty()) return {};
  TextTable table;
  table.add_column("near the tolerance", TextTable::Align::Left);
  table.add_column("is stopped by", TextTable::Align::Left);
  table.add_column("along", TextTable::Align::Left);
  table.add_column("mm wide", TextTable::Align::Right);
  table.add_column("mm deep", TextTable::Align::Right);
  std::vector<std::size_t> near = assembly.near_facts;
  std::ranges::stable_sort(near, {}, [&](std::size_t f) { return assembly.facts[f].width; });
  for (const std::size_t f : std::span(near).first(std::min(near.size(), kShownRows))) {
    const BlockingFact& fact = assembly.facts[f];
    table.add_row({assembly.parts[fact.part].id, assembly.parts[fact.by].id,
                   assembly.direction_ids[fact.direction], short_text(fact.width),
                   short_text(fact.depth)});
  }
  return '\n' + table.text(context.colour()) + rows_left(near.size());
}

std::string questions_text(const ImportedAssembly& assembly) {
  if (assembly.questions.empty()) return {};
  std::string text = "\nto be answered by you:\n";
  for (const std::string& question :
       std::span(assembly.questions).first(std::min(assembly.questions.size(), kShownRows)))
    text += "  - " + printable(question) + '\n';
  return text + rows_left(assembly.questions.size());
}

// -------------------------------------------------------------------------------------------------
// as a document

ordered_json parts_json(const ImportedAssembly& assembly) {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < assembly.parts.size(); ++i) {
    const CadPartFacts& part = assembly.parts[i];
    Vector3 size{};
    for (std::size_t k = 0; k < 3; ++k) size[k] = part.box.high[k] - part.box.low[k];
    ordered_json entry = {{"id", part.id},
                          {"product", assembly.parts[part.equal].id},
                          {"mass", part.mass},
                          {"volume", part.volume},
                          {"density", part.density},
                          {"density_source", source_name(part.source)},
                          {"size", size},
                          {"triangles", part.triangles},
                          {"closed", part.closed}};
    if (!part.material.empty()) entry["material"] = part.material;
    if (assembly.flexible[i]) entry["flexible"] = true;
    list.push_back(std::move(entry));
  }
  return list;
}

ordered_json contacts_json(const ImportedAssembly& assembly) {
  ordered_json list = ordered_json::array();
  for (std::size_t c = 0; c < assembly.contacts.size(); ++c) {
    const Contact& contact = assembly.contacts[c];
    list.push_back({{"connection", assembly.problem.connections[c].id},
                    {"parts", {assembly.parts[contact.a].id, assembly.parts[contact.b].id}},
                    {"kind", kind_name(contact.kind)},
                    {"area", contact.area},
                    {"distance", contact.distance},
                    {"proposed", contact.proposed}});
  }
  return list;
}

ordered_json overlaps_json(const ImportedAssembly& assembly) {
  ordered_json list = ordered_json::array();
  for (const ImportedOverlap& overlap : assembly.overlaps) {
    const Contact& contact = assembly.contacts[overlap.contact];
    list.push_back({{"parts", {assembly.parts[contact.a].id, assembly.parts[contact.b].id}},
                    {"volume", contact.overlap->volume},
                    {"thickness", contact.overlap->thickness},
                    {"share", contact.overlap->share},
                    {"verdict", verdict_name(overlap.verdict)}});
  }
  return list;
}

ordered_json locked_json(const ImportedAssembly& assembly) {
  ordered_json list = ordered_json::array();
  for (const LockedPair& pair : assembly.locked) {
    list.push_back({{"parts", {assembly.parts[pair.a].id, assembly.parts[pair.b].id}},
                    {"joined", pair.joined}});
  }
  return list;
}

ordered_json near_json(const ImportedAssembly& assembly) {
  ordered_json list = ordered_json::array();
  for (const std::size_t f : assembly.near_facts) {
    const BlockingFact& fact = assembly.facts[f];
    list.push_back({{"part", assembly.parts[fact.part].id},
                    {"by", assembly.parts[fact.by].id},
                    {"direction", assembly.direction_ids[fact.direction]},
                    {"width", fact.width},
                    {"depth", fact.depth}});
  }
  return list;
}

ordered_json groups_json(const ImportedAssembly& assembly,
                         const std::vector<std::vector<std::uint32_t>>& groups) {
  ordered_json list = ordered_json::array();
  for (const auto& group : groups) {
    ordered_json ids = ordered_json::array();
    for (const std::uint32_t part : group) ids.push_back(assembly.parts[part].id);
    list.push_back(std::move(ids));
  }
  return list;
}

ordered_json equal_json(const ImportedAssembly& assembly) {
  ordered_json list = ordered_json::array();
  for (const auto& parts : products_of(assembly)) {
    if (parts.size() < 2) continue;
    ordered_json ids = ordered_json::array();
    for (const std::size_t part : parts) ids.push_back(assembly.parts[part].id);
    list.push_back(std::move(ids));
  }
  return list;
}

ordered_json directions_json(const ImportedAssembly& assembly) {
  ordered_json list = ordered_json::array();
  for (std::size_t d = 0; d < assembly.directions.size(); ++d) {
    list.push_back({{"id", assembly.direction_ids[d]},
                    {"opposite", id_of_opposite(assembly.direction_ids[d])},
                    {"vector", assembly.directions[d]}});
  }
  return list;
}

}  // namespace

std::string import_summary(const ImportedAssembly& assembly, const ImportFacts& facts,
                           const Context& context) {
  return head(assembly, facts) + parts_table(assembly, context) +
         overlaps_table(assembly, context) + near_table(assembly, context) +
         questions_text(assembly);
}

ordered_json import_json(const ImportedAssembly& assembly, const ImportFacts& facts) {
  ordered_json seconds = ordered_json::object();
  for (const auto& [stage, time] : facts.seconds) seconds[stage] = time;
  const auto file = [](const std::string& name) {
    return name.empty() ? ordered_json() : ordered_json(name);
  };
  return {{"name", assembly.model.name},
          {"problem", file(facts.problem_file)},
          {"geometry", file(facts.shapes_file)},
          {"unit", assembly.model.unit},
          {"millimetres_per_unit", assembly.model.millimetres_per_unit},
          {"tolerance", facts.tolerance},
          {"mass", total_mass(assembly)},
          {"facts", 2 * assembly.facts.size()},
          {"directions", directions_json(assembly)},
          {"parts", parts_json(assembly)},
          {"equal", equal_json(assembly)},
          {"contacts", contacts_json(assembly)},
          {"overlaps", overlaps_json(assembly)},
          {"locked", locked_json(assembly)},
          {"near_tolerance", near_json(assembly)},
          {"base", assembly.problem.base},
          {"grounded", assembly.problem.limits.grounded},
          {"moved_at_once", assembly.moved},
          {"stuck", groups_json(assembly, assembly.stuck)},
          {"groups", groups_json(assembly, assembly.groups)},
          {"questions", assembly.questions},
          {"warnings", assembly.warnings},
          {"seconds", std::move(seconds)}};
}

}  // namespace orasp::cli
