#include "orasp/learning/imitation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "orasp/bounds/piece_bound.h"
#include "orasp/learning/detail/adam.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/and_or.h"
#include "orasp/planners/automatic.h"
#include "orasp/planners/beam.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

namespace {

constexpr std::uint64_t kLabelExpansions = 3'000;
constexpr std::size_t kSmall = 12;  // connections that are quickly gone through
constexpr std::uint64_t kLabelBytes = 64U << 20U;
constexpr std::size_t kMostUnsettled = 40;
constexpr double kLeastGain = 1e-4;  // of the loss held out, to go on
constexpr std::size_t kMostWalks = 64;
constexpr std::size_t kBatch = 16;
constexpr float kAveraged = 0.02F;  // how much of the network its average takes over at each step
// Of the steps of a walk: those that earn most at once, then random ones, then right ones.
constexpr double kGreedyShare = 0.25;
constexpr double kRightFrom = 0.5;
// Of the steps of a policy's own walk.
constexpr double kRandomShare = 0.1;

struct Answer {
  std::optional<double> value;
  double most = 0;
  /// A plan that earns the value.
  std::vector<ConnectionIndex> plan{};
};

/// What the engine says of the states of one problem.
class Oracle {
 public:
  Oracle(const TransitionSystem& system, const Budget& budget)
      : system_(system),
        budget_(budget),
        expander_(system),
        bound_(system, PieceBound::Kind::Both) {
    budget_.threads = 1;
    budget_.max_expansions = kLabelExpansions;
    budget_.max_bytes = std::min(budget_.max_bytes, kLabelBytes);
  }
  /// -infinity at a dead end; where it was not settled no value, and what it is at most.
  const Answer& value(const ConnectionSet& open) {
    const std::vector<std::uint64_t> key(open.view().begin(), open.view().end());
    const auto known = answers_.find(key);
    if (known != answers_.end()) return known->second;
    return answers_.emplace(key, asked(open)).first->second;
  }
  /// What each action of a state with a plan loses: kUnsettled where that is not known. None where
  /// the state itself is not settled. @param best  Where an action stands that is optimal.
  std::optional<std::vector<double>> losses(const ConnectionSet& open,
                                            std::span<const Action> actions, std::size_t& best);
  /// How many states were not settled.
  [[nodiscard]] std::size_t unsettled() const { return unsettled_; }

 private:
  [[nodiscard]] Answer asked(const ConnectionSet& open) {
    if (open.empty()) return {0.0, 0.0};
    Situation here = system_.situation();
    here.open = open;
    const TransitionSystem rest(system_.problem(), here);
    const Result result = proved(rest);
    if (result.status == Status::Optimal) return {result.reward, result.reward, result.sequence};
    if (result.status == Status::Infeasible) return {-kInfinity, -kInfinity};
    ++unsettled_;
    return {std::nullopt, result.bound.value_or(kInfinity)};
  }
  /// The quickest of the methods that may settle it first.
  [[nodiscard]] Result proved(const TransitionSystem& rest) const {
    if (rest.num_steps() <= kSmall) return automatic(rest, 0, budget_);
    Result result = detail::from_the_end(
        rest, [&](const TransitionSystem& from) { return beam(from, {}, budget_); });
    if (result.status == Status::Optimal || result.status == Status::Infeasible) return result;
    Result pieces = detail::from_the_end(rest, [&](const TransitionSystem& from) {
      if (and_or_obstacle(from)) return Result{};
      return and_or(from, {.rounds = 1, .symmetry = SymmetryUse::Off}, budget_);
    });
    if (pieces.status == Status::Optimal || pieces.status == Status::Infeasible) return pieces;
    if (pieces.bound && (!result.bound || *pieces.bound < *result.bound)) return pieces;
    return result;
  }
  /// What the plan earns where this connection of it comes first; -infinity where it may not.
  [[nodiscard]] double with_first(ConnectionIndex first, std::span<const ConnectionIndex> plan,
                                  ConnectionSet open);

