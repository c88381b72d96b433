#pragma once

#include <filesystem>
#include <string>

#include "orasp/mip/mip_model.h"

namespace orasp {

/// An integer program in the LP format of CPLEX, which CBC, HiGHS, Gurobi, SCIP and GLPK read too.
/// Numbers are written so that they read back exactly. The constant of the objective is a column
/// `constant` fixed to 1; a column that occurs nowhere is listed with a 0. Remarks are comments,
/// with what is no printable ASCII character as '?'.
[[nodiscard]] std::string lp_text(const MipModel& model);

/// The same in free MPS format, names without spaces, which every solver reads.
[[nodiscard]] std::string mps_text(const MipModel& model);

/// Writes it as the name ends: .lp or .mps. The file is written whole or not at all.
/// @throws InputError for another ending (before anything is done: require_model_file), or where it
/// cannot be written.
void write_model(const MipModel& model, const std::filesystem::path& file);
void require_model_file(const std::filesystem::path& file);

}  // namespace orasp
