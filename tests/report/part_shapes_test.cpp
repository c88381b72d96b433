// The shapes of parts for a page: what is read of a binary glTF file, what is left of it, and what
// is said of files that are none.

#include "orasp/report/part_shapes.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/model/error.h"

namespace orasp {
namespace {

using nlohmann::json;

Problem problem_of(const std::vector<std::string>& ids,
                   const std::vector<std::optional<Vector3>>& positions = {}) {
  ProblemSpec spec;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Part part;
    part.id = ids[i];
    if (i < positions.size()) part.position = positions[i];
    spec.parts.push_back(part);
    if (i > 0) spec.connections.push_back({.id = {}, .parts = {ids[i - 1], ids[i]}});
  }
  return Problem(std::move(spec));
}

/// A file in the making: its JSON, and its bytes.
struct Glb {
  json document = {{"asset", {{"version", "2.0"}}}, {"nodes", json::array()}};
  std::string bytes;

  std::size_t accessor(const std::string& data, std::size_t count, int type, const char* shape) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", data.size()}});
    bytes += data;
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", type},
                                     {"count", count},
                                     {"type", shape}});
    return document["accessors"].size() - 1;
  }
  template <class Number>
  std::size_t list(const std::vector<Number>& numbers, int type, const char* shape,
                   std::size_t width) {
    std::string data(numbers.size() * sizeof(Number), '\0');
    std::memcpy(data.data(), numbers.data(), data.size());
    return accessor(data, numbers.size() / width, type, shape);
  }
  std::size_t mesh(const std::vector<float>& points, const std::vector<std::uint32_t>& corners) {
    const std::size_t position = list(points, 5126, "VEC3", 3);
    const std::size_t indices = list(corners, 5125, "SCALAR", 1);
    document["meshes"].push_back(
        {{"primitives", {{{"attributes", {{"POSITION", position}}}, {"indices", indices}}}}});
    return document["meshes"].size() - 1;
  }
  /// A box with a corner in the origin.
  std::size_t box(float x, float y, float z) {
    std::vector<float> points;
    for (int i = 0; i < 8; ++i) {
      points.insert(points.end(),
                    {(i & 1) != 0 ? x : 0.0F, (i & 2) != 0 ? y : 0.0F, (i & 4) != 0 ? z : 0.0F});
    }
    return mesh(points, {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                         2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5});
  }
  void node(const char* name, std::size_t mesh, const json& more = json::object()) {
    json one = {{"name", name}, {"mesh", mesh}};
    one.update(more);
    document["nodes"].push_back(one);
  }
  [[nodiscard]] std::string text() const {
    json whole = document;
    whole["buffers"] = {{{"byteLength", bytes.size()}}};
    std::string head = whole.dump();
    head.resize((head.size() + 3) / 4 * 4, ' ');
    std::string data = bytes;
    data.resize((data.size() + 3) / 4 * 4);
    std::string file = "glTF";
    const auto put = [&file](std::size_t number) {
      const auto word = static_cast<std::uint32_t>(number);
      file.append(reinterpret_cast<const char*>(&word), 4);
    };
    put(2);
    put(28 + head.size() + data.size());
    put(head.size());
    file += "JSON" + head;
    put(data.size());
    file.append("BIN\0", 4);
    return file + data;
  }
};

/// Two boxes: "a" 1 x 2 x 3 in the origin, "b" 1 x 1 x 1 three metres along x.
Glb two_boxes() {
  Glb glb;
  glb.node("a", glb.box(1, 2, 3));
  glb.node("b", glb.box(1, 1, 1), {{"translation", {3, 0, 0}}});
  return glb;
}

/// What a page draws of each part: the box around it, and how many triangles and lines it has.
struct Drawn {
  Vector3 low{1e9, 1e9, 1e9};
  Vector3 high{-1e9, -1e9, -1e9};
  std::size_t triangles = 0;
  std::size_t lines = 0;
  std::size_t mesh = 0;
};

