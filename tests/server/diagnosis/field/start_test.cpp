// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/data/start.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/diagnosis/field/sheet_of.h"

namespace tenter::diagnosis {
namespace {

using testing::compliant_cloth;
using testing::data_of;
using testing::sheets_of;
using testing::SheetTruth;

model::Model membrane_times(double factor) {
  model::Model model = compliant_cloth();
  for (model::Parameter* p : estimation::parameters_of(model))
    if (p->unit == "N/m") p->value *= factor;
  return model;
}

TEST(Start, ForcesSayHowStiffAMembraneIs) {
  const FieldData data =
      data_of(sheets_of({.model = compliant_cloth(), .frames = 8}, compliant_cloth()));
  const model::Model truth = compliant_cloth();
  for (const double factor : {0.02, 1.0, 30.0}) {
    const auto scaled = scaled_to_forces(membrane_times(factor), data);
    ASSERT_TRUE(scaled) << factor;
    const auto found = estimation::parameters_of(*scaled),
               true_ones = estimation::parameters_of(truth);
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (found[i]->unit != "N/m" || !(true_ones[i]->value > 0.0)) continue;
      const double share = found[i]->value / true_ones[i]->value;
      EXPECT_GT(share, 0.5) << factor;  // bending has its part of the force
      EXPECT_LT(share, 2.0) << factor;
    }
  }
}

TEST(Start, WithoutForcesNothingIsSaidOfAMembrane) {
  FieldData data = data_of(sheets_of({.model = compliant_cloth(), .frames = 4}, compliant_cloth()));
  for (auto& sequence : data.sequences)
    for (auto& frame : sequence.frames) frame.forces_N.setConstant(std::nan(""));
  EXPECT_FALSE(scaled_to_forces(compliant_cloth(), data));
}

}  // namespace
}  // namespace tenter::diagnosis
