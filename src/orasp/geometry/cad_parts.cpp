#include "orasp/geometry/cad_parts.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "orasp/geometry/detail/part_names.h"
#include "orasp/geometry/detail/plain_text.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

constexpr double kUnknownDensity = 1200;  ///< kg/m^3: plastics
constexpr double kSteel = 7850;
constexpr double kCubicMetre = 1e9;  ///< mm^3

struct NamedDensity {
  std::string_view word;  ///< in small letters
  std::string_view material;
  double density;
};

/// Words of names and materials that tell a density, longer words first where one holds another.
constexpr std::array<NamedDensity, 20> kNamedDensities = {{
    {"stainless", "stainless steel", 7900},
    {"steel", "steel", kSteel},
    {"aluminium", "aluminium", 2700},
    {"aluminum", "aluminium", 2700},
    {"brass", "brass", 8500},
    {"bronze", "bronze", 8800},
    {"copper", "copper", 8960},
    {"titanium", "titanium", 4500},
    {"cast iron", "cast iron", 7200},
    {"polycarbonate", "polycarbonate", 1200},
    {"nylon", "nylon", 1140},
    {"delrin", "acetal", 1410},
    {"petg", "PETG", 1270},
    {"acrylic", "acrylic", 1180},
    {"silicone", "silicone", 1150},
    {"rubber", "rubber", 1200},
    {"plywood", "plywood", 600},
    {"abs plastic", "ABS", 1060},
    {"glass", "glass", 2500},
    {"bearing", "steel", kSteel},
}};

/// A name that may be an id: valid UTF-8, no control characters, no blanks at its ends.
std::string clean(std::string_view name) {
  std::string text;
  for (std::size_t i = 0; i < name.size();) {
    const std::size_t length = detail::character_length(name.substr(i));
    const auto byte = static_cast<unsigned char>(name[i]);
    if (length == 0) {
      text += '?';
    } else if (byte < 0x20 || byte == 0x7F) {
      text += ' ';
    } else {
      text += name.substr(i, length);
    }
    i += std::max<std::size_t>(length, 1);
  }
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

/// Gives every part its name and id.
void name_parts(std::span<const CadPart> parts, std::vector<CadPartFacts>& facts) {
  std::set<std::string> taken;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    facts[i].name = clean(parts[i].name);
    if (facts[i].name.empty()) facts[i].name = "part " + std::to_string(i + 1);
    // Names that no other part has are kept for the part that has them.
    taken.insert(facts[i].name);
  }
  std::map<std::string, std::size_t> used;
  for (CadPartFacts& part : facts) {
    std::size_t& number = used[part.name];
    part.id = part.name;
    if (++number == 1) continue;
    do {
      part.id = part.name + " " + std::to_string(number++);
    } while (!taken.insert(part.id).second);
    --number;
  }
}

void find_equal(std::span<const CadPart> parts, std::vector<CadPartFacts>& facts) {
  std::map<std::string, std::size_t> first;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    facts[i].equal = i;
    if (parts[i].product.empty()) continue;
    facts[i].equal = first.emplace(parts[i].product, i).first->second;
  }
}

bool is_plausible_density(double density) {
  constexpr double kFoam = 1;  // kg/m^3
  constexpr double kOsmium = 23'000;
  return density >= kFoam && density <= kOsmium;
}

/// The density that a name tells, if any.
std::optional<NamedDensity> density_named(std::string_view name) {
  if (detail::names_fastener(name)) return NamedDensity{"", "steel", kSteel};
  const std::string small = detail::lower(name);
  for (const NamedDensity& entry : kNamedDensities) {
    if (small.find(entry.word) != std::string::npos) return entry;
  }
  return std::nullopt;
}

