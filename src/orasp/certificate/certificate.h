#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/model/tolerance.h"

namespace orasp {

/// Why no plan of a problem earns more than a bound, or why there is none: evidence that whoever
/// doubts an answer can check without trusting whoever found it (docs/certificates.md).
struct Certificate {
  enum class Kind {
    Sizes,   ///< what the cuts of a piece of n parts gain at most
    Prices,  ///< what a cut gains at most that moves a part, beside Sizes
    Places,  ///< what a connection earns at most, and what a place in the order does
    Pieces,  ///< what the cuts of a piece of these very parts gain at most, beside Sizes
    States,  ///< what is still to be earned at most from each state that can be reached
    Waits,   ///< connections each of which waits for another of them: there is no plan
    Locked,  ///< two parts that nothing can part: there is no plan
  };
  struct State {
    ConnectionSet present{};  ///< in assembly too: the step looked at backwards removes one of them
    double value = -kInfinity;  ///< -infinity: nothing leads from here to the end
  };

  struct Piece {
    std::vector<PartIndex> parts{};  ///< ascending, two or more
    /// How many subassemblies it may be at a time; 0 where max_subassemblies is not stated. Never
    /// more than floor(log2(parts)), which is as much as any piece can make use of.
    std::size_t allowed = 0;
    double value = -kInfinity;  ///< -infinity: it cannot be taken apart
  };

  Kind kind = Kind::Sizes;
  double bound = -kInfinity;  ///< no plan earns more; -infinity: there is none
  /// Sizes, Prices and Pieces: by number of parts, from 0; -infinity where the limits allow no cut.
  std::vector<double> sizes{};
  /// Prices: by part, 0 or less; 0 of a base part.
  std::vector<double> prices{};
  /// Prices: groups of parts that are moved at once, whatever the plan, if one part of their piece
  /// is never moved.
  struct Together {
    PartIndex stays{};
    std::vector<std::vector<PartIndex>> groups{};  ///< of two or more, none of which is in another
  };
  std::vector<Together> together{};
  /// Places: by connection, and by how many are removed before.
  std::vector<double> connections{};
  std::vector<double> places{};
  /// Pieces: those that are worth less than their size.
  std::vector<Piece> pieces{};
  /// States: by number of connections removed, from 0.
  std::vector<std::vector<State>> layers{};
  /// Waits: ascending. `first`: none of them can be the first to be removed; else none can be the
  /// first to be made.
  std::vector<ConnectionIndex> waiting{};
  bool first = true;
  /// Locked.
  std::array<PartIndex, 2> locked{};
};

/// "sizes", "prices", "places", "pieces", "states", "waits", "locked".
[[nodiscard]] std::string_view kind_name(Certificate::Kind kind);

/// Why there are no certificates for such a problem, in one sentence; empty where there are.
[[nodiscard]] std::string without_certificates(const Problem& problem);

/// The most pieces that a certificate lists, and the most cuts that are looked at for it.
inline constexpr std::size_t kMostCertifiedPieces = 200'000;
inline constexpr std::uint64_t kMostCertifiedCuts = 40'000'000;

/// The most states that a certificate lists; fewer where there are so many connections that the
/// file would be too large to be read.
inline constexpr std::size_t kMostCertifiedStates = 1'000'000;

/// A certificate, or why there is none.
struct Certified {
  std::optional<Certificate> certificate{};
  std::string reason{};  ///< one sentence, where there is none
};

/// Looks for a certificate that no plan earns more than `reward` (nothing: that there is no plan),
/// up to `tolerance`.
/// Idea.      The cheapest first: sizes, for a plan; what waits for itself, locked parts and sizes,
///            where there is none; then prices; then places; then pieces, where at most so many
///            are needed; then all states, where there are at most `most_states`.
/// Guarantee. check_certificate() finds nothing wrong with what is returned; it is asked before.
/// Cost.      Sizes: O(parts^2). Places: O(connections^3). Pieces: exponential. States: their
///            number * connections * parts.
/// Stop.      `stop` is asked now and then; when it says true there is no certificate.
[[nodiscard]] Certified make_certificate(
    const Problem& problem, std::optional<double> reward, double tolerance,
    std::size_t most_states = kMostCertifiedStates,
    const std::function<bool()>& stop = [] { return false; });

/// The same for a plan, with the steps of the problem's direction: what it earns, and how far sums
/// of its rewards may be off, is what check_optimality() will compare with. Nothing: that there is
/// no plan. @throws InputError as check_plan().
[[nodiscard]] Certified certify(
    const Problem& problem, std::optional<std::span<const ConnectionIndex>> plan,
    const std::function<bool()>& stop = [] { return false; });

/// What the check of a certificate found.
struct CertificateCheck {
  bool holds = false;
  std::string fault{};             ///< one sentence, where it does not
  double bound = kInfinity;        ///< proved, rounded up; -infinity: there is no plan
  std::uint64_t inequalities = 0;  ///< that were verified
};

/// Checks a certificate.
/// Problem.   Whoever wrote it may be mistaken, or the file damaged.
/// Idea.      Its numbers are a potential: each step may earn no more than it takes from it, so a
///            plan earns no more than what is there at the start. Every inequality is verified from
///            the problem's own data, and what they prove is added up with every sum rounded up.
///            It holds if that is no more than the bound that it states.
/// Reference. Farkas' lemma and the dual of the longest path; McConnell, Mehlhorn, Naeher and
///            Schweitzer (2011), Certifying algorithms, Computer Science Review 5.
/// Guarantee. No line is shared with planners, their bounds or their graphs, and none with the
///            model's rules and rewards for planning (docs/certificates.md says what is shared).
///            A certificate with other numbers may hold, if what it says is still proved.
/// Cost.      As make_certificate().
/// Errors.    @throws InputError as check_plan().
[[nodiscard]] CertificateCheck check_certificate(const Problem& problem,
                                                 const Certificate& certificate);

/// The verdict on a plan and a certificate together, or on the claim that there is no plan.
struct OptimalityCheck {
  /// The plan is legal, and none earns more than it by more than `tolerance`; or there is none.
  bool proved = false;
  std::string fault{};  ///< one sentence, where it is not
  double reward = 0;
  double bound = kInfinity;
  double tolerance = 0;  ///< what sums of the plan's rewards may lose or gain, twice
  std::uint64_t inequalities = 0;
};

/// Replays a plan (check_plan()), checks a certificate, and compares. The steps are those of the
/// problem's direction. @throws InputError as check_plan().
[[nodiscard]] OptimalityCheck check_optimality(const Problem& problem,
                                               std::span<const ConnectionIndex> plan,
                                               const Certificate& certificate);

/// Checks a certificate that there is no plan; `reward` and `tolerance` stay 0.
[[nodiscard]] OptimalityCheck check_infeasibility(const Problem& problem,
                                                  const Certificate& certificate);

}  // namespace orasp
