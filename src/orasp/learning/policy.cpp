#include "orasp/learning/policy.h"

#include <algorithm>
#include <string>

#include "orasp/learning/detail/observed_columns.h"
#include "orasp/learning/piece_network.h"
#include "orasp/model/error.h"
#include "orasp/planners/depth_first_plan.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/task.h"

namespace orasp {

namespace {

/// out += factor * row. Compiled for several processors; the same numbers on each, since every
/// element is on its own and nothing is fused.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
__attribute__((target_clones("avx2", "default")))
#endif
void add_scaled(const float* row, float factor, float* out, std::size_t size) {
  for (std::size_t o = 0; o < size; ++o) {
    out[o] += factor * row[o];
  }
}

/// Leaves in `in` what the layers say of inputs that are 1 where `ones` says so, else 0; `out` is
/// scratch.
void run_layers(const std::vector<DenseLayer>& layers, SetView ones, std::vector<float>& in,
                std::vector<float>& out) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const DenseLayer& layer = layers[l];
    out = layer.bias;
    if (l == 0) {
      for_each_connection(ones, [&](ConnectionIndex i) {
        add_scaled(layer.weights.data() + i * layer.outputs, 1.0F, out.data(), layer.outputs);
      });
    } else {
      for (std::size_t i = 0; i < layer.inputs; ++i) {
        if (in[i] > 0)
          add_scaled(layer.weights.data() + i * layer.outputs, in[i], out.data(), layer.outputs);
      }
    }
    std::swap(in, out);
  }
}

}  // namespace

bool operator==(const DenseLayer& a, const DenseLayer& b) {
  return a.inputs == b.inputs && a.outputs == b.outputs && a.weights == b.weights &&
         a.bias == b.bias;
}

struct PolicyEvaluator::Pieces {
  explicit Pieces(const TransitionSystem& system) : observer(system) {}
  PieceObserver observer;
  PieceEvaluator evaluator;
  PieceSteps steps;
  std::vector<ConnectionIndex> connections;
};

PolicyEvaluator::PolicyEvaluator(const Policy& policy) : policy_(policy) {
  if (policy.pieces || policy.of_states)
    throw InputError("a policy that values pieces or states is asked together with its problem");
}

PolicyEvaluator::PolicyEvaluator(const Policy& policy, const TransitionSystem& system)
    : policy_(policy), pieces_(policy.pieces ? std::make_unique<Pieces>(system) : nullptr) {}

PolicyEvaluator::~PolicyEvaluator() = default;

std::span<const float> PolicyEvaluator::outputs(SetView open) {
  run_layers(policy_.layers, open, in_, out_);
  return in_;
}

void PolicyEvaluator::values(SetView open, std::span<const Action> actions,
                             std::span<double> values) {
  if (pieces_) {
    pieces_->connections.clear();
    for (const Action& action : actions) pieces_->connections.push_back(action.connection);
    pieces_->steps.clear();
    pieces_->observer.describe(open, pieces_->connections, pieces_->steps);
    const std::span<const float> numbers =
        pieces_->evaluator.numbers(*policy_.pieces, pieces_->steps);
    for (std::size_t i = 0; i < actions.size(); ++i) {
      values[i] = policy_.scale * static_cast<double>(numbers[i]) +
                  (policy_.adds_reward ? actions[i].reward : 0);
    }
    return;
  }
  const std::span<const float> out = outputs(open);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    values[i] = policy_.scale * static_cast<double>(out[actions[i].connection]) +
                (policy_.adds_reward ? actions[i].reward : 0);
  }
}

std::size_t PolicyEvaluator::choose(SetView open, std::span<const Action> actions) {
  values_.resize(actions.size());
  values(open, actions, values_);
  return static_cast<std::size_t>(std::ranges::max_element(values_) - values_.begin());
}

std::optional<std::string> policy_obstacle(const TransitionSystem& system, const Policy& policy) {
  if (policy.of_states != system.wide()) {
    return policy.of_states ? "was given a policy for problems with a goal, part steps or costs "
                              "between steps, and this one has none of these"
                            : "was given a policy for problems without a goal, part steps or costs "
                              "between steps, and this one has one of these";
  }
  if (policy.of_states) {
    const std::size_t columns = detail::ObservedColumns(system).size();
    if (policy.num_inputs() == columns) return std::nullopt;
    return "was given a policy that looks at " + std::to_string(policy.num_inputs()) +
           " columns of a state, and those of the problem have " + std::to_string(columns);
  }
  if (policy.num_connections() == system.num_connections()) return std::nullopt;
  return "was given a policy for " + std::to_string(policy.num_connections()) +
         " connections, and the problem has " + std::to_string(system.num_connections());
}

Result detail::follow_states(const TransitionSystem& system, const Policy& policy,
                             const Budget& budget) {
  if (const auto reason = policy_obstacle(system, policy)) throw Refusal("dqn", *reason);
  const ObservedColumns columns(system);
  std::vector<std::uint64_t> bits;
  std::vector<float> in;
  std::vector<float> out;
  return wide_plan_by(
      system, "dqn",
      [&](SetView state) {
        if (system.ends(state)) return 0.0;
        columns.collect(state, bits);
        run_layers(policy.layers, bits, in, out);
        return policy.scale * static_cast<double>(in.front());
      },
      budget);
}

Result follow_policy(const TransitionSystem& system, const Policy& policy,
                     const ConnectionSet& from, const ConnectionSet& forbidden,
                     const Budget& budget) {
  if (system.wide()) throw Refusal("dqn", std::string(kPlainSteps));
  if (const auto reason = policy_obstacle(system, policy)) throw Refusal("dqn", *reason);
  PolicyEvaluator evaluator(policy, system);
  std::vector<double> values;
  std::vector<std::pair<double, Action>> ranked;
  const auto best_first = [&](SetView open, std::span<Action> actions) {
    values.resize(actions.size());
    evaluator.values(open, actions, values);
    ranked.clear();
    for (std::size_t i = 0; i < actions.size(); ++i) {
      if (!forbidden.contains(actions[i].connection)) ranked.emplace_back(values[i], actions[i]);
    }
    std::ranges::stable_sort(ranked,
                             [](const auto& a, const auto& b) { return a.first > b.first; });
    for (std::size_t i = 0; i < ranked.size(); ++i) actions[i] = ranked[i].second;
    return ranked.size();
  };
  ConnectionSet to(system.num_connections());
  for_each_connection(forbidden.view(), [&](ConnectionIndex c) {
    if (from.contains(c)) to.insert(c);
  });
  return detail::depth_first_search(system, from, to, budget, "dqn", best_first);
}

Result follow_policy(const TransitionSystem& system, const Policy& policy, const Budget& budget) {
  if (auto result = detail::infeasible_at_once(system, "dqn")) return *result;
  Result result = system.wide() ? detail::follow_states(system, policy, budget)
                                : follow_policy(system, policy, system.start(),
                                                ConnectionSet(system.num_connections()), budget);
  if (result.status == Status::Feasible) detail::judge_by(detail::bound_of_start(system), result);
  return result;
}

}  // namespace orasp
