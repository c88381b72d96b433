// Fuzz target: the bytes are a policy file, of a network or of states.
//
// Whatever they are, both readers accept them or refuse them in one sentence. The checksum of a
// network's file would keep nearly every change out, so it is also put right before reading. A
// network that is accepted is written and read back the same, and followed on a small problem it
// makes a legal plan. A policy of states that is accepted can be simulated.
#include "fuzz/property.h"
#include "orasp/io/digest.h"
#include "orasp/io/policy_file.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/io/state_policy_json.h"
#include "orasp/model/validate.h"

namespace orasp::fuzz {
namespace {

constexpr std::size_t kChecksumBytes = 64;

/// Three parts in a row whose first connection fails half of the time.
const Problem& worn_problem() {
  static const Problem kProblem = parse_problem(R"({"format": "orasp-problem/1", "name": "Worn",
    "parts": [{"id": "1"}, {"id": "2"}, {"id": "3"}],
    "connections": [{"parts": ["1", "2"], "success": 0.5,
                     "on_failure": {"breaks": ["2-3"]}}, {"parts": ["2", "3"]}]})");
  return kProblem;
}

void check_network(std::string_view bytes) {
  const std::optional<PolicyFile> file = accepted([&] { return parse_policy(bytes); });
  if (!file) return;
  const std::string written = policy_bytes(*file);
  const PolicyFile again = parse_policy(written);
  require(again.trained.policy == file->trained.policy, "writing a policy keeps its numbers");
  require(again.problem_digest == file->problem_digest, "writing a policy keeps its problem");
  require(policy_bytes(again) == written, "what was written is written the same again");
  static const Problem kProblem = load_scenario("4piece");
  const TransitionSystem system(kProblem);
  const std::optional<Result> result =
      accepted([&] { return follow_policy(system, file->trained.policy, {}); });
  if (result && result->has_plan()) {
    require(evaluate(kProblem, result->sequence).valid, "a policy makes a legal plan");
  }
}

void check_states(std::string_view text) {
  static const Problem& kProblem = worn_problem();
  static const TransitionSystem kSystem(kProblem);
  const auto states = accepted([&] { return parse_state_policy(kSystem, text); });
  if (!states) return;
  for (const PolicyState& state : *states) {
    require(state.next < kProblem.num_connections(), "a policy names connections of its problem");
    require(std::isfinite(state.reward), "a policy's rewards are finite");
  }
}

}  // namespace
}  // namespace orasp::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace orasp::fuzz;
  const std::string_view bytes = text_of(data, size);
  check_network(bytes);
  if (size >= kChecksumBytes) {
    std::string mended(bytes.substr(0, size - kChecksumBytes));
    mended += orasp::detail::sha256_hex(mended);
    check_network(mended);
  }
  check_states(bytes);
  return 0;
}
