#include "orasp/mip/mip_model.h"

#include <array>

#include <gtest/gtest.h>

namespace orasp {
namespace {

TEST(MipModel, AddsUpTermsOfTheSameColumnAndDropsZeros) {
  MipModel model;
  const MipColumn x = model.add_binary("x");
  const MipColumn y = model.add_continuous("y", 4);
  model.add_row("r", MipSum().add(y, 2).add(x, 1).add(y, 3).add(x, -1).add(7), MipSense::AtMost, 9);
  EXPECT_EQ(model.num_rows(), 1U);
  EXPECT_EQ(model.columns_of(), std::vector<MipColumn>{y});
  EXPECT_EQ(model.values(), std::vector<double>{5});
  EXPECT_EQ(model.rows()[0].right, 2);  // 9 - 7
  EXPECT_EQ(model.num_integers(), 1U);
}

TEST(MipModel, KeepsNoRowThatIsTrueWithoutColumnsAndAContradictionForOneThatIsFalse) {
  MipModel model;
  const MipColumn x = model.add_binary("x");
  model.add_row("true", MipSum().add(x, 1).add(x, -1).add(1), MipSense::AtMost, 1);
  EXPECT_EQ(model.num_rows(), 0U);
  model.add_row("false", MipSum().add(2), MipSense::AtMost, 1);
  EXPECT_EQ(model.num_rows(), 1U);
  EXPECT_EQ(model.broken_by(std::array{0.0, 0.0}, 1e-9), "false");
}

TEST(MipModel, NamesWhatValuesBreak) {
  MipModel model;
  const MipColumn x = model.add_binary("x", 2);
  const MipColumn y = model.add_continuous("y", 4, -1);
  model.add_constant(10);
  model.add_row("r", MipSum().add(x, 1).add(y, 1), MipSense::AtLeast, 2);
  EXPECT_EQ(model.broken_by(std::array{1.0, 1.5}, 1e-9), "");
  EXPECT_EQ(model.broken_by(std::array{0.5, 1.5}, 1e-9), "x");
  EXPECT_EQ(model.broken_by(std::array{1.0, 4.5}, 1e-9), "y");
  EXPECT_EQ(model.broken_by(std::array{1.0, 0.5}, 1e-9), "r");
  EXPECT_EQ(model.objective_of(std::array{1.0, 1.5}), 10.5);
  model.fix(x, 0);
  EXPECT_EQ(model.broken_by(std::array{1.0, 1.5}, 1e-9), "x");
}

TEST(MipModel, MakesNamesOfIndices) {
  EXPECT_EQ(mip_name("in", 3, 12), "in_3_12");
  EXPECT_EQ(mip_name("x"), "x");
}

}  // namespace
}  // namespace orasp
