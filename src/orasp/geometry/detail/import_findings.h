#pragma once

#include "orasp/geometry/assembly_from_cad.h"

namespace orasp::detail {

/// Adds what is noteworthy of an import: overlaps, locked pairs, facts near the tolerance, groups,
/// warnings and questions.
void add_findings(ImportedAssembly& assembly, const ImportSettings& settings);

}  // namespace orasp::detail
