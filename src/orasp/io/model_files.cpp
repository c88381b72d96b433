#include "orasp/io/model_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "orasp/geometry/contacts.h"
#include "orasp/geometry/detail/plain_text.h"
#include "orasp/geometry/mesh_reader.h"
#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/json_members.h"
#include "orasp/model/detail/vector_math.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

namespace fs = std::filesystem;
using detail::fail;
using detail::JsonDocument;
using detail::JsonKind;
using detail::JsonValue;
using detail::Members;
using detail::Place;

// -------------------------------------------------------------------------------------------------
// poses

Vector3 row_times(const std::array<Vector3, 3>& rows, std::size_t column) {
  return {rows[0][column], rows[1][column], rows[2][column]};
}

/// Turns about the fixed x, then y, then z.
std::array<Vector3, 3> turned_by(const Vector3& angles) {
  const double cx = std::cos(angles[0]);
  const double sx = std::sin(angles[0]);
  const double cy = std::cos(angles[1]);
  const double sy = std::sin(angles[1]);
  const double cz = std::cos(angles[2]);
  const double sz = std::sin(angles[2]);
  const std::array<Vector3, 3> rows = {{{cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx},
                                        {sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx},
                                        {-sy, cy * sx, cy * cx}}};
  return {row_times(rows, 0), row_times(rows, 1), row_times(rows, 2)};
}

std::array<Vector3, 3> axes_of_quaternion(std::array<double, 4> q, const Place& place) {
  const double length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (!(length > 0)) fail(place, "a quaternion of length 0 is no turn");
  for (double& number : q) number /= length;
  const auto [w, x, y, z] = q;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
           {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
           {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}}};
}

std::array<Vector3, 3> axes_of_rows(const std::vector<Vector3>& rows, const Place& place) {
  if (rows.size() != 3) fail(place, fmt::format("expected three rows, found {}", rows.size()));
  const std::array<Vector3, 3> axes = {row_times({rows[0], rows[1], rows[2]}, 0),
                                       row_times({rows[0], rows[1], rows[2]}, 1),
                                       row_times({rows[0], rows[1], rows[2]}, 2)};
  constexpr double kSame = 1e-4;
  bool is_turn = detail::dot(detail::cross(axes[0], axes[1]), axes[2]) > 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j <= i; ++j)
      is_turn = is_turn && std::abs(detail::dot(axes[i], axes[j]) - (i == j ? 1 : 0)) < kSame;
  }
  if (!is_turn) fail(place, "the matrix is not a turn: its rows are not of length 1 and upright");
  return axes;
}

Placement read_pose(JsonValue value, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>(
      {"position", "quaternion", "euler", "matrix", "final_state", "initial_state"});
  const Members members(value, place, kKeys);
  Placement pose;
  int turns = 0;
  if (const auto state = members.find("final_state")) {
    const std::array<double, 6> numbers =
        detail::read_point<6>(*state, Place(place, "final_state"));
    pose.origin = {numbers[0], numbers[1], numbers[2]};
    pose.axes = turned_by({numbers[3], numbers[4], numbers[5]});
    return pose;
  }
  members.read("position", pose.origin, detail::read_point<3>);
  members.read("quaternion", pose.axes, [&](JsonValue numbers, const Place& at) {
    ++turns;
    return axes_of_quaternion(detail::read_point<4>(numbers, at), at);
  });
  members.read("euler", pose.axes, [&](JsonValue numbers, const Place& at) {
    ++turns;
    return turned_by(detail::read_point<3>(numbers, at));
  });
  members.read("matrix", pose.axes, [&](JsonValue rows, const Place& at) {
    ++turns;
    return axes_of_rows(
        detail::read_array(rows, at, "an array of three rows", detail::read_point<3>), at);
  });
  if (turns > 1) fail(place, R"("quaternion", "euler" and "matrix" exclude each other)");
  return pose;
}

std::string file_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::error_code error;
  if (!stream || fs::is_directory(file, error))
    throw InputError(file.string() + ": it cannot be opened");
  // Read in pieces: of a pipe no size is known before.
  std::string text;
  std::string piece(std::size_t{1} << 16U, '\0');
  while (stream.read(piece.data(), static_cast<std::streamsize>(piece.size())),
         stream.gcount() > 0) {
    text.append(piece, 0, static_cast<std::size_t>(stream.gcount()));
    if (text.size() > detail::kMaxJsonBytes)
      throw InputError(file.string() + ": it is larger than 256 MiB");
  }
  return text;
}

