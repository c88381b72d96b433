#include "orasp/report/part_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include "orasp/model/detail/vector_math.h"
#include "orasp/model/error.h"
#include "orasp/report/detail/glb_reader.h"
#include "orasp/report/detail/report_page.h"

namespace orasp {
namespace {

using detail::operator*;
using detail::PlacedMesh;
using detail::RawMesh;
using detail::RawShapes;
using detail::Transform;
using nlohmann::ordered_json;

/// What simplification may move without being seen, as shares of the product's and of the part's
/// size.
constexpr double kUnseenInProduct = 2e-4;
constexpr double kUnseenInPart = 4e-3;
/// A part keeps at least so many triangles, where it has them.
constexpr std::size_t kFewestTriangles = 48;
/// A corner is shaded as one surface where its triangles bend less, and drawn as an edge elsewhere.
constexpr double kSmoothCosine = 0.77;  // 40 degrees
constexpr std::size_t kMostNeighbours = 64;

struct Extent {
  Vector3 low{1e300, 1e300, 1e300};
  Vector3 high{-1e300, -1e300, -1e300};

  void add(const Vector3& point) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], point[k]);
      high[k] = std::max(high[k], point[k]);
    }
  }
  [[nodiscard]] double diagonal() const {
    return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  }
};

Vector3 wide(const std::array<float, 3>& point) {
  return {point[0], point[1], point[2]};
}

Extent extent_of(const RawMesh& mesh) {
  Extent extent;
  for (const std::uint32_t corner : mesh.corners) extent.add(wide(mesh.points[corner]));
  return extent;
}

/// Points at one place, as near as makes no difference, become one, and triangles without area go:
/// faces that were meshed one by one then hang together.
void weld(RawMesh& mesh) {
  constexpr double kSamePlace = 1e-6;
  const double grid = std::max(kSamePlace * extent_of(mesh).diagonal(), 1e-9);
  std::vector<std::array<std::int64_t, 3>> places(mesh.points.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k)
      places[i][k] = std::llround(static_cast<double>(mesh.points[i][k]) / grid);
  }
  std::vector<unsigned> remap(mesh.points.size());
  const std::size_t points =
      meshopt_generateVertexRemap(remap.data(), mesh.corners.data(), mesh.corners.size(),
                                  places.data(), places.size(), sizeof places[0]);
  std::vector<std::array<float, 3>> kept(points);
  meshopt_remapVertexBuffer(kept.data(), mesh.points.data(), mesh.points.size(),
                            sizeof mesh.points[0], remap.data());
  std::vector<std::uint32_t> corners;
  for (std::size_t i = 0; i + 2 < mesh.corners.size(); i += 3) {
    const std::uint32_t a = remap[mesh.corners[i]];
    const std::uint32_t b = remap[mesh.corners[i + 1]];
    const std::uint32_t c = remap[mesh.corners[i + 2]];
    if (a != b && b != c && c != a) corners.insert(corners.end(), {a, b, c});
  }
  if (corners.empty()) corners.assign(3, remap[mesh.corners[0]]);  // a part that is one point
  mesh.points = std::move(kept);
  mesh.corners = std::move(corners);
}

/// At best `triangles`, and no point moved by more than `error` (in units of the mesh).
void simplify(RawMesh& mesh, std::size_t triangles, double error) {
  const float scale =
      meshopt_simplifyScale(&mesh.points[0][0], mesh.points.size(), sizeof mesh.points[0]);
  if (!(scale > 0)) return;
  std::vector<std::uint32_t> fewer(mesh.corners.size());
  const std::size_t size =
      meshopt_simplify(fewer.data(), mesh.corners.data(), mesh.corners.size(), &mesh.points[0][0],
                       mesh.points.size(), sizeof mesh.points[0], triangles * 3,
                       static_cast<float>(error / static_cast<double>(scale)), 0, nullptr);
  if (size < 3) return;
  fewer.resize(size);
  mesh.corners = std::move(fewer);
}

/// Fewer triangles, whatever it costs the shape.
void simplify_sloppily(RawMesh& mesh, std::size_t triangles) {
  std::vector<std::uint32_t> fewer(mesh.corners.size());
  const std::size_t size = meshopt_simplifySloppy(
      fewer.data(), mesh.corners.data(), mesh.corners.size(), &mesh.points[0][0],
      mesh.points.size(), sizeof mesh.points[0], triangles * 3, 1.0F, nullptr);
  if (size < 3) return;
  fewer.resize(size);
  mesh.corners = std::move(fewer);
}

