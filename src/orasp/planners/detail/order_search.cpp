#include "orasp/planners/detail/order_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"

namespace orasp::detail {

/// An order of steps, by their numbers in PlacePrices::Values, and what moves in it are worth.
class OrderSearch::Order {
 public:
  Order(const PlacePrices::Values& values, std::vector<std::uint32_t> steps)
      : values_(values), steps_(std::move(steps)), in_block_(steps_.size(), 0) {
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
    for (bool moving = true; moving && made < most;) {
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
      if (sum > best + 1e-9 * scale_) {
        best = sum;
        found = true;
        best_steps_ = steps_;
      }
    }
    forget(block);
    if (found) {
      std::swap(steps_, best_steps_);
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
        const bool waits = std::ranges::any_of(values_.waits_for[second], [&](std::uint32_t other) {
          return place_[other] >= i;
        });
        if (waits) continue;
        std::swap(steps_[i], steps_[j]);
        return true;
      }
    }
    return false;
  }

  const PlacePrices::Values& values_;
  std::vector<std::uint32_t> steps_;
  std::vector<std::uint32_t> saved_;
  std::vector<std::uint32_t> best_steps_;
  std::vector<unsigned char> in_block_;
  std::vector<std::size_t> place_;
  double scale_ = 0;
};

OrderSearch::OrderSearch(const TransitionSystem& system, std::shared_ptr<const PlacePrices> prices)
    : system_(system), prices_(std::move(prices)), expander_(system) {}

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

bool OrderSearch::improve(const Budget& budget, std::uint64_t rounds, Result& result) {
  const PlacePrices::Values& values = prices_->values();
  bool better = false;
  if (!begun_) {
    begun_ = true;
    better = try_order(prices_->order(), result);
  }
  if (!result.has_plan() || values.steps.size() < 2) return better;
  const auto numbered = [&] {
    std::vector<std::uint32_t> steps;
    for (const ConnectionIndex c : result.sequence)
      steps.push_back(static_cast<std::uint32_t>(std::ranges::lower_bound(values.steps, c) -
                                                 values.steps.begin()));
    return steps;
  };
  const auto named = [&](const Order& order) {
    std::vector<ConnectionIndex> sequence;
    for (const std::uint32_t step : order.steps()) sequence.push_back(values.steps[step]);
    return sequence;
  };
  SplitMix64 random(1);
  std::vector<std::uint32_t> from = numbered();
  double total = Order(values, from).total();
  for (std::uint64_t round = 0; round < rounds && budget.expired() == Stop::None; ++round) {
    Order order(values, from);
    if (round > 0) order.shake(random);
    // Where other rules forbid the top of a climb, the way there may still help.
    const std::size_t all = order.climb(4 * order.size() + 100);
    const bool promising =
        order.total() > total + kRewardTolerance * std::max(1.0, std::abs(total));
    if (promising && try_order(named(order), result)) {
      better = true;
      from = order.steps();
      total = order.total();
      continue;
    }
    if (round > 0 || all == 0) continue;
    for (std::size_t made = 0; made < all && budget.expired() == Stop::None; ++made) {
      Order one(values, from);
      if (one.climb(1) == 0 || !try_order(named(one), result)) break;
      better = true;
      from = one.steps();
      total = one.total();
    }
  }
  return better;
}

}  // namespace orasp::detail
