#include "orasp/planners/detail/order_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"

namespace orasp::detail {

/// A legal plan, by numbers of steps, whose states are kept, so that a change of a few steps is
/// walked through from the first to the last of them.
class OrderSearch::Walk {
 public:
  Walk(const TransitionSystem& system, Expander& expander, const PlacePrices::Values& values,
       const Budget& budget, std::uint64_t most)
      : system_(system), expander_(expander), values_(values), budget_(budget), left_(most) {}

  /// Whether no more steps may be looked at.
  [[nodiscard]] bool over() const { return left_ == 0; }
  [[nodiscard]] double reward() const {
    double sum = 0;
    for (const double one : rewards_) sum += one;
    return sum;
  }
  /// Walks through all of an order, which must be legal.
  void begin(const std::vector<std::uint32_t>& steps) {
    states_.assign(1, system_.start());
    rewards_.clear();
    for (const std::uint32_t step : steps) take(step);
  }
  /// How much more it earns to have these steps from place `first` to place `last`; nothing where
  /// that is not legal, or may not be looked at any more.
  [[nodiscard]] std::optional<double> gain(const std::vector<std::uint32_t>& steps,
                                           std::size_t first, std::size_t last) {
    ConnectionSet state = states_[first];
    double sum = 0;
    for (std::size_t k = first; k <= last; ++k) {
      if (left_ == 0) return std::nullopt;
      if (--left_ % 256 == 0 && budget_.expired() != Stop::None) left_ = 0;
      const ConnectionIndex c = values_.steps[steps[k]];
      const auto legal = expander_.legal_actions(state.view());
      const auto action = std::ranges::find(legal, c, &Action::connection);
      if (action == legal.end()) return std::nullopt;
      sum += action->reward - rewards_[k];
      state.erase(c);
    }
    return sum;
  }
  /// Makes the change that `gain` was asked for.
  void follow(const std::vector<std::uint32_t>& steps, std::size_t first) {
    states_.resize(first + 1);
    rewards_.resize(first);
    for (std::size_t k = first; k < steps.size(); ++k) take(steps[k]);
  }

 private:
  void take(std::uint32_t step) {
    const ConnectionIndex c = values_.steps[step];
    double reward = 0;
    for (const Action& action : expander_.legal_actions(states_.back().view())) {
      if (action.connection == c) reward = action.reward;
    }
    rewards_.push_back(reward);
    states_.push_back(states_.back());
    states_.back().erase(c);
  }

  const TransitionSystem& system_;
  Expander& expander_;
  const PlacePrices::Values& values_;
  const Budget& budget_;
  std::uint64_t left_;
  std::vector<ConnectionSet> states_;  ///< before each step, and at the end
  std::vector<double> rewards_;
};

/// An order of steps, by their numbers in PlacePrices::Values, and what moves in it are worth.
class OrderSearch::Order {
 public:
  /// With a `walk`, moves are made that are legal there.
  Order(const PlacePrices::Values& values, std::vector<std::uint32_t> steps, Walk* walk = nullptr)
      : values_(values), walk_(walk), steps_(std::move(steps)), in_block_(steps_.size(), 0) {
    for (const std::uint32_t step : steps_) {
      for (const double slope : {of(values.by_place, step), of(values.by_seconds, step)})
        scale_ = std::max(scale_, std::abs(slope));
    }
    for (const double value : values.table) {
      if (std::isfinite(value)) scale_ = std::max(scale_, std::abs(value));
    }
  }

  [[nodiscard]] const std::vector<std::uint32_t>& steps() const { return steps_; }
  [[nodiscard]] std::size_t size() const { return steps_.size(); }

  /// What the whole order earns, by what is known of each step, but for what it always earns.
  [[nodiscard]] double total() const {
    double sum = 0;
    double seconds = 0;
    for (std::size_t k = 0; k < size(); ++k) {
      sum += value(steps_[k], k) + of(values_.by_seconds, steps_[k]) * seconds;
      seconds += of(values_.seconds, steps_[k]);
    }
    return sum;
  }