void find_density(const CadPart& part, const Densities& densities, CadPartFacts& facts) {
  facts.material = clean(part.material);
  if (part.density && is_plausible_density(*part.density)) {
    facts.density = *part.density;
    facts.source = DensitySource::File;
    return;
  }
  auto named = part.material.empty() ? std::nullopt : density_named(part.material);
  if (!named) named = density_named(facts.name);
  if (named) {
    facts.density = named->density;
    facts.source = DensitySource::Name;
    if (facts.material.empty()) facts.material = named->material;
    return;
  }
  facts.density = densities.others.value_or(kUnknownDensity);
  facts.source = densities.others ? DensitySource::Given : DensitySource::Default;
}

bool matches(std::string_view pattern, std::string_view text) {
  // Each star is tried at its shortest first; the last one that was met is the one to widen.
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t star = std::string_view::npos;
  std::size_t from = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      from = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++from;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

[[noreturn]] void fail_unknown(const std::string& word, std::span<const CadPartFacts> parts,
                               const std::string& what) {
  std::string known;
  constexpr std::size_t kShown = 4;
  std::set<std::string> names;
  for (const CadPartFacts& part : parts) {
    if (!names.insert(part.name).second || names.size() > kShown) continue;
    known += (known.empty() ? "\"" : ", \"") + part.name + "\"";
  }
  throw InputError(what + ": no part is called \"" + clean(word) + "\"; parts are called " + known +
                   (names.size() > kShown ? ", ..." : ""));
}

}  // namespace

std::vector<CadPartFacts> part_facts(std::span<const CadPart> parts, const Densities& densities) {
  std::vector<CadPartFacts> facts(parts.size());
  name_parts(parts, facts);
  find_equal(parts, facts);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const MeshMeasure measured = measure(parts[i].mesh);
    facts[i].box = measured.box;
    facts[i].closed = measured.closed;
    facts[i].triangles = parts[i].mesh.triangles.size();
    facts[i].volume = parts[i].volume.value_or(std::max(measured.volume, 0.0));
    facts[i].centroid = parts[i].centroid.value_or(measured.centroid);
    find_density(parts[i], densities, facts[i]);
  }
  // What was placed otherwise was measured otherwise, in the last digits: equal parts weigh the
  // same.
  for (CadPartFacts& part : facts) {
    constexpr double kRounding = 1e-3;
    const double first = facts[part.equal].volume;
    if (std::abs(part.volume - first) <= kRounding * first) part.volume = first;
  }
  for (const auto& [word, density] : densities.by_part) {
    const std::vector<std::size_t> meant = parts_called(word, facts);
    if (meant.empty()) fail_unknown(word, facts, "density");
    for (const std::size_t part : meant) {
      facts[part].density = density;
      facts[part].source = DensitySource::Given;
    }
  }
  for (CadPartFacts& part : facts) part.mass = part.volume * part.density / kCubicMetre;
  return facts;
}

std::vector<bool> parts_with_equals(std::span<const CadPartFacts> parts) {
  std::vector<bool> shared(parts.size(), false);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::size_t first = parts[i].equal;
    if (first != i) shared[i] = shared[first] = true;
  }
  return shared;
}

std::vector<std::size_t> parts_called(std::string_view word, std::span<const CadPartFacts> parts) {
  std::vector<std::size_t> meant;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (matches(word, parts[i].id) || matches(word, parts[i].name)) meant.push_back(i);
  }
  return meant;
}

std::vector<std::size_t> parts_listed(const std::string& list, std::span<const CadPartFacts> parts,
                                      const std::string& what) {
  std::vector<std::size_t> all = parts_called(list, parts);
  if (!all.empty()) return all;
  std::set<std::size_t> meant;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    const std::string word = clean(list.substr(begin, end - begin));
    const std::vector<std::size_t> called = parts_called(word, parts);
    if (called.empty()) fail_unknown(word, parts, what);
    meant.insert(called.begin(), called.end());
    begin = end + 1;
  }
  return {meant.begin(), meant.end()};
}

}  // namespace orasp
