#include "orasp/geometry/detail/import_findings.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "orasp/geometry/detail/part_names.h"
#include "orasp/model/detail/wording.h"

namespace orasp::detail {

namespace {

constexpr double kInside = 0.2;  ///< of the smaller part's volume

std::string quoted(const std::string& id) {
  return "\"" + id + "\"";
}

std::string counted(std::size_t number, const std::string& noun) {
  return std::to_string(number) + " " + noun + (number == 1 ? "" : "s");
}

/// Questions that the same products ask many times are asked once.
class Questions {
 public:
  explicit Questions(ImportedAssembly& assembly) : assembly_(assembly) {}

  void ask(std::uint32_t a, std::uint32_t b, const std::string& rest) {
    const std::pair key(assembly_.parts[a].equal, assembly_.parts[b].equal);
    const auto [entry, is_new] = position_.emplace(key, pairs_.size());
    if (is_new)
      pairs_.push_back({quoted(assembly_.parts[a].id), quoted(assembly_.parts[b].id), rest, 0});
    ++pairs_[entry->second].count;
  }
  void put() {
    for (const Pair& pair : pairs_) {
      const std::string more =
          pair.count > 1 ? " (and " + counted(pair.count - 1, "pair") + " like them)" : "";
      assembly_.questions.push_back(pair.a + " and " + pair.b + more + pair.rest);
    }
  }

