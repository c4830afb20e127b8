// SPDX-License-Identifier: GPL-3.0-or-later
// The curves that models are exported with are those that simulations run on.
#include "common/model/export/term_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "server/mechanics/law.h"

namespace tenter::mechanics {
namespace {

TEST(TermCurve, IsTheLawOfTheSimulation) {
  for (const char* name : {"linear", "constant_stress", "hermite_stiffness", "bspline_stiffness",
                           "convex_spline", "hermite_energy", "gaussian_energy"}) {
    for (const auto& [points, is_even] :
         {std::pair{2, true}, {4, true}, {5, true}, {9, true}, {5, false}, {9, false}}) {
      const model::LawRow& row = *model::find_law(name);
      if (row.spline ? points < row.min_points : points != 2) continue;
      model::Law law;
      law.name = name;
      if (!is_even && !model::may_have_knots(law)) continue;
      law.range_lo = -0.06;
      law.range_hi = 0.35;
      for (int k = 1; !is_even && k < model::spline_pieces(law, points); ++k)
        law.knots.push_back(0.3 - 0.3 / (k * k));  // the first at zero, then denser and denser
      law.parameters = model::default_parameters(row, points);
      std::vector<double> p;
      for (model::Parameter& parameter : law.parameters)
        p.push_back(parameter.value =
                        70.0 + 40.0 * std::sin(static_cast<double>(3 * p.size()) + 1.0));
      const auto made = make_law(law, 1);
      const auto curve = model::TermCurve::of(law, model::Domain::membrane);
      ASSERT_TRUE(made && curve) << name;
      double scale = 0.0;
      for (double eps = -0.15; eps < 0.5; eps += 0.0137) {
        LawOutput out{};
        LawInput in;
        in.strain = &eps;
        in.parameters = p.data();
        (*made)->evaluate(in, out);
        const double size = std::abs(out.tangent[0][0]) + std::abs(out.stress[0]) + 1.0;
        scale = std::max(scale, size);
        EXPECT_NEAR(curve->stress(law, eps), out.stress[0], 1e-10 * size) << name << " at " << eps;
        EXPECT_NEAR(curve->stiffness(law, eps), out.tangent[0][0], 1e-9 * size)
            << name << " at " << eps;
      }
      EXPECT_GT(scale, 20.0) << name;
    }
  }
}

}  // namespace
}  // namespace tenter::mechanics