std::size_t drawn(const std::vector<RawMesh>& meshes, const std::vector<std::size_t>& times) {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < meshes.size(); ++i) sum += times[i] * (meshes[i].corners.size() / 3);
  return sum;
}

/// Brings what is drawn down to `most` triangles, each mesh in proportion.
void fit(std::vector<RawMesh>& meshes, const std::vector<std::size_t>& times, std::size_t most) {
  for (const bool sloppily : {false, true}) {
    const std::size_t all = drawn(meshes, times);
    if (all <= most) return;
    const double share = static_cast<double>(most) / static_cast<double>(all);
    for (RawMesh& mesh : meshes) {
      const std::size_t own = mesh.corners.size() / 3;
      const auto wanted = static_cast<std::size_t>(share * static_cast<double>(own));
      const std::size_t target = std::min(own, std::max(wanted, kFewestTriangles));
      if (own <= target) continue;
      if (sloppily) {
        simplify_sloppily(mesh, target);
      } else {
        simplify(mesh, target, 0.03 * extent_of(mesh).diagonal());
      }
    }
  }
}

/// A mesh as a page holds it: each point with a normal, triangles, and pairs of points that are
/// drawn as lines.
struct PageMesh {
  std::vector<std::array<float, 3>> points;
  std::vector<std::array<std::int8_t, 4>> normals;
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> lines;
};

Vector3 minus(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return {double{a[0]} - b[0], double{a[1]} - b[1], double{a[2]} - b[2]};
}
std::array<std::int8_t, 4> packed(const Vector3& normal) {
  std::array<std::int8_t, 4> bytes{};
  for (std::size_t k = 0; k < 3; ++k)
    bytes[k] = static_cast<std::int8_t>(std::lround(127 * std::clamp(normal[k], -1.0, 1.0)));
  return bytes;
}

/// The edges at which the surface ends or bends sharply, each once.
std::vector<std::array<std::uint32_t, 2>> sharp_edges(const RawMesh& mesh,
                                                      const std::vector<Vector3>& flat) {
  struct Side {
    std::array<std::uint32_t, 2> edge;
    std::size_t triangle;
  };
  std::vector<Side> sides;
  sides.reserve(mesh.corners.size());
  for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
    const std::size_t first = i / 3 * 3;
    const std::uint32_t a = mesh.corners[i];
    const std::uint32_t b = mesh.corners[first + (i + 1 - first) % 3];
    sides.push_back({{std::min(a, b), std::max(a, b)}, i / 3});
  }
  std::ranges::sort(sides, {},
                    [](const Side& side) { return std::pair(side.edge, side.triangle); });
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].edge == sides[i].edge) ++end;
    const bool smooth = end - i == 2 && detail::dot(flat[sides[i].triangle],
                                                    flat[sides[i + 1].triangle]) > kSmoothCosine;
    if (!smooth) edges.push_back(sides[i].edge);
    i = end;
  }
  return edges;
}

