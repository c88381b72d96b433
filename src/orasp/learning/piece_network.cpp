#include "orasp/learning/piece_network.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "orasp/learning/environment.h"
#include "orasp/learning/replay_buffer.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"

namespace orasp {

namespace {

constexpr std::size_t kFeatures = PiecePolicy::kFeatures;
constexpr std::size_t kOutputs = PiecePolicy::kOutputs;
constexpr std::uint32_t kNone = PieceSteps::kNone;

/// Where each layer's matrix begins among the weights, its shape, and what comes after the layers.
struct Layout {
  struct Layer {
    std::size_t begin;
    std::size_t inputs;
    std::size_t outputs;
    [[nodiscard]] std::size_t bias() const { return begin + inputs * outputs; }
    [[nodiscard]] std::size_t end() const { return bias() + outputs; }
  };
  std::vector<Layer> layers;
  std::size_t direct = 0;
  std::size_t step = 0;
  std::size_t end = 0;

  explicit Layout(const std::vector<std::size_t>& hidden) {
    std::size_t inputs = kFeatures;
    std::size_t begin = 0;
    const auto add = [&](std::size_t outputs) {
      layers.push_back({begin, inputs, outputs});
      begin = layers.back().end();
      inputs = outputs;
    };
    for (const std::size_t units : hidden) add(units);
    add(kOutputs);
    direct = begin;
    step = direct + kFeatures * kOutputs;
    end = step + PiecePolicy::kStep;
  }
};

/// out[row] += in[row] * matrix, for each of `rows` rows. The same numbers on every processor:
/// every element is on its own and nothing is fused.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
__attribute__((target_clones("avx2", "default")))
#endif
void add_product(const float* in, std::size_t rows, std::size_t inputs, std::size_t outputs,
                 const float* matrix, float* out) {
  for (std::size_t r = 0; r < rows; ++r) {
    float* to = out + r * outputs;
    for (std::size_t i = 0; i < inputs; ++i) {
      const float factor = in[r * inputs + i];
      if (factor == 0) continue;
      const float* row = matrix + i * outputs;
      for (std::size_t o = 0; o < outputs; ++o) to[o] += factor * row[o];
    }
  }
}

/// The derivatives of add_product: of the matrix, and, where `d_in` is not null, of the inputs.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
__attribute__((target_clones("avx2", "default")))
#endif
void add_product_back(const float* in, std::size_t rows, std::size_t inputs, std::size_t outputs,
                      const float* matrix, const float* d_out, float* d_matrix, float* d_in) {
  for (std::size_t r = 0; r < rows; ++r) {
    const float* from = d_out + r * outputs;
    for (std::size_t i = 0; i < inputs; ++i) {
      const float factor = in[r * inputs + i];
      float* d_row = d_matrix + i * outputs;
      if (factor != 0) {
        for (std::size_t o = 0; o < outputs; ++o) d_row[o] += factor * from[o];
      }
      if (d_in == nullptr || factor <= 0) continue;  // what was cut to 0 passes nothing on
      const float* row = matrix + i * outputs;
      float sum = 0;
      for (std::size_t o = 0; o < outputs; ++o) sum += from[o] * row[o];
      d_in[r * inputs + i] += sum;
    }
  }
}

/// Solves (matrix + ridge) * x = right by Cholesky's factors; matrix is symmetric, of shape [n, n],
/// and is overwritten.
std::vector<double> solved(std::vector<double> matrix, std::vector<double> right, double ridge) {
  const std::size_t n = right.size();
  for (std::size_t i = 0; i < n; ++i) matrix[i * n + i] += ridge;
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t k = 0; k < j; ++k) {
      for (std::size_t i = j; i < n; ++i)
        matrix[i * n + j] -= matrix[i * n + k] * matrix[j * n + k];
    }
    const double pivot = std::sqrt(matrix[j * n + j]);
    for (std::size_t i = j; i < n; ++i) matrix[i * n + j] /= pivot;
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) right[i] -= matrix[i * n + k] * right[k];
    right[i] /= matrix[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) right[i] -= matrix[k * n + i] * right[k];
    right[i] /= matrix[i * n + i];
  }
  return right;
}

}  // namespace

