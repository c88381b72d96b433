#include "orasp/bounds/bound_kinds.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "orasp/bounds/connection_bound.h"
#include "orasp/bounds/piece_bound.h"
#include "orasp/bounds/place_bound.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/objectives/objective_kind.h"
#include "orasp/model/tolerance.h"

namespace orasp {

namespace {

/// The bound of the paper, under which no step earns more than 0; here the step that completes may.
class ZeroBound final : public Bound {
 public:
  explicit ZeroBound(const TransitionSystem& system)
      : completes_first_(system.completes_first()), num_steps_(system.num_steps()) {
    const std::size_t connections = system.num_connections();
    for (ConnectionIndex c = 0; c < connections; ++c) {
      known_ = known_ && system.reward_range(c, connections, false).greatest <= 0;
      last_ = std::max(last_, system.reward_range(c, connections, true).greatest);
    }
    known_ = known_ && std::isfinite(last_);
  }
  [[nodiscard]] bool known() const override { return known_; }
  [[nodiscard]] double operator()(SetView open) override {
    if (!known_) return kInfinity;
    const std::size_t left = count(open);
    return left == 0 || (completes_first_ && left < num_steps_) ? 0 : last_;
  }
  void of_successors(SetView open, double here, std::span<const Action>,
                     std::span<double> bounds) override {
    std::ranges::fill(bounds, completes_first_ || count(open) == 1 ? 0 : here);
  }

 private:
  bool known_ = true;
  bool completes_first_;
  std::size_t num_steps_;
  double last_ = 0;
};

/// The terms of an objective that see the piece only; nothing where it has none.
std::optional<Objective> of_pieces(const Objective& objective,
                                   const detail::ProblemTotals& totals) {
  if (const auto* const sum = std::get_if<WeightedSum>(&objective.parameters)) {
    WeightedSum kept;
    for (const WeightedObjective& term : sum->terms) {
      if (auto part = of_pieces(term.objective, totals))
        kept.terms.push_back({term.weight, std::move(*part)});
    }
    if (kept.terms.empty()) return std::nullopt;
    return Objective{objective.type, std::move(kept)};
  }
  std::vector<WeightedTerm> terms;
  kind_of(objective).add_terms(objective.parameters, 1, totals, terms);
  const bool pieces_only = std::ranges::all_of(
      terms, [](const WeightedTerm& addend) { return addend.term->sees.piece_only; });
  return pieces_only ? std::optional(objective) : std::nullopt;
}

/// The bound of an objective that is a sum: of what sees the piece only by PieceBound, of the rest
/// by PlaceBound. Each is admissible and consistent for its terms, so their sum is for all.
class SumBound final : public Bound {
 public:
  /// What the bounds of all threads share: the problem without the other terms, and prices.
  struct Shared {
    Shared(const TransitionSystem& system, Objective objective)
        : problem(system.problem().with_objective(std::move(objective))),
          forwards(problem, system.situation()) {
      if (system.completes_first()) backwards.reset(new TransitionSystem(forwards.backwards()));
    }
    [[nodiscard]] const TransitionSystem& system() const {
      return backwards ? *backwards : forwards;
    }
    Problem problem;
    TransitionSystem forwards;
    std::unique_ptr<const TransitionSystem> backwards;
    std::shared_ptr<const PlacePrices> prices;
  };

  SumBound(const TransitionSystem& system, std::shared_ptr<Shared> shared)
      : shared_(std::move(shared)), pieces_(shared_->system(), PieceBound::Kind::Both) {
    if (!pieces_.known()) return;
    if (!shared_->prices)
      shared_->prices =
          std::make_shared<const PlacePrices>(system, PlacePrices::Terms::NotOfPiecesAlone);
    places_ = std::make_unique<PlaceBound>(system, shared_->prices);
    most_of_start_ = pieces_(shared_->system().start().view()) + shared_->prices->most_of_start();
  }
  [[nodiscard]] bool known() const override { return places_ && places_->known(); }
  [[nodiscard]] double operator()(SetView open) override {
    return known() ? pieces_(open) + (*places_)(open) : kInfinity;
  }
  void of_successors(SetView open, double here, std::span<const Action> actions,
                     std::span<double> bounds) override {
    if (!known()) return Bound::of_successors(open, here, actions, bounds);
    rest_.resize(actions.size());
    places_->of_successors(open, here, actions, rest_);
    pieces_.of_successors(open, pieces_(open), actions, bounds);
    for (std::size_t i = 0; i < actions.size(); ++i) bounds[i] += rest_[i];
  }
  [[nodiscard]] const std::shared_ptr<Shared>& shared() const { return shared_; }
  [[nodiscard]] double most_of_start() const { return most_of_start_; }

