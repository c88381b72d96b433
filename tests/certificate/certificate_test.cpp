// Certificates against brute force on seeded random problems (tests/random_problems.h,
// tests/oracle.h): they are written where there is something to prove, they hold, and a damaged one
// holds only where what it says is still true.

#include "orasp/certificate/certificate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/io/certificate_json.h"
#include "orasp/io/formula_parser.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/random.h"
#include "tests/checks.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"
#include "tests/wide_oracle.h"
#include "tests/wide_problems.h"

namespace orasp {
namespace {

constexpr std::uint64_t kSeeds = 500;

/// Whether the claim of a certificate is true, by brute force.
bool true_claim(double bound, const oracle::OracleResult& truth) {
  return truth.feasible ? bound >= truth.best - reward_tolerance(truth.best) : true;
}

bool true_claim(double bound, const oracle::WideResult& truth) {
  return !truth.best || bound >= *truth.best - reward_tolerance(*truth.best);
}

struct Answer {
  Result result;
  Certified certified;
};

Answer answer(const Problem& problem) {
  Answer found;
  found.result = solve(problem, "auto");
  if (found.result.status == Status::Infeasible) {
    found.certified = make_certificate(problem, std::nullopt, 0);
  } else {
    const PlanCheck check =
        check_plan(problem, Situation::whole(problem.num_connections()), found.result.sequence);
    found.certified = make_certificate(problem, check.reward, 2 * check.tolerance);
  }
  return found;
}

/// The kinds are counted, so that the test is known to look at each of them.
TEST(CertificateTest, EveryAnswerToARandomProblemIsCertified) {
  std::map<std::pair<Certificate::Kind, Direction>, int> met;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    if (!without_certificates(problem).empty()) continue;
    const oracle::OracleResult truth = oracle::brute_force(spec);
    const Answer found = answer(problem);
    ASSERT_TRUE(found.certified.certificate) << found.certified.reason;
    const Certificate& certificate = *found.certified.certificate;
    ++met[{certificate.kind, problem.direction()}];
    EXPECT_TRUE(check_certificate(problem, certificate).holds);
    const Certificate read = parse_certificate(problem, certificate_text(problem, certificate));
    if (truth.feasible) {
      const OptimalityCheck check = check_optimality(problem, found.result.sequence, read);
      EXPECT_TRUE(check.proved) << check.fault;
      EXPECT_NEAR(read.bound, truth.best, reward_tolerance(truth.best));
    } else {
      const CertificateCheck check = check_certificate(problem, read);
      EXPECT_TRUE(check.holds) << check.fault;
      EXPECT_EQ(check.bound, -kInfinity);
    }
  }
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    EXPECT_GE((met[{Certificate::Kind::Sizes, direction}]), least_of(10));
    EXPECT_GE((met[{Certificate::Kind::Pieces, direction}]), least_of(1));
    // What the order tells takes places where these suffice, and else all states.
    EXPECT_GE((met[{Certificate::Kind::Places, direction}]), least_of(1));
    EXPECT_GE(
        (met[{Certificate::Kind::States, direction}] + met[{Certificate::Kind::Places, direction}]),
        least_of(50));
    EXPECT_GE((met[{Certificate::Kind::Waits, direction}]), least_of(10));
    EXPECT_GE((met[{Certificate::Kind::Locked, direction}]), least_of(1));
  }
}

