#include "orasp/planners/detail/grounded_outlook.h"

#include <algorithm>

#include "orasp/model/detail/rules.h"

namespace orasp::detail {

GroundedOutlook::GroundedOutlook(const TransitionSystem& system)
    : system_(system),
      applies_(system.rules().by_part && system.rules().grounded && system.takes_apart() &&
               !system.rules().has_goal && system.rules().num_kept == 0 &&
               system.rules().blocking && system.problem().spec().base.size() == 1) {
  if (!applies_) return;
  const Problem& problem = system.problem();
  while (!problem.in_base(base_)) ++base_;
  const std::size_t parts = problem.num_parts();
  there_.resize(parts);
  number_.resize(parts);
  low_.resize(parts);
  holder_.resize(parts);
  hanging_.resize(parts);
}

bool GroundedOutlook::is_shut(SetView open) {
  find_holders(open);
  // The deepest first: much comes off in the first round.
  std::size_t left = visited_.size() - 1;
  for (bool some = true; some && left > 0;) {
    some = false;
    for (std::size_t i = visited_.size(); i-- > 1;) {
      const PartIndex part = visited_[i];
      if (there_[part] == 0 || hanging_[part] != 0 || !leaves(part)) continue;
      there_[part] = 0;
      --hanging_[holder_[part]];
      --left;
      some = true;
    }
  }
  return left > 0;
}

// Whether some direction is free of all that is there.
bool GroundedOutlook::leaves(PartIndex part) {
  const Problem& problem = system_.problem();
  const auto all = problem.direction_bits();
  free_.assign(all.begin(), all.end());
  return std::ranges::all_of(problem.blockers()[part], [&](const Blocker& blocker) {
    return there_[blocker.by] == 0 || problem.take_out(blocker, free_);
  });
}

// Goes through all that hangs on the base, depth first.
void GroundedOutlook::find_holders(SetView open) {
  const AssemblyGraph& graph = system_.rules().graph;
  std::ranges::fill(there_, static_cast<unsigned char>(0));
  std::ranges::fill(number_, 0U);
  std::ranges::fill(hanging_, 0U);
  visited_.assign(1, base_);
  visits_.assign(1, {base_, base_, 0});
  number_[base_] = low_[base_] = 1;
  there_[base_] = 1;
  while (!visits_.empty()) {
    Visit& visit = visits_.back();
    const PartIndex part = visit.part;
    const auto around = graph.around(part);
    if (visit.next < around.size()) {
      const auto& half = around[visit.next++];
      if (half.other == visit.from || !contains(open, half.connection)) continue;
      if (number_[half.other] != 0) {
        low_[part] = std::min(low_[part], number_[half.other]);
        continue;
      }
      visited_.push_back(half.other);
      number_[half.other] = low_[half.other] = static_cast<std::uint32_t>(visited_.size());
      there_[half.other] = 1;
      visits_.push_back({half.other, part, 0});
      continue;
    }
    holder_[part] = visit.from;  // the part above, until that is known
    visits_.pop_back();
    if (!visits_.empty())
      low_[visits_.back().part] = std::min(low_[visits_.back().part], low_[part]);
  }
  // From above to below: it hangs on the part above, or on what that hangs on.
  for (std::size_t i = 1; i < visited_.size(); ++i) {
    const PartIndex part = visited_[i];
    const PartIndex above = holder_[part];
    if (low_[part] < number_[above]) holder_[part] = holder_[above];
    ++hanging_[holder_[part]];
  }
}

}  // namespace orasp::detail
