// SPDX-License-Identifier: Apache-2.0
#include "common/capture/units.h"

#include <gtest/gtest.h>

namespace tenter::capture {
namespace {

TEST(Units, ConvertWhatLaboratoriesWrite) {
  const auto si = [](const std::string& from, const std::string& to) {
    const auto c = conversion(from, to);
    EXPECT_TRUE(c) << from;
    return c ? c->apply(1.0) : 0.0;
  };
  EXPECT_DOUBLE_EQ(si("mm", "m"), 1e-3);
  EXPECT_DOUBLE_EQ(si("inch", "m"), 0.0254);
  EXPECT_DOUBLE_EQ(si("kPa", "Pa"), 1e3);
  EXPECT_DOUBLE_EQ(si("N/mm2", "Pa"), 1e6);
  EXPECT_DOUBLE_EQ(si("N/mm", "N/m"), 1e3);
  EXPECT_DOUBLE_EQ(si("N/cm", "N/m"), 100.0);
  EXPECT_NEAR(si("lbf", "N"), 4.4482216152605, 1e-12);
  EXPECT_NEAR(si("gf", "N"), 9.80665e-3, 1e-15);
  EXPECT_DOUBLE_EQ(si("percent", "1"), 0.01);
  EXPECT_DOUBLE_EQ(si("%", "1"), 0.01);
  EXPECT_DOUBLE_EQ(si("min", "s"), 60.0);
  EXPECT_NEAR(si("degree", "radian"), 0.017453292519943295, 1e-17);
}

TEST(Units, LeaveSiUntouched) {
  const auto c = conversion("N/m", "N/m");
  ASSERT_TRUE(c);
  EXPECT_TRUE(c->identity);
  EXPECT_EQ(c->apply(0.1), 0.1);
}

TEST(Units, RefuseWhatDoesNotFit) {
  EXPECT_EQ(conversion("kPa", "N").error().message, "unit \"kPa\" cannot be turned into \"N\"");
  EXPECT_EQ(conversion("blorp", "m").error().message, "unknown unit \"blorp\"");
  EXPECT_EQ(conversion("", "1").error().message,
            "the unit is empty; write \"1\" for a plain number");
  // an angle is dimensionless to UDUNITS, but it is not an amount of shear
  EXPECT_EQ(conversion("degree", "1").error().message,
            "unit \"degree\" cannot be turned into a plain number");
  EXPECT_FALSE(conversion("radian", "1"));
  EXPECT_FALSE(conversion("1", "radian"));
}

}  // namespace
}  // namespace tenter::capture
