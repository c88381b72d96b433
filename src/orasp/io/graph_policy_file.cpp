#include "orasp/io/graph_policy_file.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/io/detail/policy_bytes.h"
#include "orasp/io/objective_json.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kBegin = "{\"format\":\"orasp-graph-policy/1\"";

GraphPolicyFile from_header(const Json& header, std::string_view numbers) {
  GraphPolicyFile file;
  file.kind.objective = header.at("objective").get<std::string>();
  file.kind.direction = header.at("direction").get<std::string>();
  file.kind.keys = header.at("keys").get<std::set<std::string>>();
  if (!header.at("seed").is_number_unsigned())
    throw InputError("its seed is not a whole number of 0 or more");
  file.seed = header.at("seed").get<std::uint64_t>();
  const std::size_t size = GraphPolicy::num_weights();
  if (header.at("part_features") != GraphState::kPartFeatures ||
      header.at("action_features") != GraphState::kActionFeatures ||
      header.at("hidden") != GraphPolicy::kHidden || header.at("rounds") != GraphPolicy::kRounds ||
      numbers.size() != size * sizeof(float))
    throw InputError("its network is of another shape than this program's");
  file.policy.weights = detail::FloatReader(numbers).take(size);
  return file;
}

}  // namespace

ProblemKind kind_of(const Problem& problem) {
  ProblemKind kind;
  kind.objective = objective_text(problem.objective());
  kind.direction = problem.direction() == Direction::Assembly ? "assembly" : "disassembly";
  const auto note = [&](bool stated, const char* key) {
    if (stated) kind.keys.insert(key);
  };
  const Limits& limits = problem.limits();
  note(!problem.spec().base.empty(), "base");
  note(problem.spec().blocking.has_value(), "blocking");
  note(limits.max_subassemblies.has_value(), "max_subassemblies");
  note(limits.max_moved_parts.has_value(), "max_moved_parts");
  note(limits.max_moved_mass.has_value(), "max_moved_mass");
  note(limits.grounded, "grounded");
  note(!problem.precedence().empty(), "precedence");
  return kind;
}

ProblemKind kind_of_both(const ProblemKind& a, const ProblemKind& b) {
  if (a.objective != b.objective)
    throw InputError(
        "one policy is for one objective with its parameters, and the problems state several; "
        "--objective sets one for all");
  if (a.direction != b.direction)
    throw InputError(
        "one policy is for one direction, and the problems state both; --direction sets one for "
        "all");
  ProblemKind both = a;
  both.keys.insert(b.keys.begin(), b.keys.end());
  return both;
}

std::string graph_policy_bytes(const GraphPolicyFile& file) {
  const Json header = {{"format", "orasp-graph-policy/1"},
                       {"objective", file.kind.objective},
                       {"direction", file.kind.direction},
                       {"keys", file.kind.keys},
                       {"seed", file.seed},
                       {"part_features", GraphState::kPartFeatures},
                       {"action_features", GraphState::kActionFeatures},
                       {"hidden", GraphPolicy::kHidden},
                       {"rounds", GraphPolicy::kRounds}};
  std::string bytes = header.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
  detail::append_floats(bytes, file.policy.weights);
  return detail::sealed(std::move(bytes));
}

bool is_graph_policy(std::string_view bytes) {
  return bytes.starts_with(kBegin);
}

GraphPolicyFile parse_graph_policy(std::string_view bytes) {
  if (!is_graph_policy(bytes))
    throw InputError(
        "this is no policy of `orasp train --problems`: it does not begin with "
        "{\"format\":\"orasp-graph-policy/1\"");
  const auto [line, numbers] = detail::opened(bytes);
  try {
    return from_header(Json::parse(line), numbers);
  } catch (const Json::exception&) {  // whose own words repeat bytes of the file
    throw InputError("the policy's first line is not as it should be");
  } catch (const InputError& error) {
    throw InputError(std::string("the policy is not as it should be: ") + error.what());
  }
}

void require_kind(const Problem& problem, const ProblemKind& kind, std::string_view file) {
  const ProblemKind mine = kind_of(problem);
  if (mine.objective != kind.objective)
    throw InputError(fmt::format("{} was trained for the objective {}, and this problem has {}",
                                 file, kind.objective, mine.objective));
  if (mine.direction != kind.direction)
    throw InputError(
        fmt::format("{} was trained for {}, not for {}", file, kind.direction, mine.direction));
  for (const std::string& key : mine.keys) {
    if (!kind.keys.contains(key))
      throw InputError(
          fmt::format("{} was trained on problems without {}, and this problem has it", file, key));
  }
}

}  // namespace orasp
