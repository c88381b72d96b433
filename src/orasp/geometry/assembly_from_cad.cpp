#include "orasp/geometry/assembly_from_cad.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "orasp/geometry/detail/grounded_order.h"
#include "orasp/geometry/detail/import_findings.h"
#include "orasp/geometry/detail/take_apart.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

/// A number with `digits` significant ones, so that files stay short and the same everywhere.
double rounded(double number, int digits) {
  if (!std::isfinite(number) || number == 0) return 0;
  std::array<char, 64> text{};
  const auto written = std::to_chars(text.data(), text.data() + text.size(), number,
                                     std::chars_format::scientific, digits - 1);
  double read = 0;
  std::from_chars(text.data(), written.ptr, read);
  return read;
}

void tell(const ImportSettings& settings, std::string_view phase) {
  if (settings.stop.stop_requested()) throw Interrupted();
  if (settings.progress) settings.progress({.phase = phase});
}

/// Takes the parts out that the user does not want. Ids stay those of the whole model.
void exclude(ImportedAssembly& assembly, const std::string& list) {
  if (list.empty()) return;
  const std::vector<std::size_t> out = parts_listed(list, assembly.parts, "exclude");
  if (out.size() == assembly.parts.size()) throw InputError("exclude: no part is left");
  std::vector<CadPart> parts;
  std::vector<CadPartFacts> facts;
  std::map<std::size_t, std::size_t> first_equal;
  for (std::size_t i = 0; i < assembly.parts.size(); ++i) {
    if (std::ranges::binary_search(out, i)) continue;
    const std::size_t position = facts.size();
    const std::size_t equal = first_equal.emplace(assembly.parts[i].equal, position).first->second;
    parts.push_back(std::move(assembly.model.parts[i]));
    facts.push_back(std::move(assembly.parts[i]));
    facts.back().equal = equal;
  }
  assembly.model.parts = std::move(parts);
  assembly.parts = std::move(facts);
}

GeometrySettings geometry_settings(const ImportSettings& settings) {
  return {.tolerance = settings.tolerance, .threads = settings.threads, .stop = settings.stop};
}

/// Blocking among the parts that are stiff. The kernel sees them alone, in their order.
void find_facts(ImportedAssembly& assembly, const ImportSettings& settings) {
  const std::size_t count = assembly.parts.size();
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> stiff;
  std::vector<std::uint32_t> place(count, kNone);
  std::vector<CadPart> parts;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (assembly.flexible[i]) continue;
    place[i] = static_cast<std::uint32_t>(stiff.size());
    stiff.push_back(i);
    parts.push_back(std::move(assembly.model.parts[i]));
  }
  std::vector<Contact> contacts;
  for (const Contact& contact : assembly.contacts) {
    if (assembly.flexible[contact.a] || assembly.flexible[contact.b]) continue;
    contacts.push_back(contact);
    contacts.back().a = place[contact.a];
    contacts.back().b = place[contact.b];
  }
  const GeometrySettings geometry = geometry_settings(settings);
  assembly.directions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  assembly.direction_ids = {"+x", "+y", "+z"};
  if (settings.directions == ImportDirections::Geometry) {
    tell(settings, "directions");
    for (Vector3 direction : suggested_directions(parts, contacts, geometry)) {
      if (assembly.directions.size() >= kMaxDirectionPairs) break;
      for (double& number : direction) number = rounded(number, 9);
      assembly.direction_ids.push_back("d" + std::to_string(assembly.directions.size() - 2));
      assembly.directions.push_back(direction);
    }
  }
  tell(settings, "blocking");
  assembly.facts = find_blocking(parts, contacts, assembly.directions, geometry);
  for (BlockingFact& fact : assembly.facts) {
    fact.part = stiff[fact.part];
    fact.by = stiff[fact.by];
  }
  for (std::size_t i = 0; i < stiff.size(); ++i)
    assembly.model.parts[stiff[i]] = std::move(parts[i]);
}

std::string opposite_id(const std::string& id) {
  return id.starts_with('+') ? "-" + id.substr(1) : "-" + id;
}

void add_connections(ImportedAssembly& assembly, const ImportSettings& settings) {
  ProblemSpec& problem = assembly.problem;
  std::set<std::string> taken;
  for (const Contact& contact : assembly.contacts) {
    Connection connection;
    connection.parts = {assembly.parts[contact.a].id, assembly.parts[contact.b].id};
    connection.id = connection.parts[0] + "-" + connection.parts[1];
    const std::string name = connection.id;
    for (int number = 2; !taken.insert(connection.id).second; ++number)
      connection.id = name + " " + std::to_string(number);
    connection.duration = settings.durations[static_cast<std::size_t>(contact.kind)];
    problem.connections.push_back(std::move(connection));
  }
}

