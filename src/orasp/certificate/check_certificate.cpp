#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>

#include "orasp/certificate/certificate.h"
#include "orasp/certificate/detail/earned.h"
#include "orasp/certificate/detail/leaving.h"
#include "orasp/certificate/detail/outward.h"
#include "orasp/certificate/detail/piece_bound.h"
#include "orasp/certificate/detail/piece_cuts.h"
#include "orasp/certificate/detail/piece_values.h"
#include "orasp/certificate/detail/place_rewards.h"
#include "orasp/certificate/detail/removals.h"
#include "orasp/certificate/detail/size_rewards.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/plan_check.h"

namespace orasp {

namespace {

using detail::add_up;
using detail::PieceValues;
using detail::Removals;
using detail::SizeRewards;

/// One check; each of the seven returns a fault, or nothing and the bound that it has proved.
class Checker {
 public:
  Checker(const Problem& problem, const Certificate& certificate)
      : problem_(problem), certificate_(certificate) {}

  CertificateCheck run() {
    CertificateCheck check;
    check.fault = without_certificates(problem_);
    if (check.fault.empty()) check.fault = fault();
    check.inequalities = inequalities_;
    check.bound = proved_;
    if (!check.fault.empty()) {
      check.bound = kInfinity;
      return check;
    }
    // Not `proved_ > bound`: a bound that is no number states nothing.
    check.holds = proved_ <= certificate_.bound;
    if (!check.holds)
      check.fault = "it proves that no plan earns more than " + detail::number_text(proved_) +
                    ", and states " +
                    (certificate_.bound == -kInfinity
                         ? std::string("that there is no plan")
                         : "the smaller bound " + detail::number_text(certificate_.bound));
    return check;
  }

 private:
  std::string fault() {
    switch (certificate_.kind) {
      case Certificate::Kind::Sizes: return fault_of_sizes();
      case Certificate::Kind::Prices: return fault_of_prices();
      case Certificate::Kind::Places: return fault_of_places();
      case Certificate::Kind::Pieces: return fault_of_pieces();
      case Certificate::Kind::States: return fault_of_states();
      case Certificate::Kind::Waits: return fault_of_waits();
      case Certificate::Kind::Locked: break;
    }
    return fault_of_locked();
  }

  std::string fault_of_sizes();
  std::string fault_of_table(const SizeRewards& rewards);
  std::string fault_of_prices();
  std::string fault_of_together(std::span<const PartIndex> piece, const Certificate::Together& said,
                                std::size_t number);
  [[nodiscard]] double worth_of_prices(std::span<const PartIndex> piece, PartIndex stays) const;
  std::string prove_prices(const SizeRewards& rewards);
  std::string fault_of_places();
  std::string fault_of_pieces();
  [[nodiscard]] std::string fault_of_names(const PieceValues& values) const;
  void prove_bound(const SizeRewards& rewards, const PieceValues& values);
  std::string fault_of_states();
  std::string fault_of_waits();
  std::string fault_of_locked();
  [[nodiscard]] bool waits(ConnectionIndex connection, const ConnectionSet& others) const;

