#pragma once

#include <nlohmann/json_fwd.hpp>

#include "cli/paper/paper.h"
#include "orasp/drawing/document.h"

namespace orasp::cli {

/// The page of the paper's numbers, ours beside the printed ones, with its figures. Draws them:
/// @throws InputError if Graphviz or gnuplot is missing.
[[nodiscard]] Document paper_page(const Paper& paper);

/// The same numbers for programs: format orasp-paper/1.
[[nodiscard]] nlohmann::ordered_json paper_json(const Paper& paper);

}  // namespace orasp::cli
