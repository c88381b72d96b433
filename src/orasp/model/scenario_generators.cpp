#include "orasp/model/scenario_generators.h"

#include <algorithm>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "orasp/model/random.h"

namespace orasp {
namespace {

/// Two parts by number, from 1; first < second.
using Pair = std::pair<std::size_t, std::size_t>;

Pair ordered(std::size_t a, std::size_t b) {
  return {std::min(a, b), std::max(a, b)};
}

void require_parts(std::size_t parts, const std::string& name) {
  if (parts < 1 || parts > kMaxParts) {
    throw InputError(name + ": " + std::to_string(parts) +
                     " parts are not possible; it takes 1 to " + std::to_string(kMaxParts));
  }
}

ProblemSpec assembly(std::string name, std::size_t parts, std::vector<Pair> pairs) {
  ProblemSpec spec;
  spec.name = std::move(name);
  spec.parts.resize(parts);
  for (std::size_t i = 0; i < parts; ++i) spec.parts[i].id = std::to_string(i + 1);
  std::ranges::sort(pairs);
  spec.connections.reserve(pairs.size());
  for (const auto& [a, b] : pairs) {
    Connection& connection = spec.connections.emplace_back();
    connection.parts = {std::to_string(a), std::to_string(b)};
  }
  return spec;
}

/// Draws a Pruefer code and decodes it: at each step the smallest leaf left is joined to the code's
/// next label. In linear time: a pointer runs upwards over the leaves, and only a label below it
/// that has just become a leaf is taken out of turn (Wang, Wang and Wu 2009).
std::vector<Pair> tree_pairs(std::size_t parts, SplitMix64& random) {
  std::vector<Pair> pairs;
  if (parts < 2) return pairs;
  pairs.reserve(parts - 1);
  std::vector<std::size_t> code(parts - 2);
  std::vector<std::size_t> degree(parts + 1, 1);
  for (std::size_t& label : code) {
    label = static_cast<std::size_t>(random.below(parts)) + 1;
    ++degree[label];
  }
  std::size_t pointer = 1;
  while (degree[pointer] != 1) ++pointer;
  std::size_t leaf = pointer;
  for (const std::size_t label : code) {
    pairs.push_back(ordered(leaf, label));
    if (--degree[label] == 1 && label < pointer) {
      leaf = label;
    } else {
      do ++pointer;
      while (degree[pointer] != 1);
      leaf = pointer;
    }
  }
  pairs.push_back(ordered(leaf, parts));
  return pairs;
}

}  // namespace

ProblemSpec chain(std::size_t parts) {
  const std::string name = "chain:" + std::to_string(parts);
  require_parts(parts, name);
  std::vector<Pair> pairs;
  pairs.reserve(parts);
  for (std::size_t i = 1; i < parts; ++i) pairs.emplace_back(i, i + 1);
  return assembly(name, parts, std::move(pairs));
}

ProblemSpec grid(std::size_t rows, std::size_t columns) {
  const std::string name = "grid:" + std::to_string(rows) + "x" + std::to_string(columns);
  if (rows < 1 || columns < 1 || rows > kMaxParts || columns > kMaxParts) {
    throw InputError(name + ": a grid has at least 1 row and 1 column, and at most " +
                     std::to_string(kMaxParts) + " parts");
  }
  require_parts(rows * columns, name);
  const std::size_t connections = rows * (columns - 1) + columns * (rows - 1);
  if (connections > kMaxConnections) {
    throw InputError(name + ": it would have " + std::to_string(connections) +
                     " connections; a problem has at most " + std::to_string(kMaxConnections));
  }
  std::vector<Pair> pairs;
  pairs.reserve(connections);
  const auto number = [columns](std::size_t row, std::size_t column) {
    return row * columns + column + 1;
  };
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      if (column + 1 < columns) pairs.emplace_back(number(row, column), number(row, column + 1));
      if (row + 1 < rows) pairs.emplace_back(number(row, column), number(row + 1, column));
    }
  }
  ProblemSpec spec = assembly(name, rows * columns, std::move(pairs));
  for (std::size_t i = 0; i < spec.parts.size(); ++i) {
    const std::size_t row = i / columns;
    const std::size_t column = i % columns;
    spec.parts[i].position = {static_cast<double>(column), static_cast<double>(row), 0};
  }
  return spec;
}

ProblemSpec random_tree(std::size_t parts, std::uint64_t seed) {
  const std::string name = "tree:" + std::to_string(parts) + ":" + std::to_string(seed);
  require_parts(parts, name);
  SplitMix64 random(seed);
  return assembly(name, parts, tree_pairs(parts, random));
}

ProblemSpec random_graph(std::size_t parts, std::size_t connections, std::uint64_t seed) {
  const std::string name = "random:" + std::to_string(parts) + ":" + std::to_string(connections) +
                           ":" + std::to_string(seed);
  require_parts(parts, name);
  const std::size_t most = std::min(parts * (parts - 1) / 2, kMaxConnections);
  if (connections < parts - 1 || connections > most) {
    throw InputError(name + ": " + std::to_string(connections) + " connections are not possible; " +
                     std::to_string(parts) + " parts take " + std::to_string(parts - 1) + " to " +
                     std::to_string(most) + ", at most one for each pair");
  }
  SplitMix64 random(seed);
  std::vector<Pair> pairs = tree_pairs(parts, random);
  const auto key = [parts](const Pair& pair) { return pair.first * (parts + 1) + pair.second; };
  std::unordered_set<std::size_t> taken;
  for (const Pair& pair : pairs) taken.insert(key(pair));
  // Rejection: even where every pair is wanted, about ln(pairs) draws are needed for each.
  while (pairs.size() < connections) {
    const auto a = static_cast<std::size_t>(random.below(parts)) + 1;
    const auto b = static_cast<std::size_t>(random.below(parts)) + 1;
    if (a == b) continue;
    const Pair pair = ordered(a, b);
    if (taken.insert(key(pair)).second) pairs.push_back(pair);
  }
  return assembly(name, parts, std::move(pairs));
}

}  // namespace orasp
