#include "orasp/learning/vector_environment.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "orasp/learning/detail/observed_columns.h"
#include "orasp/learning/detail/transition_cache.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

using detail::in_quotes;

constexpr std::size_t kByte = 8;  // bits

/// The eight bits of each byte as numbers 0 or 1, the lowest first.
template <class Number>
struct BitsOfBytes {
  std::array<std::array<Number, kByte>, 256> rows{};
  constexpr BitsOfBytes() {
    for (std::size_t byte = 0; byte < rows.size(); ++byte) {
      for (std::size_t bit = 0; bit < kByte; ++bit)
        rows[byte][bit] = static_cast<Number>(byte >> bit & 1U);
    }
  }
};
template <class Number>
constexpr BitsOfBytes<Number> kBits{};

/// Writes the first `row.size()` bits of a set as numbers 0 or 1.
template <class Number>
void write_bits(SetView set, std::span<Number> row) {
  Number* out = row.data();
  std::size_t left = row.size();
  for (std::size_t w = 0; left != 0; ++w) {
    std::uint64_t word = set[w];
    for (std::size_t b = 0; b < sizeof(word) && left != 0; ++b, word >>= kByte) {
      const auto& bits = kBits<Number>.rows[word & 0xffU];
      const std::size_t size = std::min(left, kByte);
      if (size == kByte) {
        std::memcpy(out, bits.data(), sizeof(bits));  // of a size that the compiler knows
      } else {
        std::copy_n(bits.data(), size, out);
      }
      out += size;
      left -= size;
    }
  }
}

void require_size(std::size_t given, std::size_t wanted, const char* name) {
  if (given == wanted) return;
  throw InputError(std::string(name) + ": " + std::to_string(given) + " numbers are given, " +
                   std::to_string(wanted) + " are needed");
}

}  // namespace

VectorEnvironment::VectorEnvironment(const TransitionSystem& system, std::size_t episodes,
                                     const VectorEnvironmentOptions& options)
    : system_(system),
      options_(options),
      cache_(std::make_unique<detail::TransitionCache>(system)),
      observed_(std::make_unique<const detail::ObservedColumns>(system)),
      num_actions_(cache_->columns().size()),
      observation_size_(observed_->size()),
      max_steps_(system.num_steps() + (system.rules().may_stop ? 1 : 0)),
      start_(system.start_state().begin(), system.start_state().end()),
      states_(episodes),
      expansions_(episodes),
      over_(episodes, 0),
      totals_(episodes, 0.0),
      lengths_(episodes, 0),
      history_(episodes * max_steps_),
      places_(episodes),
      next_(episodes) {
  best_actions_.reserve(max_steps_);
  if (const auto reason = system.infeasibility())
    throw InputError("no episode can begin: " + reason->message);
  start_after({});
}

VectorEnvironment::~VectorEnvironment() = default;
VectorEnvironment::VectorEnvironment(VectorEnvironment&&) noexcept = default;

void VectorEnvironment::start_after(std::span<const std::int64_t> actions) {
  std::vector<std::uint32_t> taken;
  std::uint32_t state = cache_->number(system_.start_state());
  for (std::size_t i = 0;; ++i) {
    cache_->want(state);
    cache_->expand();
    const std::uint32_t expansion = cache_->expansion(state);
    if (i == actions.size()) {
      if (cache_->transitions(expansion).empty()) {
        if (system_.ends(cache_->state(state)))
          throw InputError("no episode can begin: nothing is left to be done");
        throw InputError("no episode can begin: no step is legal");
      }
      start_state_ = state;
      start_expansion_ = expansion;
      break;
    }
    const std::int64_t action = actions[i];
    if (const std::string why = obstacle_in(state, action); !why.empty())
      throw InputError("the first steps, [" + std::to_string(i) + "]: " + why);
    taken.push_back(static_cast<std::uint32_t>(action));
    state = cache_->next(state, cache_->place(expansion, taken.back()));
  }
  const SetView begins = cache_->state(start_state_);
  start_.assign(begins.begin(), begins.end());
  start_actions_ = std::move(taken);
  best_reward_.reset();
  best_actions_.clear();
  for (std::size_t i = 0; i < size(); ++i) begin(i);
}

void VectorEnvironment::begin(std::size_t episode) {
  states_[episode] = start_state_;
  expansions_[episode] = start_expansion_;
  over_[episode] = 0;
  totals_[episode] = 0;
  lengths_[episode] = 0;
}

void VectorEnvironment::check(const EpisodeBuffers& buffers) const {
  const std::size_t observations = size() * observation_size_;
  const auto check_one = [](const auto& buffer, std::size_t wanted, const char* name) {
    if (!buffer.empty()) require_size(buffer.size(), wanted, name);
  };
  check_one(buffers.observations, observations, "observations");
  check_one(buffers.observation_bytes, observations, "observation_bytes");
  check_one(buffers.masks, size() * num_actions_, "masks");
  check_one(buffers.rewards, size(), "rewards");
  check_one(buffers.terminated, size(), "terminated");
  check_one(buffers.truncated, size(), "truncated");
  check_one(buffers.final_observations, observations, "final_observations");
  check_one(buffers.final_observation_bytes, observations, "final_observation_bytes");
  check_one(buffers.returns, size(), "returns");
  check_one(buffers.lengths, size(), "lengths");
}

