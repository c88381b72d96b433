// assimp: the only file that includes it, with detail/package_3mf.cpp the whole of the module
// orasp_assimp.so. One function is found by name: orasp_make_mesh_reader_1. It uses headers of the
// library, none of its code.

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "orasp/geometry/contacts.h"
#include "orasp/geometry/detail/package_3mf.h"
#include "orasp/geometry/detail/plain_text.h"
#include "orasp/geometry/mesh_reader.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

constexpr std::uint32_t kNoVertex = ~std::uint32_t{0};

using Place = std::array<float, 3>;

struct PlaceHash {
  std::size_t operator()(const Place& place) const {
    std::uint64_t mixed = 0;
    for (const float number : place)
      mixed = (mixed ^ std::bit_cast<std::uint32_t>(number)) * 0x9E3779B97F4A7C15U;
    return static_cast<std::size_t>(mixed ^ mixed >> 32U);
  }
};

/// Vertices by where they lie.
using Numbers = std::unordered_map<Place, std::uint32_t, PlaceHash>;

/// The library's message as part of a sentence: one line, no full stop.
std::string one_line(std::string message) {
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  message = detail::trimmed(message);
  while (message.ends_with('.')) message.pop_back();
  return message.empty() ? "no reason given" : message;
}

/// What one unit of a format is by its own rules or by custom.
struct FormatUnit {
  double millimetres;
  const char* name;
  bool stated;  ///< the format says so; else it is a custom
};

FormatUnit unit_of(const std::string& extension) {
  if (extension == ".gltf" || extension == ".glb") return {1000, "m", true};
  return {1, "mm", false};
}

/// The units of a 3MF file.
constexpr std::array<std::pair<std::string_view, FormatUnit>, 6> kUnitsOf3mf = {{
    {"micron", {0.001, "um", true}},
    {"millimeter", {1, "mm", true}},
    {"centimeter", {10, "cm", true}},
    {"inch", {25.4, "inch", true}},
    {"foot", {304.8, "foot", true}},
    {"meter", {1000, "m", true}},
}};

/// The text of an OBJ file with names that the library cannot confuse: it takes the first word for
/// the name, and objects of one name for one.
struct ObjText {
  std::string text;
  std::vector<std::string> names;  ///< "part_0" stands for the first of them, and so on
};

ObjText with_plain_names(const std::string& obj) {
  const auto first_letter = [](std::string_view line) {
    const bool named = line.size() > 1 && (line[1] == ' ' || line[1] == '\t');
    return named ? line[0] : '\0';
  };
  const auto for_each_line = [&obj](auto&& visit) {
    for (std::size_t begin = 0; begin < obj.size();) {
      const std::size_t end = std::min(obj.find('\n', begin), obj.size());
      visit(std::string_view(obj).substr(begin, end - begin));
      begin = end + 1;
    }
  };
  bool has_objects = false;
  for_each_line([&](std::string_view line) { has_objects |= first_letter(line) == 'o'; });
  ObjText plain;
  plain.text.reserve(obj.size() + obj.size() / 16);
  std::unordered_map<std::string, std::size_t> groups;
  for_each_line([&](std::string_view line) {
    const char letter = first_letter(line);
    if (letter == 'g' && has_objects) return;  // the groups of an object are one part
    if (letter != 'o' && letter != 'g') {
      plain.text.append(line).append("\n");
      return;
    }
    const std::string name = detail::trimmed(std::string(line.substr(2)));
    std::size_t number = plain.names.size();
    // A group may go on later; an object is a new one each time.
    if (letter == 'g') number = groups.emplace(name, number).first->second;
    if (number == plain.names.size()) plain.names.push_back(name);
    plain.text += "o part_" + std::to_string(number) + "\n";
  });
  return plain;
}

/// Serves one file from memory, all others from where they lie.
class OneFileInMemory final : public Assimp::DefaultIOSystem {
 public:
  OneFileInMemory(std::string file, const std::string& text)
      : file_(std::move(file)), text_(text) {}
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (file_ != file) return DefaultIOSystem::Open(file, mode);
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(text_.data()),
                                      text_.size());
  }

 private:
  std::string file_;
  const std::string& text_;
};

/// Reads one file.
class MeshFile {
 public:
  MeshFile(const std::filesystem::path& file, bool whole, const CadReadSettings& settings)
      : file_(file), whole_(whole), settings_(settings) {}

  CadModel read() {
    if (settings_.progress) settings_.progress({.phase = "reading"});
    const std::string extension = detail::lower(file_.extension().string());
    if (std::ranges::find(kMeshEndings, extension) == kMeshEndings.end())
      fail("its name does not end in .obj, .stl, .ply, .gltf, .glb or .3mf");
    std::error_code error;
    const auto size = std::filesystem::file_size(file_, error);
    if (error) fail(error.message());
    if (size == 0) fail("it is empty");
    load();
    FormatUnit unit = unit_of(extension);
    if (extension == ".3mf") unit = unit_of_package();
    scale_ = settings_.millimetres_per_unit.value_or(unit.millimetres);
    model_.millimetres_per_unit = scale_;
    model_.unit = settings_.millimetres_per_unit ? "" : unit.name;
    model_.unit_assumed = !settings_.millimetres_per_unit && !unit.stated;
    visit(*scene_->mRootNode, aiMatrix4x4(), 0);
    finish();
    return std::move(model_);
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(file_.string() + ": " + reason);
  }

