#include "orasp/report/detail/glb_reader.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"
#include "orasp/report/detail/report_page.h"
#include "orasp/report/part_shapes.h"

namespace orasp::detail {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

template <class... Arguments>
[[noreturn]] void damaged(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  throw InputError(fmt::format(text, std::forward<Arguments>(arguments)...));
}

std::uint32_t word(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// The two chunks of a file.
struct Chunks {
  std::string_view text;
  std::string_view data;
};

Chunks chunks_of(std::string_view bytes) {
  constexpr std::uint32_t kMagic = 0x46546C67;
  constexpr std::uint32_t kJson = 0x4E4F534A;
  constexpr std::uint32_t kData = 0x004E4942;
  constexpr std::size_t kHead = 12;
  if (bytes.size() < 4 || word(bytes, 0) != kMagic) damaged("it is not a binary glTF file");
  if (bytes.size() < kHead) damaged("it is cut off within its first {} bytes", kHead);
  if (word(bytes, 4) != 2) damaged("it is glTF version {}, and 2 is read", word(bytes, 4));
  const std::size_t length = word(bytes, 8);
  if (length > bytes.size()) {
    damaged("it is cut off after {} of its {}", bytes.size(), counted(length, "byte"));
  }
  Chunks chunks;
  bool has_text = false;
  for (std::size_t at = kHead; at + 8 <= length;) {
    const std::size_t size = word(bytes, at);
    const std::uint32_t kind = word(bytes, at + 4);
    if (size > length - at - 8) damaged("a chunk in it is longer than the file");
    if (kind == kJson && !has_text) {
      chunks.text = bytes.substr(at + 8, size);
      has_text = true;
    } else if (kind == kData && chunks.data.empty()) {
      chunks.data = bytes.substr(at + 8, size);
    }
    at += 8 + (size + 3) / 4 * 4;
  }
  if (!has_text) damaged("it has no chunk of JSON");
  return chunks;
}

/// A count or a position in a list: of `object`, or of a default.
std::optional<std::size_t> index_in(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  constexpr double kMost = 4294967295.0;
  if (!found->is_number() || found->get<double>() < 0 || found->get<double>() > kMost ||
      found->get<double>() != std::floor(found->get<double>()))
    damaged("its JSON has a \"{}\" that is no whole number", key);
  return static_cast<std::size_t>(found->get<double>());
}

const json& list_in(const json& object, const char* key) {
  static const json kEmpty = json::array();
  const auto found = object.find(key);
  if (found == object.end()) return kEmpty;
  if (!found->is_array()) damaged("its JSON has \"{}\" that are no list", key);
  return *found;
}

const json& object_at(const json& list, std::size_t index, const char* kind) {
  if (index >= list.size() || !list[index].is_object())
    damaged("its JSON names the {} {}, which is not there", kind, index);
  return list[index];
}

template <std::size_t kCount>
std::array<double, kCount> numbers_in(const json& object, const char* key,
                                      const std::array<double, kCount>& otherwise) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  std::array<double, kCount> values{};
  if (!found->is_array() || found->size() != kCount)
    damaged("its JSON has a \"{}\" that is not {} numbers", key, kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!(*found)[i].is_number() || !std::isfinite((*found)[i].template get<double>()))
      damaged("its JSON has a \"{}\" that is not {} numbers", key, kCount);
    values[i] = (*found)[i].template get<double>();
  }
  return values;
}

Transform place_of(const json& node) {
  if (node.contains("matrix")) {
    const auto m = numbers_in<16>(node, "matrix", {});
    return {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10], m[12], m[13], m[14]};
  }
  const auto t = numbers_in<3>(node, "translation", {0, 0, 0});
  const auto [x, y, z, w] = numbers_in<4>(node, "rotation", {0, 0, 0, 1});
  const auto s = numbers_in<3>(node, "scale", {1, 1, 1});
  return {(1 - 2 * (y * y + z * z)) * s[0],
          2 * (x * y + z * w) * s[0],
          2 * (x * z - y * w) * s[0],
          2 * (x * y - z * w) * s[1],
          (1 - 2 * (x * x + z * z)) * s[1],
          2 * (y * z + x * w) * s[1],
          2 * (x * z + y * w) * s[2],
          2 * (y * z - x * w) * s[2],
          (1 - 2 * (x * x + y * y)) * s[2],
          t[0],
          t[1],
          t[2]};
}