/// The same with a base, grounded pieces, numbers of the user's own and precedence stated either
/// way (tests/wide_problems.h), by a second brute force.
TEST(CertificateTest, EveryAnswerToAWideProblemIsCertified) {
  int proved = 0;
  int infeasible = 0;
  int with_base = 0;
  int grounded = 0;
  int by_sizes = 0;
  for (std::uint64_t seed = 0; seed < some_of(3 * kSeeds); ++seed) {
    ProblemSpec spec = wide_random_problem(seed);
    spec.goal.reset();
    spec.action = StepKind::Connection;
    SCOPED_TRACE(spec.name);
    if (seed % 3 == 0)
      spec.objective = random_objective(
          std::vector<std::string>{"cubesat", "piece_cost", "completion", "fuel"}[seed / 3 % 4],
          seed);
    if (spec.objective.type == "callable") continue;
    const Problem problem(spec);
    if (!without_certificates(problem).empty()) continue;
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    const Answer found = answer(problem);
    ASSERT_TRUE(found.certified.certificate) << found.certified.reason;
    const Certificate& certificate = *found.certified.certificate;
    if (!spec.base.empty()) ++with_base;
    if (spec.limits.grounded) ++grounded;
    if (certificate.kind == Certificate::Kind::Sizes && !spec.base.empty()) ++by_sizes;
    if (truth.best) {
      ++proved;
      EXPECT_TRUE(check_optimality(problem, found.result.sequence, certificate).proved);
      EXPECT_NEAR(certificate.bound, *truth.best, reward_tolerance(*truth.best));
    } else {
      ++infeasible;
      EXPECT_EQ(certificate.bound, -kInfinity);
    }
    // The cheapest proof of anything, tight or not.
    const Certified any = make_certificate(problem, kInfinity, 0);
    ASSERT_TRUE(any.certificate) << any.reason;
    // What brute force adds up is rounded to nearest.
    if (truth.best) {
      EXPECT_GE(any.certificate->bound, *truth.best - 1e-12 * std::max(1.0, std::abs(*truth.best)));
    }
  }
  EXPECT_GE(proved, least_of(400));
  EXPECT_GE(infeasible, least_of(40));
  EXPECT_GE(with_base, least_of(100));
  EXPECT_GE(grounded, least_of(20));
  EXPECT_GE(by_sizes, least_of(20));
}

/// A bound by sizes is one whether it is reached or not, and so is a potential of states.
TEST(CertificateTest, WhatIsProvedIsNeverBelowTheBest) {
  int by_sizes = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    ProblemSpec spec = random_problem(seed);
    spec.objective =
        random_objective(std::vector<std::string>{"cubesat", "cubesat_zone", "custom", "piece_cost",
                                                  "completion", "fuel", "time"}[seed % 7],
                         seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    if (!without_certificates(problem).empty()) continue;
    const oracle::OracleResult truth = oracle::brute_force(spec);
    // Whatever is asked for is proved: the cheapest kind, with the bound that it has.
    const Certified certified = make_certificate(problem, kInfinity, 0);
    ASSERT_TRUE(certified.certificate) << certified.reason;
    if (certified.certificate->kind == Certificate::Kind::Sizes) ++by_sizes;
    EXPECT_TRUE(true_claim(certified.certificate->bound, truth))
        << certified.certificate->bound << " < " << truth.best;
  }
  EXPECT_GE(by_sizes, least_of(300));
}

