#include "orasp/io/import_files.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "orasp/io/atomic_file.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/detail/vector_math.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// With four significant digits: what is measured on triangles has no more.
double short_number(double number) {
  if (!std::isfinite(number) || number == 0) return 0;
  std::array<char, 64> text{};
  const auto written = std::to_chars(text.data(), text.data() + text.size(), number,
                                     std::chars_format::scientific, 3);
  double read = 0;
  std::from_chars(text.data(), written.ptr, read);
  return read;
}

const char* kind_name(Contact::Kind kind) {
  switch (kind) {
    case Contact::Kind::Touch: return "contact";
    case Contact::Kind::Fit: return "fit";
    case Contact::Kind::Fastener: return "fastener";
  }
  return "";
}

const char* source_name(DensitySource source) {
  switch (source) {
    case DensitySource::File: return "file";
    case DensitySource::Given: return "given";
    case DensitySource::Name: return "name";
    case DensitySource::Default: return "default";
  }
  return "";
}

void annotate_parts(const ImportedAssembly& assembly, ordered_json& parts) {
  for (std::size_t i = 0; i < assembly.parts.size(); ++i) {
    const CadPartFacts& facts = assembly.parts[i];
    ordered_json& part = parts[i];
    part["x-volume"] = short_number(facts.volume / (kMetre * kMetre * kMetre));
    part["x-density"] = short_number(facts.density);
    part["x-density-source"] = source_name(facts.source);
    if (!facts.material.empty()) part["x-material"] = facts.material;
    if (assembly.flexible[i]) part["x-flexible"] = true;
  }
}

void annotate_connections(const ImportedAssembly& assembly, ordered_json& connections) {
  for (std::size_t c = 0; c < assembly.contacts.size(); ++c) {
    const Contact& contact = assembly.contacts[c];
    ordered_json& connection = connections[c];
    connection["x-kind"] = kind_name(contact.kind);
    connection["x-area"] = short_number(contact.area / (kMetre * kMetre));
    if (contact.distance > 0) connection["x-distance"] = short_number(contact.distance / kMetre);
    if (contact.proposed) connection["x-proposed"] = true;
    if (contact.overlap)
      connection["x-overlap"] = short_number(contact.overlap->thickness / kMetre);
  }
}

void annotate_blocked(const ImportedAssembly& assembly, ordered_json& blocked) {
  const std::vector<PairFacts> pairs = facts_by_pair(assembly);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    ordered_json widths = ordered_json::array();
    ordered_json depths = ordered_json::array();
    for (const DirectedFact& fact : pairs[i].facts) {
      widths.push_back(short_number(fact.fact->width / kMetre));
      depths.push_back(short_number(fact.fact->depth / kMetre));
    }
    blocked[i]["x-width"] = std::move(widths);
    blocked[i]["x-depth"] = std::move(depths);
  }
}

/// A line for each element.
std::string lines(const ordered_json& list, const std::string& indent) {
  if (list.empty()) return "[]";
  std::string text = "[";
  for (const ordered_json& item : list)
    text += (text.size() > 1 ? ",\n" : "\n") + indent + "  " + detail::inline_text(item);
  return text + "\n" + indent + "]";
}

/// In the layout of problem_text().
std::string laid_out(const ordered_json& problem) {
  std::string text = "{";
  for (const auto& [key, value] : problem.items()) {
    text += (text.size() > 1 ? ",\n  " : "\n  ") + detail::inline_text(key) + ": ";
    if (key == "parts" || key == "connections" || key == "precedence") {
      text += lines(value, "  ");
    } else if (key == "blocking") {
      text += "{";
      for (const auto& [member, content] : value.items()) {
        text += (text.back() == '{' ? "\n    " : ",\n    ") + detail::inline_text(member) + ": ";
        text += member == "blocked" ? lines(content, "    ") : detail::inline_text(content);
      }
      text += "\n  }";
    } else {
      text += detail::inline_text(value);
    }
  }
  return text + "\n}\n";
}

// -------------------------------------------------------------------------------------------------
// shapes

/// Corners as a picture wants them: a vertex stands once for each smooth piece of surface round it.
struct SmoothMesh {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  std::vector<std::uint32_t> indices;
};