  const Problem& problem_;
  const Certificate& certificate_;
  double proved_ = kInfinity;
  std::uint64_t inequalities_ = 0;
};

// A table g over numbers of parts, with g(1) = 0 and, for every cut that the limits do not forbid,
//
//     g(a + b) >= cut(a, b) + g(a) + g(b).
//
// The sum of g over the pieces of a state is a potential of what its cuts earn: a cut of any piece
// takes at least what it earns from it, and at the end all pieces are single parts. -infinity says
// that a piece can never be taken apart.
std::string Checker::fault_of_sizes() {
  const SizeRewards rewards(problem_);
  if (std::string fault = fault_of_table(rewards); !fault.empty()) return fault;
  prove_bound(rewards, PieceValues(problem_, rewards, certificate_.sizes));
  return {};
}

std::string Checker::fault_of_table(const SizeRewards& rewards) {
  if (!rewards.known())
    return "the objective is not told by the sizes of pieces, and the kind \"" +
           std::string(kind_name(certificate_.kind)) + "\" proves nothing of it";
  const std::vector<double>& g = certificate_.sizes;
  const auto pieces = detail::piece_sizes(problem_, ConnectionSet::all(problem_.num_connections()));
  const std::size_t largest = pieces.empty() ? 0 : *std::ranges::max_element(pieces);
  if (g.size() != largest + 1)
    return "sizes: " + std::to_string(largest + 1) + " numbers are wanted, for pieces of 0 to " +
           std::to_string(largest) + " parts, and " + std::to_string(g.size()) + " are there";
  if (largest >= 1 && g[1] != 0) return "sizes[1]: a single part is worth 0";
  // Two pieces that both hold base parts come apart without a motion, which no limit forbids.
  const bool limited = problem_.limits().max_moved_parts && problem_.spec().base.size() < 2;
  const std::size_t most = limited ? *problem_.limits().max_moved_parts : largest;
  for (std::size_t n = 2; n <= largest; ++n) {
    for (std::size_t a = 1; a <= n / 2 && a <= most; ++a) {
      // The first part of the connection may be on either side.
      for (const std::size_t first : {a, n - a}) {
        const double worth = add_up(rewards.cut(first, n - first), add_up(g[a], g[n - a]));
        ++inequalities_;
        if (!(g[n] >= worth))
          return "sizes[" + std::to_string(n) + "]: " + detail::number_text(g[n]) +
                 " is less than a cut into " + std::to_string(a) + " and " + std::to_string(n - a) +
                 " parts is worth, " + detail::number_text(worth);
      }
    }
  }
  return {};
}

void Checker::prove_bound(const SizeRewards& rewards, const PieceValues& values) {
  proved_ = -kInfinity;
  for (const detail::PieceGroup& group :
       detail::piece_groups(problem_, rewards, values, detail::PieceCuts(problem_)))
    proved_ = std::max(proved_, group.bound);
}

// A table g as that of sizes for all that is told by sizes, and for the rest a price y(p) <= 0 of
// each part: a cut that moves a piece with p in it earns no more of the rest than that. Let P(S) be
// the sum of the prices of a piece S without its base part, or without the least price where it has
// none. A cut of S moves M off K. If K has the base part, P(S) - P(M) - P(K) is the least price in
// M. If there is none it is the greater of the least price in M and that in K. Each price in M is
// at least what the cut earns, so the sum of P over the pieces of a state falls by no less.
std::string Checker::fault_of_prices() {
  const SizeRewards rewards(problem_, true);
  if (std::string fault = fault_of_table(rewards); !fault.empty()) return fault;
  const std::vector<double>& prices = certificate_.prices;
  if (prices.size() != problem_.num_parts())
    return "prices: " + std::to_string(problem_.num_parts()) +
           " numbers are wanted, one for each part, and " + std::to_string(prices.size()) +
           " are there";
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    const bool fixed = problem_.in_base(part);
    const double least = rewards.price(part);
    ++inequalities_;
    if (fixed ? prices[part] != 0 : !(prices[part] >= least && prices[part] <= 0))
      return "prices[" + std::to_string(part) + "]: " + detail::number_text(prices[part]) +
             (fixed ? std::string(" is not 0, and a base part never moves")
                    : " is not from " + detail::number_text(least) + ", which moving " +
                          detail::in_quotes(problem_.part_id(part)) + " earns, to 0");
  }
  return prove_prices(rewards);
}

// The prices of a piece without that of the part that stays.
double Checker::worth_of_prices(std::span<const PartIndex> piece, PartIndex stays) const {
  double sum = 0;
  for (const PartIndex part : piece) {
    if (part != stays) sum = add_up(sum, certificate_.prices[part]);
  }
  return sum;
}

std::string Checker::fault_of_together(std::span<const PartIndex> piece,
                                       const Certificate::Together& said, std::size_t number) {
  const std::string place = "together[" + std::to_string(number) + "]";
  const detail::Leaving leaving(problem_, piece, said.stays);
  if (!leaving.possible())
    return place + ": some part could never leave " +
           detail::in_quotes(problem_.part_id(said.stays));
  std::vector<bool> seen(problem_.num_parts(), false);
  seen[said.stays] = true;
  for (const std::vector<PartIndex>& group : said.groups) {
    for (const PartIndex part : group) {
      const bool inside = std::ranges::find(piece, part) != piece.end();
      ++inequalities_;
      if (!inside || seen[part] || !leaving.together(group.front(), part))
        return place + ": nothing makes " + detail::in_quotes(problem_.part_id(part)) + " leave " +
               detail::in_quotes(problem_.part_id(said.stays)) + " together with " +
               detail::in_quotes(problem_.part_id(group.front())) + " alone";
      seen[part] = true;
    }
  }
  return {};
}

// Follow the side that stays: it ends as one part, which is never moved, and each other part of the
// piece ends as the last of what was moved in some cut. So the prices without that of the part that
// stays are a bound, whichever it is; the greatest of them bounds all plans. What leaves it in one
// move, M, is moved with all its mass, and then comes apart, by one cut fewer than it has parts, in
// which all of them move once more but one. So beyond the prices of its parts it takes the price of
// its mass without the heaviest of them; and so does each group in M, all groups together no more
// than M.
std::string Checker::prove_prices(const SizeRewards& rewards) {
  const std::vector<double>& prices = certificate_.prices;
  prove_bound(rewards, PieceValues(problem_, rewards, certificate_.sizes));
  const detail::PieceCuts cuts(problem_);
  std::vector<bool> told(problem_.num_parts(), false);
  for (const Certificate::Together& said : certificate_.together) {
    if (told[said.stays])
      return "together: " + detail::in_quotes(problem_.part_id(said.stays)) + " stays twice";
    told[said.stays] = true;
  }
  for (const auto& piece : cuts.pieces_of(ConnectionSet::all(problem_.num_connections()))) {
    const auto base =
        std::ranges::find_if(piece, [&](PartIndex part) { return problem_.in_base(part); });
    double most = -kInfinity;
    for (std::size_t i = 0; i < certificate_.together.size(); ++i) {
      const Certificate::Together& said = certificate_.together[i];
      if (std::ranges::find(piece, said.stays) == piece.end()) continue;
      if (std::string fault = fault_of_together(piece, said, i); !fault.empty()) return fault;
      if (base != piece.end() && said.stays != *base) continue;  // the base part is what stays
      double worth = worth_of_prices(piece, said.stays);
      for (const std::vector<PartIndex>& group : said.groups)
        worth = add_up(worth, rewards.price_of_group(group));
      most = std::max(most, worth);
    }
    // Of those of which nothing is said the one that costs most to move.
    std::optional<PartIndex> last;
    for (const PartIndex part : piece) {
      if (told[part] || (base != piece.end() && part != *base)) continue;
      if (!last || prices[part] < prices[*last]) last = part;
    }
    if (last) most = std::max(most, worth_of_prices(piece, *last));
    if (proved_ > -kInfinity) proved_ = add_up(proved_, most);
  }
  return {};
}

// A number u(c) for each connection and v(k) for each place in the order. A plan gives each
// connection a place of its own, so if
//
//     v(k) >= earned(c, k) - u(c)
//
// wherever c may have the place k, it earns no more than all u and v together. How many states a
// plan has left to choose from does not matter, nor in which it makes a step.
std::string Checker::fault_of_places() {
  const detail::PlaceRewards rewards(problem_);
  if (!rewards.known())
    return "the objective is not told by connections and their places, and the kind \"places\" "
           "proves nothing of it";
  const std::size_t connections = problem_.num_connections();
  const auto fault_of = [&](const char* key, const std::vector<double>& numbers) -> std::string {
    if (numbers.size() != connections)
      return std::string(key) + ": " + std::to_string(connections) + " numbers are wanted, and " +
             std::to_string(numbers.size()) + " are there";
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (!std::isfinite(numbers[i]))
        return std::string(key) + "[" + std::to_string(i) + "]: a number is wanted";
    }
    return {};
  };
  for (std::string fault : {fault_of("connections", certificate_.connections),
                            fault_of("places", certificate_.places)}) {
    if (!fault.empty()) return fault;
  }
  double sum = 0;
  for (std::size_t place = 0; place < connections; ++place) {
    for (ConnectionIndex c = 0; c < connections; ++c) {
      if (!rewards.possible(c, place)) continue;
      const double left = add_up(rewards.most(c, place), -certificate_.connections[c]);
      ++inequalities_;
      if (!(certificate_.places[place] >= left))
        return "places[" + std::to_string(place) +
               "]: " + detail::number_text(certificate_.places[place]) + " is less than what " +
               detail::in_quotes(problem_.connection_id(c)) + " earns there beyond its own, " +
               detail::number_text(left);
    }
    sum = add_up(sum, certificate_.places[place]);
  }
  for (const double own : certificate_.connections) sum = add_up(sum, own);
  proved_ = sum;
  return {};
}