/// Changes one thing in a certificate. Returns whether there was something to change.
bool damage(Certificate& certificate, SplitMix64& random) {
  const auto other = [&](double value) {
    const double by =
        (random.below(2) == 0 ? 1 : -1) * std::ldexp(1.0, -static_cast<int>(random.below(30)));
    return std::isfinite(value) ? value + by : by;
  };
  if (random.below(5) == 0) {
    certificate.bound = random.below(4) == 0 ? -kInfinity : other(certificate.bound);
    return true;
  }
  switch (certificate.kind) {
    case Certificate::Kind::Sizes: {
      if (certificate.sizes.empty()) return false;
      const std::size_t at = random.below(certificate.sizes.size());
      if (random.below(4) == 0) {
        certificate.sizes.erase(certificate.sizes.begin() + static_cast<std::ptrdiff_t>(at));
      } else {
        certificate.sizes[at] = random.below(4) == 0 ? -kInfinity : other(certificate.sizes[at]);
      }
      return true;
    }
    case Certificate::Kind::Prices: {
      const std::size_t at = random.below(certificate.prices.size());
      if (random.below(2) == 0) {
        // Any parts are said to leave together.
        const auto any = [&] {
          return static_cast<PartIndex>(random.below(certificate.prices.size()));
        };
        if (certificate.together.empty() || random.below(3) == 0)
          certificate.together.push_back({.stays = any()});
        auto& groups = certificate.together[random.below(certificate.together.size())].groups;
        if (groups.empty() || random.below(2) == 0) groups.push_back({any()});
        groups[random.below(groups.size())].push_back(any());
        return true;
      }
      if (random.below(4) == 0) {
        certificate.prices.erase(certificate.prices.begin() + static_cast<std::ptrdiff_t>(at));
      } else {
        certificate.prices[at] = other(certificate.prices[at]);
      }
      return true;
    }
    case Certificate::Kind::Places: {
      std::vector<double>& numbers =
          random.below(2) == 0 ? certificate.connections : certificate.places;
      const std::size_t at = random.below(numbers.size());
      if (random.below(4) == 0) {
        numbers.erase(numbers.begin() + static_cast<std::ptrdiff_t>(at));
      } else {
        numbers[at] = random.below(8) == 0 ? -kInfinity : other(numbers[at]);
      }
      return true;
    }
    case Certificate::Kind::Pieces: {
      if (certificate.pieces.empty()) return false;
      const std::size_t at = random.below(certificate.pieces.size());
      Certificate::Piece& piece = certificate.pieces[at];
      switch (random.below(4)) {
        case 0:
          certificate.pieces.erase(certificate.pieces.begin() + static_cast<std::ptrdiff_t>(at));
          break;
        case 1: piece.value = random.below(4) == 0 ? -kInfinity : other(piece.value); break;
        case 2: piece.parts.erase(piece.parts.begin()); break;
        default: piece.allowed += 1; break;
      }
      return true;
    }
    case Certificate::Kind::States: {
      auto& layer = certificate.layers[random.below(certificate.layers.size())];
      if (layer.empty()) return false;
      const std::size_t at = random.below(layer.size());
      if (random.below(4) == 0) {
        layer.erase(layer.begin() + static_cast<std::ptrdiff_t>(at));
      } else {
        layer[at].value = random.below(4) == 0 ? -kInfinity : other(layer[at].value);
      }
      return true;
    }
    case Certificate::Kind::Waits:
      certificate.waiting.erase(
          certificate.waiting.begin() +
          static_cast<std::ptrdiff_t>(random.below(certificate.waiting.size())));
      return true;
    case Certificate::Kind::Locked: break;
  }
  certificate.locked[1] = static_cast<PartIndex>((certificate.locked[1] + 1) % 3);
  return true;
}

/// A problem whose best plan is not told by the sizes of pieces: what may be cut off is limited by
/// blocking, by precedence and by how many subassemblies there may be.
ProblemSpec problem_of_pieces(std::uint64_t seed) {
  SplitMix64 random(seed ^ 0x70696563ULL);
  ProblemSpec spec;
  const std::size_t parts = 3 + static_cast<std::size_t>(random.below(4));
  for (std::size_t p = 0; p < parts; ++p) {
    spec.parts.push_back({.id = std::to_string(p)});
    if (p == 0) continue;
    spec.connections.push_back({.parts = {std::to_string(random.below(p)), std::to_string(p)}});
  }
  for (std::uint64_t more = random.below(3); more > 0 && spec.connections.size() < 8; --more) {
    const std::uint64_t a = random.below(parts);
    const std::uint64_t b = (a + 1 + random.below(parts - 1)) % parts;
    spec.connections.push_back(
        {.id = "more " + std::to_string(more), .parts = {std::to_string(a), std::to_string(b)}});
  }
  for (std::size_t c = 0; c < spec.connections.size(); ++c) {
    if (spec.connections[c].id.empty()) spec.connections[c].id = "c" + std::to_string(c);
  }
  const auto connection = [&] {
    return spec.connections[random.below(spec.connections.size())].id;
  };
  if (random.below(3) > 0) {
    Blocking blocking;
    for (const char* id : {"+x", "-x", "+y", "-y"})
      blocking.directions.emplace_back(std::string(id));
    for (std::uint64_t pairs = 1 + random.below(4); pairs > 0; --pairs) {
      const std::uint64_t a = random.below(parts);
      const std::uint64_t b = (a + 1 + random.below(parts - 1)) % parts;
      Blocked entry{.part = std::to_string(a), .by = std::to_string(b)};
      for (const char* id : {"+x", "-x", "+y", "-y"}) {
        if (random.below(3) > 0) entry.directions.emplace_back(id);
      }
      if (!entry.directions.empty()) blocking.blocked.push_back(entry);
    }
    spec.blocking = blocking;
  }
  if (random.below(3) == 0) {
    const std::string first = connection();
    const std::string then = connection();
    if (first != then) spec.precedence.push_back({.connection = then, .after = {first}});
  }
  if (random.below(2) == 0) spec.limits.max_subassemblies = 1 + random.below(2);
  if (random.below(4) == 0) spec.limits.max_moved_parts = 1 + random.below(2);
  if (random.below(4) == 0) spec.base = {spec.parts[random.below(parts)].id};
  if (!spec.base.empty() && random.below(2) == 0) spec.limits.grounded = true;
  if (random.below(6) == 0) spec.base = {"0", "1"};
  const std::vector<std::string> objectives = {"cubesat",    "cubesat_zone", "custom",
                                               "piece_cost", "completion",   "fuel"};
  spec.objective = random_objective(objectives[random.below(objectives.size())], seed);
  if (random.below(2) == 0) spec.direction = Direction::Assembly;
  spec.name = "pieces " + std::to_string(seed);
  return spec;
}

