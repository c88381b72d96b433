#include "orasp/learning/detail/transition_cache.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "orasp/model/detail/rules.h"
#include "orasp/model/error.h"

namespace orasp::detail {

ActionColumns::ActionColumns(const TransitionSystem& system)
    : connections_(system.num_connections()), ways_(1), may_stop_(system.rules().may_stop) {
  const Rules& rules = system.rules();
  if (rules.by_part) {
    throw InputError(
        "action: the environment knows steps that take one connection each; here they take parts "
        "off, and those are too many to be numbered");
  }
  for (std::size_t i = 0; i < rules.context.radix.size(); ++i) {
    if (!rules.totals.attributes[i].of_connection.empty()) continue;  // not the direction
    directions_ = system.problem().directions();
    ways_ = 1 + directions_.size();
  }
}

std::uint32_t ActionColumns::column(const PlanStep& step) const {
  std::size_t column = connections_ * ways_;
  if (!step.connections.empty()) {
    column = step.connections.front() * ways_;
    if (ways_ > 1 && step.direction) {
      const auto direction = std::ranges::find(directions_, *step.direction);
      column += 1 + static_cast<std::size_t>(direction - directions_.begin());
    }
  }
  return static_cast<std::uint32_t>(column);
}

PlanStep ActionColumns::step(std::uint32_t column) const {
  PlanStep step;
  if (column == connections_ * ways_) return step;
  step.connections.push_back(static_cast<ConnectionIndex>(column / ways_));
  if (column % ways_ != 0) step.direction = directions_[column % ways_ - 1];
  return step;
}

TransitionCache::TransitionCache(const TransitionSystem& system, Steps steps)
    : system_(system),
      expander_(system),
      columns_(steps == Steps::Columns ? std::optional(ActionColumns(system)) : std::nullopt),
      words_(system.words()),
      mask_words_(columns_ ? words_for(columns_->size()) : 0),
      table_(words_) {
  first_.push_back(0);
}

std::uint32_t TransitionCache::number(SetView state) {
  const auto [number, is_new] = table_.insert(state.data());
  if (is_new) expansion_.push_back(kUnknown);
  return number;
}

std::uint32_t TransitionCache::find_next(std::uint32_t from, std::uint64_t place) {
  // Where there is more to states, remember() has seen to it.
  assert(!system_.wide());
  const SetView here = state(from);
  scratch_.assign(here.begin(), here.end());
  const std::uint32_t column = transitions_[place].column;
  scratch_[column / 64] &= ~(std::uint64_t{1} << (column % 64));
  return transitions_[place].next = number(scratch_);
}

void TransitionCache::expand() {
  if (wanted_.empty()) return;
  // Several episodes may want one state.
  std::vector<std::uint32_t> wanted = std::exchange(wanted_, {});
  std::ranges::sort(wanted);
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  if (system_.wide()) {
    // Where an action leads is known until the next state is expanded.
    for (const std::uint32_t number : wanted) {
      batch_.assign(state(number).begin(), state(number).end());
      remember(number, expander_.legal_actions(batch_));
    }
  } else {
    batch_.clear();
    for (const std::uint32_t number : wanted) {
      const SetView key = state(number);
      batch_.insert(batch_.end(), key.begin(), key.end());
    }
    expander_.for_each_expansion(
        batch_, [&](std::size_t i, std::span<const Action> legal) { remember(wanted[i], legal); });
  }
  wanted.clear();
  wanted_ = std::move(wanted);  // keeps its memory
}

void TransitionCache::remember(std::uint32_t from, std::span<const Action> legal) {
  const std::size_t begin = transitions_.size();
  // A state that ends a plan has no actions, whatever the Expander says of what is still there.
  if (system_.ends(state(from))) legal = {};
  if (system_.wide()) {
    scratch_.resize(words_);
    for (const Action& action : legal) {
      expander_.successor(batch_, action, scratch_);
      const std::uint32_t column =
          columns_ ? columns_->column(expander_.plan_step(action)) : action.number;
      transitions_.push_back({action.reward, column, number(scratch_)});
    }
    std::ranges::sort(transitions_.span().subspan(begin), {}, &Transition::column);
  } else {
    for (const Action& action : legal)
      transitions_.push_back({action.reward, action.connection.value(), kUnknown});
  }
  if (columns_) {
    const std::size_t mask = masks_.size();
    masks_.resize(mask + mask_words_);
    std::ranges::fill(masks_.span().subspan(mask), std::uint64_t{0});
    for (const Transition& transition : transitions_.span().subspan(begin))
      masks_[mask + transition.column / 64] |= std::uint64_t{1} << (transition.column % 64);
  }
  first_.push_back(transitions_.size());
  expansion_[from] = static_cast<std::uint32_t>(first_.size() - 2);
  ++expanded_;
}

std::uint64_t TransitionCache::bytes() const {
  return table_.bytes() + expansion_.bytes() + masks_.bytes() + first_.bytes() +
         transitions_.bytes();
}

}  // namespace orasp::detail
