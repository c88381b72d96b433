#include "orasp/learning/graph_policy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/planners/depth_first_plan.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/task.h"

namespace orasp {

namespace {

constexpr std::size_t kHidden = GraphPolicy::kHidden;
constexpr std::size_t kRounds = GraphPolicy::kRounds;
constexpr std::size_t kPart = GraphState::kPartFeatures;
constexpr std::size_t kAction = GraphState::kActionFeatures;
/// What the head sees: sum and difference of two parts, the mean of all, the action's features.
constexpr std::size_t kHead = 3 * kHidden + kAction;

// Where each matrix begins among the weights; each is of shape [inputs, outputs].
constexpr std::size_t kEncode = 0;
constexpr std::size_t kEncodeBias = kEncode + kPart * kHidden;
constexpr std::size_t kRound = kEncodeBias + kHidden;
constexpr std::size_t kSquare = kHidden * kHidden;
constexpr std::size_t kRoundSize = 3 * kSquare + kHidden;  // own, connected, blocking, bias
constexpr std::size_t kHeadIn = kRound + kRounds * kRoundSize;
constexpr std::size_t kHeadBias = kHeadIn + kHead * kHidden;
constexpr std::size_t kHeadOut = kHeadBias + kHidden;
constexpr std::size_t kDirect = kHeadOut + kHidden;
constexpr std::size_t kWeights = kDirect + kAction;

/// out[row] += in[row] * matrix, for each of `rows` rows.
void add_product(const float* in, std::size_t rows, std::size_t inputs, const float* matrix,
                 float* out) {
  for (std::size_t r = 0; r < rows; ++r) {
    float* to = out + r * kHidden;
    for (std::size_t i = 0; i < inputs; ++i) {
      const float factor = in[r * inputs + i];
      if (factor == 0) continue;
      const float* row = matrix + i * kHidden;
      for (std::size_t o = 0; o < kHidden; ++o) to[o] += factor * row[o];
    }
  }
}

/// The derivatives of add_product: of the matrix, and, where `d_in` is not null, of the inputs.
void add_product_back(const float* in, std::size_t rows, std::size_t inputs, const float* matrix,
                      const float* d_out, float* d_matrix, float* d_in) {
  constexpr std::size_t kLanes = 8;
  for (std::size_t r = 0; r < rows; ++r) {
    const float* from = d_out + r * kHidden;
    for (std::size_t i = 0; i < inputs; ++i) {
      const float factor = in[r * inputs + i];
      float* d_row = d_matrix + i * kHidden;
      if (factor != 0) {
        for (std::size_t o = 0; o < kHidden; ++o) d_row[o] += factor * from[o];
      }
      if (d_in == nullptr) continue;
      const float* row = matrix + i * kHidden;
      std::array<float, kLanes> sums{};
      for (std::size_t o = 0; o < kHidden; o += kLanes) {
        for (std::size_t l = 0; l < kLanes; ++l) sums[l] += from[o + l] * row[o + l];
      }
      float sum = 0;
      for (const float part : sums) sum += part;
      d_in[r * inputs + i] += sum;
    }
  }
}

void rectify(std::vector<float>& numbers) {
  for (float& number : numbers) number = std::max(number, 0.0F);
}

/// out[p] = mean of in[q] over the neighbours q of p.
void mean_of_neighbours(const GraphState::Edges& edges, const std::vector<float>& in,
                        std::vector<float>& out) {
  out.assign(in.size(), 0.0F);
  for (std::size_t p = 0; p + 1 < edges.begin.size(); ++p) {
    const std::size_t many = edges.begin[p + 1] - edges.begin[p];
    if (many == 0) continue;
    float* to = out.data() + p * kHidden;
    for (std::size_t e = edges.begin[p]; e < edges.begin[p + 1]; ++e) {
      const float* from = in.data() + edges.to[e] * kHidden;
      for (std::size_t o = 0; o < kHidden; ++o) to[o] += from[o];
    }
    for (std::size_t o = 0; o < kHidden; ++o) to[o] /= static_cast<float>(many);
  }
}

void mean_back(const GraphState::Edges& edges, const std::vector<float>& d_out,
               std::vector<float>& d_in) {
  for (std::size_t p = 0; p + 1 < edges.begin.size(); ++p) {
    const std::size_t many = edges.begin[p + 1] - edges.begin[p];
    if (many == 0) continue;
    const float* from = d_out.data() + p * kHidden;
    const float share = 1.0F / static_cast<float>(many);
    for (std::size_t e = edges.begin[p]; e < edges.begin[p + 1]; ++e) {
      float* to = d_in.data() + edges.to[e] * kHidden;
      for (std::size_t o = 0; o < kHidden; ++o) to[o] += share * from[o];
    }
  }
}

}  // namespace

std::size_t GraphPolicy::num_weights() {
  return kWeights;
}

GraphPolicy GraphPolicy::untrained(std::uint64_t seed) {
  GraphPolicy policy;
  policy.weights.assign(kWeights, 0.0F);
  SplitMix64 random(seed);
  const auto fill = [&](std::size_t begin, std::size_t inputs) {
    const double spread = std::sqrt(3.0 / static_cast<double>(inputs));
    for (std::size_t i = 0; i < inputs * kHidden; ++i)
      policy.weights[begin + i] = static_cast<float>((2 * random.uniform() - 1) * spread);
  };
  fill(kEncode, kPart);
  for (std::size_t r = 0; r < kRounds; ++r) {
    for (std::size_t m = 0; m < 3; ++m) fill(kRound + r * kRoundSize + m * kSquare, 2 * kHidden);
  }
  fill(kHeadIn, kHead);
  policy.weights[kDirect] = 4.0F;  // the reward, relative to that of the best step
  return policy;
}

std::span<const float> GraphNetwork::worth(const GraphPolicy& policy, const GraphState& state) {
  const float* w = policy.weights.data();
  const std::size_t parts = state.num_parts();
  const std::size_t actions = state.num_actions();
  parts_.resize(kRounds + 1);
  near_.resize(kRounds);
  blocked_.resize(kRounds);
  const auto begin_with = [](const float* bias, std::size_t rows, std::vector<float>& out) {
    out.resize(rows * kHidden);
    for (std::size_t r = 0; r < rows; ++r) std::copy_n(bias, kHidden, out.data() + r * kHidden);
  };
  begin_with(w + kEncodeBias, parts, parts_[0]);
  add_product(state.parts.data(), parts, kPart, w + kEncode, parts_[0].data());
  rectify(parts_[0]);
  for (std::size_t r = 0; r < kRounds; ++r) {
    const float* own = w + kRound + r * kRoundSize;
    mean_of_neighbours(state.connected, parts_[r], near_[r]);
    mean_of_neighbours(state.blocking, parts_[r], blocked_[r]);
    begin_with(own + 3 * kSquare, parts, parts_[r + 1]);
    add_product(parts_[r].data(), parts, kHidden, own, parts_[r + 1].data());
    add_product(near_[r].data(), parts, kHidden, own + kSquare, parts_[r + 1].data());
    add_product(blocked_[r].data(), parts, kHidden, own + 2 * kSquare, parts_[r + 1].data());
    rectify(parts_[r + 1]);
  }
  const std::vector<float>& last = parts_[kRounds];
  mean_.assign(kHidden, 0.0F);
  for (std::size_t p = 0; p < parts; ++p) {
    for (std::size_t o = 0; o < kHidden; ++o) mean_[o] += last[p * kHidden + o];
  }
  for (float& number : mean_) number /= static_cast<float>(parts);
  head_in_.resize(actions * kHead);
  for (std::size_t i = 0; i < actions; ++i) {
    const float* a = last.data() + state.ends[i][0] * kHidden;
    const float* b = last.data() + state.ends[i][1] * kHidden;
    float* in = head_in_.data() + i * kHead;
    for (std::size_t o = 0; o < kHidden; ++o) {
      in[o] = a[o] + b[o];
      in[kHidden + o] = std::abs(a[o] - b[o]);
      in[2 * kHidden + o] = mean_[o];
    }
    std::copy_n(state.actions.data() + i * kAction, kAction, in + 3 * kHidden);
  }
  begin_with(w + kHeadBias, actions, head_);
  add_product(head_in_.data(), actions, kHead, w + kHeadIn, head_.data());
  rectify(head_);
  worth_.assign(actions, 0.0F);
  for (std::size_t i = 0; i < actions; ++i) {
    for (std::size_t o = 0; o < kHidden; ++o) worth_[i] += head_[i * kHidden + o] * w[kHeadOut + o];
    for (std::size_t f = 0; f < kAction; ++f)
      worth_[i] += state.actions[i * kAction + f] * w[kDirect + f];
  }
  return worth_;
}

void GraphNetwork::backward(const GraphPolicy& policy, const GraphState& state,
                            std::span<const float> slope, std::span<float> gradient) {
  const float* w = policy.weights.data();
  float* g = gradient.data();
  const std::size_t parts = state.num_parts();
  const std::size_t actions = state.num_actions();
  // The head.
  std::vector<float> d_head(actions * kHidden, 0.0F);
  for (std::size_t i = 0; i < actions; ++i) {
    for (std::size_t o = 0; o < kHidden; ++o) {
      const float out = head_[i * kHidden + o];
      g[kHeadOut + o] += slope[i] * out;
      if (out <= 0) continue;
      d_head[i * kHidden + o] = slope[i] * w[kHeadOut + o];
      g[kHeadBias + o] += d_head[i * kHidden + o];
    }
    for (std::size_t f = 0; f < kAction; ++f)
      g[kDirect + f] += slope[i] * state.actions[i * kAction + f];
  }
  d_in_.assign(actions * kHead, 0.0F);
  add_product_back(head_in_.data(), actions, kHead, w + kHeadIn, d_head.data(), g + kHeadIn,
                   d_in_.data());
  const std::vector<float>& last = parts_[kRounds];
  d_parts_.assign(parts * kHidden, 0.0F);
  std::array<float, kHidden> d_mean{};
  for (std::size_t i = 0; i < actions; ++i) {
    const std::size_t a = state.ends[i][0] * kHidden;
    const std::size_t b = state.ends[i][1] * kHidden;
    const float* d = d_in_.data() + i * kHead;
    for (std::size_t o = 0; o < kHidden; ++o) {
      const float sign = last[a + o] > last[b + o]   ? 1.0F
                         : last[a + o] < last[b + o] ? -1.0F
                                                     : 0.0F;
      d_parts_[a + o] += d[o] + sign * d[kHidden + o];
      d_parts_[b + o] += d[o] - sign * d[kHidden + o];
      d_mean[o] += d[2 * kHidden + o];
    }
  }
  for (std::size_t p = 0; p < parts; ++p) {
    for (std::size_t o = 0; o < kHidden; ++o)
      d_parts_[p * kHidden + o] += d_mean[o] / static_cast<float>(parts);
  }
  // The rounds, from the last to the first.
  std::vector<float> d_mean_of(parts * kHidden);
  for (std::size_t r = kRounds; r-- > 0;) {
    const std::size_t at = kRound + r * kRoundSize;
    for (std::size_t k = 0; k < parts * kHidden; ++k) {
      if (parts_[r + 1][k] <= 0) d_parts_[k] = 0;
      g[at + 3 * kSquare + k % kHidden] += d_parts_[k];
    }
    d_next_.assign(parts * kHidden, 0.0F);
    add_product_back(parts_[r].data(), parts, kHidden, w + at, d_parts_.data(), g + at,
                     d_next_.data());
    std::ranges::fill(d_mean_of, 0.0F);
    add_product_back(near_[r].data(), parts, kHidden, w + at + kSquare, d_parts_.data(),
                     g + at + kSquare, d_mean_of.data());
    mean_back(state.connected, d_mean_of, d_next_);
    if (!state.blocking.to.empty()) {
      std::ranges::fill(d_mean_of, 0.0F);
      add_product_back(blocked_[r].data(), parts, kHidden, w + at + 2 * kSquare, d_parts_.data(),
                       g + at + 2 * kSquare, d_mean_of.data());
      mean_back(state.blocking, d_mean_of, d_next_);
    }
    d_parts_.swap(d_next_);
  }
  for (std::size_t k = 0; k < parts * kHidden; ++k) {
    if (parts_[0][k] <= 0) d_parts_[k] = 0;
    g[kEncodeBias + k % kHidden] += d_parts_[k];
  }
  add_product_back(state.parts.data(), parts, kPart, w + kEncode, d_parts_.data(), g + kEncode,
                   nullptr);
}

std::optional<std::string> graph_policy_obstacle(const TransitionSystem& system) {
  if (system.wide()) return std::string(kPlainSteps);
  if (system.problem().uncertain())
    return "plans with a policy only where every attempt succeeds, and here one may fail";
  return std::nullopt;
}

Result follow_graph_policy(const TransitionSystem& system, const GraphPolicy& policy,
                           const Budget& budget) {
  if (const auto reason = graph_policy_obstacle(system)) throw Refusal("dqn", *reason);
  if (auto result = detail::infeasible_at_once(system, "dqn")) return *result;
  GraphObserver observer(system);
  GraphNetwork network;
  std::vector<std::pair<float, Action>> ranked;
  const auto best_first = [&](SetView open, std::span<Action> actions) {
    if (actions.empty()) return actions.size();
    const GraphState state = observer.observe(open, actions);
    const std::span<const float> worth = network.worth(policy, state);
    ranked.clear();
    for (std::size_t i = 0; i < actions.size(); ++i) ranked.emplace_back(worth[i], actions[i]);
    std::ranges::stable_sort(ranked,
                             [](const auto& a, const auto& b) { return a.first > b.first; });
    for (std::size_t i = 0; i < ranked.size(); ++i) actions[i] = ranked[i].second;
    return actions.size();
  };
  Result result = detail::depth_first_plan(system, budget, "dqn", best_first);
  if (result.status == Status::Feasible) detail::judge_by(detail::bound_of_start(system), result);
  return result;
}

}  // namespace orasp