/// What an accessor says of its bytes.
struct Numbers {
  const char* data = nullptr;
  std::size_t count = 0;
  std::size_t stride = 0;
  std::size_t type = 0;  ///< of glTF: 5120 to 5126
  bool normalised = false;

  template <class Number>
  [[nodiscard]] Number as(std::size_t element, std::size_t component) const {
    Number number;
    std::memcpy(&number, data + element * stride + component * sizeof number, sizeof number);
    return number;
  }
  [[nodiscard]] double real(std::size_t element, std::size_t component) const {
    const auto whole = [this](auto number) {
      const auto most = static_cast<double>(std::numeric_limits<decltype(number)>::max());
      return normalised ? std::max(-1.0, static_cast<double>(number) / most)
                        : static_cast<double>(number);
    };
    switch (type) {
      case 5120: return whole(as<std::int8_t>(element, component));
      case 5121: return whole(as<std::uint8_t>(element, component));
      case 5122: return whole(as<std::int16_t>(element, component));
      case 5123: return whole(as<std::uint16_t>(element, component));
      default: return as<float>(element, component);
    }
  }
  [[nodiscard]] std::uint32_t index(std::size_t element) const {
    switch (type) {
      case 5121: return as<std::uint8_t>(element, 0);
      case 5123: return as<std::uint16_t>(element, 0);
      default: return as<std::uint32_t>(element, 0);
    }
  }
};

class GlbReader {
 public:
  GlbReader(const Problem& problem, const Chunks& chunks)
      : problem_(problem),
        data_(chunks.data),
        root_(json::parse(chunks.text.begin(), chunks.text.end(), nullptr, false)) {
    if (!root_.is_object()) damaged("its JSON cannot be read");
    for (PartIndex part = 0; part < problem.num_parts(); ++part)
      by_id_.emplace(problem.part_id(part), part);
  }

  RawShapes read();

 private:
  /// A mesh of the file that hangs on the node of a part, and where.
  using Piece = std::pair<std::size_t, Transform>;
  struct Visit {
    std::size_t node;
    Transform place;      ///< in the world
    std::size_t owner;    ///< the part that it belongs to; num_parts(): none
    Transform from_part;  ///< in the frame of the part's own node
  };

  void walk();
  [[nodiscard]] Numbers numbers(std::size_t accessor, bool indices) const;
  void add_primitive(const json& primitive, const Transform& place, RawMesh& mesh,
                     std::map<std::array<double, 4>, std::size_t>& colours);
  [[nodiscard]] RawMesh mesh_of(const std::vector<Piece>& pieces);

  const Problem& problem_;
  std::string_view data_;
  json root_;
  std::unordered_map<std::string_view, PartIndex> by_id_;
  std::vector<std::vector<Piece>> pieces_;
  std::vector<std::optional<Transform>> places_;
  std::size_t points_read_ = 0;  // of all surfaces, however often they share points
};

Numbers GlbReader::numbers(std::size_t accessor, bool indices) const {
  const json& stated = object_at(list_in(root_, "accessors"), accessor, "accessor");
  if (stated.contains("sparse")) damaged("it has sparse accessors, which are not read");
  Numbers found;
  found.type = index_in(stated, "componentType").value_or(0);
  found.count = index_in(stated, "count").value_or(0);
  const auto normalised = stated.find("normalized");
  found.normalised = normalised != stated.end() && normalised->is_boolean() && *normalised;
  const auto shape = stated.find("type");
  const std::string_view wanted = indices ? "SCALAR" : "VEC3";
  if (shape == stated.end() || !shape->is_string() ||
      shape->get_ref<const std::string&>() != wanted)
    damaged("the accessor {} in it is not of type {}", accessor, wanted);
  const std::map<std::size_t, std::size_t> sizes =
      indices ? std::map<std::size_t, std::size_t>{{5121, 1}, {5123, 2}, {5125, 4}}
              : std::map<std::size_t, std::size_t>{
                    {5120, 1}, {5121, 1}, {5122, 2}, {5123, 2}, {5126, 4}};
  const auto size = sizes.find(found.type);
  if (size == sizes.end())
    damaged("the accessor {} in it has numbers of type {}, which are not read", accessor,
            found.type);
  const std::size_t width = size->second * (indices ? 1 : 3);
  const auto view_number = index_in(stated, "bufferView");
  if (!view_number) damaged("the accessor {} in it has no bytes", accessor);
  const json& view = object_at(list_in(root_, "bufferViews"), *view_number, "buffer view");
  const json& buffer =
      object_at(list_in(root_, "buffers"), index_in(view, "buffer").value_or(0), "buffer");
  if (buffer.contains("uri") || index_in(view, "buffer").value_or(0) != 0)
    damaged("its shapes are in another file, and one that holds all is read");
  found.stride = index_in(view, "byteStride").value_or(width);
  const std::size_t begin = index_in(view, "byteOffset").value_or(0);
  const std::size_t length = index_in(view, "byteLength").value_or(0);
  const std::size_t offset = index_in(stated, "byteOffset").value_or(0);
  if (begin > data_.size() || length > data_.size() - begin || found.stride < width ||
      (found.count > 0 && offset + (found.count - 1) * found.stride + width > length))
    damaged("the accessor {} in it reaches beyond the end of its bytes", accessor);
  found.data = data_.data() + begin + offset;
  return found;
}