std::size_t PiecePolicy::num_weights(const std::vector<std::size_t>& hidden) {
  return Layout(hidden).end;
}

// -------------------------------------------------------------------------------------------------
// What is seen

void PieceSteps::clear() {
  rows.clear();
  steps.clear();
  begin.assign(1, 0);
  pieces.clear();
  keys_.clear();
  std::ranges::fill(slots_, kNone);
}

std::size_t PieceSteps::slot_of(const Key& key) const {
  std::uint64_t hash = 0;
  for (const std::uint64_t word : key) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 32U;
  }
  std::size_t slot = hash & (slots_.size() - 1);
  while (slots_[slot] != kNone && keys_[slots_[slot]] != key)
    slot = (slot + 1) & (slots_.size() - 1);
  return slot;
}

std::pair<std::uint32_t, bool> PieceSteps::row(const Key& key) {
  if (slots_.size() < 2 * (keys_.size() + 1)) {
    slots_.assign(std::max<std::size_t>(1024, 2 * slots_.size()), kNone);
    for (std::size_t r = 0; r < keys_.size(); ++r)
      slots_[slot_of(keys_[r])] = static_cast<std::uint32_t>(r);
  }
  std::uint32_t& held = slots_[slot_of(key)];
  if (held != kNone) return {held, false};
  held = static_cast<std::uint32_t>(keys_.size());
  keys_.push_back(key);
  return {held, true};
}

void PieceObserver::Sums::add(const Sums& other, double times) {
  parts += times * other.parts;
  degree += times * other.degree;
  squares += times * other.squares;
  leaves += times * other.leaves;
  mass += times * other.mass;
  base += times * other.base;
}

PieceObserver::PieceObserver(const TransitionSystem& system)
    : system_(system), connectivity_(system.rules().graph, true) {
  for (const Part& part : system.problem().parts()) total_mass_ += part.mass;
}

PieceObserver::Sums PieceObserver::of(const detail::Side& side) const {
  const PartIndex* const first = connectivity_.walked().data();
  Sums sums;
  for (const std::span<const PartIndex> run : side.runs) {
    if (run.empty()) continue;
    const auto begin = static_cast<std::size_t>(run.data() - first);
    sums.add(before_[begin + run.size()]);
    sums.add(before_[begin], -1);
  }
  return sums;
}

void PieceObserver::change_degree(Sums& sums, PartIndex part, double by) const {
  const double degree = degrees_[part];
  sums.degree += by;
  sums.squares += by * (2 * degree + by);
  sums.leaves += (degree + by == 1 ? 1 : 0) - (degree == 1 ? 1 : 0);
}

std::array<float, kFeatures> PieceObserver::features(const Sums& sums) const {
  const Problem& problem = system_.problem();
  const double parts = sums.parts;
  const double connections = sums.degree / 2;
  const double cycles = connections - parts + 1;
  const auto one_if = [](bool holds) { return holds ? 1.0 : 0.0; };
  const std::array<double, kFeatures> all = {
      1,
      parts / static_cast<double>(problem.num_parts()),
      connections / static_cast<double>(problem.num_connections()),
      0.25 * std::log2(parts),
      0.25 * std::log2(1 + connections),
      0.25 * std::log2(1 + std::max(cycles, 0.0)),
      one_if(parts == 1),
      one_if(parts == 2),
      one_if(parts == 3),
      one_if(parts == 4),
      one_if(parts == 5),
      one_if(parts == 6),
      sums.leaves / parts,
      parts > 1 ? sums.squares / (parts * (parts - 1)) : 0,
      one_if(parts > 2 && connections == parts - 1 && sums.squares == parts * (parts - 1)),
      one_if(cycles <= 0),
      one_if(cycles == 1),
      total_mass_ > 0 ? sums.mass / total_mass_ : 0,
      total_mass_ > 0 ? std::min(4.0, sums.mass / parts * static_cast<double>(problem.num_parts()) /
                                          total_mass_)
                      : 0,
      one_if(sums.base > 0)};
  std::array<float, kFeatures> rounded{};
  for (std::size_t f = 0; f < kFeatures; ++f) rounded[f] = static_cast<float>(all[f]);
  return rounded;
}

