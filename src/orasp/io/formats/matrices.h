#pragma once

#include <string_view>

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// Matrices of contact and interference as CSV, one below the other. A matrix begins with a line of
/// its name ("contact", or a direction, "+x" to "-z") and the ids of the parts; a line for each
/// part follows: its id, then 0 or 1 for each. Contact is symmetric: 1 is a connection.
/// In the matrix of a direction, 1 in the line of i and the column of j says that i cannot move
/// along it, for j stands in the way. Where only one direction of an axis has a matrix, the other
/// is its transpose, and where both have one they are put together.
/// Reference. Dini and Santochi (1992), Automated sequencing and subassembly detection in assembly
/// planning, CIRP Annals 41(1), 1-4: contact and interference matrices.
/// @throws InputError with the line of the first fault.
[[nodiscard]] Converted read_matrices(std::string_view text);

}  // namespace orasp