void VectorEnvironment::reset(const EpisodeBuffers& buffers) {
  const std::vector<std::uint8_t> all(size(), 1);
  reset(all, buffers);
}

void VectorEnvironment::reset(std::span<const std::uint8_t> which, const EpisodeBuffers& buffers) {
  require_size(which.size(), size(), "which");
  check(buffers);
  for (std::size_t i = 0; i < size(); ++i) {
    if (which[i] != 0) {
      begin(i);
      if (!buffers.rewards.empty()) buffers.rewards[i] = 0;
      if (!buffers.terminated.empty()) buffers.terminated[i] = 0;
      if (!buffers.truncated.empty()) buffers.truncated[i] = 0;
    }
    write_state(i, buffers);
  }
}

void VectorEnvironment::observe(const EpisodeBuffers& buffers) const {
  check(buffers);
  for (std::size_t i = 0; i < size(); ++i) write_state(i, buffers);
}

void VectorEnvironment::step(std::span<const std::int64_t> actions, const EpisodeBuffers& buffers) {
  require_size(actions.size(), size(), "actions");
  check(buffers);
  keep_to_limit();
  detail::TransitionCache& cache = *cache_;
  for (std::size_t i = 0; i < size(); ++i) {
    if (over_[i] != 0) {
      if (options_.autoreset == Autoreset::NextStep) continue;
      throw InputError("episode " + std::to_string(i) + " is over; reset it before its next step");
    }
    const auto action = static_cast<std::uint64_t>(actions[i]);
    if (action >= num_actions_ ||
        !contains(cache.mask(expansions_[i]), static_cast<std::uint32_t>(action)))
      refuse(i, actions[i]);
    places_[i] = cache.place(expansions_[i], static_cast<std::uint32_t>(action));
  }
  for (std::size_t i = 0; i < size(); ++i) {
    if (over_[i] != 0) continue;
    next_[i] = cache.next(states_[i], places_[i]);
    cache.want(next_[i]);
  }
  cache.expand();

  // From here on nothing throws.
  for (std::size_t i = 0; i < size(); ++i) {
    double reward = 0;
    bool ended = false;
    bool stuck = false;
    if (over_[i] != 0) {
      begin(i);
    } else {
      const detail::TransitionCache::Transition& transition = cache.transition(places_[i]);
      reward = transition.reward;
      totals_[i] += reward;
      history_[i * max_steps_ + lengths_[i]++] = transition.column;
      states_[i] = next_[i];
      expansions_[i] = cache.expansion(next_[i]);
      if (cache.transitions(expansions_[i]).empty()) {
        ended = system_.ends(cache.state(next_[i]));
        stuck = !ended;
        over_[i] = 1;
        if (ended) note_best(i);
        write_observation(next_[i], i, buffers.final_observations, buffers.final_observation_bytes);
        if (!buffers.returns.empty()) buffers.returns[i] = totals_[i];
        if (!buffers.lengths.empty()) buffers.lengths[i] = lengths_[i];
        if (options_.autoreset == Autoreset::SameStep) begin(i);
      }
    }
    if (!buffers.rewards.empty()) buffers.rewards[i] = reward;
    if (!buffers.terminated.empty()) buffers.terminated[i] = ended ? 1 : 0;
    if (!buffers.truncated.empty()) buffers.truncated[i] = stuck ? 1 : 0;
    write_state(i, buffers);
  }
}

void VectorEnvironment::write_state(std::size_t episode, const EpisodeBuffers& buffers) const {
  write_observation(states_[episode], episode, buffers.observations, buffers.observation_bytes);
  if (buffers.masks.empty()) return;
  write_bits(cache_->mask(expansions_[episode]),
             buffers.masks.subspan(episode * num_actions_, num_actions_));
}

void VectorEnvironment::write_observation(std::uint32_t state, std::size_t episode,
                                          std::span<float> floats,
                                          std::span<std::uint8_t> bytes) const {
  const SetView key = cache_->state(state);
  const auto write = [&]<class Number>(std::span<Number> all) {
    if (all.empty()) return;
    const std::span<Number> row = all.subspan(episode * observation_size_, observation_size_);
    const std::size_t connections = system_.num_connections();
    write_bits(key, row.first(connections));
    if (row.size() == connections) return;
    std::fill(row.begin() + static_cast<std::ptrdiff_t>(connections), row.end(), Number{0});
    observed_->for_each_of_context(key, [&](std::size_t column) { row[column] = 1; });
  };
  write(floats);
  write(bytes);
}

