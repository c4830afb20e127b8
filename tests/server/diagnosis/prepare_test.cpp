// SPDX-License-Identifier: GPL-3.0-or-later
// What is set aside before anything is fitted: misread samples, and not the top of a range.
#include "server/diagnosis/prepare.h"

#include <gtest/gtest.h>

#include "tests/server/diagnosis/prepared_twin.h"

namespace tenter::diagnosis {
namespace {

TEST(Prepare, LeavesTheFlatTopOfASaturatedCellToTheFit) {
  // so little is cut off that few readings show it, each in the middle of sharp peaks
  const Prepared cut =
      testing::prepared_twin({.effects = {"load_cell_saturation:x"}, .size = 1.0, .seed = 501});
  EXPECT_TRUE(cut.outliers.empty()) << cut.outliers.size();
}

TEST(Prepare, SetsMisreadSamplesAside) {
  const Prepared misread =
      testing::prepared_twin({.effects = {"outliers"}, .size = 3.0, .seed = 501});
  EXPECT_GE(misread.outliers.size(), 5U);
}

}  // namespace
}  // namespace tenter::diagnosis