void place_part(CadPart& part, Placement pose, double scale) {
  for (double& number : pose.origin) number *= scale;
  for (Vector3& vertex : part.mesh.vertices) vertex = pose.placed(vertex);
  for (FaceHint& hint : part.faces) {
    hint.point = pose.placed(hint.point);
    hint.direction = pose.turned(hint.direction);
  }
  if (part.centroid) part.centroid = pose.placed(*part.centroid);
  if (!part.placement) return;
  Placement both;
  for (std::size_t i = 0; i < 3; ++i) both.axes[i] = pose.turned(part.placement->axes[i]);
  both.origin = pose.placed(part.placement->origin);
  part.placement = both;
}

// -------------------------------------------------------------------------------------------------
// files

std::string lower_extension(const fs::path& file) {
  return detail::lower(file.extension().string());
}

bool is_step(const fs::path& file) {
  static const std::set<std::string> kEndings = {".step", ".stp", ".p21"};
  return kEndings.contains(lower_extension(file));
}

bool is_mesh(const fs::path& file) {
  return std::ranges::find(kMeshEndings, lower_extension(file)) != kMeshEndings.end();
}

/// Digits compare by their value: "2" before "10".
bool natural_less(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (!digit(a[i]) || !digit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
      continue;
    }
    const auto number = [&](const std::string& text, std::size_t& at) {
      while (at < text.size() && text[at] == '0') ++at;
      const std::size_t begin = at;
      while (at < text.size() && digit(text[at])) ++at;
      return text.substr(begin, at - begin);
    };
    const std::string left = number(a, i);
    const std::string right = number(b, j);
    if (left.size() != right.size()) return left.size() < right.size();
    if (left != right) return left < right;
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;
}

std::vector<fs::path> meshes_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (is_mesh(at->path()) && !at->is_directory()) files.push_back(at->path());
  }
  if (error) throw InputError(folder.string() + ": " + error.message());
  if (files.empty()) {
    throw InputError(folder.string() +
                     ": no file in this folder ends in .obj, .stl, .ply, .gltf, .glb or .3mf");
  }
  std::ranges::sort(files, natural_less,
                    [](const fs::path& file) { return file.filename().string(); });
  return files;
}

/// Whether `b` is `a` moved along: the same triangles, all vertices shifted alike. Sets `shift`.
bool is_copy(const Mesh& a, const Mesh& b, double tolerance, Vector3& shift) {
  if (a.vertices.size() != b.vertices.size() || a.triangles != b.triangles) return false;
  for (std::size_t i = 0; i < 3; ++i) shift[i] = b.vertices[0][i] - a.vertices[0][i];
  for (std::size_t v = 0; v < a.vertices.size(); ++v) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (std::abs(b.vertices[v][i] - a.vertices[v][i] - shift[i]) > tolerance) return false;
    }
  }
  return true;
}

/// Files of triangles do not say which parts are equal: those are found that are copies, moved but
/// not turned.
void mark_copies(std::vector<CadPart>& parts, double tolerance) {
  std::map<std::string, std::size_t> uses;
  for (const CadPart& part : parts) ++uses[part.product];
  std::map<std::pair<std::size_t, std::size_t>, std::vector<std::size_t>> by_size;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    CadPart& part = parts[i];
    if (!part.product.empty() && uses[part.product] > 1) continue;
    std::vector<std::size_t>& originals =
        by_size[{part.mesh.vertices.size(), part.mesh.triangles.size()}];
    Vector3 shift{};
    const auto original = std::ranges::find_if(originals, [&](std::size_t other) {
      return is_copy(parts[other].mesh, part.mesh, tolerance, shift);
    });
    if (original == originals.end()) {
      originals.push_back(i);
      part.product = "original " + std::to_string(i);
      part.placement = Placement{};
      continue;
    }
    part.product = parts[*original].product;
    part.placement = Placement{.axes = Placement{}.axes, .origin = shift};
  }
}

/// Reads files one by one into one model.
class ModelBuilder {
 public:
  ModelBuilder(const ModelFiles& files, const CadReadSettings& settings)
      : files_(files), settings_(settings) {}

  CadModel build() {
    std::optional<Poses> poses;
    if (!files_.poses.empty()) poses = read_poses(files_.poses);
    for (const fs::path& model : files_.models) add_model(model);
    std::error_code error;
    if (files_.models.size() > 1 || model_.name.empty() ||
        fs::is_directory(files_.models[0], error)) {
      model_.name = name_of(files_.models[0]);
    }
    if (poses) apply(*poses);
    if (meshes_) finish_meshes();
    return std::move(model_);
  }

 private:
  static std::string name_of(const fs::path& model) {
    const fs::path whole = fs::absolute(model).lexically_normal();
    const fs::path name = whole.has_filename() ? whole : whole.parent_path();
    return name.stem().string();
  }