 private:
  std::shared_ptr<Shared> shared_;
  PieceBound pieces_;
  std::unique_ptr<PlaceBound> places_;
  double most_of_start_ = kInfinity;
  std::vector<double> rest_;
};

/// Whether what some step earns depends on when it comes, and something is known of that: of a
/// function of many steps there is nothing but its range.
bool sees_when(const TransitionSystem& system) {
  return std::ranges::any_of(system.rules().terms, [](const WeightedTerm& addend) {
    const TermSight& sees = addend.term->sees;
    return addend.weight != 0 &&
           (sees.by_place || (sees.elapsed && !addend.term->can_take_notes()));
  });
}

std::unique_ptr<Bound> best_bound(const TransitionSystem& system, const Bound* like) {
  if (const auto* const sum = dynamic_cast<const SumBound*>(like))
    return std::make_unique<SumBound>(system, sum->shared());
  if (const auto* const places = dynamic_cast<const PlaceBound*>(like))
    return std::make_unique<PlaceBound>(system, places->prices());
  auto pieces = std::make_unique<PieceBound>(system, PieceBound::Kind::Both,
                                             dynamic_cast<const PieceBound*>(like));
  if (pieces->known()) return pieces;
  const bool by_when = sees_when(system);
  if (by_when && system.takes_apart()) {
    const Objective& objective = system.problem().objective();
    if (auto part = of_pieces(objective, system.rules().totals)) {
      auto sum = std::make_unique<SumBound>(
          system, std::make_shared<SumBound::Shared>(system, std::move(*part)));
      if (sum->known()) return sum;
    }
  }
  auto connections = std::make_unique<ConnectionBound>(system);
  if (connections->known() && !by_when) return connections;
  auto places = std::make_unique<PlaceBound>(system, PlacePrices::Terms::All);
  if (places->known()) return places;
  return connections;
}

}  // namespace

BoundKind bound_called(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kBoundNames.size(); ++i) {
    if (kBoundNames[i] == name) return static_cast<BoundKind>(i);
    known += (known.empty() ? "" : ", ") + std::string(kBoundNames[i]);
  }
  throw InputError("unknown bound '" + std::string(name) + "'; known: " + known);
}

std::unique_ptr<Bound> make_bound(const TransitionSystem& system, BoundKind kind,
                                  const Bound* like) {
  const auto* const pieces = dynamic_cast<const PieceBound*>(like);
  switch (kind) {
    case BoundKind::None: return std::make_unique<ZeroBound>(system);
    case BoundKind::Connections: return std::make_unique<ConnectionBound>(system);
    case BoundKind::Sizes:
      return std::make_unique<PieceBound>(system, PieceBound::Kind::Sizes, pieces);
    case BoundKind::Parts:
      return std::make_unique<PieceBound>(system, PieceBound::Kind::Parts, pieces);
    case BoundKind::Best: break;
  }
  return best_bound(system, like);
}

StartByPlaces start_by_places(const Bound& bound) {
  if (const auto* const places = dynamic_cast<const PlaceBound*>(&bound);
      places != nullptr && places->known())
    return {places->prices()->most_of_start(), places->prices()};
  if (const auto* const sum = dynamic_cast<const SumBound*>(&bound); sum != nullptr && sum->known())
    return {sum->most_of_start(), sum->shared()->prices};
  return {kInfinity};
}

}  // namespace orasp