PageMesh shaded(const RawMesh& mesh) {
  const std::size_t triangles = mesh.corners.size() / 3;
  std::vector<Vector3> flat(triangles);   // of length 1
  std::vector<Vector3> heavy(triangles);  // as long as the triangle is large
  std::vector<std::vector<std::uint32_t>> around(mesh.points.size());
  for (std::size_t t = 0; t < triangles; ++t) {
    const auto point = [&](std::size_t k) { return mesh.points[mesh.corners[3 * t + k]]; };
    heavy[t] = detail::cross(minus(point(1), point(0)), minus(point(2), point(0)));
    flat[t] = detail::facing(heavy[t]);
    for (std::size_t k = 0; k < 3; ++k)
      around[mesh.corners[3 * t + k]].push_back(static_cast<std::uint32_t>(t));
  }
  PageMesh page;
  std::map<std::pair<std::uint32_t, std::array<std::int8_t, 4>>, std::uint32_t> known;
  std::vector<std::uint32_t> any(mesh.points.size());  // of the points of the page that lie there
  for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
    const std::uint32_t corner = mesh.corners[i];
    Vector3 normal = flat[i / 3];
    if (around[corner].size() <= kMostNeighbours) {
      Vector3 sum{};
      for (const std::uint32_t t : around[corner]) {
        if (detail::dot(flat[t], flat[i / 3]) <= kSmoothCosine) continue;
        for (std::size_t k = 0; k < 3; ++k) sum[k] += heavy[t][k];
      }
      if (detail::dot(sum, sum) > 0) normal = detail::facing(sum);
    }
    const auto bytes = packed(normal);
    const auto [entry, is_new] =
        known.emplace(std::pair(corner, bytes), static_cast<std::uint32_t>(page.points.size()));
    if (is_new) {
      page.points.push_back(mesh.points[corner]);
      page.normals.push_back(bytes);
    }
    any[corner] = entry->second;
    page.corners.push_back(entry->second);
  }
  for (const auto& [a, b] : sharp_edges(mesh, flat))
    page.lines.insert(page.lines.end(), {any[a], any[b]});
  // In an order that graphics cards like, and points in the order in which triangles use them.
  std::vector<std::uint32_t> ordered(page.corners.size());
  meshopt_optimizeVertexCache(ordered.data(), page.corners.data(), page.corners.size(),
                              page.points.size());
  std::vector<unsigned> remap(page.points.size());
  meshopt_optimizeVertexFetchRemap(remap.data(), ordered.data(), ordered.size(),
                                   page.points.size());
  PageMesh sorted;
  sorted.points.resize(page.points.size());
  sorted.normals.resize(page.points.size());
  for (std::size_t i = 0; i < page.points.size(); ++i) {
    sorted.points[remap[i]] = page.points[i];
    sorted.normals[remap[i]] = page.normals[i];
  }
  for (const std::uint32_t corner : ordered) sorted.corners.push_back(remap[corner]);
  for (const std::uint32_t end : page.lines) sorted.lines.push_back(remap[end]);
  return sorted;
}

/// Whether a place keeps angles: it turns, mirrors, moves and scales alike in all directions.
bool keeps_angles(const Transform& t) {
  const std::array<Vector3, 3> columns = {Vector3{t[0], t[1], t[2]}, Vector3{t[3], t[4], t[5]},
                                          Vector3{t[6], t[7], t[8]}};
  const double size = detail::dot(columns[0], columns[0]);
  constexpr double kExact = 1e-5;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(std::abs(detail::dot(columns[i], columns[i]) - size) <= kExact * size)) return false;
    if (!(std::abs(detail::dot(columns[i], columns[(i + 1) % 3])) <= kExact * size)) return false;
  }
  return size > 0;
}

double size_of(const Transform& t) {
  return std::sqrt(detail::dot({t[0], t[1], t[2]}, {t[0], t[1], t[2]}));
}

/// Meshes at places that do not keep angles are put there, so that normals and nodes may be simple.
void straighten(RawShapes& shapes) {
  for (PlacedMesh& part : shapes.of_part) {
    if (keeps_angles(part.place)) continue;
    RawMesh own = shapes.meshes[part.mesh];
    for (auto& point : own.points) {
      const Vector3 there = part.place * wide(point);
      for (std::size_t k = 0; k < 3; ++k) point[k] = static_cast<float>(there[k]);
    }
    part = {shapes.meshes.size(), detail::kIdentity};
    shapes.meshes.push_back(std::move(own));
  }
}

/// Turns what was written with y up, where the positions of the parts are in it then and not now.
void turn_upright(const Problem& problem, RawShapes& shapes) {
  constexpr Transform kTurn = {1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0};  // (x, y, z) to (x, -z, y)
  std::size_t inside = 0;
  std::size_t inside_turned = 0;
  std::size_t stated = 0;
  for (PartIndex part = 0; part < problem.num_parts(); ++part) {
    const auto& position = problem.parts()[part].position;
    if (!position) continue;
    ++stated;
    const PlacedMesh& placed = shapes.of_part[part];
    for (const bool turned : {false, true}) {
      const Transform place = turned ? kTurn * placed.place : placed.place;
      Extent extent;
      for (const auto& point : shapes.meshes[placed.mesh].points) extent.add(place * wide(point));
      const double slack = 0.01 * extent.diagonal();
      bool within = true;
      for (std::size_t k = 0; k < 3; ++k)
        within = within && (*position)[k] >= extent.low[k] - slack &&
                 (*position)[k] <= extent.high[k] + slack;
      (turned ? inside_turned : inside) += within ? 1 : 0;
    }
  }
  if (inside_turned != stated || inside == stated) return;
  for (PlacedMesh& part : shapes.of_part) part.place = kTurn * part.place;
}

// -------------------------------------------------------------------------------------------------
// Writing