/// With so few states allowed that only what is smaller than a list of states proves anything.
Certified without_states(const Problem& problem, const oracle::WideResult& truth) {
  if (!truth.best) return make_certificate(problem, std::nullopt, 0, 0);
  return make_certificate(problem, *truth.best, 1e-9 * std::max(1.0, std::abs(*truth.best)), 0);
}

// By brute force, whatever the pieces say; and a certificate of pieces that is damaged in one thing
// holds only where what it says is still true.
TEST(CertificateTest, PiecesProveWhatSizesDoNot) {
  std::map<Direction, int> by_pieces;
  int infeasible = 0;
  int limited = 0;
  int refused = 0;
  int lower_by_a_bit = 0;
  for (std::uint64_t seed = 0; seed < some_of(4 * kSeeds); ++seed) {
    const ProblemSpec spec = problem_of_pieces(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    ASSERT_EQ(without_certificates(problem), "");
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    const Certified found = without_states(problem, truth);
    if (!found.certificate || found.certificate->kind != Certificate::Kind::Pieces) continue;
    ++by_pieces[problem.direction()];
    infeasible += truth.best ? 0 : 1;
    limited += problem.limits().max_subassemblies ? 1 : 0;
    EXPECT_TRUE(true_claim(found.certificate->bound, truth)) << found.certificate->bound;
    EXPECT_TRUE(
        check_certificate(problem,
                          parse_certificate(problem, certificate_text(problem, *found.certificate)))
            .holds);
    // What is a single bit less than the sum of what is below it is no bound: rounding to nearest
    // would let it pass.
    const Certificate& whole = *found.certificate;
    for (std::size_t at = 0; at <= whole.pieces.size(); ++at) {
      Certificate certificate = whole;
      double& value = at < whole.pieces.size() ? certificate.pieces[at].value : certificate.bound;
      if (!std::isfinite(value)) continue;
      value = std::nextafter(value, -kInfinity);
      const CertificateCheck check = check_certificate(problem, certificate);
      lower_by_a_bit += check.holds ? 0 : 1;
      if (at == whole.pieces.size()) {
        EXPECT_FALSE(check.holds);
      }
    }
    SplitMix64 random(seed);
    for (int i = 0; i < 8; ++i) {
      Certificate certificate = *found.certificate;
      if (!damage(certificate, random)) continue;
      const CertificateCheck check = check_certificate(problem, certificate);
      refused += check.holds ? 0 : 1;
      if (check.holds) {
        EXPECT_TRUE(true_claim(certificate.bound, truth)) << certificate_text(problem, certificate);
      } else {
        EXPECT_FALSE(check.fault.empty());
      }
    }
  }
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly})
    EXPECT_GE(by_pieces[direction], least_of(100));
  EXPECT_GE(limited, least_of(50));
  EXPECT_GE(infeasible, least_of(20));
  EXPECT_GE(refused, least_of(500));
  EXPECT_GE(lower_by_a_bit, least_of(200));
}

