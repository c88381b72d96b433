#include "orasp/planners/detail/advised_pass.h"

#include <algorithm>
#include <utility>

#include "orasp/containers/parallel.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/same_successor.h"

namespace orasp::detail {

struct AdvisedPass::State {
  double reward;
  double rest;
  double against;  ///< summed along the way
  std::uint64_t hash;
};

/// A state of the next layer: the state `parent` of this one less `connection`.
struct AdvisedPass::Candidate {
  double reward;
  double rest;
  double against;
  std::uint64_t hash;
  std::uint32_t parent;
  ConnectionIndex connection;
};

/// How a state of a layer was reached from the layer before.
struct AdvisedPass::Taken {
  std::uint32_t parent;
  ConnectionIndex connection;
};

struct AdvisedPass::Worker {
  Worker(const TransitionSystem& system, const MakeAdvice& make, BoundKind kind, const Bound* like)
      : expander(system), bound(make_bound(system, kind, like)), advice(make(system)) {}

  Expander expander;
  std::unique_ptr<Bound> bound;
  std::unique_ptr<StepAdvice> advice;
  std::vector<double> rests;
  std::vector<double> against;
  std::vector<Action> actions;
  std::vector<Candidate> found;
  std::uint64_t expanded = 0;
  std::uint64_t generated = 0;
  std::uint64_t pruned = 0;
  Stop stop = Stop::None;
};

AdvisedPass::AdvisedPass(const TransitionSystem& system, const MakeAdvice& advice, BoundKind kind,
                         const Bound* like, unsigned threads)
    : system_(system), words_(system.words()) {
  for (unsigned t = 0; t < std::max(1U, threads); ++t)
    workers_.push_back(std::make_unique<Worker>(system, advice, kind, like));
}

AdvisedPass::~AdvisedPass() = default;

SetView AdvisedPass::state_of(std::size_t i) const {
  return {states_.data() + i * words_, words_};
}

bool AdvisedPass::same_state(const Candidate& a, const Candidate& b) const {
  return same_successor(state_of(a.parent), a.connection, state_of(b.parent), b.connection);
}

void AdvisedPass::expand(Worker& worker, std::size_t begin, std::size_t end, double least,
                         double tick, bool bounded, const Budget& budget) {
  const bool last = count(state_of(0)) == 1;
  for (std::size_t i = begin; i < end; ++i) {
    if ((worker.stop = budget.expired()) != Stop::None) return;
    const SetView open = state_of(i);
    const auto legal = worker.expander.legal_actions(open);
    worker.actions.assign(legal.begin(), legal.end());
    ++worker.expanded;
    worker.rests.assign(worker.actions.size(), 0);
    if (bounded) worker.bound->of_successors(open, layer_[i].rest, worker.actions, worker.rests);
    const auto in_vain = [&](std::size_t a) {
      const double promise = layer_[i].reward + worker.actions[a].reward + worker.rests[a];
      return bounded && promise <= least + (last ? 0 : tick);
    };
    worker.against.assign(worker.actions.size(), 0);
    bool asked = false;
    for (std::size_t a = 0; a < worker.actions.size(); ++a) {
      ++worker.generated;
      if (in_vain(a)) {
        ++worker.pruned;
        continue;
      }
      if (!asked) worker.advice->judge(open, worker.actions, worker.against);
      asked = true;
      const ConnectionIndex c = worker.actions[a].connection;
      worker.found.push_back({layer_[i].reward + worker.actions[a].reward, worker.rests[a],
                              layer_[i].against + worker.against[a], layer_[i].hash ^ mixed(c + 1U),
                              static_cast<std::uint32_t>(i), c});
    }
  }
}

// Of the ways to one state the one that earns most; of those the one against which least was said.
void AdvisedPass::merge_equal(std::vector<Candidate>& found) const {
  std::ranges::stable_sort(found, [](const Candidate& a, const Candidate& b) {
    if (a.hash != b.hash) return a.hash < b.hash;
    if (a.reward != b.reward) return a.reward > b.reward;
    return a.against < b.against;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    bool known = false;
    for (std::size_t k = kept; k-- > 0 && found[k].hash == found[i].hash && !known;) {
      known = same_state(found[k], found[i]);
      if (known) found[k].against = std::min(found[k].against, found[i].against);
    }
    if (!known) found[kept++] = found[i];
  }
  found.resize(kept);
}

// Expands the layer. Returns the successors, each state once.
std::vector<AdvisedPass::Candidate> AdvisedPass::successors(double tick, const Budget& budget,
                                                            Result& result) {
  const bool bounded = workers_.front()->bound->known();
  const std::size_t used = layer_.size() < 4 * workers_.size() ? 1 : workers_.size();
  const double least = result.has_plan() ? result.reward : -kInfinity;
  run_parallel(used, [&](std::size_t t) {
    const Share share = share_of(layer_.size(), used, t);
    expand(*workers_[t], share.begin, share.end, least, tick, bounded, budget);
  });
  std::vector<Candidate> found;
  for (std::size_t t = 0; t < used; ++t) {
    Worker& worker = *workers_[t];
    result.statistics.expanded += std::exchange(worker.expanded, 0);
    result.statistics.generated += std::exchange(worker.generated, 0);
    result.statistics.pruned += std::exchange(worker.pruned, 0);
    if (result.stop == Stop::None) result.stop = worker.stop;
    found.insert(found.end(), worker.found.begin(), worker.found.end());
    worker.found.clear();
  }
  if (result.stop == Stop::None)
    result.stop = budget.expired(found.capacity() * sizeof(Candidate), result.statistics.expanded);
  merge_equal(found);
  return found;
}

// Makes the next layer of those of `found` against which least was said. Returns the greatest
// promise of the others.
double AdvisedPass::go_on(std::vector<Candidate>& found, std::size_t width,
                          std::vector<Taken>& ways) {
  std::ranges::sort(found, [](const Candidate& a, const Candidate& b) {
    if (a.against != b.against) return a.against < b.against;
    if (a.reward + a.rest != b.reward + b.rest) return a.reward + a.rest > b.reward + b.rest;
    if (a.hash != b.hash) return a.hash < b.hash;
    return std::pair(a.parent, a.connection) < std::pair(b.parent, b.connection);
  });
  const bool bounded = workers_.front()->bound->known();
  double left_out = -kInfinity;
  for (std::size_t i = width; i < found.size(); ++i)
    left_out = std::max(left_out, bounded ? found[i].reward + found[i].rest : kInfinity);
  found.resize(std::min(found.size(), width));
  std::vector<std::uint64_t> states;
  std::vector<State> layer;
  for (const Candidate& c : found) {
    const SetView parent = state_of(c.parent);
    states.insert(states.end(), parent.begin(), parent.end());
    std::uint64_t* const words = states.data() + states.size() - words_;
    words[c.connection / 64] &= ~(std::uint64_t{1} << (c.connection % 64));
    layer.push_back({c.reward, c.rest, c.against, c.hash});
    ways.push_back({c.parent, c.connection});
  }
  states_.swap(states);
  layer_.swap(layer);
  return left_out;
}

double AdvisedPass::run(std::size_t width, double tick, const Budget& budget, Result& result) {
  Bound& bound = *workers_.front()->bound;
  const ConnectionSet start = system_.start();
  states_.assign(start.view().begin(), start.view().end());
  layer_.assign(1, {0, bound.known() ? bound(start.view()) : 0, 0, 0});
  double left_out = -kInfinity;
  std::vector<std::vector<Taken>> taken;  // by layer: how each of its states was reached
  for (std::size_t k = 0; k < system_.num_steps() && !layer_.empty(); ++k) {
    std::vector<Candidate> found = successors(tick, budget, result);
    if (result.stop != Stop::None) return left_out;
    left_out = std::max(left_out, go_on(found, width, taken.emplace_back()));
  }
  if (layer_.empty() || (result.has_plan() && layer_.front().reward <= result.reward))
    return left_out;
  result.reward = layer_.front().reward;
  result.status = Status::Feasible;
  result.sequence.assign(taken.size(), 0);
  std::size_t at = 0;
  for (std::size_t k = taken.size(); k-- > 0;) {
    result.sequence[k] = taken[k][at].connection;
    at = taken[k][at].parent;
  }
  return left_out;
}

}  // namespace orasp::detail
