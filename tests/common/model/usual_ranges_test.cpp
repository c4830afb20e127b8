// SPDX-License-Identifier: Apache-2.0
#include "common/model/usual_ranges.h"

#include <gtest/gtest.h>

#include "common/model/presets.h"

namespace tenter::model {
namespace {

Term term_of(const char* strain, const char* law) {
  Term term;
  term.strain.name = strain;
  term.law.name = law;
  return term;
}

TEST(UsualRanges, AreKnownForStiffnessOfClothAlone) {
  EXPECT_TRUE(usual_range(term_of("green_u", "linear")));
  EXPECT_TRUE(usual_range(term_of("bend_d", "bspline_stiffness")));
  EXPECT_FALSE(usual_range(term_of("green_u", "dahl")));
  EXPECT_FALSE(usual_range(term_of("spring_u", "linear")));
  EXPECT_FALSE(usual_range(term_of("solid_green_xx", "linear")));
}

TEST(UsualRanges, PresetsOfClothStartInside) {
  for (const char* name : {"cloth_stvk", "cloth_stvk_spline", "cloth_soft", "cloth_soft_spline"}) {
    const Model model = preset(name).value();
    int seen = 0;
    for (const Term& term : model.terms) {
      const auto usual = usual_range(term);
      if (!usual) continue;
      for (const Parameter& p : term.law.parameters) {
        ++seen;
        EXPECT_GE(p.value, usual->lo) << name << " " << term.id << "." << p.name;
        EXPECT_LE(p.value, usual->hi) << name << " " << term.id << "." << p.name;
      }
    }
    EXPECT_GE(seen, 5) << name;
  }
}

}  // namespace
}  // namespace tenter::model
