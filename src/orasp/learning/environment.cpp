#include "orasp/learning/environment.h"

#include <algorithm>
#include <string>

#include "orasp/model/error.h"

namespace orasp {

void indicate(SetView open, std::span<float> indicator) {
  std::ranges::fill(indicator, 0.0F);
  for_each_connection(open, [&](ConnectionIndex c) { indicator[c] = 1; });
}

Environment::Environment(const TransitionSystem& system, std::size_t episodes)
    : system_(system),
      expander_(system),
      words_(system.words()),
      states_(episodes * words_),
      open_counts_(episodes),
      actions_(episodes),
      stale_(episodes, true),
      totals_(episodes),
      forbidden_(system.num_connections()) {
  if (system.wide())
    throw InputError(
        "Environment knows steps that take one connection each until none is left, and earn what "
        "they earn whatever came before; here a goal, part steps or costs between steps say "
        "otherwise: VectorEnvironment takes goals and costs between steps");
  for (std::size_t i = 0; i < episodes; ++i) reset(i);
}

void Environment::reset(std::size_t episode) {
  reset(episode, system_.start());
}

void Environment::reset(std::size_t episode, const ConnectionSet& open) {
  std::ranges::copy(open.view(), states_.begin() + static_cast<std::ptrdiff_t>(episode * words_));
  open_counts_[episode] = open.size();
  totals_[episode] = 0;
  stale_[episode] = true;
}

void Environment::forbid(const ConnectionSet& connections) {
  for_each_connection(connections.view(), [&](ConnectionIndex c) { forbidden_.insert(c); });
  stale_.assign(size(), true);
}

SetView Environment::open(std::size_t episode) const {
  return SetView(states_).subspan(episode * words_, words_);
}

std::span<const Action> Environment::actions(std::size_t episode) {
  if (stale_[episode]) refresh();
  return actions_[episode];
}

void Environment::refresh() {
  batch_.clear();
  batch_episodes_.clear();
  for (std::size_t i = 0; i < size(); ++i) {
    if (!stale_[i]) continue;
    stale_[i] = false;
    actions_[i].clear();
    if (done(i)) continue;
    const SetView state = open(i);
    batch_.insert(batch_.end(), state.begin(), state.end());
    batch_episodes_.push_back(i);
  }
  expanded_ += batch_episodes_.size();
  expander_.for_each_expansion(batch_, [&](std::size_t place, std::span<const Action> legal) {
    std::vector<Action>& actions = actions_[batch_episodes_[place]];
    for (const Action& action : legal) {
      if (!forbidden_.contains(action.connection)) actions.push_back(action);
    }
  });
}

void Environment::mask(std::size_t episode, std::span<float> mask) {
  std::ranges::fill(mask, 0.0F);
  for (const Action& action : actions(episode)) mask[action.connection] = 1;
}

void Environment::observe(std::size_t episode, std::span<float> observation) const {
  indicate(open(episode), observation);
}

double Environment::step(std::size_t episode, ConnectionIndex connection) {
  const std::span<const Action> legal = actions(episode);
  const auto action = std::ranges::lower_bound(legal, connection, {}, &Action::connection);
  if (action == legal.end() || action->connection != connection) {
    throw InputError("connection " + std::to_string(connection) +
                     " cannot be handled now: it is not among the legal actions");
  }
  const double reward = action->reward;
  states_[episode * words_ + connection / 64] &= ~(std::uint64_t{1} << (connection % 64));
  --open_counts_[episode];
  totals_[episode] += reward;
  stale_[episode] = true;
  return reward;
}

bool Environment::done(std::size_t episode) const {
  const SetView state = open(episode);
  const SetView kept = forbidden_.view();
  for (std::size_t w = 0; w < words_; ++w) {
    if ((state[w] & ~kept[w]) != 0) return false;
  }
  return true;
}

}  // namespace orasp
