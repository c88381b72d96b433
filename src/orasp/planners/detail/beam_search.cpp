#include "orasp/planners/detail/beam_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/containers/parallel.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/same_successor.h"
#include "orasp/task/memory_limit.h"

namespace orasp::detail {

namespace {

/// With SymmetryUse::Auto so many states are expanded before symmetry is looked for.
constexpr std::uint64_t kBeforeBeamSymmetry = 10'000;

}  // namespace

BeamSearch::BeamSearch(const TransitionSystem& system, const BeamOptions& options,
                       const Budget& budget, Result& result)
    : system_(system),
      budget_(budget),
      words_(system.words()),
      allowed_(allowed_bytes(budget)),
      symmetry_use_(options.symmetry),
      result_(result),
      workers_(std::max(1U, budget.threads)),
      crew_(options.crew),
      proved_(options.most) {
  for (Worker& worker : workers_) {
    worker.expander = std::make_unique<Expander>(system);
    if (crew_ != nullptr) worker.found_for.resize(crew_->size());
    const Bound* const made = workers_.front().bound.get();
    worker.bound = make_bound(system, options.bound, made != nullptr ? made : options.like);
  }
  bounded_ = workers_.front().bound->known();
  const StartByPlaces by_places = start_by_places(*workers_.front().bound);
  proved_ = std::min(proved_, by_places.most);
  for (Worker& worker : workers_) {
    if (by_places.prices && StepInFront::applies(system, *by_places.prices))
      worker.in_front = std::make_unique<StepInFront>(system, by_places.prices);
  }
  if (by_places.prices) orders_ = std::make_unique<OrderSearch>(system, by_places.prices);
  if (options.advice != nullptr && crew_ == nullptr && !system.completes_first()) {
    advised_ = std::make_unique<AdvisedPass>(system, *options.advice, options.bound,
                                             workers_.front().bound.get(), budget.threads);
  }
}

void BeamSearch::run() {
  const double most = bounded_ ? (*workers_.front().bound)(system_.start().view()) : kInfinity;
  tick_ = kRewardTolerance * (std::isfinite(most) ? std::max(1.0, std::abs(most)) : 1.0);
  proved_ = std::min(proved_, most);
  improve_order();
  done_ = meets_bound();
  for (std::size_t width = 1; !done_ && result_.stop == Stop::None; width *= 2) {
    ++result_.statistics.sweeps;
    look_for_symmetry();
    const double left_out = pass(width);
    if (result_.stop != Stop::None) break;
    proved_ = std::min(proved_, std::max(left_out, result_.reward));
    if (left_out > -kInfinity && !meets_bound()) improve_order();
    done_ = left_out == -kInfinity || meets_bound();
    if (!done_ && advised_) follow_advice();
  }
  if (std::isfinite(proved_)) result_.bound = proved_;
  std::array<std::uint64_t, 2> counts = {merged_, reopened_};
  std::array<double, 1> peak = {static_cast<double>(peak_bytes_)};
  if (crew_ != nullptr) {
    crew_->take_sums(counts);
    crew_->take_greatest(peak);
  }
  result_.statistics.pruned += counts[0];
  result_.statistics.reopened += counts[1];
  result_.statistics.peak_bytes = static_cast<std::uint64_t>(peak[0]);
}

// Before a pass.
void BeamSearch::look_for_symmetry() {
  const bool automatic = symmetry_use_ == SymmetryUse::Auto;
  if (symmetry_use_ == SymmetryUse::Off) return;
  if (automatic &&
      (workers_.front().in_front != nullptr || result_.statistics.expanded < kBeforeBeamSymmetry))
    return;
  symmetry_ = symmetry_for(system_, symmetry_use_, "beam");
  symmetry_use_ = SymmetryUse::Off;  // known once and for all
  if (crew_ != nullptr && !all_found_the_same(symmetry_)) symmetry_.reset();
  if (!symmetry_) return;
  form_ = symmetry_->form();
  for (Worker& worker : workers_) {
    worker.form = form_;
    worker.in_front.reset();  // it compares states as they are
  }
}

// Between two passes: passes by advice, each twice as wide as the one before, as long as a
// question costs less than so many expansions that were made.
void BeamSearch::follow_advice() {
  constexpr std::uint64_t kExpansionsForQuestion = 64;
  constexpr double kLoose = 1e-3;
  const auto loose = [&] {
    return !bounded_ || !result_.has_plan() ||
           proved_ - result_.reward > kLoose * std::max(1.0, std::abs(proved_));
  };
  while (!done_ && result_.stop == Stop::None && loose() &&
         (asked_ + advised_width_ * system_.num_steps()) * kExpansionsForQuestion <=
             result_.statistics.expanded) {
    const std::uint64_t before = result_.statistics.expanded;
    const double left_out = advised_->run(advised_width_, tick_, budget_, result_);
    asked_ += result_.statistics.expanded - before;
    advised_width_ *= 2;
    if (result_.stop != Stop::None) return;
    proved_ = std::min(proved_, std::max(left_out, result_.reward));
    done_ = left_out == -kInfinity || meets_bound();
  }
}

// Where rewards depend on when steps come, moves the steps of a new plan about.
void BeamSearch::improve_order() {
  if (!orders_ || result_.reward == improved_) return;
  if (crew_ == nullptr || crew_->member() == 0) orders_->improve(budget_, kOrderRounds, result_);
  if (crew_ != nullptr) take_plan_of_first();
  improved_ = result_.reward;
}

bool BeamSearch::same_state(const Candidate& a, const Candidate& b) {
  if (a.hash != b.hash) return false;
  if (crew_ != nullptr || form_) {
    if (words_ == 1 && form_) return true;  // hashes of one word differ where the words do
    return std::ranges::equal(bits_of(a, one_), bits_of(b, other_));
  }
  return same_successor(state_of(layer_, a.parent), a.connection, state_of(layer_, b.parent),
                        b.connection);
}

bool BeamSearch::before(const Candidate& a, const Candidate& b) {
  const double left = ticks_of(a.promise);
  const double right = ticks_of(b.promise);
  if (left != right) return left > right;
  const std::uint64_t one = order_of(a.hash);
  const std::uint64_t other = order_of(b.hash);
  if (one != other) return one < other;
  return std::ranges::lexicographical_compare(bits_of(a, one_), bits_of(b, other_));
}

bool BeamSearch::comes_first(const Origin& a, ConnectionIndex by_a, const Origin& b,
                             ConnectionIndex by_b) const {
  const double left = ticks_of(a.promise);
  const double right = ticks_of(b.promise);
  if (left != right) return left > right;
  const std::uint64_t one = order_of(a.hash);
  const std::uint64_t other = order_of(b.hash);
  return one != other ? one < other : by_a < by_b;
}

double BeamSearch::pass(std::size_t width) {
  const std::size_t depth = system_.num_steps();
  double left_out = -kInfinity;
  taken_.clear();
  taken_by_.clear();
  begins_.assign(1, 0);
  layer_.clear();
  if (crew_ == nullptr || member_of(0) == crew_->member()) {
    const ConnectionSet start = system_.start();
    layer_.states.assign(start.view().begin(), start.view().end());
    layer_.rewards.push_back(0);
    layer_.rests.push_back(bounded_ ? (*workers_.front().bound)(start.view()) : 0);
    layer_.hashes.push_back(0);
  }
  std::uint64_t size = 1;
  for (std::size_t k = 0; k < depth && size > 0; ++k) {
    const bool last = k + 1 == depth;
    left_out = std::max(left_out, crew_ != nullptr ? expand_layer_with_crew(width, last)
                                                   : expand_layer(width, last));
    if (result_.stop != Stop::None) return left_out;
    make_next_layer();
    size = crew_ != nullptr ? at_most_ : layer_.size();
  }
  // The only state of the last layer is the goal.
  std::array<double, 2> ends = {left_out, layer_.size() > 0 ? layer_.rewards.front() : -kInfinity};
  if (crew_ != nullptr) crew_->take_greatest(ends);
  if (size > 0 && (ends[1] > result_.reward || !result_.has_plan())) take_plan(ends[1]);
  return ends[0];
}

// Fills survivors_ with the best `width` successors of the layer.
double BeamSearch::expand_layer(std::size_t width, bool last) {
  double left_out = -kInfinity;
  survivors_.clear();
  slots_.assign(64, 0);
  const std::size_t size = layer_.size();
  // The same for any number of threads, so that the answer is the same.
  constexpr std::size_t chunk = 1024;
  width_ = width;
  for (std::size_t begin = 0; begin < size; begin += chunk) {
    const std::size_t survivors_before = survivors_.size();
    const std::size_t end = std::min(size, begin + chunk);
    merge_all(expand(begin, end, last));
    grew_by_ = survivors_.size() - survivors_before;
    if (survivors_.size() > 2 * width) left_out = std::max(left_out, cut_down(width));
    poll();
    if (result_.stop != Stop::None) return left_out;
  }
  if (survivors_.size() > width) left_out = std::max(left_out, cut_down(width));
  return left_out;
}

// Expands states of the layer. Returns how many workers did.
std::size_t BeamSearch::expand(std::size_t begin, std::size_t end, bool last) {
  const std::size_t size = end - begin;
  const std::size_t used = size < 4 * workers_.size() ? 1 : workers_.size();
  run_parallel(used, [&](std::size_t t) {
    const Share share = share_of(size, used, t);
    work(workers_[t], begin + share.begin, begin + share.end, last);
  });
  return used;
}

// Takes over what the workers found, in the order of the layer.
void BeamSearch::merge_all(std::size_t workers) {
  for (std::size_t t = 0; t < workers; ++t) {
    Worker& worker = workers_[t];
    result_.statistics.expanded += worker.expanded;
    result_.statistics.generated += worker.generated;
    result_.statistics.pruned += worker.pruned;
    worker.expanded = worker.generated = worker.pruned = 0;
    if (result_.stop == Stop::None) result_.stop = worker.stop;
    for (const Candidate& candidate : worker.found) merge(candidate);
    worker.found.clear();
  }
}

void BeamSearch::work(Worker& worker, std::size_t begin, std::size_t end, bool last) {
  for (std::size_t i = begin; i < end; ++i) {
    if ((i - begin) % 64 == 63 && (worker.stop = budget_.expired()) != Stop::None) return;
    const SetView open = state_of(layer_, i);
    const auto legal = worker.expander->legal_actions(open);
    ++worker.expanded;
    worker.rests.assign(legal.size(), 0);
    // What is known of a state may be more than of the one that stands for it, or less.
    const double here = form_ && bounded_ ? (*worker.bound)(open) : layer_.rests[i];
    if (bounded_) worker.bound->of_successors(open, here, legal, worker.rests);
    std::optional<ConnectionIndex> alone;
    if (worker.in_front && result_.has_plan())
      alone =
          worker.in_front->find(open, legal, layer_.rewards[i] + layer_.rests[i] - result_.reward);
    for (std::size_t a = 0; a < legal.size(); ++a) {
      if (alone && legal[a].connection != *alone) continue;
      const double reward = layer_.rewards[i] + legal[a].reward;
      const double promise = reward + worker.rests[a];
      ++worker.generated;
      // The reward at the goal is no promise but a fact, so it needs no tolerance.
      if (bounded_ && result_.has_plan() && promise <= result_.reward + (last ? 0 : tick_)) {
        ++worker.pruned;
        continue;
      }
      const ConnectionIndex c = legal[a].connection;
      if (crew_ != nullptr) {
        append_record(worker, static_cast<std::uint32_t>(i), c, reward, worker.rests[a]);
        continue;
      }
      std::uint64_t hash = layer_.hashes[i] ^ mark_of(c);
      if (worker.form) {
        write_successor(open, c, worker.form, worker.next);
        hash = hash_value(worker.next);
      }
      worker.found.push_back(
          {promise, reward, worker.rests[a], hash, static_cast<std::uint32_t>(i), c});
    }
  }
}

// Returns whether its state is new.
bool BeamSearch::merge(const Candidate& candidate) {
  if (survivors_.size() * 2 >= slots_.size()) index(slots_.size() * 4);
  std::size_t i = mixed(candidate.hash) & (slots_.size() - 1);
  while (slots_[i] != 0) {
    Candidate& other = survivors_[slots_[i] - 1];
    if (same_state(other, candidate)) {
      ++merged_;
      if (candidate.reward > other.reward) {
        replace(other, candidate);
        ++reopened_;
      } else if (crew_ != nullptr && candidate.reward == other.reward &&
                 comes_first(arrived_.origins[candidate.parent], candidate.connection,
                             arrived_.origins[other.parent], other.connection)) {
        replace(other, candidate);
      }
      return false;
    }
    i = (i + 1) & (slots_.size() - 1);
  }
  survivors_.push_back(candidate);
  slots_[i] = static_cast<std::uint32_t>(survivors_.size());
  return true;
}

// Puts a better way to the same state in the place of a survivor.
void BeamSearch::replace(Candidate& survivor, const Candidate& candidate) {
  const std::uint32_t place = survivor.parent;
  survivor = candidate;
  if (crew_ == nullptr) return;
  arrived_.origins[place] = arrived_.origins[candidate.parent];
  survivor.parent = place;
}

void BeamSearch::index(std::size_t slots) {
  slots_.assign(slots, 0);
  for (std::size_t k = 0; k < survivors_.size(); ++k) {
    std::size_t i = mixed(survivors_[k].hash) & (slots - 1);
    while (slots_[i] != 0) i = (i + 1) & (slots - 1);
    slots_[i] = static_cast<std::uint32_t>(k + 1);
  }
}

double BeamSearch::cut_down(std::size_t width) {
  const auto order = [this](const Candidate& a, const Candidate& b) { return before(a, b); };
  std::nth_element(survivors_.begin(), survivors_.begin() + static_cast<std::ptrdiff_t>(width),
                   survivors_.end(), order);
  const double left_out = drop_from(width);
  // nth_element leaves an order of its own; what follows must not depend on it.
  std::sort(survivors_.begin(), survivors_.end(), order);
  index(slots_.size());
  return left_out;
}

// Leaves out all survivors from the given place on. Returns the greatest promise of them.
double BeamSearch::drop_from(std::size_t kept) {
  double left_out = -kInfinity;
  for (std::size_t i = kept; i < survivors_.size(); ++i)
    left_out = std::max(left_out, bounded_ ? survivors_[i].promise : kInfinity);
  survivors_.resize(kept);
  return left_out;
}

void BeamSearch::make_next_layer() {
  next_.clear();
  next_.states.reserve(survivors_.size() * words_);
  next_.rewards.reserve(survivors_.size());
  next_.rests.reserve(survivors_.size());
  next_.hashes.reserve(survivors_.size());
  std::sort(survivors_.begin(), survivors_.end(),
            [this](const Candidate& a, const Candidate& b) { return before(a, b); });
  for (const Candidate& candidate : survivors_) {
    const SetView state = bits_of(candidate, one_);
    next_.states.insert(next_.states.end(), state.begin(), state.end());
    next_.rewards.push_back(candidate.reward);
    next_.rests.push_back(candidate.rest);
    next_.hashes.push_back(candidate.hash);
    std::uint32_t parent = candidate.parent;
    if (crew_ != nullptr) {
      const Origin& origin = arrived_.origins[candidate.parent];
      parent = origin.parent;
      taken_by_.push_back(origin.member);
    }
    taken_.push_back({parent, static_cast<std::uint16_t>(candidate.connection)});
  }
  begins_.push_back(taken_.size());
  std::swap(layer_, next_);
}

void BeamSearch::take_plan(double reward) {
  const std::size_t depth = system_.num_steps();
  result_.reward = reward;
  result_.status = Status::Feasible;
  result_.sequence.assign(depth, 0);
  std::size_t index = 0;
  std::size_t member = crew_ != nullptr ? member_of_goal() : 0;
  for (std::size_t k = depth; k-- > 0;) {
    // Of a crew the member that holds the state knows how it was reached, and tells the others.
    std::array<double, 3> back = {-1, -1, -1};
    if (crew_ == nullptr || member == crew_->member()) {
      const Taken& taken = taken_[begins_[k] + index];
      back = {static_cast<double>(taken.connection), static_cast<double>(taken.parent),
              crew_ != nullptr ? static_cast<double>(taken_by_[begins_[k] + index]) : 0};
    }
    if (crew_ != nullptr) crew_->take_greatest(back);
    result_.sequence[k] = static_cast<std::uint32_t>(back[0]);
    index = static_cast<std::size_t>(back[1]);
    member = static_cast<std::size_t>(back[2]);
  }
  if (form_) result_.sequence = true_sequence(system_, *form_, result_.sequence);
}

void BeamSearch::poll() {
  std::uint64_t bytes =
      taken_.capacity() * sizeof(Taken) + taken_by_.capacity() * sizeof(std::uint32_t) +
      arrived_.states.capacity() * 8 + arrived_.origins.capacity() * sizeof(Origin) +
      exchanged_bytes_ + survivors_.capacity() * sizeof(Candidate) +
      slots_.capacity() * sizeof(std::uint32_t);
  for (const Layer* layer : {&layer_, &next_})
    bytes += layer->states.capacity() * 8 + layer->size() * 24;
  for (const Worker& worker : workers_) bytes += worker.found.capacity() * sizeof(Candidate);
  peak_bytes_ = std::max(peak_bytes_, bytes);
  // Memory is judged before it is taken: by what the next chunk and the next layer may need.
  // Tables grow by doubling, and for a moment both the old and the new one are there.
  const std::size_t survivors = survivors_.size() + 2 * grew_by_;
  const std::size_t next = std::min(survivors, width_);
  std::uint64_t soon = bytes_with(taken_, taken_.size() + next) + exchanged_bytes_ +
                       bytes_with(survivors_, survivors) +
                       bytes_with(slots_, survivors * 2 < slots_.size() ? 0 : slots_.size() * 4) +
                       bytes_with(next_.states, next * words_) + layer_.states.capacity() * 8 +
                       (layer_.size() + next_.rewards.capacity() + next) * 24;
  if (crew_ != nullptr) {
    soon += bytes_with(taken_by_, taken_by_.size() + next) +
            bytes_with(arrived_.states, survivors * words_) +
            bytes_with(arrived_.origins, survivors);
  }
  for (const Worker& worker : workers_) soon += worker.found.capacity() * sizeof(Candidate);
  // A member of a crew tells the others, and all stop in the next round.
  Stop& stop = crew_ != nullptr ? own_stop_ : result_.stop;
  if (stop == Stop::None)
    stop = soon > allowed_ ? Stop::MemoryLimit : budget_.expired(soon, result_.statistics.expanded);
  budget_.report({.phase = "pass",
                  .done = result_.statistics.sweeps,
                  .states = layer_.size(),
                  .best = result_.reward});
}

}  // namespace orasp::detail