// Values v of some pieces beside the table. What a piece is worth, w, is what is listed of it, or
// what the table says of its number of parts, if that is less. For every piece that is listed, and
// every cut of it that some plan may make,
//
//     v(S) >= cut(a, b) + w(A) + w(B).
//
// Cuts for which the table says so already are not looked at. So the sum of w over the pieces of a
// state is a potential, as that of the table is. Where max_subassemblies is stated, it is a piece
// together with the number of subassemblies that it may be at a time that is worth something
// (PieceValues).
std::string Checker::fault_of_pieces() {
  const SizeRewards rewards(problem_);
  if (std::string fault = fault_of_table(rewards); !fault.empty()) return fault;
  PieceValues values(problem_, rewards, certificate_.sizes);
  if (std::string fault = fault_of_names(values); !fault.empty()) return fault;
  for (const Certificate::Piece& piece : certificate_.pieces)
    values.list(piece.parts, piece.allowed, piece.value);
  detail::PieceCuts cuts(problem_);
  std::string fault;
  for (std::size_t i = 0; i < certificate_.pieces.size(); ++i) {
    const auto& [parts, allowed, value] = certificate_.pieces[i];
    const auto check = [&, &value = value, &allowed = allowed](const detail::PieceCuts::Side& a,
                                                               const detail::PieceCuts::Side& b) {
      const double worth = add_up(values.cut(a, b), values.of_both(a, b, allowed));
      ++inequalities_;
      if (value >= worth) return true;
      fault = "pieces[" + std::to_string(i) + "]: " + detail::number_text(value) +
              " is less than a cut into " + std::to_string(a.size()) + " and " +
              std::to_string(b.size()) + " parts, of which the first holds " +
              detail::in_quotes(problem_.part_id(a.front())) + ", is worth, " +
              detail::number_text(worth);
      return false;
    };
    if (!cuts.for_each(parts, values.sizes_above(parts.size(), value), kMostCertifiedCuts, check))
      return fault.empty() ? "pieces: there are more than " + std::to_string(kMostCertifiedCuts) +
                                 " cuts to look at"
                           : fault;
  }
  prove_bound(rewards, values);
  return {};
}