/// Triangles round a vertex are one piece of surface where they meet at less than 35 degrees.
SmoothMesh smoothed(const std::vector<Vector3>& vertices,
                    const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  constexpr double kCrease = 0.819;  // cosine of 35 degrees
  std::vector<Vector3> weighted;     // by triangle, as long as twice its area
  std::vector<Vector3> facing;
  std::vector<std::vector<std::uint32_t>> round(vertices.size());
  for (const auto& [a, b, c] : triangles) {
    const Vector3 normal = detail::cross(detail::minus(vertices[b], vertices[a]),
                                         detail::minus(vertices[c], vertices[a]));
    for (const std::uint32_t corner : {a, b, c})
      round[corner].push_back(static_cast<std::uint32_t>(weighted.size()));
    weighted.push_back(normal);
    facing.push_back(detail::facing(normal));
  }
  SmoothMesh smooth;
  std::vector<std::vector<std::uint32_t>> made(vertices.size());
  const auto corner_of = [&](std::uint32_t vertex, std::size_t triangle) {
    Vector3 sum{};
    for (const std::uint32_t other : round[vertex]) {
      if (detail::dot(facing[other], facing[triangle]) < kCrease) continue;
      for (std::size_t i = 0; i < 3; ++i) sum[i] += weighted[other][i];
    }
    const Vector3 unit = detail::facing(sum);
    std::array<float, 3> normal{};
    for (std::size_t i = 0; i < 3; ++i)
      normal[i] = static_cast<float>(std::round(unit[i] * 1e4) / 1e4) + 0.0F;
    for (const std::uint32_t known : made[vertex]) {
      if (smooth.normals[known] == normal) return known;
    }
    const auto number = static_cast<std::uint32_t>(smooth.positions.size());
    made[vertex].push_back(number);
    std::array<float, 3> position{};
    for (std::size_t i = 0; i < 3; ++i)
      position[i] = static_cast<float>(vertices[vertex][i] / kMetre) + 0.0F;
    smooth.positions.push_back(position);
    smooth.normals.push_back(normal);
    return number;
  };
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const std::uint32_t corner : triangles[t]) smooth.indices.push_back(corner_of(corner, t));
  }
  return smooth;
}

/// A quaternion [x, y, z, w] of a turn.
std::array<double, 4> quaternion_of(const std::array<Vector3, 3>& axes) {
  const double xx = axes[0][0];
  const double yy = axes[1][1];
  const double zz = axes[2][2];
  std::array<double, 4> q{};
  if (xx + yy + zz > 0) {
    const double s = 2 * std::sqrt(1 + xx + yy + zz);
    q = {(axes[1][2] - axes[2][1]) / s, (axes[2][0] - axes[0][2]) / s,
         (axes[0][1] - axes[1][0]) / s, s / 4};
  } else if (xx > yy && xx > zz) {
    const double s = 2 * std::sqrt(1 + xx - yy - zz);
    q = {s / 4, (axes[1][0] + axes[0][1]) / s, (axes[2][0] + axes[0][2]) / s,
         (axes[1][2] - axes[2][1]) / s};
  } else if (yy > zz) {
    const double s = 2 * std::sqrt(1 + yy - xx - zz);
    q = {(axes[1][0] + axes[0][1]) / s, s / 4, (axes[2][1] + axes[1][2]) / s,
         (axes[2][0] - axes[0][2]) / s};
  } else {
    const double s = 2 * std::sqrt(1 + zz - xx - yy);
    q = {(axes[2][0] + axes[0][2]) / s, (axes[2][1] + axes[1][2]) / s, s / 4,
         (axes[0][1] - axes[1][0]) / s};
  }
  double length = 0;
  for (const double number : q) length += number * number;
  for (double& number : q) number = std::round(number / std::sqrt(length) * 1e9) / 1e9 + 0.0;
  return q;
}

