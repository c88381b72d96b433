#include "orasp/cluster/cluster_beam.h"

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "orasp/model/error.h"
#include "orasp/planners/detail/crew.h"

namespace orasp {

namespace {

/// What another rank threw.
class FaultElsewhere : public InputError {
 public:
  using InputError::InputError;
};

/// Each text begins with '+', or with '-' and says why its rank goes on no further.
class RankCrew final : public detail::Crew {
 public:
  explicit RankCrew(Ranks& ranks) : ranks_(ranks) {}
  [[nodiscard]] std::size_t size() const override { return ranks_.size(); }
  [[nodiscard]] std::size_t member() const override { return ranks_.rank(); }
  [[nodiscard]] std::vector<std::string> told_by_all(const std::string& mine) override {
    std::vector<std::string> told = ranks_.gather_everywhere('+' + mine);
    for (std::string& text : told) {
      if (text.front() == '-') throw FaultElsewhere(text.substr(1));
      text.erase(0, 1);
    }
    return told;
  }
  [[nodiscard]] std::vector<std::string> exchange(std::vector<std::string> texts) override {
    return ranks_.exchange(std::move(texts));
  }
  void take_sums(std::span<std::uint64_t> numbers) override { ranks_.take_sums(numbers); }
  void take_greatest(std::span<double> numbers) override { ranks_.take_greatest(numbers); }

 private:
  Ranks& ranks_;
};

}  // namespace

Result cluster_beam(const TransitionSystem& system, BeamOptions options, const Budget& budget,
                    Ranks& ranks) {
  if (system.wide() || system.problem().uncertain())
    throw Refusal("beam",
                  "does its work in one process where there is a goal, a cost between steps or an "
                  "attempt that may fail");
  RankCrew crew(ranks);
  options.crew = &crew;
  const std::uint64_t sent_before = ranks.bytes_sent();
  // The module for symmetry may be missing on one machine only.
  const auto obstacle = symmetry_obstacle(system, options.symmetry);
  for (const std::string& told : ranks.gather_everywhere(obstacle.value_or(std::string()))) {
    if (!told.empty()) throw Refusal("beam", told);
  }
  Result result;
  try {
    result = beam(system, options, budget);
  } catch (const FaultElsewhere&) {
    throw;
  } catch (const InputError& error) {
    // The others wait to be told what this rank found; they throw the same.
    static_cast<void>(ranks.gather_everywhere(std::string("-") + error.what()));
    throw;
  }
  std::vector<std::uint64_t> sent = {ranks.bytes_sent() - sent_before};
  ranks.take_sums(sent);
  result.notes.push_back("the layers lay on " + std::to_string(ranks.size()) + " ranks, with " +
                         std::to_string(result.statistics.peak_bytes) + " bytes on the fullest; " +
                         std::to_string(sent[0]) +
                         " bytes of what they found were sent between them");
  return result;
}

}  // namespace orasp