  const TransitionSystem& system_;
  Budget budget_;
  Expander expander_;
  PieceBound bound_;
  std::size_t unsettled_ = 0;
  std::map<std::vector<std::uint64_t>, Answer> answers_;
};

double Oracle::with_first(ConnectionIndex first, std::span<const ConnectionIndex> plan,
                          ConnectionSet open) {
  double earned = 0;
  const auto take = [&](ConnectionIndex c) {
    const auto legal = expander_.legal_actions(open.view());
    const auto at = std::ranges::find(legal, c, &Action::connection);
    if (at == legal.end()) return false;
    earned += at->reward;
    open.erase(c);
    return true;
  };
  if (!take(first)) return -kInfinity;
  for (const ConnectionIndex c : plan) {
    if (c != first && !take(c)) return -kInfinity;
  }
  return earned;
}

std::optional<std::vector<double>> Oracle::losses(const ConnectionSet& open,
                                                  std::span<const Action> actions,
                                                  std::size_t& best) {
  const Answer here = value(open);
  if (!here.value || !std::isfinite(*here.value)) return std::nullopt;
  const double most = *here.value;
  const double slack = kRewardTolerance * std::max(1.0, std::abs(most));
  std::vector<double> bounds(actions.size(), kInfinity);
  if (bound_.known()) bound_.of_successors(open.view(), bound_(open.view()), actions, bounds);
  std::vector<double> losses;
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    if (c == here.plan.front()) best = i;
    const double by_bound = most - actions[i].reward - bounds[i];
    if (by_bound > slack) {
      losses.push_back(by_bound);
      continue;
    }
    // Most optimal actions stand later in a plan that is known.
    if (c == here.plan.front() || with_first(c, here.plan, open) >= most - slack) {
      losses.push_back(0);
      continue;
    }
    ConnectionSet after = open;
    after.erase(c);
    const Answer& rest = value(after);
    const double loss = most - actions[i].reward - rest.most;
    if (loss > slack)
      losses.push_back(loss);
    else
      losses.push_back(rest.value ? 0.0 : LabelledState::kUnsettled);
  }
  return losses;
}

/// -log of the softmax's share of the optimal actions, plus the mean loss; writes its slopes.
double loss_of(const LabelledState& labelled, std::span<const float> worth,
               std::vector<float>& slope) {
  const std::size_t size = worth.size();
  const float most = std::ranges::max(worth);
  std::vector<double> share(size);
  double sum = 0;
  for (std::size_t i = 0; i < size; ++i) {
    if (labelled.settled(i)) sum += share[i] = std::exp(double{worth[i]} - most);
  }
  sum = std::max(sum, 1e-300);
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

/// Of the actions of which it is known what they lose the one worth most.
std::size_t best_settled(const LabelledState& labelled, std::span<const float> worth) {
  std::size_t best = worth.size();
  for (std::size_t i = 0; i < worth.size(); ++i) {
    if (labelled.settled(i) && (best == worth.size() || worth[i] > worth[best])) best = i;
  }
  return best;
}

void shuffle(std::vector<std::size_t>& order, SplitMix64& random) {
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
}

/// One training.
class Pupil {
 public:
  Pupil(std::span<const TransitionSystem* const> systems, const ImitationOptions& options,
        const Budget& budget, const std::function<void(const ImitationRecord&)>& log,
        const GraphPolicy* resume)
      : systems_(systems),
        options_(options),
        budget_(budget),
        log_(log),
        random_(options.seed),
        order_(systems.size()),
        held_out_(systems.size() < 2 ? 0 : std::max<std::size_t>(1, systems.size() / 5)),
        outcome_{resume != nullptr ? *resume : GraphPolicy::untrained(options.seed), {}, {}} {
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = i;
    shuffle(order_, random_);
    record_.problems = systems.size() - held_out_;
    record_.held_out_problems = held_out_;
  }

  [[nodiscard]] Imitation learn() {
    ask_engine(options_.states, nullptr);
    if (lessons_.empty()) return std::move(outcome_);
    judge_beginning();
    learn_epochs();
    if (options_.own_states == 0 || outcome_.stop != Stop::None) return std::move(outcome_);
    record_.own = true;
    const GraphPolicy mine = outcome_.policy;
    ask_engine(options_.own_states, &mine);
    if (outcome_.stop != Stop::None) return std::move(outcome_);
    judge_beginning();
    learn_epochs();
    return std::move(outcome_);
  }

 private:
  /// Adds states of each problem to what is learned from, or to what is asked in the end.
  void ask_engine(std::size_t states, const GraphPolicy* own) {
    for (std::size_t i = 0; i < order_.size() && budget_.expired() == Stop::None; ++i) {
      std::vector<LabelledState>& to = i < held_out_ ? exam_ : lessons_;
      for (LabelledState& one :
           label_states(*systems_[order_[i]], states, random_.next(), budget_, own))
        to.push_back(std::move(one));
    }
    outcome_.stop = budget_.expired();
    record_.states = lessons_.size();
    record_.held_out_states = exam().size();
  }
  [[nodiscard]] const std::vector<LabelledState>& exam() const {
    return exam_.empty() ? lessons_ : exam_;
  }
  void examine(const GraphPolicy& policy) {
    record_.held_out_loss = 0;
    record_.held_out_right = 0;
    const double share = 1.0 / static_cast<double>(exam().size());
    for (const LabelledState& one : exam()) {
      const std::span<const float> worth = network_.worth(policy, one.state);
      record_.held_out_loss += share * loss_of(one, worth, slope_);
      if (one.loss[best_settled(one, worth)] == 0) record_.held_out_right += share;
    }
    record_.seconds = watch_.seconds();
  }
  void judge_beginning() {
    record_.loss = 0;
    examine(outcome_.policy);
    outcome_.best = record_;
    if (log_) log_(record_);
  }
  /// Learns on from the best policy so far until it gets no better.
  void learn_epochs() {
    GraphPolicy policy = outcome_.policy;
    GraphPolicy average = policy;
    detail::Adam adam(policy.weights.size());
    std::vector<std::size_t> turn(lessons_.size());
    for (std::size_t i = 0; i < turn.size(); ++i) turn[i] = i;
    const std::size_t most = record_.epoch + options_.most_epochs;
    while (record_.epoch < most && record_.epoch < outcome_.best.epoch + options_.patience) {
      shuffle(turn, random_);
      ++record_.epoch;
      learn_epoch(turn, adam, policy, average);
      if (outcome_.stop != Stop::None) return;
      examine(average);
      if (record_.held_out_loss < outcome_.best.held_out_loss - kLeastGain) {
        outcome_.best = record_;
        outcome_.policy = average;
      }
      if (log_) log_(record_);
    }
  }
  void learn_epoch(std::span<const std::size_t> turn, detail::Adam& adam, GraphPolicy& policy,
                   GraphPolicy& average) {
    record_.loss = 0;
    std::vector<float> gradient(policy.weights.size());
    for (std::size_t begin = 0; begin < turn.size(); begin += kBatch) {
      const std::size_t end = std::min(begin + kBatch, turn.size());
      std::ranges::fill(gradient, 0.0F);
      for (std::size_t i = begin; i < end; ++i) {
        const LabelledState& one = lessons_[turn[i]];
        record_.loss += loss_of(one, network_.worth(policy, one.state), slope_) /
                        static_cast<double>(turn.size());
        for (float& number : slope_) number /= static_cast<float>(end - begin);
        network_.backward(policy, one.state, slope_, gradient);
      }
      adam.step(gradient, options_.learning_rate, policy.weights);
      for (std::size_t w = 0; w < average.weights.size(); ++w)
        average.weights[w] += kAveraged * (policy.weights[w] - average.weights[w]);
      outcome_.stop = budget_.expired();
      if (outcome_.stop != Stop::None) return;
    }
  }

  std::span<const TransitionSystem* const> systems_;
  const ImitationOptions& options_;
  const Budget& budget_;
  const std::function<void(const ImitationRecord&)>& log_;
  const Stopwatch watch_;
  SplitMix64 random_;
  std::vector<std::size_t> order_;
  std::size_t held_out_;
  Imitation outcome_;
  ImitationRecord record_;
  std::vector<LabelledState> lessons_;
  std::vector<LabelledState> exam_;
  GraphNetwork network_;
  std::vector<float> slope_;
};

}  // namespace