/// The chunk of bytes of a file, and what its JSON says of them.
class GlbWriter {
 public:
  /// Adds a mesh; returns its number and the place that its whole numbers stand for.
  std::pair<std::size_t, Transform> add(const PageMesh& mesh, const std::array<double, 4>& colour);
  void add_node(const std::string& id, std::size_t part, std::size_t mesh, const Transform& place);
  [[nodiscard]] std::string text() const;

 private:
  /// The number of a view of these bytes. `stride` 0: of indices.
  std::size_t view(std::string_view bytes, std::size_t stride);
  std::size_t indices(const std::vector<std::uint32_t>& list, std::size_t points);
  std::size_t material(const std::array<double, 4>& colour);

  std::string bytes_;
  ordered_json views_ = ordered_json::array();
  ordered_json accessors_ = ordered_json::array();
  ordered_json meshes_ = ordered_json::array();
  ordered_json materials_ = ordered_json::array();
  ordered_json nodes_ = ordered_json::array();
};

template <class Element>
std::string_view bytes_of(const std::vector<Element>& list) {
  return {reinterpret_cast<const char*>(list.data()), list.size() * sizeof(Element)};
}

std::size_t GlbWriter::view(std::string_view bytes, std::size_t stride) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  ordered_json stated = {
      {"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
  if (stride > 0) stated["byteStride"] = stride;
  stated["target"] = stride > 0 ? 34962 : 34963;
  views_.push_back(std::move(stated));
  bytes_ += bytes;
  return views_.size() - 1;
}

std::size_t GlbWriter::indices(const std::vector<std::uint32_t>& list, std::size_t points) {
  const bool small = points <= 65535;
  std::size_t number = 0;
  if (small) {
    const std::vector<std::uint16_t> narrow(list.begin(), list.end());
    number = view(bytes_of(narrow), 0);
  } else {
    number = view(bytes_of(list), 0);
  }
  accessors_.push_back({{"bufferView", number},
                        {"componentType", small ? 5123 : 5125},
                        {"count", list.size()},
                        {"type", "SCALAR"}});
  return accessors_.size() - 1;
}

std::size_t GlbWriter::material(const std::array<double, 4>& colour) {
  ordered_json stated = ordered_json::object();
  if (colour[3] > 0) {
    ordered_json numbers = ordered_json::array();
    for (const double x : colour) numbers.push_back(std::round(x * 1000) / 1000);
    stated["pbrMetallicRoughness"]["baseColorFactor"] = std::move(numbers);
  }
  const auto found = std::ranges::find(materials_, stated);
  if (found != materials_.end()) return static_cast<std::size_t>(found - materials_.begin());
  materials_.push_back(std::move(stated));
  return materials_.size() - 1;
}

std::pair<std::size_t, Transform> GlbWriter::add(const PageMesh& mesh,
                                                 const std::array<double, 4>& colour) {
  struct Point {
    std::array<std::uint16_t, 4> position;
    std::array<std::int8_t, 4> normal;
  };
  Extent extent;
  for (const auto& point : mesh.points) extent.add(wide(point));
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) size = std::max(size, extent.high[k] - extent.low[k]);
  constexpr double kMost = 65535;
  const double step = size > 0 ? size / kMost : 1;
  std::vector<Point> points(mesh.points.size());
  std::array<std::uint16_t, 3> most{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double number = std::round((double{mesh.points[i][k]} - extent.low[k]) / step);
      points[i].position[k] = static_cast<std::uint16_t>(std::clamp(number, 0.0, kMost));
      most[k] = std::max(most[k], points[i].position[k]);
    }
    points[i].position[3] = 0;
    points[i].normal = mesh.normals[i];
  }
  const std::size_t number = view(bytes_of(points), sizeof(Point));
  accessors_.push_back({{"bufferView", number},
                        {"componentType", 5123},
                        {"count", points.size()},
                        {"type", "VEC3"},
                        {"min", {0, 0, 0}},
                        {"max", most}});
  accessors_.push_back({{"bufferView", number},
                        {"byteOffset", 8},
                        {"componentType", 5120},
                        {"normalized", true},
                        {"count", points.size()},
                        {"type", "VEC3"}});
  const std::size_t position = accessors_.size() - 2;
  const std::size_t painted = material(colour);
  ordered_json primitives = {{{"attributes", {{"POSITION", position}, {"NORMAL", position + 1}}},
                              {"indices", indices(mesh.corners, points.size())},
                              {"material", painted}}};
  if (!mesh.lines.empty())
    primitives.push_back({{"attributes", {{"POSITION", position}}},
                          {"indices", indices(mesh.lines, points.size())},
                          {"mode", 1}});
  meshes_.push_back({{"primitives", std::move(primitives)}});
  return {meshes_.size() - 1,
          {step, 0, 0, 0, step, 0, 0, 0, step, extent.low[0], extent.low[1], extent.low[2]}};
}