std::vector<Drawn> drawn(const PartShapes& shapes) {
  const std::string& file = shapes.glb;
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, file.data() + at, 4);
    return value;
  };
  EXPECT_EQ(word(8), file.size());
  const json document = json::parse(file.substr(20, word(12)));
  const std::size_t data = 28 + word(12);
  std::vector<Drawn> parts;
  for (const json& node : document["nodes"]) {
    EXPECT_EQ(node["extras"]["part"], parts.size());
    Drawn part;
    part.mesh = node["mesh"];
    const json& primitives = document["meshes"][part.mesh]["primitives"];
    const json& points = document["accessors"][primitives[0]["attributes"]["POSITION"].get<int>()];
    const json& view = document["bufferViews"][points["bufferView"].get<int>()];
    for (std::size_t i = 0; i < points["count"]; ++i) {
      std::array<std::uint16_t, 3> point{};
      std::memcpy(point.data(), file.data() + data + view["byteOffset"].get<std::size_t>() + 12 * i,
                  6);
      const json& m = node["matrix"];
      for (std::size_t k = 0; k < 3; ++k) {
        const double x = m[k].get<double>() * point[0] + m[4 + k].get<double>() * point[1] +
                         m[8 + k].get<double>() * point[2] + m[12 + k].get<double>();
        part.low[k] = std::min(part.low[k], x);
        part.high[k] = std::max(part.high[k], x);
      }
    }
    const auto count = [&](std::size_t i) {
      return document["accessors"][primitives[i]["indices"].get<int>()]["count"].get<std::size_t>();
    };
    part.triangles = count(0) / 3;
    if (primitives.size() > 1) part.lines = count(1) / 2;
    parts.push_back(part);
  }
  return parts;
}

void expect_box(const Drawn& part, const Vector3& low, const Vector3& high) {
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(part.low[k], low[k], 1e-4);
    EXPECT_NEAR(part.high[k], high[k], 1e-4);
  }
}

std::string fault(const Problem& problem, std::string_view file) {
  try {
    (void)part_shapes(problem, file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

/// What is said of two boxes after a change.
std::string fault_after(const std::function<void(Glb&)>& change) {
  Glb glb = two_boxes();
  change(glb);
  return fault(problem_of({"a", "b"}), glb.text());
}

TEST(PartShapes, EachPartIsWhereItsNodeIs) {
  const PartShapes shapes = part_shapes(problem_of({"b", "a"}), two_boxes().text());
  const std::vector<Drawn> parts = drawn(shapes);
  ASSERT_EQ(parts.size(), 2);
  expect_box(parts[0], {3, 0, 0}, {4, 1, 1});
  expect_box(parts[1], {0, 0, 0}, {1, 2, 3});
  EXPECT_EQ(shapes.triangles, 24);
  EXPECT_EQ(shapes.triangles_read, 24);
}

TEST(PartShapes, ABoxHasTwelveTrianglesAndTwelveEdges) {
  const std::vector<Drawn> parts = drawn(part_shapes(problem_of({"a", "b"}), two_boxes().text()));
  EXPECT_EQ(parts[0].triangles, 12);
  EXPECT_EQ(parts[0].lines, 12);
}

// A node "group" turned by 90 degrees about z: (x, y, z) goes to (-y, x, z). In it "a", moved by
// (1, 0, 0), with a nameless half that is moved by (0, 0, 5); and, below "a", the part "b".
TEST(PartShapes, NodesBelowAPartAreItsOwnUnlessTheyAreOtherParts) {
  Glb glb;
  const std::size_t box = glb.box(1, 2, 3);
  const double half = std::sqrt(0.5);
  glb.document["nodes"] = {
      {{"name", "group"}, {"rotation", {0, 0, half, half}}, {"children", {1}}},
      {{"name", "a"}, {"translation", {1, 0, 0}}, {"mesh", box}, {"children", {2, 3}}},
      {{"translation", {0, 0, 5}}, {"mesh", box}},
      {{"name", "b"}, {"scale", {2, 2, 2}}, {"mesh", box}}};
  const PartShapes shapes = part_shapes(problem_of({"a", "b"}), glb.text());
  const std::vector<Drawn> parts = drawn(shapes);
  expect_box(parts[0], {-2, 1, 0}, {0, 2, 8});
  expect_box(parts[1], {-4, 1, 0}, {0, 3, 6});
  EXPECT_EQ(parts[0].triangles, 24);
}

TEST(PartShapes, PartsWithOneMeshShareIt) {
  Glb glb;
  const std::size_t box = glb.box(1, 1, 1);
  glb.node("a", box);
  glb.node("b", box, {{"translation", {2, 0, 0}}});
  glb.node("c", box, {{"scale", {1, 2, 1}}});
  const std::vector<Drawn> parts = drawn(part_shapes(problem_of({"a", "b", "c"}), glb.text()));
  EXPECT_EQ(parts[0].mesh, parts[1].mesh);
  EXPECT_NE(parts[0].mesh, parts[2].mesh) << "it is stretched, and its normals differ";
  expect_box(parts[2], {0, 0, 0}, {1, 2, 1});
}

TEST(PartShapes, NumbersOfSeveralTypesAreRead) {
  Glb glb;
  // 0 to 100 in bytes, without indices; a strip of two triangles in 16-bit numbers.
  const std::size_t bytes =
      glb.list<std::uint8_t>({0, 0, 0, 100, 0, 0, 0, 100, 0}, 5121, "VEC3", 3);
  const std::size_t shorts = glb.list<std::int16_t>(
      {0, 0, 0, 32767, 0, 0, 0, -32767, 0, 32767, -32767, 0}, 5122, "VEC3", 3);
  glb.document["accessors"][shorts]["normalized"] = true;
  const std::size_t indices = glb.list<std::uint8_t>({0, 1, 2, 3}, 5121, "SCALAR", 1);
  glb.document["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", bytes}}}}}}},
      {{"primitives",
        {{{"attributes", {{"POSITION", shorts}}}, {"indices", indices}, {"mode", 5}}}}}};
  glb.node("a", 0);
  glb.node("b", 1);
  const std::vector<Drawn> parts = drawn(part_shapes(problem_of({"a", "b"}), glb.text()));
  expect_box(parts[0], {0, 0, 0}, {100, 100, 0});
  expect_box(parts[1], {0, -1, 0}, {1, 0, 0});
  EXPECT_EQ(parts[1].triangles, 2);
}