  void add_model(const fs::path& model) {
    std::error_code error;
    const fs::file_status status = fs::status(model, error);
    if (!fs::exists(status)) throw InputError(model.string() + ": there is no such file or folder");
    if (fs::is_directory(status)) {
      const std::vector<fs::path> meshes = meshes_in(model);
      for (std::size_t i = 0; i < meshes.size(); ++i) {
        if (settings_.progress)
          settings_.progress({.phase = "reading", .done = i, .total = meshes.size()});
        add_mesh(meshes[i], true);
      }
      return;
    }
    if (is_step(model)) {
      if (!cad_) cad_ = make_cad_reader();
      add(cad_->read(model, settings_), model);
    } else if (is_mesh(model)) {
      add_mesh(model, files_.models.size() > 1);
    } else {
      throw InputError(model.string() +
                       ": its name ends in none of .step, .stp, .obj, .stl, .ply, .gltf, .glb and "
                       ".3mf");
    }
  }

  void add_mesh(const fs::path& file, bool whole) {
    if (settings_.stop.stop_requested()) throw Interrupted();
    if (!mesh_) mesh_ = make_mesh_reader();
    meshes_ = true;
    CadReadSettings quiet = settings_;
    quiet.progress = nullptr;
    add(mesh_->read(file, whole, quiet), file);
  }

  void add(CadModel read, const fs::path& file) {
    if (model_.parts.empty()) {
      model_.name = read.name;
      model_.unit = read.unit;
      model_.millimetres_per_unit = read.millimetres_per_unit;
      model_.tolerance = read.tolerance;
    } else {
      model_.tolerance = std::min(model_.tolerance, read.tolerance);
    }
    model_.unit_assumed |= read.unit_assumed;
    const std::string prefix = std::to_string(++read_) + ": ";
    for (CadPart& part : read.parts) {
      if (!part.product.empty()) part.product.insert(0, prefix);
      stems_.push_back(file.stem().string());
      scales_.push_back(read.millimetres_per_unit);
      model_.parts.push_back(std::move(part));
    }
    for (std::string& warning : read.warnings) model_.warnings.push_back(std::move(warning));
  }

  void apply(const Poses& poses) {
    std::set<std::string> used;
    std::size_t without = 0;
    for (std::size_t i = 0; i < model_.parts.size(); ++i) {
      CadPart& part = model_.parts[i];
      auto pose = poses.by_name.find(part.name);
      if (pose == poses.by_name.end()) pose = poses.by_name.find(stems_[i]);
      if (pose == poses.by_name.end()) {
        ++without;
        continue;
      }
      used.insert(pose->first);
      place_part(part, pose->second, scales_[i]);
    }
    for (const auto& [name, pose] : poses.by_name) {
      if (!used.contains(name))
        throw InputError(fmt::format("{}: there is a pose of \"{}\", but no such part",
                                     files_.poses.string(), name));
    }
    if (without > 0) {
      model_.warnings.push_back(
          fmt::format("{} has no pose of {} of the parts; they stay where they are drawn",
                      files_.poses.filename().string(), without));
    }
  }

  /// What meshes leave open: the unit, and the tolerance by the size of the whole.
  void finish_meshes() {
    Box box;
    for (const CadPart& part : model_.parts) {
      for (const Vector3& vertex : part.mesh.vertices) box.add(vertex);
    }
    model_.tolerance = settings_.tolerance.value_or(default_tolerance(box.diagonal()));
    constexpr double kRounding = 0.01;  // of the tolerance
    if (!cad_) mark_copies(model_.parts, kRounding * model_.tolerance);
    if (model_.unit_assumed) {
      model_.warnings.push_back(
          "the mesh files do not say their unit of length: millimetres are assumed; --unit gives "
          "another");
    }
    std::error_code error;
    const fs::path beside = files_.models[0] / "config.json";
    if (files_.poses.empty() && fs::is_directory(files_.models[0], error) &&
        fs::exists(beside, error)) {
      model_.warnings.push_back(
          "a file config.json lies beside the meshes; if it holds poses, "
          "--pose " +
          beside.string() + " reads them");
    }
  }

  const ModelFiles& files_;
  const CadReadSettings& settings_;
  std::unique_ptr<CadReader> cad_;
  std::unique_ptr<MeshReader> mesh_;
  bool meshes_ = false;
  std::size_t read_ = 0;            ///< files so far
  std::vector<std::string> stems_;  ///< by part, of its file
  std::vector<double> scales_;      ///< by part, mm a unit
  CadModel model_;
};

}  // namespace

Poses parse_poses(std::string_view json) {
  const JsonDocument document = JsonDocument::parse(json);
  Poses poses;
  poses.by_name =
      detail::read_by_name(document.root(), Place(""), "an object of poses by name", read_pose);
  return poses;
}

Poses read_poses(const fs::path& file) {
  const std::string text = file_text(file);
  try {
    return parse_poses(text);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

CadModel read_model(const ModelFiles& files, const CadReadSettings& settings) {
  if (files.models.empty()) throw InputError("there is no model to read");
  return ModelBuilder(files, settings).build();
}

}  // namespace orasp
