// SPDX-License-Identifier: GPL-3.0-or-later
// Which effects may keep their names.
#include "server/diagnosis/verdicts/path.h"

#include <gtest/gtest.h>

namespace tenter::diagnosis {
namespace {

TEST(Path, MoreIsAskedOfANameWhereMoreStaysUnexplained) {
  const auto stays = [](double share, double left) { return stands_in(share, left).empty(); };
  EXPECT_TRUE(stays(0.4, 0.05));
  EXPECT_FALSE(stays(0.3, 0.05));
  EXPECT_TRUE(stays(0.55, 0.2));
  EXPECT_FALSE(stays(0.45, 0.2));
  EXPECT_TRUE(stays(0.7, 0.29));
  EXPECT_FALSE(stays(0.55, 0.45));                    // what backlash leaves of a delay
  EXPECT_FALSE(stays(0.9, 0.6));                      // of the little that was left when it came in
  EXPECT_FALSE(stands_in(0.85, 0.15, true).empty());  // what a lens bends leaves of a scale
  EXPECT_TRUE(stands_in(0.95, 0.15, true).empty());
  EXPECT_TRUE(stands_in(0.85, 0.05, true).empty());
}

TEST(Path, ManyEffectsOfWhichNoneExplainsMuchAreASeries) {
  EXPECT_TRUE(is_a_series(3, 0.35));
  EXPECT_FALSE(is_a_series(2, 0.25));  // of two causes that add up
  EXPECT_FALSE(is_a_series(5, 0.6));   // a knit has many
}

}  // namespace
}  // namespace tenter::diagnosis