void GlbReader::add_primitive(const json& primitive, const Transform& place, RawMesh& mesh,
                              std::map<std::array<double, 4>, std::size_t>& colours) {
  const std::size_t mode = index_in(primitive, "mode").value_or(4);
  if (mode < 4) return;  // points and lines are no surface
  if (mode > 6) damaged("it has primitives of mode {}, which is none", mode);
  const auto attributes = primitive.find("attributes");
  const auto position = attributes != primitive.end() && attributes->is_object()
                            ? index_in(*attributes, "POSITION")
                            : std::nullopt;
  if (!position) damaged("a surface in it has no positions");
  const Numbers points = numbers(*position, false);
  points_read_ += points.count;
  if (points_read_ > 3 * kMaxShapeTriangles)
    damaged("it has more than {}", counted(kMaxShapeTriangles, "triangle"));
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (std::size_t i = 0; i < points.count; ++i) {
    const Vector3 point = place * Vector3{points.real(i, 0), points.real(i, 1), points.real(i, 2)};
    constexpr double kFarthest = 1e9;
    for (const double x : point) {
      if (!(std::abs(x) <= kFarthest))
        damaged("a point in it is not a number, or farther than 1e9 m");
    }
    mesh.points.push_back(
        {static_cast<float>(point[0]), static_cast<float>(point[1]), static_cast<float>(point[2])});
  }
  std::vector<std::uint32_t> corners;
  if (const auto indices = index_in(primitive, "indices")) {
    const Numbers list = numbers(*indices, true);
    for (std::size_t i = 0; i < list.count; ++i) {
      corners.push_back(list.index(i));
      if (corners.back() >= points.count)
        damaged("a triangle in it has a corner that is not there");
    }
  } else {
    for (std::size_t i = 0; i < points.count; ++i) corners.push_back(static_cast<std::uint32_t>(i));
  }
  if (mesh.corners.size() / 3 + corners.size() > 3 * kMaxShapeTriangles)
    damaged("it has more than {}", counted(kMaxShapeTriangles, "triangle"));
  const std::size_t before = mesh.corners.size();
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    for (const std::size_t i : {a, b, c}) mesh.corners.push_back(first + corners[i]);
  };
  if (mode == 4) {
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) add(i, i + 1, i + 2);
  } else {
    for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
      if (mode == 6) {
        add(0, i + 1, i + 2);
      } else {
        add(i, i + 1 + i % 2, i + 2 - i % 2);
      }
    }
  }
  std::array<double, 4> colour{};
  if (const auto material = index_in(primitive, "material")) {
    const json& stated = object_at(list_in(root_, "materials"), *material, "material");
    const auto surface = stated.find("pbrMetallicRoughness");
    if (surface != stated.end() && surface->is_object() && surface->contains("baseColorFactor")) {
      colour = numbers_in<4>(*surface, "baseColorFactor", {1, 1, 1, 1});
      for (double& x : colour) x = std::clamp(x, 0.0, 1.0);
      colour[3] = 1;
    }
  }
  colours[colour] += mesh.corners.size() - before;
}

RawMesh GlbReader::mesh_of(const std::vector<Piece>& pieces) {
  RawMesh mesh;
  std::map<std::array<double, 4>, std::size_t> colours;
  for (const auto& [number, place] : pieces) {
    const json& stated = object_at(list_in(root_, "meshes"), number, "mesh");
    for (const json& primitive : list_in(stated, "primitives")) {
      if (!primitive.is_object()) damaged("its JSON has a primitive that is no object");
      add_primitive(primitive, place, mesh, colours);
    }
  }
  const auto most =
      std::ranges::max_element(colours, {}, [](const auto& one) { return one.second; });
  if (most != colours.end()) mesh.colour = most->first;
  return mesh;
}