TEST(PartShapes, AFileWithYUpIsTurnedWherePositionsSaySo) {
  const std::string file = two_boxes().text();
  // (x, y, z) goes to (x, -z, y): "a" to 0..1, -3..0, 0..2.
  const Problem turned = problem_of({"a", "b"}, {Vector3{0.5, -1.5, 1}, Vector3{3.5, -0.5, 0.5}});
  expect_box(drawn(part_shapes(turned, file))[0], {0, -3, 0}, {1, 0, 2});
  const Problem upright = problem_of({"a", "b"}, {Vector3{0.5, 1, 1.5}, Vector3{3.5, 0.5, 0.5}});
  expect_box(drawn(part_shapes(upright, file))[0], {0, 0, 0}, {1, 2, 3});
}

TEST(PartShapes, ManyTrianglesBecomeFewAndTheShapeStays) {
  // Forty spheres of 20,000 triangles each with a radius of 1.
  Glb glb;
  std::vector<float> points;
  std::vector<std::uint32_t> corners;
  constexpr std::uint32_t kRings = 100;
  for (std::uint32_t i = 0; i <= kRings; ++i) {
    for (std::uint32_t j = 0; j < kRings; ++j) {
      const double a = M_PI * i / kRings;
      const double b = 2 * M_PI * j / kRings;
      points.push_back(static_cast<float>(std::sin(a) * std::cos(b)));
      points.push_back(static_cast<float>(std::sin(a) * std::sin(b)));
      points.push_back(static_cast<float>(std::cos(a)));
      if (i == kRings) continue;
      const std::uint32_t next = (j + 1) % kRings;
      const std::uint32_t row = i * kRings;
      corners.insert(corners.end(), {row + j, row + kRings + j, row + next, row + next,
                                     row + kRings + j, row + kRings + next});
    }
  }
  const std::size_t mesh = glb.mesh(points, corners);
  std::vector<std::string> ids;
  for (int i = 0; i < 40; ++i) {
    ids.push_back("ball " + std::to_string(i));
    glb.node(ids.back().c_str(), mesh, {{"translation", {3 * i, 0, 0}}});
  }
  const Problem problem = problem_of(ids);
  const PartShapes shapes = part_shapes(problem, glb.text());
  EXPECT_EQ(shapes.triangles_read, 800'000);
  EXPECT_LE(shapes.triangles, kMaxPageTriangles);
  EXPECT_GT(shapes.triangles, kMaxPageTriangles / 20);
  EXPECT_LE(shapes.glb.size(), kMaxPageShapeBytes);
  const Drawn last = drawn(shapes).back();
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(last.high[k] - last.low[k], 2, 0.05);
  EXPECT_EQ(last.lines, 0) << "a sphere has no edge";
  EXPECT_EQ(shapes.glb, part_shapes(problem, glb.text()).glb);
}

TEST(PartShapes, WhatIsNoFileOfShapesIsSaidInAClause) {
  const Problem problem = problem_of({"a", "b"});
  const std::string file = two_boxes().text();
  EXPECT_EQ(fault(problem, ""), "it is not a binary glTF file");
  EXPECT_EQ(fault(problem, "solid cube"), "it is not a binary glTF file");
  EXPECT_EQ(fault(problem, file.substr(0, 9)), "it is cut off within its first 12 bytes");
  EXPECT_EQ(fault(problem, file.substr(0, 100)), "it is cut off after 100 of its " +
                                                     std::to_string(file.size() / 1000) + "," +
                                                     std::to_string(file.size() % 1000) + " bytes");
  std::string old = file;
  old[4] = 1;
  EXPECT_EQ(fault(problem, old), "it is glTF version 1, and 2 is read");
  std::string broken = file;
  broken[20] = '!';
  EXPECT_EQ(fault(problem, broken), "its JSON cannot be read");
  EXPECT_EQ(fault(problem_of({"a", "b", "lid"}), file), "no node in it has the id of part \"lid\"");
}

TEST(PartShapes, WhatIsDamagedIsSaidInAClause) {
  EXPECT_EQ(fault_after([](Glb& glb) { glb.document["nodes"][1]["name"] = "a"; }),
            "two nodes in it have the id of part \"a\"");
  EXPECT_EQ(fault_after([](Glb& glb) { glb.document["nodes"][1]["mesh"] = 7; }),
            "its JSON names the mesh 7, which is not there");
  EXPECT_EQ(fault_after([](Glb& glb) { glb.document["nodes"][1].erase("mesh"); }),
            "the node of part \"b\" in it has no triangle");
  EXPECT_EQ(fault_after([](Glb& glb) {
              glb.document["nodes"][1]["children"] = {0, 0};
            }),
            "its JSON lists the node 0 twice");
  EXPECT_EQ(fault_after([](Glb& glb) {
              glb.document["nodes"][0]["children"] = {1};
              glb.document["nodes"][1]["children"] = {0};
            }),
            "no node in it has the id of part \"a\"")
      << "in a circle of nodes none is the first";
  EXPECT_EQ(fault_after([](Glb& glb) { glb.document["accessors"][0]["count"] = 4'000'000'000U; }),
            "the accessor 0 in it reaches beyond the end of its bytes");
  EXPECT_EQ(fault_after([](Glb& glb) { glb.document["accessors"][0]["componentType"] = 5130; }),
            "the accessor 0 in it has numbers of type 5130, which are not read");
  EXPECT_EQ(fault_after([](Glb& glb) { glb.document["bufferViews"][0]["byteOffset"] = -4; }),
            "its JSON has a \"byteOffset\" that is no whole number");
  EXPECT_EQ(fault_after([](Glb& glb) { glb.bytes[glb.bytes.size() - 4] = 100; }),
            "a triangle in it has a corner that is not there");
  EXPECT_EQ(fault_after([](Glb& glb) {
              const std::uint32_t nan = 0x7FC00000;
              std::memcpy(glb.bytes.data(), &nan, 4);
            }),
            "a point in it is not a number, or farther than 1e9 m");
  EXPECT_EQ(fault_after([](Glb& glb) {
              glb.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
            }),
            "it needs the extension \"KHR_draco_mesh_compression\", which is not read");
}

// Whatever bytes a file has, the answer is shapes or a clause.
TEST(PartShapes, NoByteOfAFileDoesHarm) {
  const Problem problem = problem_of({"a", "b"});
  const std::string file = two_boxes().text();
  for (std::size_t at = 0; at < file.size(); at += 3) {
    for (const char byte : {'\0', '\xff', '9', '"'}) {
      std::string changed = file;
      changed[at] = byte;
      EXPECT_FALSE(fault(problem, changed).empty());
    }
    EXPECT_NE(fault(problem, file.substr(0, at)), "no fault");
  }
}

}  // namespace
}  // namespace orasp
