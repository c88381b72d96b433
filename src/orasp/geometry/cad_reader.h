#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "orasp/geometry/cad_model.h"
#include "orasp/task/budget.h"

namespace orasp {

/// How a model file is read.
struct CadReadSettings {
  std::optional<double> tolerance;  ///< mm; nothing: default_tolerance() of the model's diagonal
  /// What one unit of the file is; nothing: what the file says, or what is usual for its format.
  std::optional<double> millimetres_per_unit;
  bool solids = false;   ///< every solid is a part, even where a product holds several
  unsigned threads = 1;  ///< the answer is the same for any number
  std::stop_token stop;  ///< a stopped reader throws Interrupted
  std::function<void(const Progress&)> progress;  ///< told which phase begins; may be empty
};

/// The tolerance for a model of this size, mm: 0.1 between 20 mm and 2 m, else in proportion, as
/// one digit.
[[nodiscard]] inline double default_tolerance(double diagonal) {
  constexpr double kUsual = 0.1;
  constexpr double kSmall = 20;    // mm: below, the tolerance shrinks with the model
  constexpr double kLarge = 2000;  // mm: above, it grows with it
  if (!(diagonal > 0)) return kUsual;
  double tolerance = kUsual;
  if (diagonal < kSmall) tolerance = kUsual * diagonal / kSmall;
  if (diagonal > kLarge) tolerance = kUsual * diagonal / kLarge;
  const double step = std::pow(10.0, std::floor(std::log10(tolerance) + 1e-9));
  return std::max(1.0, std::round(tolerance / step)) * step;
}

/// Reads STEP files (AP203, AP214, AP242): products with their names, placements, units, colours,
/// materials and densities, and files that they refer to.
///
/// A leaf of the product tree is a part, whatever number of solids it holds; where the file is a
/// single leaf, or CadReadSettings::solids asks for it, each solid is one. Products used several
/// times are meshed once, with half the tolerance and 0.3 rad; volumes are the kernel's.
///
/// Lives in a module of its own with OpenCASCADE, loaded when the first file is read: linked in, it
/// would take 0.1 s at every start of the program.
class CadReader {
 public:
  CadReader() = default;
  CadReader(const CadReader&) = delete;
  CadReader& operator=(const CadReader&) = delete;
  virtual ~CadReader() = default;
  /// @throws InputError with one sentence that names the file; Interrupted.
  [[nodiscard]] virtual CadModel read(const std::filesystem::path& file,
                                      const CadReadSettings& settings) = 0;
};

/// Why STEP files cannot be read here, a clause that goes on from "import"; empty where they can.
[[nodiscard]] std::optional<std::string> cad_reader_obstacle();
/// @throws InputError if the module is missing or cannot be loaded, with how to get it.
[[nodiscard]] std::unique_ptr<CadReader> make_cad_reader();

}  // namespace orasp