std::optional<std::vector<double>> action_losses(const TransitionSystem& system,
                                                 const ConnectionSet& open,
                                                 std::span<const Action> actions,
                                                 const Budget& budget) {
  std::size_t best = 0;
  return Oracle(system, budget).losses(open, actions, best);
}

std::vector<LabelledState> label_states(const TransitionSystem& system, std::size_t states,
                                        std::uint64_t seed, const Budget& budget,
                                        const GraphPolicy* own) {
  std::vector<LabelledState> labelled;
  GraphNetwork network;
  SplitMix64 random(seed);
  Expander expander(system);
  GraphObserver observer(system);
  Oracle oracle(system, budget);
  double greatest = 0;
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
      if (own != nullptr) {
        const GraphState state = observer.observe(open.view(), actions);
        const std::span<const float> worth = network.worth(*own, state);
        if (kind >= kRandomShare)
          next = static_cast<std::size_t>(std::ranges::max_element(worth) - worth.begin());
      } else if (kind < kGreedyShare) {
        next = static_cast<std::size_t>(std::ranges::max_element(actions, {}, &Action::reward) -
                                        actions.begin());
      }
      if (asks) {
        std::size_t best = next;
        const auto losses = oracle.losses(open, actions, best);
        if (losses) {
          LabelledState one{observer.observe(open.view(), actions), {}};
          bool choice = false;
          for (const double loss : *losses) {
            if (loss > 0) choice = true;
            if (std::isfinite(loss)) greatest = std::max(greatest, loss);
            one.loss.push_back(static_cast<float>(loss));
          }
          if (choice) labelled.push_back(std::move(one));
          if (own == nullptr && kind >= kRightFrom) next = best;
        } else if (oracle.value(open).value) {
          break;  // no plan from here
        }
        if (oracle.unsettled() >= kMostUnsettled) too_many = std::min(too_many, open.size());
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
                  const Budget& budget, const std::function<void(const ImitationRecord&)>& log,
                  const GraphPolicy* resume) {
  for (const TransitionSystem* system : systems) {
    if (const auto reason = graph_policy_obstacle(*system)) throw Refusal("train", *reason);
  }
  return Pupil(systems, options, budget, log, resume).learn();
}

}  // namespace orasp
