#include "orasp/certificate/certificate.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "orasp/certificate/detail/earned.h"
#include "orasp/certificate/detail/leaving.h"
#include "orasp/certificate/detail/outward.h"
#include "orasp/certificate/detail/piece_cuts.h"
#include "orasp/certificate/detail/piece_proof.h"
#include "orasp/certificate/detail/place_rewards.h"
#include "orasp/certificate/detail/removals.h"
#include "orasp/certificate/detail/size_rewards.h"
#include "orasp/model/plan_check.h"

namespace orasp {

namespace {

using detail::add_up;

/// Bellman's recursion over sizes, every sum rounded up; `prices` beside it, where that says more.
std::optional<Certificate> by_sizes(const Problem& problem, bool prices = false) {
  const detail::SizeRewards rewards(problem, prices);
  if (!rewards.known() || (prices && !rewards.priced())) return std::nullopt;
  Certificate certificate;
  if (prices) {
    certificate.kind = Certificate::Kind::Prices;
    for (PartIndex part = 0; part < problem.num_parts(); ++part) {
      const bool fixed = problem.in_base(part);
      certificate.prices.push_back(fixed ? 0.0 : std::min(0.0, rewards.price(part)));
    }
  }
  const auto pieces = detail::piece_sizes(problem, ConnectionSet::all(problem.num_connections()));
  const std::size_t largest = pieces.empty() ? 0 : *std::ranges::max_element(pieces);
  const bool limited = problem.limits().max_moved_parts && problem.spec().base.size() < 2;
  const std::size_t most = limited ? *problem.limits().max_moved_parts : largest;
  std::vector<double>& g = certificate.sizes;
  g.assign(largest + 1, -kInfinity);
  for (std::size_t n = 0; n <= std::min<std::size_t>(1, largest); ++n) g[n] = 0;
  for (std::size_t n = 2; n <= largest; ++n) {
    for (std::size_t a = 1; a <= n / 2 && a <= most; ++a) {
      for (const std::size_t first : {a, n - a})
        g[n] = std::max(g[n], add_up(rewards.cut(first, n - first), add_up(g[a], g[n - a])));
    }
  }
  return certificate;
}

/// Adds to prices which parts leave together, for those parts which by prices alone may stay.
/// @returns false where nothing does.
bool add_together(const Problem& problem, Certificate& certificate,
                  const std::function<bool()>& stop) {
  constexpr std::size_t kMostParts = 512;
  const detail::SizeRewards rewards(problem, true);
  bool any = false;
  for (auto& piece :
       detail::PieceCuts(problem).pieces_of(ConnectionSet::all(problem.num_connections()))) {
    if (piece.size() > kMostParts) continue;
    const std::vector<PartIndex> all = piece;
    if (std::ranges::any_of(all, [&](PartIndex part) { return problem.in_base(part); }))
      std::erase_if(piece, [&](PartIndex part) { return !problem.in_base(part); });
    std::ranges::stable_sort(piece, {}, [&](PartIndex part) { return certificate.prices[part]; });
    double best = -kInfinity;
    for (const PartIndex stays : piece) {
      if (stop()) return false;
      // The part that costs least when it stays is left to the end; those after it cost more.
      double worth = 0;
      for (const PartIndex part : all) worth += part == stays ? 0 : certificate.prices[part];
      if (worth <= best) break;
      const detail::Leaving leaving(problem, all, stays);
      const auto groups = leaving.groups();
      for (const std::vector<PartIndex>& group : groups) worth += rewards.price_of_group(group);
      best = std::max(best, worth);
      if (groups.empty()) break;
      certificate.together.push_back({stays, groups});
      any = true;
    }
  }
  return any;
}

/// Prices of connections and places, where these tell what steps earn.
std::optional<Certificate> by_places(const Problem& problem) {
  if (problem.num_connections() > detail::kMostCertifiedPlaces) return std::nullopt;
  const detail::PlaceRewards rewards(problem);
  if (!rewards.known()) return std::nullopt;
  detail::PlaceProof proof = detail::prove_by_places(rewards, problem.num_connections());
  if (proof.connections.empty()) return std::nullopt;
  Certificate certificate;
  certificate.kind = Certificate::Kind::Places;
  certificate.connections = std::move(proof.connections);
  certificate.places = std::move(proof.places);
  return certificate;
}

/// All states that can be reached, and from the last layer backwards what is still to be earned.
Certified by_states(const Problem& problem, std::size_t most_states,
                    const std::function<bool()>& stop) {
  detail::Removals removals(problem);
  const std::size_t connections = problem.num_connections();
  // A file of more than 256 MiB is not read.
  constexpr std::size_t kMostBytes = std::size_t{200} << 20U;
  most_states = std::min(most_states, kMostBytes / (connections / 4 + 40));
  Certificate certificate;
  certificate.kind = Certificate::Kind::States;
  auto& layers = certificate.layers;
  layers.push_back({{.present = ConnectionSet::all(connections)}});
  if (!removals.start_allowed()) return {std::move(certificate), {}};
  using Places = std::unordered_map<ConnectionSet, std::size_t>;
  std::vector<Places> places(1);
  places[0].emplace(layers[0][0].present, 0);
  std::size_t states = 1;
  const auto give_up = [&](std::size_t done) -> std::optional<Certified> {
    if (states > most_states)
      return Certified{{},
                       "more than " + std::to_string(most_states) +
                           " states can be reached, which is more than a certificate lists"};
    if (done % 256 == 0 && stop()) return Certified{{}, "it was stopped"};
    return std::nullopt;
  };
  for (std::size_t k = 0; k < connections; ++k) {
    layers.emplace_back();
    places.emplace_back();
    for (std::size_t i = 0; i < layers[k].size(); ++i) {
      if (auto given_up = give_up(i)) return *std::move(given_up);
      ConnectionSet after = layers[k][i].present;
      removals.look_at(after);
      for_each_connection(layers[k][i].present.view(), [&](ConnectionIndex c) {
        if (!removals.allowed(c)) return;
        after.erase(c);
        if (places[k + 1].emplace(after, layers[k + 1].size()).second) {
          layers[k + 1].push_back({.present = after});
          ++states;
        }
        after.insert(c);
      });
    }
  }
  for (Certificate::State& end : layers[connections]) end.value = 0;
  for (std::size_t k = connections; k-- > 0;) {
    for (std::size_t i = 0; i < layers[k].size(); ++i) {
      if (auto given_up = give_up(i)) return *std::move(given_up);
      Certificate::State& here = layers[k][i];
      ConnectionSet after = here.present;
      removals.look_at(after);
      bool finite = true;
      for_each_connection(here.present.view(), [&](ConnectionIndex c) {
        if (!removals.allowed(c)) return;
        after.erase(c);
        const double next = layers[k + 1][places[k + 1].at(after)].value;
        after.insert(c);
        if (next == -kInfinity) return;
        const detail::Removals::Reward reward = removals.reward();
        finite = finite && reward.finite;
        here.value = std::max(here.value, add_up(reward.most, next));
      });
      if (!finite) return {{}, "some step has no finite reward"};
    }
    places.pop_back();
  }
  return {std::move(certificate), {}};
}

/// The largest set of connections each of which waits for another of them, if there is one: those
/// that wait for none are taken away until all that are left do.
std::optional<Certificate> by_waiting(const Problem& problem, bool first) {
  Certificate certificate;
  certificate.kind = Certificate::Kind::Waits;
  certificate.first = first;
  ConnectionSet left = ConnectionSet::all(problem.num_connections());
  const auto is_left = [&](ConnectionIndex c) { return left.contains(c); };
  for (bool changed = true; changed;) {
    ConnectionSet waits(problem.num_connections());
    for (const PrecedenceClause& clause : problem.precedence()) {
      const ConnectionIndex c = clause.connection;
      const auto& any = first ? clause.after_any : clause.made_after_any;
      if (!any.empty() && std::ranges::all_of(any, is_left)) waits.insert(c);
      if (first) {
        if (std::ranges::any_of(clause.after, is_left)) waits.insert(c);
      } else if (is_left(c)) {
        for (const ConnectionIndex other : clause.after) {
          if (other != c) waits.insert(other);
        }
      }
    }
    changed = false;
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      if (!left.contains(c) || waits.contains(c)) continue;
      left.erase(c);
      changed = true;
    }
  }
  if (left.empty()) return std::nullopt;
  for_each_connection(left.view(), [&](ConnectionIndex c) { certificate.waiting.push_back(c); });
  return certificate;
}

/// Two parts that block each other in every direction.
std::optional<Certificate> by_locked_parts(const Problem& problem) {
  Certificate certificate;
  certificate.kind = Certificate::Kind::Locked;
  for (PartIndex part = 0; part < problem.num_parts(); ++part) {
    for (const Blocker& blocker : problem.blockers()[part]) {
      if (blocker.by < part) continue;
      const bool all = std::ranges::all_of(problem.directions(), [&](DirectionIndex direction) {
        return problem.blocks(blocker, direction.value());
      });
      if (!all) continue;
      certificate.locked = {part, blocker.by};
      if (check_certificate(problem, certificate).holds) return certificate;
    }
  }
  return std::nullopt;
}

}  // namespace

