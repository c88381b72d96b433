// From meshes that are built here to a problem: ids, masses, connections, what blocks, findings,
// and the two files.

#include <algorithm>
#include <cstring>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/catalogue.h"
#include "orasp/geometry/assembly_from_cad.h"
#include "orasp/io/import_files.h"
#include "orasp/io/model_files.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using nlohmann::json;

/// A box along the axes, its faces outward.
CadPart box(const std::string& name, const Vector3& low, const Vector3& high) {
  CadPart part;
  part.name = name;
  for (const double x : {low[0], high[0]}) {
    for (const double y : {low[1], high[1]}) {
      for (const double z : {low[2], high[2]}) part.mesh.vertices.push_back({x, y, z});
    }
  }
  part.mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                         {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  return part;
}

/// Three boxes of 10 mm in a row along x; the one in the middle is a little higher.
CadModel row() {
  CadModel model;
  model.name = "row";
  model.parts = {box("block", {0, 0, 0}, {10, 10, 10}), box("block", {10, 0, 0}, {20, 10, 12}),
                 box("block", {20, 0, 0}, {30, 10, 10})};
  for (const std::size_t i : {0, 2}) {
    model.parts[i].product = "block";
    model.parts[i].placement =
        Placement{.axes = Placement{}.axes, .origin = {static_cast<double>(i) * 10, 0, 0}};
  }
  return model;
}

std::string refusal(const auto& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(Import, IdsAreNamesMadeUnique) {
  CadModel model = row();
  model.parts[0].name = "  block ";
  model.parts[2].name = "block 2";
  const ImportedAssembly assembly = assembly_from_cad(model, {});
  EXPECT_EQ(assembly.parts[0].id, "block");
  EXPECT_EQ(assembly.parts[1].id, "block 3");  // "block 2" is the name of another part
  EXPECT_EQ(assembly.parts[2].id, "block 2");
}

TEST(Import, NamesThatAreNoIdsAreMadeSome) {
  CadModel model = row();
  model.parts[0].name = "";
  model.parts[1].name = "a\nb";
  model.parts[2].name = "caf\xC3\xA9 \xFF";
  const ImportedAssembly assembly = assembly_from_cad(model, {});
  EXPECT_EQ(assembly.parts[0].id, "part 1");
  EXPECT_EQ(assembly.parts[1].id, "a b");
  EXPECT_EQ(assembly.parts[2].id, "caf\xC3\xA9 ?");
  EXPECT_NO_THROW(static_cast<void>(Problem(assembly.problem)));
}

TEST(Import, MassIsVolumeTimesDensityAndItsSourceIsKept) {
  CadModel model = row();
  model.parts[0].density = 2700;
  model.parts[1].name = "screw M5x10";
  ImportSettings settings;
  const ImportedAssembly assembly = assembly_from_cad(model, settings);
  // 1,000 mm^3 are 1e-6 m^3; the middle one has 1,200 mm^3.
  EXPECT_NEAR(assembly.problem.parts[0].mass, 2700e-6, 1e-12);
  EXPECT_EQ(assembly.parts[0].source, DensitySource::File);
  EXPECT_NEAR(assembly.problem.parts[1].mass, 7850 * 1.2e-6, 1e-12);
  EXPECT_EQ(assembly.parts[1].source, DensitySource::Name);
  EXPECT_NEAR(assembly.problem.parts[2].mass, 1200e-6, 1e-12);
  EXPECT_EQ(assembly.parts[2].source, DensitySource::Default);

  settings.densities = {.others = 1000, .by_part = {{"screw*", 8000}}};
  const ImportedAssembly given = assembly_from_cad(model, settings);
  EXPECT_NEAR(given.problem.parts[1].mass, 8000 * 1.2e-6, 1e-12);
  EXPECT_NEAR(given.problem.parts[2].mass, 1000e-6, 1e-12);
  EXPECT_EQ(given.parts[2].source, DensitySource::Given);
}

TEST(Import, EqualPartsWeighTheSameToTheLastDigit) {
  CadModel model = row();
  model.parts[0].volume = 1000;
  model.parts[2].volume = 1000.02;  // measured where it lies
  const ImportedAssembly assembly = assembly_from_cad(model, {});
  EXPECT_EQ(assembly.problem.parts[0].mass, assembly.problem.parts[2].mass);
  model.parts[2].volume = 1100;  // of one name, but another shape
  const ImportedAssembly others = assembly_from_cad(model, {});
  EXPECT_LT(others.problem.parts[0].mass, others.problem.parts[2].mass);
}

TEST(Import, ADensityThatNoMaterialHasIsPassedOver) {
  CadModel model = row();
  model.parts[0].density = 2.7e6;
  const ImportedAssembly assembly = assembly_from_cad(model, {});
  EXPECT_EQ(assembly.parts[0].source, DensitySource::Default);
  EXPECT_TRUE(std::ranges::any_of(assembly.warnings, [](const std::string& warning) {
    return warning.find("no material has") != std::string::npos;
  }));
}

TEST(Import, PartsThatTouchAreJoinedAndBlockEachOther) {
  const ImportedAssembly assembly = assembly_from_cad(row(), {});
  ASSERT_EQ(assembly.contacts.size(), 2U);
  EXPECT_EQ(assembly.problem.connections[0].id, "block-block 2");
  EXPECT_EQ(assembly.problem.connections[1].id, "block 2-block 3");
  EXPECT_NEAR(assembly.contacts[0].area, 100, 1);
  // The first is blocked by the second along +x alone, as is the second by the third; and the
  // first by the third.
  const std::vector<PairFacts> pairs = facts_by_pair(assembly);
  ASSERT_EQ(pairs.size(), 3U);
  for (const PairFacts& pair : pairs) {
    ASSERT_EQ(pair.facts.size(), 1U);
    EXPECT_EQ(pair.facts[0].direction, "+x");
    EXPECT_NEAR(pair.facts[0].fact->width, 10, 0.5);
  }
  EXPECT_EQ(assembly.moved, 1U);
  EXPECT_EQ(assembly.problem.limits.max_moved_parts, 1U);
}

TEST(Import, TheBaseIsThePartWithMostConnectionsUnlessNamed) {
  ImportSettings settings;
  const ImportedAssembly chosen = assembly_from_cad(row(), settings);
  EXPECT_TRUE(chosen.base_chosen);
  EXPECT_EQ(chosen.problem.base, std::vector<std::string>{"block 2"});
  EXPECT_TRUE(chosen.problem.limits.grounded);
  settings.base = "none";
  const ImportedAssembly none = assembly_from_cad(row(), settings);
  EXPECT_TRUE(none.problem.base.empty());
  EXPECT_FALSE(none.problem.limits.grounded);
  settings.base = "block 3";
  const ImportedAssembly named = assembly_from_cad(row(), settings);
  EXPECT_FALSE(named.base_chosen);
  EXPECT_TRUE(named.problem.limits.grounded);
}

TEST(Import, TheProblemIsSolved) {
  const Result result = solve(Problem(assembly_from_cad(row(), {}).problem), "auto");
  EXPECT_EQ(result.status, Status::Optimal);
  EXPECT_EQ(result.steps.size(), 2U);  // from the one in the middle, which is the base
}

TEST(Import, SettingsNamePartsByIdByNameAndByPattern) {
  ImportSettings settings;
  settings.exclude = "block 2";
  EXPECT_EQ(assembly_from_cad(row(), settings).parts.size(), 2U);
  settings.exclude = "block 2,block 3";
  const ImportedAssembly one = assembly_from_cad(row(), settings);
  ASSERT_EQ(one.parts.size(), 1U);
  EXPECT_EQ(one.parts[0].id, "block");
  settings.exclude = "*";
  EXPECT_EQ(refusal([&] { static_cast<void>(assembly_from_cad(row(), settings)); }),
            "exclude: no part is left");
  settings.exclude = "";
  settings.base = "housing";
  EXPECT_EQ(refusal([&] { static_cast<void>(assembly_from_cad(row(), settings)); }),
            R"(base: no part is called "housing"; parts are called "block")");
  settings.base = "block 3";
  EXPECT_EQ(assembly_from_cad(row(), settings).problem.base, std::vector<std::string>{"block 3"});
}

TEST(Import, AFlexiblePartIsJoinedButBlocksNothing) {
  ImportSettings settings;
  settings.flexible = "block 2";
  const ImportedAssembly assembly = assembly_from_cad(row(), settings);
  EXPECT_EQ(assembly.contacts.size(), 2U);
  ASSERT_EQ(assembly.facts.size(), 1U);
  EXPECT_EQ(assembly.facts[0].part, 0U);
  EXPECT_EQ(assembly.facts[0].by, 2U);
}

TEST(Import, APartInAClosedBoxIsLockedAndTheUserIsAsked) {
  CadModel model;
  model.name = "closed";
  model.parts = {box("shell", {0, 0, 0}, {20, 20, 20}), box("core", {5, 5, 5}, {15, 15, 15})};
  // The shell's cavity is the core, inside out.
  Mesh& shell = model.parts[0].mesh;
  for (const Vector3& vertex : model.parts[1].mesh.vertices) shell.vertices.push_back(vertex);
  for (auto [a, b, c] : model.parts[1].mesh.triangles)
    shell.triangles.push_back({a + 8, c + 8, b + 8});
  const ImportedAssembly assembly = assembly_from_cad(model, {});
  ASSERT_EQ(assembly.locked.size(), 1U);
  EXPECT_TRUE(assembly.locked[0].joined);
  EXPECT_EQ(assembly.stuck, (std::vector<std::vector<std::uint32_t>>{{0, 1}}));
  ASSERT_FALSE(assembly.questions.empty());
  EXPECT_NE(assembly.questions.front().find("block each other along every direction"),
            std::string::npos);
  EXPECT_EQ(solve(Problem(assembly.problem), "auto").status, Status::Infeasible);
}

TEST(Import, PartsInTheirOwnFramesAreMissedPoses) {
  CadModel model;
  model.name = "frames";
  for (int i = 0; i < 4; ++i) {
    const double half = 5 + i;
    model.parts.push_back(box("part", {-half, -half, -half / 2}, {half, half, half / 2}));
  }
  const ImportedAssembly assembly = assembly_from_cad(model, {});
  EXPECT_TRUE(std::ranges::any_of(assembly.warnings, [](const std::string& warning) {
    return warning.find("poses are missing") != std::string::npos;
  }));
}

TEST(Import, ThreadsDoNotChangeAByte) {
  ImportSettings settings;
  std::string problem;
  std::string shapes;
  for (const unsigned threads : {1U, 2U, 5U}) {
    settings.threads = threads;
    const ImportedAssembly assembly = assembly_from_cad(row(), settings);
    if (threads == 1) {
      problem = imported_problem_text(assembly, "row.glb");
      shapes = shapes_glb(assembly);
    }
    EXPECT_EQ(imported_problem_text(assembly, "row.glb"), problem);
    EXPECT_EQ(shapes_glb(assembly), shapes);
  }
}

TEST(Import, TheFileTellsWhatTheModelTells) {
  const json file = json::parse(imported_problem_text(assembly_from_cad(row(), {}), "row.glb"));
  EXPECT_EQ(file["geometry"]["file"], "row.glb");
  EXPECT_EQ(file["action"], "part");
  EXPECT_EQ(file["parts"][0]["product"], "block");
  EXPECT_FALSE(file["parts"][1].contains("product"));
  EXPECT_EQ(file["parts"][2]["product"], "block");
  EXPECT_EQ(file["parts"][0]["x-density-source"], "default");
  EXPECT_NEAR(file["parts"][1]["x-volume"], 1.2e-6, 1e-12);
  EXPECT_NEAR(file["parts"][1]["position"][0], 0.015, 1e-12);
  EXPECT_EQ(file["connections"][0]["x-kind"], "contact");
  EXPECT_NEAR(file["connections"][0]["x-area"], 1e-4, 1e-6);
  const json& blocked = file["blocking"]["blocked"][0];
  EXPECT_EQ(blocked["directions"], json({"+x"}));
  ASSERT_EQ(blocked["x-width"].size(), 1U);
  EXPECT_NEAR(blocked["x-width"][0], 0.01, 0.0005);
  EXPECT_GT(blocked["x-depth"][0], 0);
}

/// The JSON of a binary glTF file.
json document_of(const std::string& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  return json::parse(glb.substr(20, length));
}

TEST(Import, EqualPartsShareAMeshInTheFileOfShapes) {
  const std::string glb = shapes_glb(assembly_from_cad(row(), {}));
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 8, 4);
  EXPECT_EQ(length, glb.size());
  const json document = document_of(glb);
  ASSERT_EQ(document["nodes"].size(), 3U);
  EXPECT_EQ(document["nodes"][0]["name"], "block");
  EXPECT_EQ(document["nodes"][0]["mesh"], document["nodes"][2]["mesh"]);
  EXPECT_EQ(document["nodes"][2]["translation"], json({0.02, 0.0, 0.0}));
  EXPECT_EQ(document["meshes"].size(), 2U);
  // In metres, and a box has its eight corners once for each of three faces.
  const json& positions = document["accessors"][0];
  EXPECT_EQ(positions["count"], 24);
  EXPECT_NEAR(positions["max"][0], 0.01, 1e-9);
}

TEST(Poses, AreReadInFourWays) {
  const Poses poses = parse_poses(R"({
    "a": {"position": [1, 2, 3]},
    "b": {"position": [0, 0, 0], "euler": [0, 0, 1.5707963267948966]},
    "c": {"quaternion": [0.7071067811865476, 0, 0, 0.7071067811865476]},
    "d": {"matrix": [[0, -1, 0], [1, 0, 0], [0, 0, 1]]},
    "e": {"final_state": [1, 2, 3, 0, 0, 1.5707963267948966], "initial_state": [0, 0, 0, 0, 0, 0]}
  })");
  ASSERT_EQ(poses.by_name.size(), 5U);
  EXPECT_EQ(poses.by_name.at("a").placed({1, 1, 1}), (Vector3{2, 3, 4}));
  for (const char* const name : {"b", "c", "d", "e"}) {  // a quarter turn about z: x becomes y
    const Vector3 turned = poses.by_name.at(name).turned({1, 0, 0});
    EXPECT_NEAR(turned[0], 0, 1e-12) << name;
    EXPECT_NEAR(turned[1], 1, 1e-12) << name;
  }
  EXPECT_EQ(poses.by_name.at("e").origin, (Vector3{1, 2, 3}));
}