std::uint32_t PieceObserver::row_of(const Sums& sums, PieceSteps& steps) const {
  const auto whole = [](double number) { return static_cast<std::uint64_t>(number); };
  const auto [row, is_new] = steps.row(
      {whole(sums.parts) << 32U | whole(sums.degree), whole(sums.leaves) << 32U | whole(sums.base),
       whole(sums.squares), std::bit_cast<std::uint64_t>(sums.mass)});
  if (is_new) {
    const auto all = features(sums);
    steps.rows.insert(steps.rows.end(), all.begin(), all.end());
  }
  return row;
}

void PieceObserver::describe(SetView open, std::span<const ConnectionIndex> connections,
                             PieceSteps& steps) {
  const Problem& problem = system_.problem();
  const ConnectionSet present = system_.present(open);
  connectivity_.analyse(present.view(), true);
  degrees_.assign(problem.num_parts(), 0);
  for_each_connection(present.view(), [&](ConnectionIndex c) {
    const auto& [a, b] = problem.ends(c);
    if (a == b) return;
    ++degrees_[a];
    ++degrees_[b];
  });
  const std::span<const PartIndex> walked = connectivity_.walked();
  before_.resize(walked.size() + 1);
  before_[0] = {};
  for (std::size_t i = 0; i < walked.size(); ++i) {
    const PartIndex part = walked[i];
    const double degree = degrees_[part];
    before_[i + 1] = before_[i];
    before_[i + 1].add({.parts = 1,
                        .degree = degree,
                        .squares = degree * degree,
                        .leaves = degree == 1 ? 1.0 : 0.0,
                        .mass = problem.parts()[part].mass,
                        .base = problem.in_base(part) ? 1.0 : 0.0});
  }
  const auto state = static_cast<std::uint32_t>(steps.begin.size() - 1);
  for (std::size_t i = 0; i < walked.size();) {
    const detail::Side piece = connectivity_.piece_of(walked[i]);
    if (piece.parts() > 1) steps.pieces.push_back(row_of(of(piece), steps));
    i += piece.parts();
  }
  steps.begin.push_back(static_cast<std::uint32_t>(steps.pieces.size()));

  const std::size_t num_open = count(open);
  const auto row_if_piece = [&](const Sums& sums) {
    return sums.parts > 1 ? row_of(sums, steps) : kNone;
  };
  for (const ConnectionIndex c : connections) {
    PieceSteps::Step step;
    step.state = state;
    step.last = num_open == 1;
    const auto& [a, b] = problem.ends(c);
    if (a == b) {  // holds nothing together
      steps.steps.push_back(step);
      continue;
    }
    if (system_.takes_apart()) {
      const Sums whole = of(connectivity_.piece_of(a));
      step.before[0] = row_of(whole, steps);
      if (connectivity_.below(c) == 0) {
        Sums after = whole;
        change_degree(after, a, -1);
        change_degree(after, b, -1);
        step.after[0] = row_of(after, steps);
      } else {
        Sums lower = of(connectivity_.lower_side(c));
        Sums upper = of(connectivity_.upper_side(c));
        const bool a_below = connectivity_.lower_end(c) == a;
        change_degree(lower, a_below ? a : b, -1);
        change_degree(upper, a_below ? b : a, -1);
        step.sides = {row_of(lower, steps), row_of(upper, steps)};
        step.after = {row_if_piece(lower), row_if_piece(upper)};
      }
    } else {
      Sums joined = of(connectivity_.piece_of(a));
      step.before[0] = row_if_piece(joined);
      if (!connectivity_.same_piece(a, b)) {
        const Sums other = of(connectivity_.piece_of(b));
        step.before[1] = row_if_piece(other);
        step.sides = {row_of(joined, steps), row_of(other, steps)};
        joined.add(other);
      }
      change_degree(joined, a, 1);
      change_degree(joined, b, 1);
      step.after[0] = row_of(joined, steps);
    }
    steps.steps.push_back(step);
  }
}

// -------------------------------------------------------------------------------------------------
// The network