  /// Makes moves that earn more until there is none, or `most` were made. Returns how many.
  std::size_t climb(std::size_t most) {
    std::size_t made = 0;
    for (bool moving = true; moving && made < most && (walk_ == nullptr || !walk_->over());) {
      moving = false;
      for (std::size_t i = 0; i < size() && made < most; ++i) {
        if (move_block(i, true) || move_block(i, false)) {
          moving = true;
          ++made;
        }
      }
      if (values_.by_seconds.empty() && exchange()) {
        moving = true;
        ++made;
      }
    }
    return made;
  }

  /// Moves a few blocks anywhere.
  void shake(SplitMix64& random) {
    const std::size_t blocks = 2 + random.below(3);
    for (std::size_t k = 0; k < blocks && size() > 1; ++k) {
      const std::size_t i = random.below(size());
      saved_ = steps_;
      shift(i, random.below(2) == 0, 1 + random.below(std::min<std::size_t>(size() - 1, 20)));
    }
  }

 private:
  [[nodiscard]] static double of(const std::vector<double>& numbers, std::uint32_t step) {
    return numbers.empty() ? 0 : numbers[step];
  }
  /// What `step` earns at a place, but for what lines of seconds say.
  [[nodiscard]] double value(std::uint32_t step, std::size_t place) const {
    if (!values_.table.empty()) return values_.table[step * size() + place];
    return of(values_.by_place, step) * static_cast<double>(place);
  }

  /// A run of steps that moves as one, and what it passes. Forwards it grows by what waits for it,
  /// backwards by what it waits for.
  struct Block {
    std::size_t begin;
    std::size_t end;
    double seconds = 0;
    double by_seconds = 0;
  };
  void add_to(Block& block, std::uint32_t step) {
    in_block_[step] = 1;
    block.seconds += of(values_.seconds, step);
    block.by_seconds += of(values_.by_seconds, step);
  }
  void forget(const Block& block) {
    for (std::size_t k = block.begin; k < block.end; ++k) in_block_[steps_[k]] = 0;
  }
  [[nodiscard]] bool tied(std::uint32_t step, bool later) const {
    const auto& others = later ? values_.waits_for[step] : values_.next[step];
    return std::ranges::any_of(others, [&](std::uint32_t other) { return in_block_[other] != 0; });
  }
  /// What it is worth that a block goes past the step right after it (or before it).
  [[nodiscard]] double worth(const Block& block, bool later) const {
    const std::uint32_t other = steps_[later ? block.end : block.begin - 1];
    const double sign = later ? 1 : -1;
    double sum = sign * (block.by_seconds * of(values_.seconds, other) -
                         of(values_.by_seconds, other) * block.seconds);
    const std::size_t from = later ? block.end : block.begin - 1;
    const std::size_t to = later ? block.begin : block.end - 1;
    sum += value(other, to) - value(other, from);
    for (std::size_t k = block.begin; k < block.end; ++k)
      sum += value(steps_[k], later ? k + 1 : k - 1) - value(steps_[k], k);
    return sum;
  }
  void pass(Block& block, bool later) {
    const auto begin = steps_.begin() + static_cast<std::ptrdiff_t>(block.begin);
    const auto end = steps_.begin() + static_cast<std::ptrdiff_t>(block.end);
    if (later) {
      std::rotate(begin, end, end + 1);
      ++block.begin;
      ++block.end;
    } else {
      std::rotate(begin - 1, begin, end);
      --block.begin;
      --block.end;
    }
  }
  [[nodiscard]] bool at_end(const Block& block, bool later) const {
    return later ? block.end == size() : block.begin == 0;
  }
  // Lets the block grow by the next step, if that is tied to it.
  bool grow(Block& block, bool later) {
    const std::uint32_t other = steps_[later ? block.end : block.begin - 1];
    if (!tied(other, later)) return false;
    add_to(block, other);
    if (later) {
      ++block.end;
    } else {
      --block.begin;
    }
    return true;
  }

