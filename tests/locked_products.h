#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "orasp/model/problem.h"
#include "orasp/model/random.h"

namespace orasp {

inline constexpr std::size_t kPartsOfLocked = 8;

/// Parts at random places, joined by a random tree and some more connections; some block
/// others along some axes. In every fourth problem one part is a base part, in every fourth two.
inline ProblemSpec locked_product(std::uint64_t seed, const std::string& objective,
                                  std::size_t parts = kPartsOfLocked) {
  SplitMix64 random(seed);
  ProblemSpec spec;
  spec.name = "p" + std::to_string(seed);
  for (std::size_t p = 0; p < parts; ++p) {
    Part part;
    part.id = std::string(1, static_cast<char>('a' + p));
    part.mass = 1 + random.uniform();
    part.position = Vector3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    spec.parts.push_back(part);
  }
  const auto join = [&](std::size_t a, std::size_t b) {
    Connection connection;
    connection.id = std::to_string(spec.connections.size());
    connection.parts = {spec.parts[a].id, spec.parts[b].id};
    spec.connections.push_back(connection);
  };
  for (std::size_t p = 1; p < parts; ++p) join(p, random.below(p));
  for (std::size_t more = seed % 4; more > 0; --more) {
    const std::size_t a = random.below(parts - 1);
    join(a, a + 1 + random.below(parts - 1 - a));
  }
  if (seed % 3 != 0) {
    Blocking& blocking = spec.blocking.emplace();
    for (const char* axis : {"+x", "-x", "+y", "-y"}) blocking.directions.emplace_back(axis);
    for (std::size_t i = 0; i < 10; ++i) {
      const std::size_t a = random.below(parts);
      const std::size_t b = (a + 1 + random.below(parts - 1)) % parts;
      Blocked blocked;
      blocked.part = spec.parts[a].id;
      blocked.by = spec.parts[b].id;
      for (const char* axis : {"+x", "-x", "+y", "-y"}) {
        if (random.below(3) == 0) blocked.directions.emplace_back(axis);
      }
      if (!blocked.directions.empty()) spec.blocking->blocked.push_back(blocked);
    }
  }
  for (std::size_t base = seed % 4 < 3 ? seed % 4 : 0; base > 0; --base)
    spec.base.push_back(spec.parts[base * 2].id);
  spec.objective = Objective::named(objective);
  return spec;
}

}  // namespace orasp