// Whether each is a set of parts of the product, with a number of subassemblies that it can make
// use of.
std::string Checker::fault_of_names(const PieceValues& values) const {
  for (std::size_t i = 0; i < certificate_.pieces.size(); ++i) {
    const auto& [parts, allowed, value] = certificate_.pieces[i];
    const std::string place = "pieces[" + std::to_string(i) + "]: ";
    const bool ascending =
        std::ranges::adjacent_find(parts, std::ranges::greater_equal()) == parts.end();
    if (parts.size() < 2 || !ascending || parts.back() >= problem_.num_parts() ||
        parts.size() >= certificate_.sizes.size())
      return place + "two parts or more of one piece of the product are wanted";
    if (allowed != values.useful(allowed, parts.size()) || (values.limited() && allowed == 0))
      return place + std::to_string(allowed) +
             " is not a number of subassemblies that it can make use of at a time";
    if (std::isnan(value)) return place + "its value is no number";
  }
  return {};
}

// A number h for each state that can be reached, layer by layer. With v(k) the most by which a step
// out of layer k earns more than h(before) - h(after), a plan earns at most h(start) - h(end) plus
// the sum of all v(k) that are above 0. Where h is right up to rounding they are almost nothing.
std::string Checker::fault_of_states() {
  const auto& layers = certificate_.layers;
  const std::size_t connections = problem_.num_connections();
  Removals removals(problem_);
  using Values = std::unordered_map<ConnectionSet, double>;
  Values reached;
  const ConnectionSet all = ConnectionSet::all(connections);
  const auto listed = [&](std::size_t layer) {
    Values values;
    if (layer < layers.size()) {
      for (const Certificate::State& state : layers[layer])
        values.emplace(state.present, state.value);
    }
    return values;
  };
  const Values first = listed(0);
  const auto start = first.find(all);
  if (start == first.end())
    return "layers[0]: the state in which all connections are there is missing";
  if (!removals.start_allowed()) {
    proved_ = -kInfinity;
    return {};
  }
  reached.emplace(all, start->second);
  double bound = start->second;
  for (std::size_t k = 0; k < connections && !reached.empty(); ++k) {
    const Values next = listed(k + 1);
    Values reached_next;
    double most = 0;
    for (const auto& [present, here] : reached) {
      removals.look_at(present);
      ConnectionSet after = present;
      std::string missing;
      for_each_connection(present.view(), [&](ConnectionIndex c) {
        if (!missing.empty() || !removals.allowed(c)) return;
        after.erase(c);
        const auto found = next.find(after);
        const auto step = [&] {
          return "a step out of layer " + std::to_string(k) + ", at " +
                 detail::in_quotes(problem_.connection_id(c)) + ", ";
        };
        ++inequalities_;
        if (found == next.end()) {
          missing = "layers[" + std::to_string(k + 1) + "]: " + step() +
                    "leads to a state that is not listed";
        } else if (found->second > -kInfinity) {
          if (here == -kInfinity) {
            missing = "layers[" + std::to_string(k) + "]: " + step() +
                      "leads on from a state that is listed as a dead end";
          } else {
            const Removals::Reward reward = removals.reward();
            if (!reward.finite) missing = step() + "has no finite reward";
            most = std::max(most, add_up(add_up(reward.most, found->second), -here));
          }
        }
        if (found != next.end()) reached_next.emplace(after, found->second);
        after.insert(c);
      });
      if (!missing.empty()) return missing;
    }
    bound = add_up(bound, most);
    reached = std::move(reached_next);
  }
  for (const auto& [present, value] : reached) {
    if (present.empty() && !(value >= 0))
      return "layers[" + std::to_string(connections) + "]: the end is worth 0 or more";
  }
  proved_ = bound;
  return {};
}