  // Moves the block that begins with the step at `i` to where it is worth most, if that is more
  // than here.
  bool move_block(std::size_t i, bool later) {
    constexpr std::size_t kLongestBlock = 64;
    saved_ = steps_;
    Block block{i, i + 1};
    add_to(block, steps_[i]);
    double sum = 0;
    double best = 0;
    bool found = false;
    while (!at_end(block, later) && block.end - block.begin < kLongestBlock) {
      if (grow(block, later)) continue;
      const double more = worth(block, later);
      if (!std::isfinite(more)) break;  // beyond the places that it may have
      sum += more;
      pass(block, later);
      if (sum > best + 1e-9 * scale_ && allowed()) {
        best = sum;
        found = true;
        best_steps_ = steps_;
      }
    }
    forget(block);
    if (found) {
      std::swap(steps_, best_steps_);
      if (walk_ != nullptr) walk_->follow(steps_, changed().first);
    } else {
      std::swap(steps_, saved_);
    }
    return found;
  }

  void shift(std::size_t i, bool later, std::size_t steps) {
    Block block{i, i + 1};
    add_to(block, steps_[i]);
    while (steps > 0 && !at_end(block, later)) {
      if (grow(block, later)) continue;
      if (!std::isfinite(worth(block, later))) break;
      pass(block, later);
      --steps;
    }
    forget(block);
    if (walk_ == nullptr) return;
    const auto [first, last] = changed();
    if (first > last) return;
    if (walk_->gain(steps_, first, last)) {
      walk_->follow(steps_, first);
    } else {
      std::swap(steps_, saved_);
    }
  }

  /// The first and the last place at which the order is not that saved.
  [[nodiscard]] std::pair<std::size_t, std::size_t> changed() const {
    std::size_t first = 0;
    while (first < size() && steps_[first] == saved_[first]) ++first;
    if (first == size()) return {1, 0};
    std::size_t last = size() - 1;
    while (steps_[last] == saved_[last]) --last;
    return {first, last};
  }
  /// Whether the order that came of the one saved is legal and earns more, where there is a walk.
  [[nodiscard]] bool allowed() {
    if (walk_ == nullptr) return true;
    const auto [first, last] = changed();
    const auto more = walk_->gain(steps_, first, last);
    return more && *more > 1e-9 * scale_;
  }

  // The first two steps that earn more with their places exchanged. Only where places alone count.
  bool exchange() {
    place_.resize(size());
    for (std::size_t k = 0; k < size(); ++k) place_[steps_[k]] = k;
    for (std::size_t i = 0; i < size(); ++i) {
      const std::uint32_t first = steps_[i];
      std::size_t last = size();
      for (const std::uint32_t other : values_.next[first]) last = std::min(last, place_[other]);
      for (std::size_t j = i + 1; j < last; ++j) {
        const std::uint32_t second = steps_[j];
        const double more = value(first, j) + value(second, i) - value(first, i) - value(second, j);
        if (!(more > 1e-9 * scale_) || !std::isfinite(more)) continue;
        const bool waits = std::ranges::any_of(
            values_.waits_for[second], [&](std::uint32_t other) { return place_[other] >= i; });
        if (waits) continue;
        saved_ = steps_;
        std::swap(steps_[i], steps_[j]);
        if (allowed()) {
          if (walk_ != nullptr) walk_->follow(steps_, i);
          return true;
        }
        std::swap(steps_[i], steps_[j]);
        if (walk_ != nullptr && walk_->over()) return false;
      }
    }
    return false;
  }