Certified make_certificate(const Problem& problem, std::optional<double> reward, double tolerance,
                           std::size_t most_states, const std::function<bool()>& stop) {
  if (std::string reason = without_certificates(problem); !reason.empty())
    return {{}, std::move(reason)};
  const double wanted = reward ? *reward + tolerance : -kInfinity;
  // The bound that it states is the one that its check proves. Whether it proves what is wanted:
  const auto proves = [&](Certificate& certificate) {
    certificate.bound = kInfinity;
    const CertificateCheck check = check_certificate(problem, certificate);
    certificate.bound = check.bound;
    return check.holds && check.bound <= wanted;
  };
  if (!reward) {
    for (const bool first : {true, false}) {
      if (auto found = by_waiting(problem, first); found && proves(*found)) return {found, {}};
    }
    if (auto found = by_locked_parts(problem)) return {found, {}};
  }
  auto sizes = by_sizes(problem);
  if (sizes && proves(*sizes)) return {sizes, {}};
  if (auto found = by_sizes(problem, true)) {
    if (proves(*found)) return {found, {}};
    if (add_together(problem, *found, stop) && proves(*found)) return {found, {}};
  }
  if (auto found = by_places(problem); found && proves(*found)) return {found, {}};
  if (auto& found = sizes) {
    const detail::SizeRewards rewards(problem);
    // What is missing is told by the reward itself, so that the bound is no looser than it must be.
    found->kind = Certificate::Kind::Pieces;
    found->pieces =
        detail::prove_by_pieces(problem, rewards, found->sizes, reward.value_or(-kInfinity), stop)
            .pieces;
    if (!found->pieces.empty() && proves(*found)) return {found, {}};
  }
  Certified states = by_states(problem, most_states, stop);
  if (!states.certificate || proves(*states.certificate)) return states;
  return {{},
          reward ? "all states together prove a bound above what the plan earns"
                 : "all states together do not prove that there is no plan"};
}

Certified certify(const Problem& problem, std::optional<std::span<const ConnectionIndex>> plan,
                  const std::function<bool()>& stop) {
  if (!plan) return make_certificate(problem, std::nullopt, 0, kMostCertifiedStates, stop);
  const PlanCheck replay = check_plan(problem, Situation::whole(problem.num_connections()), *plan);
  const detail::Earned earned = detail::earned_by(problem, replay, *plan);
  return make_certificate(problem, earned.reward, earned.tolerance, kMostCertifiedStates, stop);
}

}  // namespace orasp
