#pragma once

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// Tables as CSV (RFC 4180, line feeds alone): a line of titles, then a line for each part, each
/// connection, each step of a plan. Numbers of the user's own have a column each, `number:NAME`, as
/// have attributes, `attribute:NAME`. Lists stand in one cell with ';' between ids.
/// Of a problem, tables hold parts and connections and nothing else; the notes name what is left
/// out. @throws InputError where an id in a list holds a ';'.
[[nodiscard]] Written write_parts_csv(const WriteRequest& request);
[[nodiscard]] Written write_connections_csv(const WriteRequest& request);
[[nodiscard]] Written write_steps_csv(const WriteRequest& request);

}  // namespace orasp