  const PlacePrices::Values& values_;
  Walk* walk_;
  std::vector<std::uint32_t> steps_;
  std::vector<std::uint32_t> saved_;
  std::vector<std::uint32_t> best_steps_;
  std::vector<unsigned char> in_block_;
  std::vector<std::size_t> place_;
  double scale_ = 0;
};

OrderSearch::OrderSearch(const TransitionSystem& system, std::shared_ptr<const PlacePrices> prices)
    : system_(system), prices_(std::move(prices)), expander_(system) {
  guarded_ = system.may_shut_out() || system.ordered() ||
             std::ranges::any_of(system.problem().precedence(), [](const PrecedenceClause& clause) {
               return !clause.after_any.empty() || !clause.made_after_any.empty();
             });
}

OrderSearch::~OrderSearch() = default;

// Whether an order is a plan that earns more; if so the plan of `result` is it.
bool OrderSearch::try_order(const std::vector<ConnectionIndex>& order, Result& result) {
  if (order.size() != system_.num_steps() || order.empty()) return false;
  ConnectionSet state = system_.start();
  double reward = 0;
  for (const ConnectionIndex c : order) {
    const auto legal = expander_.legal_actions(state.view());
    const auto action = std::ranges::find(legal, c, &Action::connection);
    if (action == legal.end()) return false;
    reward += action->reward;
    state.erase(c);
  }
  if (result.has_plan() &&
      reward <= result.reward + kRewardTolerance * std::max(1.0, std::abs(result.reward)))
    return false;
  result.sequence = order;
  result.reward = reward;
  result.status = Status::Feasible;
  return true;
}

std::vector<std::uint32_t> OrderSearch::numbered(const Result& result) const {
  const std::vector<ConnectionIndex>& named = prices_->values().steps;
  std::vector<std::uint32_t> steps;
  for (const ConnectionIndex c : result.sequence)
    steps.push_back(static_cast<std::uint32_t>(std::ranges::lower_bound(named, c) - named.begin()));
  return steps;
}

std::vector<ConnectionIndex> OrderSearch::named(const std::vector<std::uint32_t>& steps) const {
  std::vector<ConnectionIndex> sequence;
  for (const std::uint32_t step : steps) sequence.push_back(prices_->values().steps[step]);
  return sequence;
}

bool OrderSearch::improve(const Budget& budget, std::uint64_t rounds, Result& result) {
  bool better = false;
  if (!begun_) {
    begun_ = true;
    better = try_order(prices_->order(), result);
  }
  if (!result.has_plan() || prices_->values().steps.size() < 2) return better;
  const bool moved = guarded_ ? improve_guarded(budget, rounds, result)
                              : improve_unguarded(budget, rounds, result);
  return better || moved;
}

bool OrderSearch::improve_unguarded(const Budget& budget, std::uint64_t rounds, Result& result) {
  bool better = false;
  SplitMix64 random(1);
  std::vector<std::uint32_t> from = numbered(result);
  double total = Order(prices_->values(), from).total();
  for (std::uint64_t round = 0; round < rounds && budget.expired() == Stop::None; ++round) {
    Order order(prices_->values(), from);
    if (round > 0) order.shake(random);
    order.climb(4 * order.size() + 100);
    if (order.total() <= total + kRewardTolerance * std::max(1.0, std::abs(total)) ||
        !try_order(named(order.steps()), result))
      continue;
    better = true;
    from = order.steps();
    total = order.total();
  }
  return better;
}

bool OrderSearch::improve_guarded(const Budget& budget, std::uint64_t rounds, Result& result) {
  constexpr std::uint64_t kMostSteps = 60'000;
  bool better = false;
  SplitMix64 random(1);
  Walk walk(system_, expander_, prices_->values(), budget, kMostSteps);
  std::vector<std::uint32_t> from = numbered(result);
  for (std::uint64_t round = 0; round < rounds && !walk.over(); ++round) {
    walk.begin(from);
    Order order(prices_->values(), from, &walk);
    if (round > 0) order.shake(random);
    order.climb(4 * order.size() + 100);
    if (walk.reward() > result.reward && try_order(named(order.steps()), result)) {
      better = true;
      from = order.steps();
    }
  }
  return better;
}

}  // namespace orasp::detail