  FormatUnit unit_of_package() {
    package_ = detail::read_3mf(file_);
    const auto* const known =
        std::ranges::find(kUnitsOf3mf, package_.unit, [](const auto& row) { return row.first; });
    if (known == kUnitsOf3mf.end())
      fail("its unit of length is \"" + package_.unit +
           "\"; 3MF knows micron, millimeter, centimeter, inch, foot and meter");
    return known->second;
  }

  void load() {
    importer_.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                                 aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
    if (detail::lower(file_.extension().string()) == ".obj") {
      std::ifstream stream(file_, std::ios::binary);
      obj_ = with_plain_names({std::istreambuf_iterator<char>(stream), {}});
      importer_.SetIOHandler(new OneFileInMemory(file_.string(), obj_.text));  // the importer's own
    }
    scene_ = importer_.ReadFile(file_.string(), aiProcess_Triangulate | aiProcess_SortByPType);
    if (settings_.stop.stop_requested()) throw Interrupted();
    if (scene_ == nullptr) {
      const std::string reason = importer_.GetErrorString();
      // What the library says of a file that holds points alone.
      if (reason.find("o meshes") != std::string::npos ||
          reason.find("no facets") != std::string::npos)
        fail("it holds no triangle");
      fail("it cannot be read: " + one_line(reason));
    }
    if (scene_->mRootNode == nullptr || scene_->mNumMeshes == 0) fail("it holds no triangle");
  }

  void visit(const aiNode& node, const aiMatrix4x4& above, int depth) {
    constexpr int kDeepest = 1000;
    if (depth > kDeepest) fail("its nodes are nested more than 1,000 deep");
    const aiMatrix4x4 here = above * node.mTransformation;
    if (node.mNumMeshes > 0) add_node(node, here);
    for (unsigned i = 0; i < node.mNumChildren; ++i) visit(*node.mChildren[i], here, depth + 1);
  }

  /// The node's name; of an OBJ file what with_plain_names() replaced, of a 3MF file that of its
  /// object.
  std::string name_of(const aiNode& node) const {
    const std::string name = detail::trimmed(node.mName.C_Str());
    constexpr std::string_view kObject = "Object_";
    if (!package_.unit.empty() && name.starts_with(kObject)) {
      const auto object = package_.names.find(name.substr(kObject.size()));
      return object != package_.names.end() ? detail::trimmed(object->second) : "";
    }
    constexpr std::string_view kPlain = "part_";
    if (obj_.names.empty() || !name.starts_with(kPlain)) return name;
    std::size_t number = obj_.names.size();
    std::from_chars(name.data() + kPlain.size(), name.data() + name.size(), number);
    return number < obj_.names.size() ? obj_.names[number] : name;
  }