void GlbWriter::add_node(const std::string& id, std::size_t part, std::size_t mesh,
                         const Transform& p) {
  nodes_.push_back(
      {{"name", id},
       {"mesh", mesh},
       {"matrix",
        {p[0], p[1], p[2], 0, p[3], p[4], p[5], 0, p[6], p[7], p[8], 0, p[9], p[10], p[11], 1}},
       {"extras", {{"part", part}}}});
}

std::string GlbWriter::text() const {
  std::vector<std::size_t> all(nodes_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const ordered_json document = {
      {"asset", {{"version", "2.0"}, {"generator", "orasp " ORASP_VERSION}}},
      {"extensionsUsed", {"KHR_mesh_quantization"}},
      {"extensionsRequired", {"KHR_mesh_quantization"}},
      {"scene", 0},
      {"scenes", {{{"nodes", all}}}},
      {"nodes", nodes_},
      {"meshes", meshes_},
      {"materials", materials_},
      {"accessors", accessors_},
      {"bufferViews", views_},
      {"buffers", {{{"byteLength", bytes_.size()}}}}};
  std::string json = document.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string data = bytes_;
  data.resize((data.size() + 3) / 4 * 4);
  std::string text;
  const auto put = [&text](std::size_t number) {
    const auto word = static_cast<std::uint32_t>(number);
    text.append(reinterpret_cast<const char*>(&word), sizeof word);
  };
  text += "glTF";
  put(2);
  put(12 + 8 + json.size() + 8 + data.size());
  put(json.size());
  text += "JSON";
  text += json;
  put(data.size());
  text.append("BIN\0", 4);
  return text + data;
}

std::string written(const Problem& problem, const RawShapes& shapes,
                    const std::vector<RawMesh>& meshes) {
  GlbWriter writer;
  std::vector<std::pair<std::size_t, Transform>> places;
  places.reserve(meshes.size());
  for (std::size_t i = 0; i < meshes.size(); ++i)
    places.push_back(writer.add(shaded(meshes[i]), meshes[i].colour));
  for (PartIndex part = 0; part < problem.num_parts(); ++part) {
    const PlacedMesh& placed = shapes.of_part[part];
    const auto& [mesh, scale] = places[placed.mesh];
    writer.add_node(problem.part_id(part), part, mesh, placed.place * scale);
  }
  return writer.text();
}

}  // namespace

PartShapes part_shapes(const Problem& problem, std::string_view glb) {
  RawShapes shapes = detail::read_glb(problem, glb);
  straighten(shapes);
  turn_upright(problem, shapes);
  std::vector<std::size_t> times(shapes.meshes.size());
  std::vector<double> scale(shapes.meshes.size());  // the largest at which it is drawn
  Extent product;
  for (const PlacedMesh& part : shapes.of_part) {
    ++times[part.mesh];
    scale[part.mesh] = std::max(scale[part.mesh], size_of(part.place));
    for (const auto& point : shapes.meshes[part.mesh].points) product.add(part.place * wide(point));
  }
  PartShapes page;
  page.triangles_read = drawn(shapes.meshes, times);
  for (std::size_t i = 0; i < shapes.meshes.size(); ++i) {
    RawMesh& mesh = shapes.meshes[i];
    if (times[i] == 0) continue;  // each part that had it was straightened
    weld(mesh);
    const double unseen = std::min(kUnseenInPart * extent_of(mesh).diagonal(),
                                   kUnseenInProduct * product.diagonal() / scale[i]);
    simplify(mesh, std::min(kFewestTriangles, mesh.corners.size() / 3), unseen);
  }
  constexpr int kTries = 6;
  std::size_t most = kMaxPageTriangles;
  for (int i = 0; i < kTries; ++i, most /= 2) {
    fit(shapes.meshes, times, most);
    page.glb = written(problem, shapes, shapes.meshes);
    page.triangles = drawn(shapes.meshes, times);
    if (page.glb.size() <= kMaxPageShapeBytes) return page;
  }
  throw InputError(fmt::format("its {} are too much for a page, simplified as they may be",
                               detail::counted(page.triangles_read, "triangle")));
}

}  // namespace orasp
