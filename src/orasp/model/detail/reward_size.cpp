#include "orasp/model/detail/reward_size.h"

#include <cmath>

#include "orasp/model/detail/wording.h"

namespace orasp::detail {

std::string unfit_reward_text(double reward) {
  if (std::isnan(reward)) return "not a number; rewards must be finite";
  if (std::isinf(reward)) return "infinite; rewards must be finite";
  return number_text(reward) + "; sums of rewards must be finite";
}

}  // namespace orasp::detail