void add_blocking(ImportedAssembly& assembly, const ImportSettings& settings) {
  Blocking blocking;
  blocking.tolerance = settings.tolerance / kMetre;
  for (std::size_t d = 0; d < assembly.directions.size(); ++d) {
    const std::string& id = assembly.direction_ids[d];
    if (d < 3) {
      blocking.directions.emplace_back(id);
      blocking.directions.emplace_back(opposite_id(id));
    } else {
      blocking.directions.emplace_back(id, assembly.directions[d]);
    }
  }
  for (const PairFacts& pair : facts_by_pair(assembly)) {
    Blocked blocked{.part = assembly.parts[pair.part].id, .by = assembly.parts[pair.by].id};
    for (const DirectedFact& fact : pair.facts) {
      blocked.directions.push_back(fact.direction);
      blocked.widths.push_back(fact.fact->width / kMetre);
    }
    blocking.blocked.push_back(std::move(blocked));
  }
  assembly.problem.blocking = std::move(blocking);
}

/// What the search for orders looks at.
struct Structure {
  std::vector<detail::BlockedAlong> blocked;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joined;
  std::size_t directions = 0;
};

Structure structure_of(const ImportedAssembly& assembly) {
  Structure structure;
  for (const BlockingFact& fact : assembly.facts)
    structure.blocked.push_back({fact.part, fact.by, 2 * fact.direction});
  for (const Contact& contact : assembly.contacts)
    structure.joined.emplace_back(contact.a, contact.b);
  structure.directions = 2 * assembly.directions.size();
  return structure;
}

/// The part of a group from which all others come off one by one: of the few with most
/// connections the first that does; ties go to the heavier.
std::optional<std::uint32_t> base_of(const ImportedAssembly& assembly, const Structure& structure,
                                     const std::vector<std::uint32_t>& group) {
  std::vector<std::size_t> joints(assembly.parts.size(), 0);
  for (const auto& [a, b] : structure.joined) {
    ++joints[a];
    ++joints[b];
  }
  std::vector<std::uint32_t> candidates = group;
  std::ranges::stable_sort(candidates, std::ranges::greater(), [&](std::uint32_t part) {
    return std::pair(joints[part], assembly.parts[part].mass);
  });
  constexpr std::size_t kTried = 5;
  candidates.resize(std::min(candidates.size(), kTried));
  for (const std::uint32_t part : candidates) {
    if (detail::has_grounded_order(group, part, structure.directions, structure.blocked,
                                   structure.joined)) {
      return part;
    }
  }
  return std::nullopt;
}

/// Whether every group that has something to take apart comes off its one base part.
bool is_grounded(const ImportedAssembly& assembly, const Structure& structure) {
  for (const auto& group : assembly.groups) {
    if (group.size() < 2) continue;
    std::vector<std::uint32_t> held;
    std::ranges::set_intersection(group, assembly.base, std::back_inserter(held));
    if (held.size() != 1 || !detail::has_grounded_order(group, held[0], structure.directions,
                                                        structure.blocked, structure.joined)) {
      return false;
    }
  }
  return true;
}

/// Finds the base, and whether the product comes apart from there.
void find_order(ImportedAssembly& assembly, const ImportSettings& settings) {
  const Structure structure = structure_of(assembly);
  const bool chooses = settings.base.empty() && settings.action == StepKind::Part;
  if (chooses) {
    for (const auto& group : assembly.groups) {
      if (group.size() < 2) continue;
      const auto part = base_of(assembly, structure, group);
      if (part) assembly.base.push_back(*part);
    }
    std::ranges::sort(assembly.base);
    if (!is_grounded(assembly, structure)) assembly.base.clear();
    assembly.base_chosen = !assembly.base.empty();
  } else if (!settings.base.empty() && settings.base != "none") {
    for (const std::size_t part : parts_listed(settings.base, assembly.parts, "base"))
      assembly.base.push_back(static_cast<std::uint32_t>(part));
  }
  std::vector<bool> fixed(assembly.parts.size(), false);
  for (const std::uint32_t part : assembly.base) fixed[part] = true;
  detail::TakenApart apart = detail::take_apart(assembly.parts.size(), structure.directions,
                                                structure.blocked, structure.joined, fixed);
  assembly.moved = apart.moved;
  assembly.moved_hang_together = apart.hangs_together;
  assembly.stuck = std::move(apart.stuck);
  assembly.problem.limits.grounded = settings.action == StepKind::Part && assembly.moved == 1 &&
                                     !assembly.base.empty() && is_grounded(assembly, structure);
}

