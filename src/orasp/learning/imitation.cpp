#include "orasp/learning/imitation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "orasp/learning/detail/adam.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/automatic.h"

namespace orasp {

namespace {

constexpr std::uint64_t kLabelExpansions = 3'000;
constexpr std::uint64_t kLabelBytes = 64U << 20U;
constexpr std::size_t kMostUnsettled = 16;
constexpr double kLeastGain = 1e-4;  // of the loss held out, to go on
constexpr std::size_t kMostWalks = 64;
constexpr std::size_t kBatch = 16;

struct Answer {
  std::optional<double> value;
  double most = 0;
};

/// What is still to be earned from a state, by the engine; remembers what it was asked.
class Oracle {
 public:
  Oracle(const TransitionSystem& system, const Budget& budget) : system_(system), budget_(budget) {
    budget_.threads = 1;
    budget_.max_expansions = kLabelExpansions;
    budget_.max_bytes = std::min(budget_.max_bytes, kLabelBytes);
  }
  /// -infinity at a dead end; where it was not settled no value, and what it is at most.
  Answer value(const ConnectionSet& open) {
    if (open.empty()) return {0.0, 0.0};
    const std::vector<std::uint64_t> key(open.view().begin(), open.view().end());
    const auto known = values_.find(key);
    if (known != values_.end()) return known->second;
    Situation here = system_.situation();
    here.open = open;
    const TransitionSystem rest(system_.problem(), here);
    const Result result = automatic(rest, 0, budget_);
    Answer answer{std::nullopt, kInfinity};
    if (result.status == Status::Optimal)
      answer = {result.reward, result.reward};
    else if (result.status == Status::Infeasible)
      answer = {-kInfinity, -kInfinity};
    else if (result.bound)
      answer.most = *result.bound;
    values_.emplace(key, answer);
    return answer;
  }