// Whether `connection` cannot be handled before all of `others`, of which it is one.
bool Checker::waits(ConnectionIndex connection, const ConnectionSet& others) const {
  const auto is_other = [&](ConnectionIndex c) { return others.contains(c); };
  return std::ranges::any_of(problem_.precedence(), [&](const PrecedenceClause& clause) {
    if (certificate_.first) {
      return clause.connection == connection &&
             (std::ranges::any_of(clause.after, is_other) ||
              (!clause.after_any.empty() && std::ranges::all_of(clause.after_any, is_other)));
    }
    if (clause.connection != connection) {
      return others.contains(clause.connection) &&
             std::ranges::find(clause.after, connection) != clause.after.end();
    }
    return !clause.made_after_any.empty() && std::ranges::all_of(clause.made_after_any, is_other);
  });
}

std::string Checker::fault_of_waits() {
  ConnectionSet others(problem_.num_connections());
  for (const ConnectionIndex c : certificate_.waiting) {
    if (c >= problem_.num_connections()) return "waiting: no such connection";
    others.insert(c);
  }
  if (others.empty()) return "waiting: nothing is listed";
  for (const ConnectionIndex c : certificate_.waiting) {
    ++inequalities_;
    if (!waits(c, others))
      return "waiting: " + detail::in_quotes(problem_.connection_id(c)) +
             " waits for no other that is listed";
  }
  proved_ = -kInfinity;
  return {};
}