 private:
  struct Pair {
    std::string a;
    std::string b;
    std::string rest;
    std::size_t count;
  };
  ImportedAssembly& assembly_;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> position_;
  std::vector<Pair> pairs_;
};

void find_overlaps(ImportedAssembly& assembly) {
  Questions questions(assembly);
  std::size_t faults = 0;
  for (std::size_t c = 0; c < assembly.contacts.size(); ++c) {
    const Contact& contact = assembly.contacts[c];
    if (!contact.overlap) continue;
    ImportedOverlap overlap{.contact = c};
    if (contact.kind == Contact::Kind::Fastener) {
      overlap.verdict = OverlapVerdict::Thread;
    } else if (contact.overlap->share > kInside) {
      overlap.verdict = OverlapVerdict::Inside;
      questions.ask(contact.a, contact.b,
                    " are drawn inside each other, " +
                        rounded_text(std::min(100.0, 100 * contact.overlap->share)) +
                        " % of the smaller part: exclude one of them if they are alternatives, or "
                        "mend the drawing if one should have a hole");
    } else if (contact.kind == Contact::Kind::Touch) {
      overlap.verdict = OverlapVerdict::Drawing;
      ++faults;
    }
    assembly.overlaps.push_back(overlap);
  }
  questions.put();
  if (faults > 0) {
    assembly.warnings.push_back(
        counted(faults, "pair") + (faults == 1 ? " is" : " are") +
        " drawn over each other where nothing tells of a thread or a press fit; the overlap is "
        "taken for a fault of the drawing and hinders nothing");
  }
}

void find_locked(ImportedAssembly& assembly) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> joined;
  for (const Contact& contact : assembly.contacts) joined.insert({contact.a, contact.b});
  constexpr std::size_t kNone = ~std::size_t{0};
  std::vector<std::size_t> stuck_in(assembly.parts.size(), kNone);
  for (std::size_t group = 0; group < assembly.stuck.size(); ++group) {
    for (const std::uint32_t part : assembly.stuck[group]) stuck_in[part] = group;
  }
  std::set<std::size_t> told;
  Questions questions(assembly);
  for (const PairFacts& pair : facts_by_pair(assembly)) {
    if (pair.facts.size() < 2 * assembly.directions.size()) continue;
    const bool touch = joined.contains({pair.part, pair.by});
    assembly.locked.push_back({.a = pair.part, .b = pair.by, .joined = touch});
    if (stuck_in[pair.part] == kNone || stuck_in[pair.part] != stuck_in[pair.by]) continue;
    told.insert(stuck_in[pair.part]);
    questions.ask(pair.part, pair.by,
                  " block each other along every direction, so nothing can part them: is one of "
                  "them flexible, to be left out, or free along a direction that is not looked "
                  "at?");
  }
  questions.put();
  for (std::size_t group = 0; group < assembly.stuck.size(); ++group) {
    if (told.contains(group)) continue;
    const auto& parts = assembly.stuck[group];
    assembly.questions.push_back(
        counted(parts.size(), "part") + ", " + quoted(assembly.parts[parts[0]].id) + " and " +
        quoted(assembly.parts[parts[1]].id) + " among them, lock each other: no straight motion " +
        "takes any of them out of the others; is one flexible, to be left out, or free along a "
        "direction that is not looked at?");
  }
}

void find_near_facts(ImportedAssembly& assembly) {
  const Blocking& blocking = *assembly.problem.blocking;
  for (std::size_t f = 0; f < assembly.facts.size(); ++f) {
    if (blocking.is_near_tolerance(assembly.facts[f].width / kMetre))
      assembly.near_facts.push_back(f);
  }
}

void note_groups(ImportedAssembly& assembly) {
  if (assembly.groups.size() < 2) return;
  assembly.questions.push_back(
      "the product falls into " + std::to_string(assembly.groups.size()) +
      " groups that do not touch, the smallest with " +
      quoted(assembly.parts[assembly.groups.back().front()].id) +
      ": does something join them that is not drawn, or is a larger tolerance right?");
}

void note_base(ImportedAssembly& assembly) {
  if (!assembly.base_chosen) return;
  std::string names;
  for (const std::uint32_t part : assembly.base)
    names += (names.empty() ? "" : ", ") + quoted(assembly.parts[part].id);
  assembly.warnings.push_back(names + (assembly.base.size() == 1 ? " is" : " are") +
                              " taken for the base, from which all else comes off part by part; "
                              "--base names another, --base none leaves it open");
}

void note_proposed(ImportedAssembly& assembly) {
  Questions questions(assembly);
  for (const Contact& contact : assembly.contacts) {
    if (!contact.proposed) continue;
    questions.ask(contact.a, contact.b,
                  " are " + rounded_text(contact.distance) +
                      " mm apart, and one of them touches nothing: they are taken for joined, is "
                      "that so?");
  }
  questions.put();
}

void note_sizes(ImportedAssembly& assembly) {
  Box box;
  for (const CadPartFacts& part : assembly.parts) {
    box.add(part.box.low);
    box.add(part.box.high);
  }
  constexpr double kLargest = 20'000;  // mm
  constexpr double kSmallest = 1;
  const double diagonal = box.diagonal();
  if (diagonal > kLargest || diagonal < kSmallest) {
    assembly.warnings.push_back("the product measures " + rounded_text(diagonal / 1000) +
                                " m across; if that is wrong, --unit says what the file is in");
  }
  for (const CadPartFacts& part : assembly.parts) {
    constexpr double kLongBolt = 500;  // mm
    if (!names_fastener(part.name) || part.box.diagonal() < kLongBolt) continue;
    assembly.warnings.push_back(quoted(part.id) + " is " +
                                rounded_text(part.box.diagonal() / 1000) +
                                " m long, much for a fastener; --unit says what the file is in");
    break;
  }
}

/// Parts that were drawn one by one, each round its own origin, lie in one another.
void note_poses(ImportedAssembly& assembly) {
  std::size_t central = 0;
  for (const CadPartFacts& part : assembly.parts) {
    double distance = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double middle = (part.box.low[i] + part.box.high[i]) / 2;
      distance += middle * middle;
    }
    constexpr double kNear = 0.25;  // of its own size
    if (std::sqrt(distance) < kNear * part.box.diagonal()) ++central;
  }
  constexpr std::size_t kFew = 3;
  constexpr double kMost = 0.8;
  const auto parts = static_cast<double>(assembly.parts.size());
  if (assembly.parts.size() < kFew || static_cast<double>(central) < kMost * parts) return;
  // Shells round one centre are a product: then their sizes differ.
  std::size_t overlapping = 0;
  for (const Contact& contact : assembly.contacts) overlapping += contact.overlap ? 1 : 0;
  if (2 * overlapping < assembly.parts.size()) return;
  assembly.warnings.push_back(
      "all parts lie round the origin and overlap, so their poses are missing: each is drawn in "
      "its own frame; --pose FILE says where they stand");
}