/// Collects the pieces of a glTF document and its one buffer.
class GlbWriter {
 public:
  std::string write(const ImportedAssembly& assembly) {
    const std::vector<bool> shared = parts_with_equals(assembly.parts);
    std::vector<std::size_t> mesh_of(assembly.parts.size());
    for (std::size_t i = 0; i < assembly.parts.size(); ++i) {
      const CadPart& part = assembly.model.parts[i];
      const std::size_t first = assembly.parts[i].equal;
      const bool moved = shared[i] && part.placement.has_value();
      ordered_json node = {{"name", assembly.parts[i].id}};
      // Equal parts share a mesh where their colours are the same too.
      const bool reuses = moved && first != i &&
                          part.colour == assembly.model.parts[first].colour &&
                          assembly.model.parts[first].placement.has_value();
      mesh_of[i] = reuses ? mesh_of[first] : add_mesh(part, moved);
      node["mesh"] = mesh_of[i];
      if (moved) put_place(*part.placement, node);
      nodes_.push_back(std::move(node));
    }
    return packed();
  }

 private:
  static void put_place(const Placement& place, ordered_json& node) {
    const std::array<double, 4> turn = quaternion_of(place.axes);
    ordered_json shift = ordered_json::array();
    for (const double number : place.origin)
      shift.push_back(std::round(number / kMetre * 1e9) / 1e9 + 0.0);
    node["translation"] = std::move(shift);
    if (turn != std::array<double, 4>{0, 0, 0, 1}) node["rotation"] = turn;
  }

  /// The mesh of a part where it stands, or in its product's frame if it is placed by its node.
  std::size_t add_mesh(const CadPart& part, bool moved) {
    std::vector<Vector3> vertices = part.mesh.vertices;
    if (moved) {
      const Placement& place = *part.placement;
      for (Vector3& vertex : vertices) {
        const Vector3 back = detail::minus(vertex, place.origin);
        vertex = {detail::dot(place.axes[0], back), detail::dot(place.axes[1], back),
                  detail::dot(place.axes[2], back)};
      }
    }
    const SmoothMesh smooth = smoothed(vertices, part.mesh.triangles);
    ordered_json primitive = {{"attributes",
                               {{"POSITION", add_points(smooth.positions, true)},
                                {"NORMAL", add_points(smooth.normals, false)}}},
                              {"indices", add_indices(smooth.indices, smooth.positions.size())}};
    if (part.colour) primitive["material"] = material_of(*part.colour);
    meshes_.push_back({{"primitives", ordered_json::array({std::move(primitive)})}});
    return meshes_.size() - 1;
  }

  std::size_t material_of(const std::array<float, 3>& colour) {
    for (std::size_t i = 0; i < colours_.size(); ++i) {
      if (colours_[i] == colour) return i;
    }
    colours_.push_back(colour);
    const auto rounded = [](float number) {
      return std::round(static_cast<double>(number) * 1e4) / 1e4;
    };
    materials_.push_back(
        {{"pbrMetallicRoughness",
          {{"baseColorFactor", {rounded(colour[0]), rounded(colour[1]), rounded(colour[2]), 1.0}},
           {"metallicFactor", 0.1},
           {"roughnessFactor", 0.6}}}});
    return colours_.size() - 1;
  }

  std::size_t add_points(const std::vector<std::array<float, 3>>& points, bool bounded) {
    constexpr int kFloat = 5126;
    constexpr int kVertices = 34962;
    ordered_json accessor = {{"bufferView", add_view(points.data(), points.size() * 12, kVertices)},
                             {"componentType", kFloat},
                             {"count", points.size()},
                             {"type", "VEC3"}};
    if (bounded && !points.empty()) {
      std::array<float, 3> low = points[0];
      std::array<float, 3> high = points[0];
      for (const auto& point : points) {
        for (std::size_t i = 0; i < 3; ++i) {
          low[i] = std::min(low[i], point[i]);
          high[i] = std::max(high[i], point[i]);
        }
      }
      accessor["min"] = low;
      accessor["max"] = high;
    }
    accessors_.push_back(std::move(accessor));
    return accessors_.size() - 1;
  }

