#include "orasp/io/scenarios.h"

#include <string>

#include <gtest/gtest.h>

#include "orasp/io/problem_json.h"
#include "tests/fault.h"
#include "tests/files.h"

namespace orasp {
namespace {

TEST(Scenarios, AreTheFilesOfTheDataFolder) {
  std::size_t embedded = 0;
  for (const ScenarioInfo& scenario : scenarios()) {
    if (scenario.generator) continue;
    ++embedded;
    const auto file = source_folder() / "data" / "scenarios" / (scenario.name + ".json");
    EXPECT_EQ(problem_digest(load_scenario(scenario.name)), problem_digest(read_problem(file)))
        << scenario.name;
  }
  EXPECT_EQ(embedded, json_files(source_folder() / "data" / "scenarios").size());
}

TEST(Scenarios, AreThePublishedOnes) {
  const auto folder = shared_folder() / "scenarios";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  for (const auto& file : json_files(folder)) {
    const std::string name = file.stem().string();
    ASSERT_TRUE(is_scenario(name)) << name;
    EXPECT_EQ(problem_digest(load_scenario(name)), problem_digest(read_problem(file))) << name;
  }
}

TEST(Scenarios, HaveASummaryInOneLine) {
  for (const ScenarioInfo& scenario : scenarios()) {
    EXPECT_FALSE(scenario.summary.empty()) << scenario.name;
    EXPECT_EQ(scenario.summary.find('\n'), std::string::npos) << scenario.name;
    if (scenario.name == "hubble") {
      EXPECT_EQ(scenario.summary, "Hubble: 20 parts, 19 connections, precedence");
    }
    if (scenario.name == "hubble-upc") {
      EXPECT_NE(scenario.summary.find(", limits"), std::string::npos);
    }
  }
}

TEST(Scenarios, HaveTheSizesOfThePaper) {
  EXPECT_EQ(load_scenario("lattice").num_connections(), 12U);
  EXPECT_EQ(load_scenario("hubble").num_parts(), 20U);
  EXPECT_EQ(load_scenario("hubble").num_connections(), 19U);
  EXPECT_EQ(load_scenario("jwst").num_parts(), 180U);
  EXPECT_EQ(load_scenario("jwst").num_connections(), 256U);
}

TEST(Scenarios, AreGeneratedFromTheirForm) {
  EXPECT_EQ(load_scenario("chain:50").num_connections(), 49U);
  EXPECT_EQ(load_scenario("chain:1").num_connections(), 0U);
  EXPECT_EQ(load_scenario("grid:5x4").num_parts(), 20U);
  EXPECT_EQ(load_scenario("tree:500:7").num_connections(), 499U);
  EXPECT_EQ(load_scenario("random:50:80:3").num_connections(), 80U);
  EXPECT_EQ(load_scenario("random:50:80:3").name(), "random:50:80:3");
  EXPECT_EQ(load_scenario("tree:3:18446744073709551615").num_parts(), 3U);
}

TEST(Scenarios, SayTheFormOfAGeneratorThatWasBegun) {
  EXPECT_EQ(fault_of([] { return load_scenario("chain:x"); }),
            "\"chain:x\" is not a scenario; write chain:N with whole numbers, as in chain:50");
  for (const char* name :
       {"chain:", "chain:-1", "chain:5 ", "chain:5:1", "grid:5", "grid:5x", "grid:5y5", "tree:5",
        "tree:5:", "random:5:6", "random:5:6:1.5", "chain:99999999999999999999"}) {
    EXPECT_NE(fault_of([&] { return load_scenario(name); }).find("is not a scenario; write "),
              std::string::npos)
        << name;
  }
  EXPECT_EQ(fault_of([] { return load_scenario("chain:0"); }),
            "chain:0: 0 parts are not possible; it takes 1 to 16384");
}

TEST(Scenarios, NameTheKnownOnesAndTheNearest) {
  const std::string fault = fault_of([] { return load_scenario("hubbel"); });
  EXPECT_EQ(fault.find("no scenario \"hubbel\"; scenarios are "), 0U);
  EXPECT_NE(fault.find("lattice, "), std::string::npos);
  EXPECT_NE(fault.find(", grid:RxC, "), std::string::npos);
  EXPECT_NE(fault.find("; did you mean \"hubble\"?"), std::string::npos);
}

TEST(Scenarios, AreRecognisedByNameOrForm) {
  EXPECT_TRUE(is_scenario("hubble"));
  EXPECT_TRUE(is_scenario("chain:50"));
  EXPECT_TRUE(is_scenario("chain:x"));  // so that load_scenario can say what is wrong
  EXPECT_FALSE(is_scenario("chain"));
  EXPECT_FALSE(is_scenario("chain.json"));
  EXPECT_FALSE(is_scenario(""));
}

}  // namespace
}  // namespace orasp