  void add_node(const aiNode& node, const aiMatrix4x4& where) {
    CadPart part;
    part.name = name_of(node);
    std::string product;
    Numbers numbers;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      const aiMesh& mesh = *scene_->mMeshes[node.mMeshes[i]];
      product += (product.empty() ? "" : "+") + std::to_string(node.mMeshes[i]);
      add_mesh(mesh, where, numbers, part);
      if (!part.colour) part.colour = colour_of(mesh);
    }
    if (part.mesh.empty()) return;
    part.product = "mesh " + product;
    part.placement = placement_of(where);
    if (!part.placement) part.product.clear();
    model_.parts.push_back(std::move(part));
  }

  /// Adds triangles where they stand; corners at one place are one vertex.
  void add_mesh(const aiMesh& mesh, const aiMatrix4x4& where, Numbers& numbers, CadPart& part) {
    std::vector<std::uint32_t> number_of(mesh.mNumVertices, kNoVertex);
    const double determinant = where.Determinant();
    const auto vertex = [&](unsigned index) {
      if (index >= mesh.mNumVertices) fail("a triangle names a vertex that is not there");
      std::uint32_t& number = number_of[index];
      if (number != kNoVertex) return number;
      const aiVector3D& own = mesh.mVertices[index];
      const Place key = {own.x + 0.0F, own.y + 0.0F, own.z + 0.0F};
      if (!std::isfinite(own.x) || !std::isfinite(own.y) || !std::isfinite(own.z))
        fail("a vertex has a coordinate that is not a finite number");
      const auto [entry, is_new] =
          numbers.emplace(key, static_cast<std::uint32_t>(part.mesh.vertices.size()));
      if (is_new) {
        const Vector3 point = placed(where, own);
        constexpr double kFarthest = 1e12;
        if (!std::ranges::all_of(point, [](double x) { return std::abs(x) <= kFarthest; }))
          fail("a vertex is not in a finite place, or farther than 1e9 m");
        part.mesh.vertices.push_back(point);
      }
      return number = entry->second;
    };
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;
      std::array<std::uint32_t, 3> triangle = {vertex(face.mIndices[0]), vertex(face.mIndices[1]),
                                               vertex(face.mIndices[2])};
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0])
        continue;
      if (determinant < 0) std::swap(triangle[1], triangle[2]);
      part.mesh.triangles.push_back(triangle);
    }
  }

  Vector3 placed(const aiMatrix4x4& where, const aiVector3D& own) const {
    const double x = own.x;
    const double y = own.y;
    const double z = own.z;
    const auto& m = where;
    return {scale_ * (m.a1 * x + m.a2 * y + m.a3 * z + m.a4),
            scale_ * (m.b1 * x + m.b2 * y + m.b3 * z + m.b4),
            scale_ * (m.c1 * x + m.c2 * y + m.c3 * z + m.c4)};
  }

  /// The node's place where that is a turn and a shift.
  std::optional<Placement> placement_of(const aiMatrix4x4& m) const {
    Placement place;
    place.axes = {{{m.a1, m.b1, m.c1}, {m.a2, m.b2, m.c2}, {m.a3, m.b3, m.c3}}};
    place.origin = {scale_ * m.a4, scale_ * m.b4, scale_ * m.c4};
    constexpr double kSame = 1e-5;  // of single precision
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double product = 0;
        for (std::size_t k = 0; k < 3; ++k) product += place.axes[i][k] * place.axes[j][k];
        if (std::abs(product - (i == j ? 1 : 0)) > kSame) return std::nullopt;
      }
    }
    if (m.Determinant() < 0) return std::nullopt;
    return place;
  }

  std::optional<std::array<float, 3>> colour_of(const aiMesh& mesh) const {
    if (mesh.mMaterialIndex >= scene_->mNumMaterials) return std::nullopt;
    const aiMaterial& material = *scene_->mMaterials[mesh.mMaterialIndex];
    aiString name;
    if (material.Get(AI_MATKEY_NAME, name) == AI_SUCCESS &&
        std::string(name.C_Str()) == AI_DEFAULT_MATERIAL_NAME) {
      return std::nullopt;
    }
    aiColor4D base;
    if (material.Get(AI_MATKEY_BASE_COLOR, base) == AI_SUCCESS) return rgb(base.r, base.g, base.b);
    aiColor3D diffuse;
    if (material.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse) == AI_SUCCESS)
      return rgb(diffuse.r, diffuse.g, diffuse.b);
    return std::nullopt;
  }
  static std::array<float, 3> rgb(float r, float g, float b) {
    return {std::clamp(r, 0.0F, 1.0F), std::clamp(g, 0.0F, 1.0F), std::clamp(b, 0.0F, 1.0F)};
  }

  void finish() {
    if (model_.parts.empty()) fail("it holds no triangle");
    model_.name = file_.stem().string();
    if (whole_ && model_.parts.size() > 1) merge();
    if (model_.parts.size() == 1) {
      if (whole_ || is_generated(model_.parts[0].name)) model_.parts[0].name = model_.name;
      return;
    }
    std::size_t nameless = 0;
    for (std::size_t i = 0; i < model_.parts.size(); ++i) {
      std::string& name = model_.parts[i].name;
      if (!is_generated(name)) continue;
      ++nameless;
      name = "part " + std::to_string(i + 1);
    }
    if (nameless > 0) {
      model_.warnings.push_back(file_.filename().string() + ": " + std::to_string(nameless) +
                                " of its parts have no name and are numbered");
    }
  }

  /// Names that the library makes where a file has none.
  static bool is_generated(const std::string& name) {
    return name.empty() || name.starts_with("nodes[") || name.starts_with("<STL_BINARY>") ||
           name.starts_with("<") || name == "defaultobject" || name == "ROOT";
  }

  void merge() {
    CadPart& first = model_.parts[0];
    for (std::size_t i = 1; i < model_.parts.size(); ++i) {
      const Mesh& mesh = model_.parts[i].mesh;
      const auto offset = static_cast<std::uint32_t>(first.mesh.vertices.size());
      first.mesh.vertices.insert(first.mesh.vertices.end(), mesh.vertices.begin(),
                                 mesh.vertices.end());
      for (auto triangle : mesh.triangles) {
        for (std::uint32_t& corner : triangle) corner += offset;
        first.mesh.triangles.push_back(triangle);
      }
    }
    first.product.clear();
    first.placement.reset();
    model_.parts.resize(1);
  }

  std::filesystem::path file_;
  bool whole_;
  const CadReadSettings& settings_;
  ObjText obj_;  // before the importer, which reads from it
  detail::Package3mf package_;
  Assimp::Importer importer_;
  const aiScene* scene_ = nullptr;
  double scale_ = 1;
  CadModel model_;
};

class AssimpReader final : public MeshReader {
 public:
  CadModel read(const std::filesystem::path& file, bool whole,
                const CadReadSettings& settings) override {
    return MeshFile(file, whole, settings).read();
  }
};

}  // namespace

}  // namespace orasp

extern "C" __attribute__((visibility("default"))) orasp::MeshReader* orasp_make_mesh_reader_1() {
  return new orasp::AssimpReader();
}
