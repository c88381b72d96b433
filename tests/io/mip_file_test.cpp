// What the two formats look like. That CBC and HiGHS read them back is in
// tests/io/mip_file_test.py.

#include "orasp/io/mip_file.h"

#include <gtest/gtest.h>

#include "orasp/model/error.h"
#include "tests/files.h"

namespace orasp {
namespace {

/// minimise 2 x - y + z / 3 + 5 under 3 x + y <= 4, x - z >= -1, y = 2 w
MipModel small_model() {
  MipModel model;
  const MipColumn x = model.add_binary("x", 2);
  const MipColumn y = model.add_column({"y", -1, 0, 7, true});
  const MipColumn z = model.add_column({"z", 1.0 / 3, -2.5, 1e10, false});
  const MipColumn w = model.add_column({"w", 0, -std::numeric_limits<double>::infinity(),
                                        std::numeric_limits<double>::infinity(), false});
  model.add_column({"unused", 0, 1, 1, true});
  model.add_constant(5);
  model.add_row("first", MipSum().add(x, 3).add(y, 1), MipSense::AtMost, 4);
  model.add_row("second", MipSum().add(x, 1).add(z, -1), MipSense::AtLeast, -1);
  model.add_row("third", MipSum().add(y, 1).add(w, -2), MipSense::Equal, 0);
  model.add_remark("x is a part called \"\xc3\xa4\n\\\"");
  return model;
}

TEST(MipFile, WritesTheLpFormat) {
  EXPECT_EQ(lp_text(small_model()),
            "\\ x is a part called \"???\\\"\n"
            "Minimize\n"
            " objective: 2 x - y + 0.3333333333333333 z + 0 unused + 5 constant\n"
            "Subject To\n"
            " first: 3 x + y <= 4\n"
            " second: x - z >= -1\n"
            " third: y - 2 w = 0\n"
            "Bounds\n"
            " 0 <= y <= 7\n"
            " -2.5 <= z <= 10000000000\n"
            " w free\n"
            " unused = 1\n"
            " constant = 1\n"
            "Binaries\n"
            " x\n"
            "Generals\n"
            " y unused\n"
            "End\n");
}

TEST(MipFile, WritesFreeMps) {
  EXPECT_EQ(mps_text(small_model()),
            "* x is a part called \"???\\\"\n"
            "NAME orasp FREE\n"
            "ROWS\n"
            " N objective\n"
            " L first\n"
            " G second\n"
            " E third\n"
            "COLUMNS\n"
            " marker1 'MARKER' 'INTORG'\n"
            " x objective 2\n"
            " x first 3\n"
            " x second 1\n"
            " y objective -1\n"
            " y first 1\n"
            " y third 1\n"
            " marker2 'MARKER' 'INTEND'\n"
            " z objective 0.3333333333333333\n"
            " z second -1\n"
            " w third -2\n"
            " marker3 'MARKER' 'INTORG'\n"
            " unused objective 0\n"
            " marker4 'MARKER' 'INTEND'\n"
            " constant objective 5\n"
            "RHS\n"
            " rhs first 4\n"
            " rhs second -1\n"
            "BOUNDS\n"
            " BV bounds x\n"
            " UP bounds y 7\n"
            " LO bounds z -2.5\n"
            " UP bounds z 10000000000\n"
            " FR bounds w\n"
            " FX bounds unused 1\n"
            " FX bounds constant 1\n"
            "ENDATA\n");
}

TEST(MipFile, BreaksLongLinesOfTheLpFormat) {
  MipModel model;
  MipSum sum;
  for (int i = 0; i < 200; ++i) sum.add(model.add_binary(mip_name("column", i)), i + 1);
  model.add_row("long", sum, MipSense::AtMost, 7);
  const std::string text = lp_text(model);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    EXPECT_LE(end - at, 220U);
    at = end + 1;
  }
}

TEST(MipFile, TakesTheFormatFromTheEndingAndRefusesOthers) {
  const TemporaryFolder folder;
  const auto lp = folder.path() / "model.lp";
  const auto mps = folder.path() / "model.mps";
  write_model(small_model(), lp);
  write_model(small_model(), mps);
  EXPECT_EQ(bytes_of(lp), lp_text(small_model()));
  EXPECT_EQ(bytes_of(mps), mps_text(small_model()));
  for (const char* name : {"model", "model.txt", "model.LP"}) {
    try {
      write_model(small_model(), folder.path() / name);
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("FILE.lp or FILE.mps"), std::string::npos)
          << error.what();
    }
    EXPECT_FALSE(std::filesystem::exists(folder.path() / name));
  }
}

}  // namespace
}  // namespace orasp
