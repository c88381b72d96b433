#include "orasp/model/objectives/cubesat_zone.h"

#include <algorithm>
#include <memory>

#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

constexpr double kFromDepot = 0.0967;
constexpr double kFromZone = 0.0823;

double zone_cost(std::size_t parts, std::size_t piece_parts, bool whole_start) {
  switch (parts) {
    case 1: return piece_parts >= 4 || whole_start ? kFromDepot : kFromZone;
    case 2: return 0.0722;
    case 3: return 0.0782;
    default: return 0;
  }
}

class CubesatZoneTerm : public ObjectiveTerm {
 public:
  explicit CubesatZoneTerm(const detail::ProblemTotals& totals)
      : problem_(totals.problem), graph_(totals.graph) {
    sees.sizes_only = sees.counting = sees.piece_only = sees.starting_pieces = true;
    // The cost of a part alone depends on whether its piece is a whole starting piece only where
    // that piece has two or three parts.
    sees.gain_by_sizes = true;
    for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
      const std::size_t piece_size = graph_.starting_piece(part);
      if (piece_size == 2 || piece_size == 3) sees.gain_by_sizes = false;
    }
  }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    static_cast<void>(movement);
    const PartIndex part = problem_.ends(facts.connection)[0];
    const std::size_t parts = facts.a_parts + facts.b_parts;
    const bool whole = parts == graph_.starting_piece(part);
    if (!pieces.rest_sizes.empty() && !facts.completes) {
      double spent = zone_cost(facts.a_parts, parts, whole);
      for (const std::uint32_t rest : pieces.rest_sizes) spent += zone_cost(rest, parts, whole);
      return 0.0 - spent;
    }
    return size_reward(facts.a_parts, facts.b_parts, facts.completes, whole);
  }
  [[nodiscard]] double size_reward(std::size_t a, std::size_t b, bool completes,
                                   bool whole_start) const override {
    if (completes) return 1;
    if (a == 0) return 0;
    return 0.0 - (zone_cost(a, a + b, whole_start) + zone_cost(b, a + b, whole_start));
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    return question.completes ? RewardRange{1, 1} : RewardRange{-2 * kFromDepot, 0};
  }
  [[nodiscard]] double greatest_gain(double weight, std::size_t moved,
                                     std::size_t kept) const override {
    return std::max(weight * size_reward(moved, kept, false, false),
                    weight * size_reward(moved, kept, false, true));
  }
  [[nodiscard]] double greatest_gain_unmoved(double weight, std::size_t first,
                                             std::size_t second) const override {
    return greatest_gain(weight, first, second);
  }

 private:
  const Problem& problem_;
  const detail::AssemblyGraph& graph_;
};

class CubesatZoneKind : public ObjectiveKindOf<CubesatZone> {
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const CubesatZone& parameters, const detail::ProblemTotals& totals) const override {
    static_cast<void>(parameters);
    return std::make_unique<CubesatZoneTerm>(totals);
  }
  [[nodiscard]] detail::CheckedTerm checked(const CubesatZone& parameters,
                                            const detail::CheckedProblem& problem) const override {
    static_cast<void>(parameters);
    detail::CheckedTerm term;
    term.value = [&problem](const detail::SeenStep& step) -> detail::CheckedValue {
      if (step.completes) return {1};
      if (!step.separates) return {0};
      const std::size_t parts = step.a_parts + step.b_parts;
      const PartIndex part = problem.problem().ends(step.connection)[0];
      const bool from_zone = parts < 4 && problem.starting_piece(part) != parts;
      const auto cost = [&](std::size_t size) {
        if (size == 1) return from_zone ? 0.0823 : 0.0967;
        if (size == 2) return 0.0722;
        return size == 3 ? 0.0782 : 0.0;
      };
      double spent = 0;
      for (const std::size_t size : step.pieces()) spent += cost(size);
      return {0.0 - spent};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& cubesat_zone_kind() {
  static const CubesatZoneKind kind;
  return kind;
}

}  // namespace orasp