TEST(CertificateTest, ADamagedOneHoldsOnlyWhereItStillTellsTheTruth) {
  int refused = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    if (!without_certificates(problem).empty()) continue;
    const oracle::OracleResult truth = oracle::brute_force(spec);
    const Answer found = answer(problem);
    ASSERT_TRUE(found.certified.certificate) << found.certified.reason;
    SplitMix64 random(seed);
    for (int i = 0; i < 8; ++i) {
      Certificate certificate = *found.certified.certificate;
      if (!damage(certificate, random)) continue;
      const CertificateCheck check = check_certificate(problem, certificate);
      if (!check.holds) {
        EXPECT_FALSE(check.fault.empty());
        ++refused;
      } else {
        EXPECT_TRUE(true_claim(certificate.bound, truth))
            << certificate_text(problem, certificate) << " but " << truth.best;
        EXPECT_TRUE(true_claim(check.bound, truth));
      }
    }
  }
  EXPECT_GE(refused, least_of(1000));
}

/// What must hold of a certificate with a true claim, tight or not: as it is read back it holds, a
/// bit below the bound that it proves it does not, and a damaged one holds only where what it says
/// is true.
class Soundness {
 public:
  void look_at(const Problem& problem, const Certificate& given, const oracle::WideResult& truth,
               SplitMix64& random);
  /// Enough of them prove the best plan, in both directions, and enough damaged ones are refused.
  void expect_enough() {
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly})
      EXPECT_GE(tight_[direction], least_of(40));
    EXPECT_GE(refused_, least_of(500));
  }

 private:
  std::map<Direction, int> tight_;
  int refused_ = 0;
};

void Soundness::look_at(const Problem& problem, const Certificate& given,
                        const oracle::WideResult& truth, SplitMix64& random) {
  const Certificate certificate = parse_certificate(problem, certificate_text(problem, given));
  EXPECT_TRUE(check_certificate(problem, certificate).holds);
  if (truth.best && certificate.bound <= *truth.best + reward_tolerance(*truth.best)) {
    ++tight_[problem.direction()];
    EXPECT_TRUE(check_optimality(problem, answer(problem).result.sequence, certificate).proved);
  }
  Certificate lower = certificate;
  lower.bound = std::nextafter(lower.bound, -kInfinity);
  EXPECT_EQ(check_certificate(problem, lower).holds, !std::isfinite(certificate.bound));
  for (int i = 0; i < 6; ++i) {
    Certificate damaged = certificate;
    if (!damage(damaged, random)) continue;
    const CertificateCheck check = check_certificate(problem, damaged);
    refused_ += check.holds ? 0 : 1;
    if (check.holds) {
      EXPECT_TRUE(true_claim(damaged.bound, truth)) << certificate_text(problem, damaged);
    } else {
      EXPECT_FALSE(check.fault.empty());
    }
  }
}

/// Parts of different masses under `fuel`, alone and in a sum, with a base part or none.
TEST(CertificateTest, PricesProveWhatDifferentMassesTake) {
  Soundness soundness;
  int with_base = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    ProblemSpec spec = problem_of_pieces(seed);
    spec.direction = seed % 2 == 0 ? Direction::Disassembly : Direction::Assembly;
    SplitMix64 random(seed ^ 0x7072696365ULL);
    for (Part& part : spec.parts) part.mass = 0.5 + 0.25 * static_cast<double>(random.below(9));
    if (spec.base.empty() && seed % 3 == 0) spec.base = {spec.parts.back().id};
    if (spec.base.size() > 1) spec.base.resize(1);
    if (seed % 3 == 1) spec.blocking.reset();
    spec.objective = Objective::named("fuel");
    if (seed % 4 == 0)
      spec.objective = {"sum", WeightedSum{.terms = {{0.7, Objective::named("fuel")},
                                                     {1, Objective::named("completion")}}}};
    SCOPED_TRACE(seed);
    const Problem problem(spec);
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    // The cheapest proof of anything, tight or not.
    const Certified any = make_certificate(problem, kInfinity, 0);
    ASSERT_TRUE(any.certificate) << any.reason;
    EXPECT_TRUE(true_claim(any.certificate->bound, truth)) << any.certificate->bound;
    if (any.certificate->kind != Certificate::Kind::Prices) continue;
    with_base += spec.base.empty() ? 0 : 1;
    soundness.look_at(problem, *any.certificate, truth, random);
    if (HasFailure()) return;
  }
  soundness.expect_enough();
  EXPECT_GE(with_base, least_of(50));
}

