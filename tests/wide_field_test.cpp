#include <filesystem>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/io/problem_json.h"
#include "tests/files.h"
#include "tests/wide_oracle.h"

namespace orasp::oracle {
namespace {

using nlohmann::json;

json field_file(const std::string& name) {
  const std::filesystem::path file = shared_folder() / "field" / name;
  return std::filesystem::exists(file) ? json::parse(bytes_of(file)) : json();
}

ProblemSpec spec_of(const json& problem) {
  return parse_problem(problem.dump()).spec();
}

constexpr const char* kAbsent = "no folder field with published cases";

void expect_reward(const std::string& name, const ProblemSpec& spec, std::optional<double> reward) {
  const WideResult found = wide_brute_force(spec);
  ASSERT_EQ(found.best.has_value(), reward.has_value()) << name;
  EXPECT_EQ(found.plans > 0, reward.has_value()) << name;
  if (!reward) return;
  EXPECT_NEAR(*found.best, *reward, 1e-9) << name;
  const std::optional<double> replayed = wide_reward_of(spec, found.best_plan);
  ASSERT_TRUE(replayed.has_value()) << name;
  EXPECT_NEAR(*replayed, *reward, 1e-9) << name;
}

TEST(WideField, RandomProblemsOfOthers) {
  const json all = field_file("wide_random.json");
  if (all.is_null()) GTEST_SKIP() << kAbsent;
  EXPECT_EQ(all.size(), 60U);
  for (const auto& [name, entry] : all.items()) {
    const json& reward = entry.at("reward");
    expect_reward(name, spec_of(entry.at("problem")),
                  reward.is_null() ? std::nullopt : std::optional<double>(reward));
  }
}

TEST(WideField, CasesWithKnownValues) {
  const json ramp = field_file("wide_ramp.json");
  if (ramp.is_null()) GTEST_SKIP() << kAbsent;
  const WideResult built = wide_brute_force(spec_of(ramp));
  EXPECT_EQ(built.best, 1693);
  EXPECT_EQ(built.plans, 3600U);
  expect_reward("selective", spec_of(field_file("wide_selective.json")), -37);
  expect_reward("grippers", spec_of(field_file("wide_grippers12.json")), -12);
  expect_reward("board", spec_of(field_file("wide_board.json")), -2);
}

}  // namespace
}  // namespace orasp::oracle