void fill_problem(ImportedAssembly& assembly, const ImportSettings& settings) {
  ProblemSpec& problem = assembly.problem;
  problem.name = assembly.model.name;
  const std::vector<bool> shared = parts_with_equals(assembly.parts);
  for (std::size_t p = 0; p < assembly.parts.size(); ++p) {
    const CadPartFacts& facts = assembly.parts[p];
    Part part;
    part.id = facts.id;
    if (facts.name != facts.id) part.name = facts.name;
    if (shared[p]) part.product = assembly.parts[facts.equal].id;
    part.mass = rounded(facts.mass, 6);
    Vector3 position{};
    for (std::size_t i = 0; i < 3; ++i) {
      // To a nanometre; what is nearer to 0 is 0.
      const double metres = std::round(facts.centroid[i] / kMetre * 1e9) / 1e9;
      position[i] = rounded(metres, 9);
    }
    part.position = position;
    problem.parts.push_back(std::move(part));
  }
  add_connections(assembly, settings);
  add_blocking(assembly, settings);
  for (const std::uint32_t part : assembly.base) problem.base.push_back(assembly.parts[part].id);
  problem.action = settings.action;
  // Subassemblies that need not move at once are not tried: they are many. Where parts that do not
  // touch must move at once nothing is known of how many go with them.
  if (settings.action == StepKind::Part && assembly.moved_hang_together)
    problem.limits.max_moved_parts = assembly.moved;
  problem.objective = Objective::named("time");
}

}  // namespace

std::vector<PairFacts> facts_by_pair(const ImportedAssembly& assembly) {
  struct Entry {
    std::uint32_t part;
    std::uint32_t by;
    std::uint32_t order;  ///< twice the direction, and 1 for its opposite
    const BlockingFact* fact;
  };
  std::vector<Entry> entries;
  entries.reserve(assembly.facts.size());
  for (const BlockingFact& fact : assembly.facts) {
    const bool turned = fact.part > fact.by;
    entries.push_back({std::min(fact.part, fact.by), std::max(fact.part, fact.by),
                       2 * fact.direction + (turned ? 1U : 0U), &fact});
  }
  std::ranges::sort(entries, {}, [](const Entry& entry) {
    return std::tuple(entry.part, entry.by, entry.order);
  });
  std::vector<PairFacts> pairs;
  for (const Entry& entry : entries) {
    if (pairs.empty() || pairs.back().part != entry.part || pairs.back().by != entry.by)
      pairs.push_back({.part = entry.part, .by = entry.by, .facts = {}});
    const std::string& id = assembly.direction_ids[entry.fact->direction];
    pairs.back().facts.push_back({entry.order % 2 == 1 ? opposite_id(id) : id, entry.fact});
  }
  return pairs;
}

ImportedAssembly assembly_from_cad(CadModel model, const ImportSettings& settings) {
  ImportedAssembly assembly;
  assembly.warnings = std::move(model.warnings);
  assembly.model = std::move(model);
  if (assembly.model.parts.empty()) throw InputError("the model holds no part");
  tell(settings, "parts");
  assembly.parts = part_facts(assembly.model.parts, settings.densities);
  exclude(assembly, settings.exclude);
  if (assembly.parts.size() > kMaxParts) {
    throw InputError("the model holds " + std::to_string(assembly.parts.size()) +
                     " parts; a problem has at most " + std::to_string(kMaxParts));
  }
  assembly.flexible.assign(assembly.parts.size(), false);
  if (!settings.flexible.empty()) {
    for (const std::size_t part : parts_listed(settings.flexible, assembly.parts, "flexible"))
      assembly.flexible[part] = true;
  }
  // What is wrong with a list is said before the long work.
  if (!settings.base.empty() && settings.base != "none")
    static_cast<void>(parts_listed(settings.base, assembly.parts, "base"));
  tell(settings, "contacts");
  assembly.contacts = find_contacts(assembly.model.parts, geometry_settings(settings));
  if (assembly.contacts.size() > kMaxConnections) {
    throw InputError("the model holds " + std::to_string(assembly.contacts.size()) +
                     " contacts; a problem has at most " + std::to_string(kMaxConnections) +
                     " connections");
  }
  find_facts(assembly, settings);
  detail::find_groups(assembly);
  find_order(assembly, settings);
  fill_problem(assembly, settings);
  detail::add_findings(assembly, settings);
  return assembly;
}

}  // namespace orasp