/// Notes which meshes belong to which part, and where the part is.
void GlbReader::walk() {
  const json& nodes = list_in(root_, "nodes");
  std::vector<bool> is_child(nodes.size());
  for (const json& node : nodes) {
    if (!node.is_object()) damaged("its JSON has a node that is no object");
    for (const json& child : list_in(node, "children")) {
      if (child.is_number_unsigned() && child.get<std::size_t>() < is_child.size())
        is_child[child.get<std::size_t>()] = true;
    }
  }
  std::vector<Visit> open;
  std::vector<bool> seen(nodes.size());
  const std::size_t nobody = problem_.num_parts();
  for (std::size_t node = nodes.size(); node-- > 0;) {
    if (!is_child[node]) open.push_back({node, kIdentity, nobody, kIdentity});
  }
  while (!open.empty()) {
    Visit visit = open.back();
    open.pop_back();
    const json& node = object_at(nodes, visit.node, "node");
    if (seen[visit.node]) damaged("its JSON lists the node {} twice", visit.node);
    seen[visit.node] = true;
    const Transform own = place_of(node);
    visit.place = visit.place * own;
    visit.from_part = visit.from_part * own;
    if (!std::ranges::all_of(visit.place, [](double x) { return std::isfinite(x); }))
      damaged("the node {} in it is nowhere", visit.node);
    const auto name = node.find("name");
    if (name != node.end() && name->is_string()) {
      const auto part = by_id_.find(name->get_ref<const std::string&>());
      if (part != by_id_.end() && visit.owner != part->second) {
        visit.owner = part->second;
        if (!places_[visit.owner]) {
          places_[visit.owner] = visit.place;
          visit.from_part = kIdentity;
        } else {
          damaged("two nodes in it have the id of part {}",
                  in_quotes(problem_.part_id(part->second)));
        }
      }
    }
    if (const auto mesh = index_in(node, "mesh"); mesh && visit.owner != nobody)
      pieces_[visit.owner].emplace_back(*mesh, visit.from_part);
    for (const json& child : list_in(node, "children")) {
      if (!child.is_number_unsigned()) damaged("its JSON has a child that is no node");
      open.push_back({child.get<std::size_t>(), visit.place, visit.owner, visit.from_part});
    }
  }
}

RawShapes GlbReader::read() {
  for (const json& extension : list_in(root_, "extensionsRequired")) {
    if (extension.is_string() && extension != "KHR_mesh_quantization" &&
        !extension.get_ref<const std::string&>().starts_with("KHR_materials_"))
      damaged("it needs the extension {}, which is not read",
              in_quotes(extension.get_ref<const std::string&>()));
  }
  pieces_.resize(problem_.num_parts());
  places_.resize(problem_.num_parts());
  walk();
  RawShapes shapes;
  std::map<std::vector<Piece>, std::size_t> known;
  std::size_t triangles = 0;
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    const std::string id = in_quotes(problem_.part_id(part));
    if (!places_[part]) damaged("no node in it has the id of part {}", id);
    const auto [entry, is_new] = known.emplace(pieces_[part], shapes.meshes.size());
    if (is_new) shapes.meshes.push_back(mesh_of(pieces_[part]));
    const RawMesh& mesh = shapes.meshes[entry->second];
    if (mesh.corners.empty()) damaged("the node of part {} in it has no triangle", id);
    triangles += mesh.corners.size() / 3;
    if (triangles > kMaxShapeTriangles)
      damaged("it has more than {}", counted(kMaxShapeTriangles, "triangle"));
    shapes.of_part.push_back({entry->second, *places_[part]});
  }
  return shapes;
}

}  // namespace

Transform operator*(const Transform& outer, const Transform& inner) {
  Transform product{};
  for (std::size_t column = 0; column < 4; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      double sum = column == 3 ? outer[9 + row] : 0.0;
      for (std::size_t k = 0; k < 3; ++k) sum += outer[3 * k + row] * inner[3 * column + k];
      product[3 * column + row] = sum;
    }
  }
  return product;
}

Vector3 operator*(const Transform& transform, const Vector3& point) {
  Vector3 image{};
  for (std::size_t row = 0; row < 3; ++row) {
    image[row] = transform[9 + row];
    for (std::size_t k = 0; k < 3; ++k) image[row] += transform[3 * k + row] * point[k];
  }
  return image;
}

RawShapes read_glb(const Problem& problem, std::string_view bytes) {
  return GlbReader(problem, chunks_of(bytes)).read();
}

}  // namespace orasp::detail
