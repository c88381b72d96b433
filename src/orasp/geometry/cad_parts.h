#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orasp/geometry/cad_model.h"

namespace orasp {

/// Where the density of a part comes from.
enum class DensitySource {
  File,     ///< the model states it
  Given,    ///< the user does
  Name,     ///< the name of the part or of its material tells it: a screw is of steel
  Default,  ///< nothing is known
};

/// A part of a model as a problem will have it.
struct CadPartFacts {
  std::string id;         ///< its name, made unique: "bolt", "bolt 2"
  std::string name;       ///< in the file, without a number; "part 3" where it has none
  std::size_t equal = 0;  ///< position of the first part of the same product and shape; its own
  double volume = 0;      ///< mm^3
  double density = 0;     ///< kg/m^3
  DensitySource source = DensitySource::Default;
  std::string material;  ///< what stands behind the density: "Steel"
  double mass = 0;       ///< kg
  Vector3 centroid{};    ///< mm
  Box box;               ///< mm
  bool closed = true;    ///< its surface has no hole
  std::size_t triangles = 0;
};

/// What the user says of densities, kg/m^3: of all parts that nothing is known of, and of some.
struct Densities {
  std::optional<double> others;
  std::vector<std::pair<std::string, double>> by_part;  ///< words of parts_called()
};

/// Facts of all parts, in their order. Names are trimmed and made valid ids.
/// @throws InputError where a density is given for a part that is not there.
[[nodiscard]] std::vector<CadPartFacts> part_facts(std::span<const CadPart> parts,
                                                   const Densities& densities);

/// By part: whether another part is equal to it.
[[nodiscard]] std::vector<bool> parts_with_equals(std::span<const CadPartFacts> parts);

/// The parts that `word` means: the one with this id, or all of this name or product; `*` stands
/// for any text. Ascending.
[[nodiscard]] std::vector<std::size_t> parts_called(std::string_view word,
                                                    std::span<const CadPartFacts> parts);

/// The parts that a list such as "belt,M3*" means: the text as a whole, else what stands between
/// its commas. Ascending, each once.
/// @throws InputError where a word means none; `what` says what the list is of: "exclude".
[[nodiscard]] std::vector<std::size_t> parts_listed(const std::string& list,
                                                    std::span<const CadPartFacts> parts,
                                                    const std::string& what);

}  // namespace orasp