std::span<const float> PieceEvaluator::numbers(const PiecePolicy& policy, const PieceSteps& steps) {
  const float* const w = policy.weights.data();
  const Layout layout(policy.hidden);
  const std::size_t rows = steps.num_rows();
  layers_.resize(layout.layers.size());
  for (std::size_t l = 0; l < layout.layers.size(); ++l) {
    const Layout::Layer& layer = layout.layers[l];
    std::vector<float>& out = layers_[l];
    out.resize(rows * layer.outputs);
    for (std::size_t r = 0; r < rows; ++r)
      std::copy_n(w + layer.bias(), layer.outputs, out.data() + r * layer.outputs);
    add_product(l == 0 ? steps.rows.data() : layers_[l - 1].data(), rows, layer.inputs,
                layer.outputs, w + layer.begin, out.data());
    if (l + 1 < layout.layers.size()) {
      for (float& number : out) number = std::max(number, 0.0F);
    }
  }
  std::vector<float>& out = layers_.back();
  add_product(steps.rows.data(), rows, kFeatures, kOutputs, w + layout.direct, out.data());

  of_states_.assign(steps.begin.size() - 1, 0.0F);
  for (std::size_t s = 0; s < of_states_.size(); ++s) {
    for (std::size_t i = steps.begin[s]; i < steps.begin[s + 1]; ++i)
      of_states_[s] += out[steps.pieces[i] * kOutputs];
  }
  numbers_.resize(steps.steps.size());
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    const PieceSteps::Step& step = steps.steps[i];
    float number = 0;
    if (!step.last) {
      number = of_states_[step.state];
      for (const std::uint32_t row : step.before) {
        if (row != kNone) number -= out[row * kOutputs];
      }
      for (const std::uint32_t row : step.after) {
        if (row != kNone) number += out[row * kOutputs];
      }
      number += w[layout.step];
    }
    if (policy.of_rewards) {
      if (step.last) number += w[layout.step + 1];
      if (step.sides[0] != kNone) {
        number += w[layout.step + 2];
        for (const std::uint32_t row : step.sides) number += out[row * kOutputs + 1];
      }
    }
    numbers_[i] = number;
  }
  return numbers_;
}

void PieceEvaluator::backward(const PiecePolicy& policy, const PieceSteps& steps,
                              std::span<const float> slope, std::span<float> gradient) {
  const float* const w = policy.weights.data();
  const Layout layout(policy.hidden);
  const std::size_t rows = steps.num_rows();
  d_out_.assign(rows * kOutputs, 0.0F);
  std::vector<float> of_states(steps.begin.size() - 1, 0.0F);
  for (std::size_t i = 0; i < steps.steps.size(); ++i) {
    const PieceSteps::Step& step = steps.steps[i];
    const float one = slope[i];
    if (!step.last) {
      of_states[step.state] += one;
      for (const std::uint32_t row : step.before) {
        if (row != kNone) d_out_[row * kOutputs] -= one;
      }
      for (const std::uint32_t row : step.after) {
        if (row != kNone) d_out_[row * kOutputs] += one;
      }
      gradient[layout.step] += one;
    }
    if (policy.of_rewards) {
      if (step.last) gradient[layout.step + 1] += one;
      if (step.sides[0] != kNone) {
        gradient[layout.step + 2] += one;
        for (const std::uint32_t row : step.sides) d_out_[row * kOutputs + 1] += one;
      }
    }
  }
  for (std::size_t s = 0; s < of_states.size(); ++s) {
    for (std::size_t i = steps.begin[s]; i < steps.begin[s + 1]; ++i)
      d_out_[steps.pieces[i] * kOutputs] += of_states[s];
  }
  add_product_back(steps.rows.data(), rows, kFeatures, kOutputs, w + layout.direct, d_out_.data(),
                   gradient.data() + layout.direct, nullptr);
  for (std::size_t l = layout.layers.size(); l-- > 0;) {
    const Layout::Layer& layer = layout.layers[l];
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t o = 0; o < layer.outputs; ++o)
        gradient[layer.bias() + o] += d_out_[r * layer.outputs + o];
    }
    d_next_.assign(l == 0 ? 0 : rows * layer.inputs, 0.0F);
    add_product_back(l == 0 ? steps.rows.data() : layers_[l - 1].data(), rows, layer.inputs,
                     layer.outputs, w + layer.begin, d_out_.data(), gradient.data() + layer.begin,
                     l == 0 ? nullptr : d_next_.data());
    d_out_.swap(d_next_);
  }
}