void note_densities(ImportedAssembly& assembly, const ImportSettings& settings) {
  std::size_t assumed = 0;
  std::size_t by_name = 0;
  double density = 0;
  for (const CadPartFacts& part : assembly.parts) {
    if (part.source == DensitySource::Name) ++by_name;
    if (part.source != DensitySource::Default) continue;
    ++assumed;
    density = part.density;
  }
  if (by_name > 0) {
    assembly.warnings.push_back("the density of " + counted(by_name, "part") +
                                " was told by its name alone, such as steel for a screw");
  }
  if (assumed > 0 && !settings.densities.others) {
    assembly.warnings.push_back("nothing tells the density of " + counted(assumed, "part") + ": " +
                                rounded_text(density) +
                                " kg/m^3 is assumed; --density gives another");
  }
  std::size_t ignored = 0;
  for (std::size_t i = 0; i < assembly.parts.size(); ++i) {
    const DensitySource source = assembly.parts[i].source;
    const bool passed_over = source == DensitySource::Name || source == DensitySource::Default;
    if (assembly.model.parts[i].density && passed_over) ++ignored;
  }
  if (ignored > 0) {
    assembly.warnings.push_back("the file states a density for " + counted(ignored, "part") +
                                " that no material has; it is passed over");
  }
  std::size_t open = 0;
  for (const CadPartFacts& part : assembly.parts) open += part.closed ? 0 : 1;
  if (open > 0) {
    assembly.warnings.push_back(counted(open, "part") + (open == 1 ? " has" : " have") +
                                " a surface with holes, so volume and mass are rough");
  }
  std::size_t empty = 0;
  for (const CadPartFacts& part : assembly.parts) empty += part.mass > 0 ? 0 : 1;
  if (empty > 0) {
    assembly.warnings.push_back(counted(empty, "part") + (empty == 1 ? " has" : " have") +
                                " no volume and so no mass");
  }
}

}  // namespace

void find_groups(ImportedAssembly& assembly) {
  std::vector<std::uint32_t> root(assembly.parts.size());
  std::iota(root.begin(), root.end(), 0U);
  const auto find = [&](std::uint32_t part) {
    while (root[part] != part) part = root[part] = root[root[part]];
    return part;
  };
  for (const Contact& contact : assembly.contacts) {
    const std::uint32_t a = find(contact.a);
    const std::uint32_t b = find(contact.b);
    root[std::max(a, b)] = std::min(a, b);
  }
  std::map<std::uint32_t, std::vector<std::uint32_t>> groups;
  for (std::uint32_t part = 0; part < assembly.parts.size(); ++part)
    groups[find(part)].push_back(part);
  for (auto& [first, group] : groups) assembly.groups.push_back(std::move(group));
  std::ranges::stable_sort(assembly.groups, std::ranges::greater(),
                           [](const auto& group) { return group.size(); });
}

void add_findings(ImportedAssembly& assembly, const ImportSettings& settings) {
  find_overlaps(assembly);
  find_locked(assembly);
  find_near_facts(assembly);
  note_groups(assembly);
  note_proposed(assembly);
  note_base(assembly);
  note_sizes(assembly);
  note_poses(assembly);
  note_densities(assembly, settings);
}

}  // namespace orasp::detail