// Two parts of one piece of the product are single at the end, so that some step moves one of them
// off the other, unless both are in pieces that hold base parts.
std::string Checker::fault_of_locked() {
  const auto [a, b] = certificate_.locked;
  if (a >= problem_.num_parts() || b >= problem_.num_parts() || a == b)
    return "parts: two parts are wanted";
  if (problem_.spec().base.size() > 1)
    return "parts: pieces that both hold base parts come apart without a motion";
  if (problem_.directions().empty()) return "parts: the problem has no blocking";
  for (const auto& [part, by] : {std::pair{a, b}, std::pair{b, a}}) {
    for (const DirectionIndex direction : problem_.directions()) {
      ++inequalities_;
      const bool blocked =
          std::ranges::any_of(problem_.blockers()[part], [&, by = by](const Blocker& blocker) {
            return blocker.by == by && problem_.blocks(blocker, direction.value());
          });
      if (!blocked)
        return "parts: " + detail::in_quotes(problem_.part_id(part)) + " can leave " +
               detail::in_quotes(problem_.part_id(by)) + " along " +
               problem_.direction_name(direction);
    }
  }
  // They hang together if adding a connection between them leaves as many pieces.
  std::vector<bool> reached(problem_.num_parts(), false);
  reached[a] = true;
  for (bool more = true; more;) {
    more = false;
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      const auto [one, other] = problem_.ends(c);
      if (reached[one] == reached[other]) continue;
      reached[one] = reached[other] = more = true;
    }
  }
  if (!reached[b]) return "parts: the two do not hang together";
  proved_ = -kInfinity;
  return {};
}

}  // namespace

std::string_view kind_name(Certificate::Kind kind) {
  switch (kind) {
    case Certificate::Kind::Sizes: return "sizes";
    case Certificate::Kind::Prices: return "prices";
    case Certificate::Kind::Places: return "places";
    case Certificate::Kind::Pieces: return "pieces";
    case Certificate::Kind::States: return "states";
    case Certificate::Kind::Waits: return "waits";
    case Certificate::Kind::Locked: break;
  }
  return "locked";
}

std::string without_certificates(const Problem& problem) {
  const ProblemSpec& spec = problem.spec();
  const std::string of = "certificates are for plans of one robot that take one connection a step";
  if (problem.objective().of_fleet()) return of + "; the objective is one of several robots";
  if (spec.action == StepKind::Part) return of + "; here steps take parts";
  if (spec.goal) return of + " until none is left; the problem has a goal";
  if (problem.uncertain() && !problem.only_retries())
    return of + " and try until they succeed; here an attempt that fails may do more";
  if (detail::CheckedReward(problem).looks_back())
    return of + " and earns the same whatever came before; the objective looks back";
  if (detail::CheckedReward(problem).needs_step())
    return "the objective is a function of the caller, of which a certificate proves nothing";
  return {};
}

CertificateCheck check_certificate(const Problem& problem, const Certificate& certificate) {
  return Checker(problem, certificate).run();
}

namespace {

/// Whether a certificate holds, and what its check says of that in a verdict.
bool holds(const Problem& problem, const Certificate& certificate, OptimalityCheck& verdict) {
  const CertificateCheck check = check_certificate(problem, certificate);
  verdict.bound = certificate.bound;
  verdict.inequalities = check.inequalities;
  if (!check.holds) verdict.fault = "the certificate does not hold: " + check.fault;
  return check.holds;
}

}  // namespace

OptimalityCheck check_optimality(const Problem& problem, std::span<const ConnectionIndex> plan,
                                 const Certificate& certificate) {
  OptimalityCheck verdict;
  const PlanCheck replay = check_plan(problem, Situation::whole(problem.num_connections()), plan);
  const detail::Earned earned = detail::earned_by(problem, replay, plan);
  verdict.reward = earned.reward;
  verdict.tolerance = earned.tolerance;
  if (!replay.legal) {
    verdict.fault = "the plan is not legal: " + replay.fault;
    return verdict;
  }
  if (!holds(problem, certificate, verdict)) return verdict;
  if (certificate.bound == -kInfinity) {
    verdict.fault = "the certificate says that there is no plan, and here is one";
  } else if (certificate.bound - verdict.reward > verdict.tolerance) {
    verdict.fault = "the plan earns " + detail::number_text(verdict.reward) +
                    ", and the certificate bounds plans by " +
                    detail::number_text(certificate.bound) + " only";
  } else {
    verdict.proved = true;
  }
  return verdict;
}

OptimalityCheck check_infeasibility(const Problem& problem, const Certificate& certificate) {
  OptimalityCheck verdict;
  if (!holds(problem, certificate, verdict)) return verdict;
  if (certificate.bound != -kInfinity) {
    verdict.fault = "the certificate bounds plans by " + detail::number_text(certificate.bound) +
                    ", and does not say that there is none";
  } else {
    verdict.proved = true;
  }
  return verdict;
}

}  // namespace orasp