// -------------------------------------------------------------------------------------------------
// Training

PieceNetwork::PieceNetwork(const TransitionSystem& system, const NetworkOptions& options,
                           bool knows_rewards)
    : options_(options),
      observer_(system),
      online_{.connections = options.connections,
              .hidden = options.hidden,
              .of_rewards = !knows_rewards,
              .weights = std::vector<float>(PiecePolicy::num_weights(options.hidden), 0.0F)},
      adam_(online_.weights.size()),
      open_(words_for(options.connections)),
      gradient_(online_.weights.size()) {
  SplitMix64 random(options.seed);
  const Layout layout(options.hidden);
  for (std::size_t l = 0; l + 1 < layout.layers.size(); ++l) {  // the outputs begin at 0
    const Layout::Layer& layer = layout.layers[l];
    const double spread = std::sqrt(6.0 / static_cast<double>(layer.inputs));
    for (std::size_t i = layer.begin; i < layer.bias(); ++i)
      online_.weights[i] = static_cast<float>((2 * random.uniform() - 1) * spread);
  }
  target_ = online_;
}

void PieceNetwork::fit(const ReplayBuffer& replay, double scale) {
  constexpr std::size_t kRest = kFeatures + 1;    // the pieces after a step; whether work is left
  constexpr std::size_t kReward = kFeatures + 2;  // the two sides; the last step; a separation
  std::vector<double> of_rest(kRest * kRest);
  std::vector<double> right_of_rest(kRest);
  std::vector<double> of_reward(kReward * kReward);
  std::vector<double> right_of_reward(kReward);
  const auto note = [](const std::vector<double>& x, double y, std::vector<double>& matrix,
                       std::vector<double>& right) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (x[i] == 0) continue;
      for (std::size_t j = 0; j < x.size(); ++j) matrix[i * x.size() + j] += x[i] * x[j];
      right[i] += x[i] * y;
    }
  };
  double counted = 0;
  for (std::size_t place = 0; place < replay.size(); ++place) {
    const ReplayBuffer::Step& taken = replay.step(place);
    if (taken.dead_end) continue;
    steps_.clear();
    const ConnectionIndex connection = taken.connection;
    observer_.describe(replay.open(place), std::span(&connection, 1), steps_);
    const PieceSteps::Step& step = steps_.steps.front();
    const auto add = [&](std::uint32_t row, double times, std::vector<double>& x) {
      for (std::size_t f = 0; row != kNone && f < kFeatures; ++f)
        x[f] += times * static_cast<double>(steps_.rows[row * kFeatures + f]);
    };
    counted += 1;
    std::vector<double> sides(kReward);
    for (const std::uint32_t row : step.sides) add(row, 1, sides);
    sides[kFeatures] = step.last ? 1 : 0;
    sides[kFeatures + 1] = step.sides[0] != kNone ? 1 : 0;
    note(sides, taken.reward / scale, of_reward, right_of_reward);
    if (step.last) continue;
    std::vector<double> after(kRest);
    for (const std::uint32_t row : steps_.pieces) add(row, 1, after);
    for (const std::uint32_t row : step.before) add(row, -1, after);
    for (const std::uint32_t row : step.after) add(row, 1, after);
    after[kFeatures] = 1;
    note(after, (taken.rest - taken.reward) / scale, of_rest, right_of_rest);
  }
  const double ridge = 1e-4 * counted + 1e-9;
  const Layout layout(options_.hidden);
  const std::vector<double> rest = solved(of_rest, right_of_rest, ridge);
  for (std::size_t f = 0; f < kFeatures; ++f)
    online_.weights[layout.direct + f * kOutputs] = static_cast<float>(rest[f]);
  online_.weights[layout.step] = static_cast<float>(rest[kFeatures]);
  if (online_.of_rewards) {
    const std::vector<double> reward = solved(of_reward, right_of_reward, ridge);
    for (std::size_t f = 0; f < kFeatures; ++f)
      online_.weights[layout.direct + f * kOutputs + 1] = static_cast<float>(reward[f]);
    online_.weights[layout.step + 1] = static_cast<float>(reward[kFeatures]);
    online_.weights[layout.step + 2] = static_cast<float>(reward[kFeatures + 1]);
  }
  target_ = online_;
}

