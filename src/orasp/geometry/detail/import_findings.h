#pragma once

#include "orasp/geometry/assembly_from_cad.h"

namespace orasp::detail {

/// Sets `groups`: the parts that connections join, each group sorted, the largest first.
void find_groups(ImportedAssembly& assembly);

/// Adds what else is noteworthy of an import: overlaps, locked pairs, facts near the tolerance,
/// warnings and questions.
void add_findings(ImportedAssembly& assembly, const ImportSettings& settings);

}  // namespace orasp::detail
