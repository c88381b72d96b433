#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/problem.h"

namespace orasp {

struct ScenarioInfo {
  std::string name;     ///< "hubble", or the form of a generator: "grid:RxC"
  std::string summary;  ///< one line
  bool generator = false;
};

/// The built-in problems, then the generators.
[[nodiscard]] std::vector<ScenarioInfo> scenarios();

/// A built-in problem or a generated one: "hubble", "chain:50", "grid:5x5", "tree:500:7"
/// (parts:seed), "random:50:80:3" (parts:connections:seed). @throws InputError that names the
/// scenarios, or the form of the generator that was begun.
[[nodiscard]] Problem load_scenario(std::string_view name);

/// Whether `name` is one of scenarios() or has the form of a generator ("chain:..."), right or
/// wrong.
[[nodiscard]] bool is_scenario(std::string_view name);

}  // namespace orasp