/// Parts in each other's way, some of which leave together: what is moved twice is counted.
TEST(CertificateTest, PricesCountWhatLeavesTogether) {
  Soundness soundness;
  int tight = 0;
  int with_base = 0;
  for (std::uint64_t seed = 0; seed < some_of(10 * kSeeds); ++seed) {
    ProblemSpec spec = problem_of_pieces(seed);
    spec.direction = seed % 2 == 0 ? Direction::Disassembly : Direction::Assembly;
    spec.limits = {};
    SplitMix64 random(seed ^ 0x746f676574686572ULL);
    for (Part& part : spec.parts) part.mass = 0.5 + 0.25 * static_cast<double>(random.below(9));
    if (spec.base.empty() && seed % 3 == 0) spec.base = {spec.parts.back().id};
    if (spec.base.size() > 1) spec.base.resize(1);
    spec.blocking = Blocking{};
    spec.blocking->directions = {"+x", "-x", "+y", "-y"};
    if (seed % 4 == 0) spec.blocking->directions.resize(2);
    for (const Part& part : spec.parts) {
      for (const Part& by : spec.parts) {
        if (part.id == by.id || random.below(3) != 0) continue;
        const auto& direction =
            spec.blocking->directions[random.below(spec.blocking->directions.size())];
        spec.blocking->blocked.push_back({part.id, by.id, {direction.id}});
      }
    }
    spec.objective = Objective::named("fuel");
    if (seed % 4 == 1)
      spec.objective = {"sum", WeightedSum{.terms = {{0.7, Objective::named("fuel")},
                                                     {1, Objective::named("completion")}}}};
    SCOPED_TRACE(seed);
    const Problem problem(spec);
    const Certified plain = make_certificate(problem, kInfinity, 0);
    if (!plain.certificate || plain.certificate->kind != Certificate::Kind::Prices) continue;
    // Asked for less than prices alone prove, but by states, which know no more than there is.
    const Certified wanted = make_certificate(problem, plain.certificate->bound - 1e-6, 0);
    if (!wanted.certificate || wanted.certificate->together.empty()) continue;
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    EXPECT_TRUE(true_claim(wanted.certificate->bound, truth)) << wanted.certificate->bound;
    EXPECT_LT(wanted.certificate->bound, plain.certificate->bound);
    if (truth.best && *truth.best > wanted.certificate->bound - 1e-6) ++tight;
    with_base += spec.base.empty() ? 0 : 1;
    for (int i = 0; i < 10; ++i) soundness.look_at(problem, *wanted.certificate, truth, random);
    if (HasFailure()) return;
  }
  soundness.expect_enough();
  EXPECT_GE(tight, least_of(30));
  EXPECT_GE(with_base, least_of(5));
}

