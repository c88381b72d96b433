#include "orasp/io/run_records.h"

#include <string>

#include <gtest/gtest.h>

#include "orasp/model/error.h"

namespace orasp {
namespace {

template <class Work>
std::string fault(Work&& work) {
  try {
    static_cast<void>(work());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(TrainingLog, LinesAreRead) {
  const auto points = parse_training_log(
      "{\"episodes\": 8, \"updates\": 1, \"greedy\": null, \"best_greedy\": null, \"best\": -2, "
      "\"bound\": -1.5}\n"
      "\n"
      "{\"episodes\": 16, \"greedy\": -1.75, \"best_greedy\": -1.75, \"best\": -1.5, \"bound\": "
      "-1.5}\n");
  ASSERT_EQ(points.size(), 2);
  EXPECT_EQ(points[0].episodes, 8);
  EXPECT_FALSE(points[0].greedy);
  EXPECT_EQ(points[0].best, -2);
  EXPECT_EQ(points[1].greedy, -1.75);
  EXPECT_EQ(points[1].bound, -1.5);
}

TEST(TrainingLog, AFaultNamesTheLine) {
  EXPECT_EQ(fault([] { return parse_training_log("{\"episodes\": 1}\n[]\n"); }),
            "training log, line 2: expected an object, found an empty array");
  EXPECT_EQ(fault([] { return parse_training_log("{\"greedy\": 1}\n"); }),
            "training log, line 1: the key \"episodes\" is missing or null");
  EXPECT_EQ(fault([] { return parse_training_log("{\"episodes\": 1, \"best\": \"x\"}"); }),
            "training log, line 1: best: expected a number or null, found the string \"x\"");
  EXPECT_EQ(fault([] { return parse_training_log("\n \n"); }), "the training log is empty");
}

TEST(Sample, RewardsAreReadFromTheCommandsOutputOrAPlainArray) {
  const std::vector<double> expected = {0.5, -1};
  EXPECT_EQ(parse_sample("{\"n\": 2, \"rewards\": [0.5, -1]}"), expected);
  EXPECT_EQ(parse_sample("[0.5, -1]"), expected);
}

TEST(Sample, WhatIsNoneIsRefused) {
  EXPECT_EQ(fault([] { return parse_sample("{}"); }),
            "the key \"rewards\" is missing, which `orasp sample --json` writes");
  EXPECT_EQ(fault([] { return parse_sample("[1, null]"); }),
            "expected an array of numbers, found null at place 1");
  EXPECT_EQ(fault([] { return parse_sample("{\"rewards\": []}"); }), "the sample holds no reward");
}

}  // namespace
}  // namespace orasp
