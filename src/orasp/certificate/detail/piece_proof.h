#pragma once

#include <functional>
#include <string>
#include <vector>

#include "orasp/certificate/certificate.h"
#include "orasp/certificate/detail/size_rewards.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// The pieces that a certificate must list, beside a table of sizes, to prove that no plan earns
/// more than `wanted`.
/// Idea.      A piece loses what its cuts gain less than its size promises. A depth-first search
///            with a memory looks for the least loss of the pieces of the product, cuts that lose
///            least first, and no further than what is missing to the proof; what it has found of a
///            piece is what the certificate says of it.
/// Guarantee. None: whether what is listed proves anything is for check_certificate() to say.
/// Cost.      Exponential at worst: at most kMostCertifiedCuts sides are looked at, twice.
struct PieceProof {
  std::vector<Certificate::Piece> pieces{};
  /// One clause, where there is none.
  std::string reason{};
};
[[nodiscard]] PieceProof prove_by_pieces(const Problem& problem, const SizeRewards& rewards,
                                         const std::vector<double>& sizes, double wanted,
                                         const std::function<bool()>& stop);

}  // namespace orasp::detail
