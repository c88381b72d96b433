#pragma once

#include <span>

#include "orasp/io/embedded_scenarios.h"

namespace orasp::detail {

/// The files of web/dist, compiled into the library by cmake/embed.cmake: the page of `orasp
/// report` ("report": its HTML with places to fill in, "report.css", "report.js", "report-3d.js").
[[nodiscard]] std::span<const EmbeddedFile> embedded_page();

}  // namespace orasp::detail