  std::size_t add_indices(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
    constexpr int kShort = 5123;
    constexpr int kLong = 5125;
    constexpr int kElements = 34963;
    const bool fits = vertices < 0xFFFF;
    std::size_t view = 0;
    if (fits) {
      const std::vector<std::uint16_t> small(indices.begin(), indices.end());
      view = add_view(small.data(), small.size() * 2, kElements);
    } else {
      view = add_view(indices.data(), indices.size() * 4, kElements);
    }
    accessors_.push_back({{"bufferView", view},
                          {"componentType", fits ? kShort : kLong},
                          {"count", indices.size()},
                          {"type", "SCALAR"}});
    return accessors_.size() - 1;
  }

  std::size_t add_view(const void* bytes, std::size_t size, int target) {
    const std::size_t offset = buffer_.size();
    buffer_.append(static_cast<const char*>(bytes), size);
    buffer_.append((4 - buffer_.size() % 4) % 4, '\0');
    views_.push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}, {"target", target}});
    return views_.size() - 1;
  }

  std::string packed() {
    ordered_json scene_nodes = ordered_json::array();
    for (std::size_t i = 0; i < nodes_.size(); ++i) scene_nodes.push_back(i);
    ordered_json document = {{"asset", {{"version", "2.0"}, {"generator", "orasp"}}},
                             {"scene", 0},
                             {"scenes", {{{"nodes", std::move(scene_nodes)}}}},
                             {"nodes", std::move(nodes_)},
                             {"meshes", std::move(meshes_)}};
    if (!materials_.empty()) document["materials"] = std::move(materials_);
    document["accessors"] = std::move(accessors_);
    document["bufferViews"] = std::move(views_);
    document["buffers"] = {{{"byteLength", buffer_.size()}}};
    std::string text = document.dump();
    text.append((4 - text.size() % 4) % 4, ' ');

    std::string file;
    const auto put = [&file](std::size_t number) {
      for (unsigned shift = 0; shift < 32; shift += 8)
        file += static_cast<char>(number >> shift & 0xFFU);
    };
    constexpr std::size_t kMagic = 0x46546C67;
    constexpr std::size_t kJsonChunk = 0x4E4F534A;
    constexpr std::size_t kBinaryChunk = 0x004E4942;
    const std::size_t size = 12 + 8 + text.size() + 8 + buffer_.size();
    if (size > 0xFFFFFFFFU)
      throw InputError("the shapes take more than 4 GiB, the most a binary glTF file may hold");
    put(kMagic);
    put(2);
    put(size);
    put(text.size());
    put(kJsonChunk);
    file += text;
    put(buffer_.size());
    put(kBinaryChunk);
    return file + buffer_;
  }

  std::string buffer_;
  std::vector<std::array<float, 3>> colours_;
  ordered_json nodes_ = ordered_json::array();
  ordered_json meshes_ = ordered_json::array();
  ordered_json materials_ = ordered_json::array();
  ordered_json accessors_ = ordered_json::array();
  ordered_json views_ = ordered_json::array();
};

/// The bytes of a regular file that is there.
std::optional<std::string> bytes_of(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return std::nullopt;
  std::ifstream stream(file, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
}

}  // namespace

std::string imported_problem_text(const ImportedAssembly& assembly, const std::string& geometry) {
  ordered_json problem = ordered_json::parse(problem_text(Problem(assembly.problem)));
  annotate_parts(assembly, problem["parts"]);
  annotate_connections(assembly, problem["connections"]);
  annotate_blocked(assembly, problem["blocking"]["blocked"]);
  if (!geometry.empty()) problem["geometry"] = {{"file", geometry}};
  return laid_out(problem);
}

std::string shapes_glb(const ImportedAssembly& assembly) {
  return GlbWriter().write(assembly);
}

fs::path write_import(const ImportedAssembly& assembly, const fs::path& file) {
  fs::path shapes = file;
  shapes.replace_extension(".glb");
  if (shapes == file)
    throw InputError(file.string() + ": a problem file must not end in .glb, as its shapes do");
  const std::string text = imported_problem_text(assembly, shapes.filename().string());
  const std::string glb = shapes_glb(assembly);
  const std::optional<std::string> before = bytes_of(shapes);
  write_file(shapes, glb);
  try {
    write_file(file, text);
  } catch (...) {
    std::error_code ignored;
    if (before) {
      write_file(shapes, *before);
    } else {
      fs::remove(shapes, ignored);
    }
    throw;
  }
  return shapes;
}

}  // namespace orasp
