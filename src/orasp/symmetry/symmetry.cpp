#include "orasp/symmetry/symmetry.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <stdexcept>

#include "orasp/model/error.h"
#include "orasp/model/tolerance.h"
#include "orasp/symmetry/automorphisms.h"
#include "orasp/symmetry/problem_graph.h"

namespace orasp {

namespace {

/// Graphs beyond this are not looked at.
constexpr std::size_t kMostVertices = 200'000;
/// Images of points under all generators together.
constexpr std::size_t kMostImages = std::size_t{1} << 26;

/// Whether some connections look alike after a few rounds in which each vertex takes in what its
/// neighbours look like. If not, nothing can be exchanged.
bool some_alike(const ColouredGraph& graph, std::size_t first, std::size_t count) {
  constexpr int kRounds = 4;
  std::vector<std::uint64_t> look(graph.size());
  for (std::size_t v = 0; v < look.size(); ++v) look[v] = mixed(graph.colours[v] + 1U);
  std::vector<std::uint64_t> next;
  for (int round = 0; round < kRounds; ++round) {
    next = look;
    for (const auto& [a, b] : graph.edges) {
      next[a] += mixed(look[b] ^ 0x9e3779b97f4a7c15ULL);
      next[b] += mixed(look[a] ^ 0x9e3779b97f4a7c15ULL);
    }
    for (std::uint64_t& value : next) value = mixed(value);
    look.swap(next);
  }
  const auto begin = look.begin() + static_cast<std::ptrdiff_t>(first);
  std::vector<std::uint64_t> looks(begin, begin + static_cast<std::ptrdiff_t>(count));
  std::ranges::sort(looks);
  return std::ranges::adjacent_find(looks) != looks.end();
}

/// What the generators do to `count` vertices from `first` on, which they take to one another;
/// those that leave all of them alone are left out.
std::vector<Permutation> restricted_to(const Automorphisms& all, std::size_t first,
                                       std::size_t count) {
  std::set<Permutation> different;
  for (const Permutation& g : all.generators) {
    Permutation restricted(count);
    bool moves = false;
    for (std::size_t c = 0; c < count; ++c) {
      restricted[c] = g[first + c] - static_cast<std::uint32_t>(first);
      moves = moves || restricted[c] != c;
    }
    if (moves) different.insert(std::move(restricted));
  }
  return {different.begin(), different.end()};
}

}  // namespace

Symmetry::Symmetry(const TransitionSystem& system) {
  const ProblemGraph problem = problem_graph(system);
  obstacle_ = problem.obstacle;
  if (obstacle_) return;
  const std::size_t parts = parts_ = system.problem().num_parts();
  const std::size_t connections = system.num_connections();
  if (problem.graph.size() > kMostVertices) {
    obstacle_ = "finds no symmetry in a problem that states so much";
    return;
  }
  if (!some_alike(problem.graph, parts, connections)) return;
  obstacle_ = automorphism_finder_obstacle();
  if (obstacle_) return;
  const Automorphisms all = make_automorphism_finder()->find(problem.graph);
  if (all.generators.size() * problem.graph.size() > kMostImages) {
    obstacle_ = "finds no symmetry in a problem that states so much";
    return;
  }
  generators_ = restricted_to(all, parts, connections);
  part_generators_ = restricted_to(all, 0, parts);
  form_ = OrbitForm(connections, generators_);
}

double Symmetry::order() const {
  double product = 1;
  for (const std::uint64_t factor : form_.order()) product *= static_cast<double>(factor);
  return product;
}

std::string Symmetry::text() const {
  if (trivial()) return {};
  constexpr double kExact = 9e15;  // whole numbers are exact
  const double all = order();
  std::string number;
  if (all < kExact) {
    number = std::to_string(static_cast<std::uint64_t>(all));
  } else {
    number = "10^" + std::to_string(static_cast<int>(std::floor(std::log10(all)))) + " or more";
    if (!std::isfinite(all)) number = "more than 10^308";
  }
  return number + " ways to exchange equal parts leave the problem as it is";
}

std::optional<std::vector<std::uint32_t>> symmetry_order(const TransitionSystem& system) {
  ProblemGraph problem = problem_graph(system);
  if (problem.obstacle || problem.graph.size() > kMostVertices) return std::nullopt;
  const std::size_t parts = system.problem().num_parts();
  const std::size_t connections = system.num_connections();
  if (!some_alike(problem.graph, parts, connections)) return std::vector<std::uint32_t>{};
  if (automorphism_finder_obstacle()) return std::nullopt;
  const auto finder = make_automorphism_finder();
  std::vector<std::uint32_t> all = finder->find(problem.graph).order;
  // Those that leave every connection where it is move no sequence: with a colour for each
  // connection they alone are left.
  const auto colours = static_cast<std::uint32_t>(problem.graph.size());
  for (std::size_t c = 0; c < connections; ++c)
    problem.graph.colours[parts + c] = colours + static_cast<std::uint32_t>(c);
  // The product of the one divided by that of the other, factor by factor.
  for (std::uint32_t divisor : finder->find(problem.graph).order) {
    for (std::uint32_t& factor : all) {
      for (std::uint32_t prime = 2; divisor > 1 && prime <= divisor;) {
        if (divisor % prime == 0 && factor % prime == 0) {
          divisor /= prime;
          factor /= prime;
        } else {
          ++prime;
        }
      }
    }
  }
  std::erase(all, 1U);
  return all;
}

std::optional<std::string> symmetry_obstacle(const TransitionSystem& system, SymmetryUse use) {
  if (use != SymmetryUse::On) return std::nullopt;
  return Symmetry(system).obstacle();
}

std::optional<Symmetry> symmetry_for(const TransitionSystem& system, SymmetryUse use,
                                     std::string_view method) {
  if (use == SymmetryUse::Off) return std::nullopt;
  Symmetry symmetry(system);
  if (use == SymmetryUse::On && symmetry.obstacle()) throw Refusal(method, *symmetry.obstacle());
  if (symmetry.trivial()) return std::nullopt;
  return symmetry;
}

std::vector<ConnectionIndex> true_sequence(const TransitionSystem& system, OrbitForm form,
                                           std::span<const ConnectionIndex> sequence) {
  Expander expander(system);
  std::vector<ConnectionIndex> result;
  const std::size_t words = system.words();
  const auto without = [words](SetView state, ConnectionIndex c) {
    std::vector<std::uint64_t> next(state.begin(),
                                    state.begin() + static_cast<std::ptrdiff_t>(words));
    next[c / 64] &= ~(std::uint64_t{1} << (c % 64));
    return next;
  };
  const SetView start = system.start_state();
  std::vector<std::uint64_t> here(start.begin(), start.end());  // where the plan is
  std::vector<std::uint64_t> stands = here;                     // what stands for it
  for (const ConnectionIndex c : sequence) {
    // What the step earns in the state in which it was made, and where it leads.
    double earned = -kInfinity;
    for (const Action& action : expander.legal_actions(stands)) {
      if (action.connection == c) earned = action.reward;
    }
    stands = without(stands, c);
    form.canonical(stands);
    // Of the steps that lead there the one that earns as much.
    double least = kInfinity;
    std::optional<ConnectionIndex> best;
    for (const Action& action : expander.legal_actions(here)) {
      const double off = std::abs(action.reward - earned);
      if (!(off < least)) continue;
      std::vector<std::uint64_t> next = without(here, action.connection);
      form.canonical(next);
      if (next != stands) continue;
      least = off;
      best = action.connection;
    }
    if (!best || least > kRewardTolerance * std::max(1.0, std::abs(earned)))
      throw std::logic_error(
          "symmetry: no step of the plan is that of the state that stands for it");
    result.push_back(*best);
    here = without(here, *best);
  }
  return result;
}

}  // namespace orasp
