#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace orasp {

/// A graph whose vertices have colours. Edges have no direction.
struct ColouredGraph {
  std::vector<std::uint32_t> colours;                 ///< by vertex
  std::vector<std::array<std::uint32_t, 2>> edges{};  ///< each once

  [[nodiscard]] std::size_t size() const { return colours.size(); }
};

/// Where each of so many things goes.
using Permutation = std::vector<std::uint32_t>;

/// The automorphisms of a coloured graph: the permutations of its vertices that keep colours and
/// edges.
struct Automorphisms {
  std::vector<Permutation> generators{};
  /// Their number is the product of these, each 2 or more.
  std::vector<std::uint32_t> order{};
};

/// Finds the automorphisms of graphs.
///
/// Reference.  McKay and Piperno (2014), Practical graph isomorphism II, J. Symbolic Computation
///             60, 94-112: the program nauty.
/// Guarantee.  All of them.
/// Cost.       Milliseconds for the graphs that products have; exponential in theory.
/// Repeatable. The same graph gives the same generators.
///
/// Lives in a module of its own, which is loaded when it is first needed.
class AutomorphismFinder {
 public:
  AutomorphismFinder() = default;
  AutomorphismFinder(const AutomorphismFinder&) = delete;
  AutomorphismFinder& operator=(const AutomorphismFinder&) = delete;
  virtual ~AutomorphismFinder() = default;
  [[nodiscard]] virtual Automorphisms find(const ColouredGraph& graph) const = 0;
};

/// Why no automorphisms are found here: the module is missing. A clause that goes on from the name
/// of a method; empty where it is there.
[[nodiscard]] std::optional<std::string> automorphism_finder_obstacle();

/// @throws InputError if the module is missing or cannot be loaded.
[[nodiscard]] std::unique_ptr<AutomorphismFinder> make_automorphism_finder();

}  // namespace orasp