 private:
  const TransitionSystem& system_;
  Budget budget_;
  std::map<std::vector<std::uint64_t>, Answer> values_;
};

/// -log of the softmax's share of the optimal actions, plus the mean loss; writes its slopes.
double loss_of(const LabelledState& labelled, std::span<const float> worth,
               std::vector<float>& slope) {
  const std::size_t size = worth.size();
  const float most = std::ranges::max(worth);
  std::vector<double> share(size);
  double sum = 0;
  for (std::size_t i = 0; i < size; ++i) sum += share[i] = std::exp(double{worth[i]} - most);
  double right = 0;
  double mean = 0;
  for (std::size_t i = 0; i < size; ++i) {
    share[i] /= sum;
    if (labelled.loss[i] == 0) right += share[i];
    mean += share[i] * labelled.loss[i];
  }
  right = std::max(right, 1e-12);
  slope.resize(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double of_right = labelled.loss[i] == 0 ? share[i] / right : 0.0;
    slope[i] = static_cast<float>(share[i] - of_right + share[i] * (labelled.loss[i] - mean));
  }
  return mean - std::log(right);
}

void shuffle(std::vector<std::size_t>& order, SplitMix64& random) {
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
}

}  // namespace

std::vector<LabelledState> label_states(const TransitionSystem& system, std::size_t states,
                                        std::uint64_t seed, const Budget& budget) {
  std::vector<LabelledState> labelled;
  SplitMix64 random(seed);
  Expander expander(system);
  GraphObserver observer(system);
  Oracle oracle(system, budget);
  double greatest = 0;
  std::size_t unsettled = 0;
  std::size_t too_many = std::numeric_limits<std::size_t>::max();  // open, for the engine
  // So that few states of a long plan are spread over it.
  const double chance =
      std::min(1.0, 3.0 * static_cast<double>(states) /
                        (8.0 * static_cast<double>(std::max<std::size_t>(1, system.num_steps()))));
  for (std::size_t walk = 0; walk < kMostWalks && labelled.size() < states; ++walk) {
    ConnectionSet open = system.start();
    while (!open.empty() && labelled.size() < states && budget.expired() == Stop::None) {
      const auto legal = expander.legal_actions(open.view());
      const std::vector<Action> actions(legal.begin(), legal.end());
      if (actions.empty()) break;
      const bool wants = open == system.start() || random.uniform() < chance;
      const bool asks = wants && actions.size() > 1 && open.size() < too_many;
      const double kind = random.uniform();
      std::size_t next = random.below(actions.size());
      if (kind < 0.25) {
        next = static_cast<std::size_t>(std::ranges::max_element(actions, {}, &Action::reward) -
                                        actions.begin());
      }
      if (asks) {
        // An action that was not settled but is bounded below the best is known to lose.
        std::vector<double> values;
        double best = -kInfinity;
        double open_end = -kInfinity;
        for (const Action& action : actions) {
          ConnectionSet after = open;
          after.erase(action.connection);
          const Answer rest = oracle.value(after);
          values.push_back(action.reward + rest.most);
          double& known = rest.value ? best : open_end;
          known = std::max(known, values.back());
          if (values.back() == kInfinity) break;
        }
        const double slack =
            std::isfinite(best) ? kRewardTolerance * std::max(1.0, std::abs(best)) : 0.0;
        const bool settled = open_end == -kInfinity || open_end < best - slack;
        if (best == -kInfinity && settled) break;  // no plan from here
        if (!settled && ++unsettled >= kMostUnsettled) too_many = std::min(too_many, open.size());
        if (settled) {
          LabelledState one{observer.observe(open.view(), actions), {}};
          bool choice = false;
          for (const double value : values) {
            const double loss = best - value <= slack ? 0.0 : best - value;
            if (loss > 0) choice = true;
            if (std::isfinite(loss)) greatest = std::max(greatest, loss);
            one.loss.push_back(static_cast<float>(loss));
          }
          if (choice) labelled.push_back(std::move(one));
          if (kind >= 0.5)
            next = static_cast<std::size_t>(std::ranges::max_element(values) - values.begin());
        }
      }
      open.erase(actions[next].connection);
    }
  }
  for (LabelledState& one : labelled) {
    for (float& loss : one.loss) {
      if (loss > 0) loss = std::isfinite(loss) ? static_cast<float>(double{loss} / greatest) : 1.0F;
    }
  }
  return labelled;
}

Imitation imitate(std::span<const TransitionSystem* const> systems, const ImitationOptions& options,
                  const Budget& budget, const std::function<void(const ImitationRecord&)>& log) {
  for (const TransitionSystem* system : systems) {
    if (const auto reason = graph_policy_obstacle(*system)) throw Refusal("train", *reason);
  }
  const Stopwatch watch;
  Imitation outcome{GraphPolicy::untrained(options.seed), {}, Stop::None};
  SplitMix64 random(options.seed);
  std::vector<std::size_t> order(systems.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  shuffle(order, random);
  const std::size_t held_out =
      systems.size() < 2 ? 0 : std::max<std::size_t>(1, systems.size() / 5);
  std::vector<LabelledState> lessons;
  std::vector<LabelledState> exam;
  for (std::size_t i = 0; i < order.size(); ++i) {
    std::vector<LabelledState>& to = i < held_out ? exam : lessons;
    for (LabelledState& one :
         label_states(*systems[order[i]], options.states, random.next(), budget))
      to.push_back(std::move(one));
    if (budget.expired() != Stop::None) break;
  }
  outcome.stop = budget.expired();
  if (exam.empty()) exam = lessons;
  if (lessons.empty()) return outcome;

  GraphPolicy policy = outcome.policy;
  GraphNetwork network;
  detail::Adam adam(policy.weights.size());
  std::vector<float> gradient(policy.weights.size());
  std::vector<float> slope;
  std::vector<std::size_t> turn(lessons.size());
  for (std::size_t i = 0; i < turn.size(); ++i) turn[i] = i;
  ImitationRecord record;
  record.problems = systems.size() - held_out;
  record.held_out_problems = held_out;
  record.states = lessons.size();
  record.held_out_states = exam.size();
  const auto examine = [&] {
    record.held_out_loss = 0;
    record.held_out_right = 0;
    const double share = 1.0 / static_cast<double>(exam.size());
    for (const LabelledState& one : exam) {
      const std::span<const float> worth = network.worth(policy, one.state);
      record.held_out_loss += share * loss_of(one, worth, slope);
      const auto chosen = static_cast<std::size_t>(std::ranges::max_element(worth) - worth.begin());
      if (one.loss[chosen] == 0) record.held_out_right += share;
    }
    record.seconds = watch.seconds();
  };
  examine();
  outcome.best = record;
  if (log) log(record);
  for (std::size_t epoch = 1;
       epoch <= options.most_epochs && epoch <= outcome.best.epoch + options.patience; ++epoch) {
    shuffle(turn, random);
    record.epoch = epoch;
    record.loss = 0;
    for (std::size_t begin = 0; begin < turn.size() && outcome.stop == Stop::None;
         begin += kBatch) {
      const std::size_t end = std::min(begin + kBatch, turn.size());
      std::ranges::fill(gradient, 0.0F);
      for (std::size_t i = begin; i < end; ++i) {
        const LabelledState& one = lessons[turn[i]];
        record.loss += loss_of(one, network.worth(policy, one.state), slope) /
                       static_cast<double>(turn.size());
        for (float& number : slope) number /= static_cast<float>(end - begin);
        network.backward(policy, one.state, slope, gradient);
      }
      adam.step(gradient, options.learning_rate, policy.weights);
      outcome.stop = budget.expired();
    }
    if (outcome.stop != Stop::None) break;
    examine();
    if (record.held_out_loss < outcome.best.held_out_loss - kLeastGain) {
      outcome.best = record;
      outcome.policy = policy;
    }
    if (log) log(record);
  }
  return outcome;
}

}  // namespace orasp