/// Objectives that the connection and its place tell, alone and in a sum, and some that see more.
TEST(CertificateTest, PlacesProveWhatTheOrderTells) {
  Soundness soundness;
  int others = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    ProblemSpec spec = problem_of_pieces(seed);
    spec.direction = seed % 2 == 0 ? Direction::Disassembly : Direction::Assembly;
    if (seed % 3 == 0) spec.blocking.reset();
    if (seed % 3 == 0) spec.limits = {};
    SplitMix64 random(seed ^ 0x706c616365ULL);
    for (Connection& connection : spec.connections) {
      connection.duration = static_cast<double>(random.below(5));
      connection.numbers["worth"] = random.uniform();
    }
    const auto formula = [](const char* text) {
      return Objective{"expression", Expression{.formula = text, .compiler = compile_formula}};
    };
    const bool sees_more = seed % 8 == 7;
    spec.objective = seed % 4 == 0   ? Objective::named("indexed")
                     : seed % 4 == 1 ? formula("-duration*before + worth*completes")
                     : sees_more     ? formula("-before*moved_mass")
                                     : formula("3*worth*after - index*before");
    if (seed % 5 == 0)
      spec.objective = {
          "sum", WeightedSum{.terms = {{-0.5, spec.objective}, {2, Objective::named("indexed")}}}};
    SCOPED_TRACE(seed);
    const Problem problem(spec);
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    // The cheapest proof of anything, tight or not.
    const Certified any = make_certificate(problem, kInfinity, 0);
    ASSERT_TRUE(any.certificate) << any.reason;
    EXPECT_TRUE(true_claim(any.certificate->bound, truth)) << any.certificate->bound;
    if (any.certificate->kind != Certificate::Kind::Places) {
      ++others;
      Certificate wrong = *any.certificate;
      wrong.kind = Certificate::Kind::Places;
      EXPECT_FALSE(check_certificate(problem, wrong).holds);
      continue;
    }
    EXPECT_FALSE(sees_more);
    soundness.look_at(problem, *any.certificate, truth, random);
    if (HasFailure()) return;
  }
  soundness.expect_enough();
  EXPECT_GE(others, least_of(20));
}

/// What the best plan earns from a state on, where each attempt is made again until it succeeds;
/// -infinity where none leads on. Brute force: `world` has every attempt succeed.
double best_of_attempts(const oracle::World& world, const std::vector<double>& success,
                        const oracle::State& open, std::map<oracle::State, double>& known) {
  if (const auto found = known.find(open); found != known.end()) return found->second;
  double best = std::ranges::find(open, true) == open.end() ? 0 : -kInfinity;
  for (const oracle::Facts& facts : world.legal_facts(open)) {
    oracle::State next = open;
    next[facts.connection] = false;
    best = std::max(best, facts.reward / success[facts.connection] +
                              best_of_attempts(world, success, next, known));
  }
  known[open] = best;
  return best;
}

/// Attempts that succeed with the same probability, or with one of each connection's own.
TEST(CertificateTest, PlansOfAttemptsMadeAgainUntilTheySucceedAreCertified) {
  std::map<Certificate::Kind, int> met;
  int refused = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    ProblemSpec spec = seed % 2 == 0 ? random_problem(seed) : problem_of_pieces(seed);
    if (seed % 4 == 0)
      spec.objective = random_objective(
          std::vector<std::string>{"cubesat", "completion", "piece_cost", "time"}[seed / 4 % 4],
          seed);
    SCOPED_TRACE(spec.name + " " + std::to_string(seed));
    // Of which this brute force knows nothing.
    spec.base.clear();
    spec.limits.grounded = false;
    const oracle::World world(spec);
    SplitMix64 random(seed);
    std::vector<double> success;
    for (Connection& connection : spec.connections) {
      connection.on_failure = {};
      connection.success =
          std::vector<double>{0.9, 0.3, 0.8, 1}[seed % 3 == 0 ? 0 : random.below(4)];
      success.push_back(connection.success);
    }
    const Problem problem(spec);
    if (!without_certificates(problem).empty()) continue;
    std::map<oracle::State, double> known;
    const double truth = world.start_infeasible()
                             ? -kInfinity
                             : best_of_attempts(world, success, world.start(), known);
    const auto is_true = [&](double bound) { return bound >= truth - reward_tolerance(truth); };
    const Result result = solve(problem, "auto");
    ASSERT_EQ(result.has_plan(), std::isfinite(truth));
    using Plan = std::optional<std::span<const ConnectionIndex>>;
    const Certified found =
        certify(problem, result.has_plan() ? Plan(result.sequence) : std::nullopt);
    ASSERT_TRUE(found.certificate) << found.reason;
    const Certificate certificate =
        parse_certificate(problem, certificate_text(problem, *found.certificate));
    ++met[certificate.kind];
    if (result.has_plan()) {
      const OptimalityCheck check = check_optimality(problem, result.sequence, certificate);
      EXPECT_TRUE(check.proved) << check.fault;
      EXPECT_NEAR(check.reward, truth, reward_tolerance(truth));
      EXPECT_NEAR(certificate.bound, truth, reward_tolerance(truth));
    } else {
      EXPECT_TRUE(check_infeasibility(problem, certificate).proved);
    }
    // The cheapest proof of anything, tight or not.
    const Certified any = make_certificate(problem, kInfinity, 0);
    ASSERT_TRUE(any.certificate) << any.reason;
    EXPECT_TRUE(is_true(any.certificate->bound)) << any.certificate->bound << " < " << truth;
    for (int i = 0; i < 4; ++i) {
      Certificate damaged = certificate;
      if (!damage(damaged, random)) continue;
      const CertificateCheck check = check_certificate(problem, damaged);
      refused += check.holds ? 0 : 1;
      if (check.holds) {
        EXPECT_TRUE(is_true(damaged.bound)) << certificate_text(problem, damaged);
      }
    }
    if (HasFailure()) return;
  }
  EXPECT_GE(met[Certificate::Kind::Sizes], least_of(50));
  EXPECT_GE(met[Certificate::Kind::Pieces], least_of(50));
  EXPECT_GE(met[Certificate::Kind::States], least_of(50));
  EXPECT_GE(refused, least_of(500));
}