void PieceNetwork::read(std::span<const float> row) {
  std::ranges::fill(open_, 0);
  connections_.clear();
  for (std::size_t c = 0; c < row.size(); ++c) {
    if (row[c] == 0) continue;
    open_[c / 64] |= std::uint64_t{1} << (c % 64);
    connections_.push_back(static_cast<ConnectionIndex>(c));
  }
}

void PieceNetwork::ask(const PiecePolicy& policy, std::span<const float> states,
                       std::span<float> values) {
  const std::size_t n = options_.connections;
  const std::size_t batch = states.size() / n;
  if (!std::ranges::equal(states, asked_)) {
    asked_.assign(states.begin(), states.end());
    asked_steps_.clear();
    for (std::size_t b = 0; b < batch; ++b) {
      read(states.subspan(b * n, n));
      observer_.describe(open_, connections_, asked_steps_);
    }
  }
  const std::span<const float> numbers = evaluator_.numbers(policy, asked_steps_);
  std::ranges::fill(values, 0.0F);
  std::size_t next = 0;
  for (std::size_t i = 0; i < batch * n; ++i) {
    if (states[i] != 0) values[i] = numbers[next++];
  }
}

void PieceNetwork::values(std::span<const float> states, std::span<float> values) {
  ask(online_, states, values);
}
void PieceNetwork::target_values(std::span<const float> states, std::span<float> values) {
  ask(target_, states, values);
}

double PieceNetwork::learn(std::span<const float> states, std::span<const std::int64_t> actions,
                           std::span<const float> targets) {
  const std::size_t n = options_.connections;
  steps_.clear();
  for (std::size_t b = 0; b < actions.size(); ++b) {
    read(states.subspan(b * n, n));
    const auto connection = static_cast<ConnectionIndex>(actions[b]);
    observer_.describe(open_, std::span(&connection, 1), steps_);
  }
  const std::span<const float> numbers = evaluator_.numbers(online_, steps_);
  slope_.resize(actions.size());
  double loss = 0;
  for (std::size_t b = 0; b < actions.size(); ++b) {
    const double off = static_cast<double>(numbers[b]) - static_cast<double>(targets[b]);
    loss += std::abs(off) < 1 ? 0.5 * off * off : std::abs(off) - 0.5;
    slope_[b] =
        static_cast<float>(std::clamp(off, -1.0, 1.0) / static_cast<double>(actions.size()));
  }
  std::ranges::fill(gradient_, 0.0F);
  evaluator_.backward(online_, steps_, slope_, gradient_);
  const auto clip = static_cast<float>(options_.gradient_clip);
  for (float& number : gradient_) number = std::clamp(number, -clip, clip);
  adam_.step(gradient_, options_.learning_rate, online_.weights);
  const auto rate = static_cast<float>(options_.target_rate);
  for (std::size_t i = 0; i < target_.weights.size(); ++i)
    target_.weights[i] += rate * (online_.weights[i] - target_.weights[i]);
  return loss / static_cast<double>(actions.size());
}

std::vector<float> PieceNetwork::state() const {
  std::vector<float> all = online_.weights;
  all.insert(all.end(), target_.weights.begin(), target_.weights.end());
  const std::vector<float> moments = adam_.state();
  all.insert(all.end(), moments.begin(), moments.end());
  return all;
}

void PieceNetwork::restore(std::span<const float> state) {
  const std::size_t size = online_.weights.size();
  if (state.size() != 4 * size + 2)
    throw InputError("the training state is of a network of another shape");
  std::ranges::copy(state.first(size), online_.weights.begin());
  std::ranges::copy(state.subspan(size, size), target_.weights.begin());
  adam_.restore(state.subspan(2 * size));
}

}  // namespace orasp
