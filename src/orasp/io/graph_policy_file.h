#pragma once

#include <set>
#include <string>
#include <string_view>

#include "orasp/learning/graph_policy.h"
#include "orasp/model/problem.h"

namespace orasp {

/// What problems a graph policy is for: those of one objective with its parameters, of one
/// direction, that state nothing but what a problem of its training stated.
struct ProblemKind {
  std::string objective;  ///< as a problem file writes it
  std::string direction;  ///< "disassembly" or "assembly"
  /// Of "base", "blocking", "max_subassemblies", "max_moved_parts", "max_moved_mass", "grounded",
  /// "precedence".
  std::set<std::string> keys;

  friend bool operator==(const ProblemKind&, const ProblemKind&) = default;
};

[[nodiscard]] ProblemKind kind_of(const Problem& problem);

/// The kind of problems of both. @throws InputError where objective or direction differ.
[[nodiscard]] ProblemKind kind_of_both(const ProblemKind& a, const ProblemKind& b);

/// What a graph policy file holds, format `orasp-graph-policy/1` (docs/format.md).
struct GraphPolicyFile {
  ProblemKind kind;
  std::uint64_t seed = 0;  ///< of its training
  GraphPolicy policy;
};

/// The bytes of the file: one line of JSON, the weights as float32, and a checksum of it all.
[[nodiscard]] std::string graph_policy_bytes(const GraphPolicyFile& file);

/// Whether the bytes begin as a graph policy does.
[[nodiscard]] bool is_graph_policy(std::string_view bytes);

/// @throws InputError for bytes that are no graph policy, damaged, cut off, or of another size.
[[nodiscard]] GraphPolicyFile parse_graph_policy(std::string_view bytes);

/// Refuses a problem of another kind than the policy's. `file` is what the sentence calls it.
/// @throws InputError.
void require_kind(const Problem& problem, const ProblemKind& kind, std::string_view file);

}  // namespace orasp