// In decimals the three steps cost 0.1 each, 0.3 in all; in binary 0.1 + 0.1 + 0.1 is above 0.3. A
// sum that is not rounded up proves less than the sum of the very numbers that it adds.
TEST(CertificateTest, RoundingMakesNoProof) {
  ProblemSpec spec;
  spec.parts = {{.id = "1"}, {.id = "2"}, {.id = "3"}, {.id = "4"}};
  spec.connections = {{.parts = {"1", "2"}}, {.parts = {"2", "3"}}, {.parts = {"3", "4"}}};
  spec.objective = Objective("completion", CompletionObjective{.join = 0.1, .step = 0, .bonus = 0});
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    spec.direction = direction;
    const Problem problem(spec);
    const Certified found = make_certificate(problem, 0.3, 1e-9);
    ASSERT_TRUE(found.certificate) << found.reason;
    // 0.1 is above a tenth, so three of them are above the number 0.3, which is below three tenths.
    EXPECT_GT(found.certificate->bound, 0.3);
    EXPECT_LT(found.certificate->bound, 0.3 + 1e-14);
    Certificate certificate = *found.certificate;
    certificate.bound = 0.3;
    EXPECT_FALSE(check_certificate(problem, certificate).holds);
    // So does a bound that is lower by the last bit of what is proved.
    certificate.bound = std::nextafter(found.certificate->bound, 0.0);
    EXPECT_FALSE(check_certificate(problem, certificate).holds);
    // A table that is right up to rounding to nearest, and too low.
    certificate = *found.certificate;
    ASSERT_EQ(certificate.kind, Certificate::Kind::Sizes);
    certificate.sizes[4] = 0.3;
    EXPECT_FALSE(check_certificate(problem, certificate).holds);
  }
}

/// The large products, by sizes alone; a plan that is not legal is not proved.
TEST(CertificateTest, LargeScenariosAreProvedBySizes) {
  for (const std::string name : {"iss", "iss-upc", "jwst", "jwst-upc", "hubble"}) {
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      SCOPED_TRACE(name);
      const Problem problem = load_scenario(name).with_direction(direction);
      Budget budget = Budget::with_time_limit(60);
      Result result = solve(Task(problem), "auto", {}, budget);
      if (result.status != Status::Optimal) continue;
      const PlanCheck replay =
          check_plan(problem, Situation::whole(problem.num_connections()), result.sequence);
      const Certified found =
          make_certificate(problem, replay.reward, 2 * replay.tolerance, 20'000);
      ASSERT_TRUE(found.certificate) << found.reason;
      EXPECT_TRUE(check_optimality(problem, result.sequence, *found.certificate).proved);
      std::reverse(result.sequence.begin(), result.sequence.end());
      EXPECT_FALSE(check_optimality(problem, result.sequence, *found.certificate).proved);
    }
  }
}

}  // namespace
}  // namespace orasp