// Forgets what is remembered where it takes too much, but for the states in which episodes stand.
void VectorEnvironment::keep_to_limit() {
  if (cache_->bytes() <= options_.max_bytes) return;
  // A new one, so that nothing is lost if an expansion throws.
  auto fresh = std::make_unique<detail::TransitionCache>(system_);
  const std::uint32_t start = fresh->number(start_);
  fresh->want(start);
  for (std::size_t i = 0; i < size(); ++i) {
    next_[i] = fresh->number(cache_->state(states_[i]));
    fresh->want(next_[i]);
  }
  fresh->expand();
  fresh->count_as_well(cache_->expanded());
  cache_ = std::move(fresh);
  start_state_ = start;
  start_expansion_ = cache_->expansion(start);
  states_.swap(next_);
  for (std::size_t i = 0; i < size(); ++i) expansions_[i] = cache_->expansion(states_[i]);
  ++forgotten_;
}

void VectorEnvironment::note_best(std::size_t episode) {
  if (best_reward_ && totals_[episode] <= *best_reward_) return;
  best_reward_ = totals_[episode];
  const auto first = history_.begin() + static_cast<std::ptrdiff_t>(episode * max_steps_);
  best_actions_.assign(first, first + lengths_[episode]);
}

void VectorEnvironment::sample(std::span<std::int64_t> actions, SplitMix64& random) const {
  require_size(actions.size(), size(), "actions");
  for (std::size_t i = 0; i < size(); ++i) {
    const auto legal = cache_->transitions(expansions_[i]);
    actions[i] = legal.empty() ? 0 : std::int64_t{legal[random.below(legal.size())].column};
  }
}

SetView VectorEnvironment::open(std::size_t episode) const {
  return system_.open(cache_->state(states_[episode]));
}

bool VectorEnvironment::done(std::size_t episode) const {
  return system_.ends(cache_->state(states_[episode]));
}

bool VectorEnvironment::dead_end(std::size_t episode) const {
  return !done(episode) && cache_->transitions(expansions_[episode]).empty();
}

bool VectorEnvironment::legal(std::size_t episode, std::int64_t action) const {
  return static_cast<std::uint64_t>(action) < num_actions_ &&
         contains(cache_->mask(expansions_[episode]), static_cast<std::uint32_t>(action));
}

std::vector<PlanStep> VectorEnvironment::plan_of(std::span<const std::uint32_t> actions) const {
  std::vector<PlanStep> plan;
  const auto add = [&](std::uint32_t action) {
    PlanStep step = cache_->columns().step(action);
    if (!step.connections.empty()) plan.push_back(std::move(step));
  };
  std::ranges::for_each(start_actions_, add);
  std::ranges::for_each(actions, add);
  return plan;
}

std::vector<PlanStep> VectorEnvironment::plan(std::size_t episode) const {
  return plan_of(std::span(history_).subspan(episode * max_steps_, lengths_[episode]));
}

std::optional<VectorEnvironment::Best> VectorEnvironment::best() const {
  if (!best_reward_) return std::nullopt;
  return Best{*best_reward_, plan_of(best_actions_)};
}

PlanStep VectorEnvironment::plan_step(std::int64_t action) const {
  if (static_cast<std::uint64_t>(action) >= num_actions_)
    throw InputError("there is no action " + std::to_string(action) + "; actions are 0 to " +
                     std::to_string(num_actions_ - 1));
  return cache_->columns().step(static_cast<std::uint32_t>(action));
}

std::int64_t VectorEnvironment::action_of(const PlanStep& step) const {
  return cache_->columns().column(step);
}

std::string VectorEnvironment::column_name(std::size_t column) const {
  return observed_->name(column);
}

std::string VectorEnvironment::obstacle(std::size_t episode, std::int64_t action) const {
  return obstacle_in(states_[episode], action);
}

// The state must have been expanded.
std::string VectorEnvironment::obstacle_in(std::uint32_t number, std::int64_t action) const {
  const SetView state = cache_->state(number);
  if (static_cast<std::uint64_t>(action) >= num_actions_)
    return "there is no action " + std::to_string(action) + "; actions are 0 to " +
           std::to_string(num_actions_ - 1);
  if (contains(cache_->mask(cache_->expansion(number)), static_cast<std::uint32_t>(action)))
    return "";
  if (system_.ends(state)) return "the plan is ended";
  const PlanStep step = plan_step(action);
  if (step.connections.empty()) return "the plan cannot end before its goal is reached";
  const ConnectionIndex c = step.connections.front();
  const std::string id = in_quotes(system_.problem().connection_id(c));
  std::string reasons;
  for (const Violation& violation : Expander(system_).violations(system_.open(state), c)) {
    if (!reasons.empty()) reasons += "; ";
    reasons += violation.message;
  }
  if (reasons.empty()) {
    reasons = step.direction ? id + " cannot be handled so that a piece leaves in direction " +
                                   in_quotes(system_.problem().direction_name(*step.direction))
                             : id + " can only be handled in a direction: a piece moves";
  }
  return "connection " + id + " cannot be handled now: " + reasons;
}

void VectorEnvironment::refuse(std::size_t episode, std::int64_t action) const {
  throw InputError("actions[" + std::to_string(episode) + "] is " + std::to_string(action) + ": " +
                   obstacle(episode, action));
}

std::uint64_t VectorEnvironment::expanded() const {
  return cache_->expanded();
}

std::size_t VectorEnvironment::remembered() const {
  return cache_->states();
}

std::uint64_t VectorEnvironment::bytes() const {
  return cache_->bytes();
}

}  // namespace orasp