TEST(Poses, EulerAnglesTurnAboutTheFixedXThenYThenZ) {
  // About x by 90 degrees, z goes to -y; then about z by 90 degrees, -y goes to x.
  const Poses poses =
      parse_poses(R"({"a": {"euler": [1.5707963267948966, 0, 1.5707963267948966]}})");
  const Vector3 turned = poses.by_name.at("a").turned({0, 0, 1});
  EXPECT_NEAR(turned[0], 1, 1e-12);
  EXPECT_NEAR(turned[1], 0, 1e-12);
  EXPECT_NEAR(turned[2], 0, 1e-12);
}

TEST(Poses, FaultsAreOneSentenceWithTheirPlace) {
  const auto fault = [](const char* text) {
    return refusal([&] { static_cast<void>(parse_poses(text)); });
  };
  EXPECT_EQ(fault(R"({"a": {"quaternion": [0, 0, 0, 0]}})"),
            "a.quaternion: a quaternion of length 0 is no turn");
  EXPECT_EQ(fault(R"({"a": {"matrix": [[2, 0, 0], [0, 1, 0], [0, 0, 1]]}})"),
            "a.matrix: the matrix is not a turn: its rows are not of length 1 and upright");
  EXPECT_NE(fault(R"({"a": {"place": [1, 2, 3]}})").find("unknown key \"place\""),
            std::string::npos);
  EXPECT_NE(fault(R"({"a": {"euler": [0, 0, 0], "quaternion": [1, 0, 0, 0]}})").find("exclude"),
            std::string::npos);
}

TEST(ReadModel, WhatIsNotThereIsNamed) {
  EXPECT_EQ(refusal([] { static_cast<void>(read_model({.models = {"nowhere.step"}}, {})); }),
            "nowhere.step: there is no such file or folder");
}

}  // namespace
}  // namespace orasp
