// SPDX-License-Identifier: GPL-3.0-or-later
// A long sheet, held on all sides, blown up by a pressure: away from its ends a cylinder.
//
// Half width a, half angle phi, radius R = a / sin phi, stretch phi / sin phi along the arc and
// none along the axis. With the nominal tension P(stretch) of the membrane, balance across the arc
// is  p = P sin phi / a.  Height of the crown: R (1 - cos phi).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

/// Half angle at which a membrane of this tension bears the pressure; the way up, below the
/// pressure's peak.
template <class Tension>
double half_angle(const Tension& tension, double pressure_Pa, double half_width_m) {
  double low = 0.0, high = 1.3;
  for (int i = 0; i < 200; ++i) {
    const double phi = 0.5 * (low + high);
    const double bears = tension(phi / std::sin(phi)) * std::sin(phi) / half_width_m;
    (bears < pressure_Pa ? low : high) = phi;
  }
  return low;
}

struct BulgedMembrane {
  const char* name;
  model::Model model;
  double (*tension)(double stretch);  ///< nominal, with no stretch along the axis
  double pressure_Pa;
};

constexpr double kStiffness = 200.0;  // N/m
constexpr double kPoisson = 0.3;

double stvk_tension(double s) {
  return 0.5 * kStiffness * s * (s * s - 1.0);
}

/// mu (sum lambda^2/2 - ln J) + c/2 (J - 1)^2, of stretches s and 1.
constexpr double kShear = 80.0, kArea = 60.0;
double neo_hookean_tension(double s) {
  return kShear * (s - 1.0 / s) + kArea * (s - 1.0);
}

std::vector<BulgedMembrane> membranes() {
  // E_uv twice is C_uv, so K (1 - nu) E_uv^2 = (K (1 - nu) / 4) C_uv^2
  BulgedMembrane stvk{"St. Venant-Kirchhoff",
                      linear_model({{"green_u", kStiffness},
                                    {"green_v", kStiffness},
                                    {"green_pair", kPoisson * kStiffness},
                                    {"green_uv", 0.5 * (1.0 - kPoisson) * kStiffness}}),
                      stvk_tension, 900.0};
  BulgedMembrane neo{"neo-Hookean", linear_model({{"area", kArea}}), neo_hookean_tension, 900.0};
  model::Term stretches;
  stretches.id = "stretches";
  stretches.strain.name = "principal_stretches";
  stretches.law.name = "ogden";
  stretches.law.parameters.resize(2);
  stretches.law.parameters[0].name = "mu";
  stretches.law.parameters[0].value = kShear;
  stretches.law.parameters[1].name = "alpha";
  stretches.law.parameters[1].value = 2.0;
  neo.model.terms.push_back(stretches);
  return {stvk, neo};
}

// The crown is the middle of a polygon in place of an arc: second order. The ends are more
// than three widths away.
TEST(Bulge, ACylinderOfKnownHeight) {
  const double width = 0.06, length = 0.42;
  for (const BulgedMembrane& membrane : membranes()) {
    SCOPED_TRACE(membrane.name);
    const double phi = half_angle(membrane.tension, membrane.pressure_Pa, 0.5 * width);
    const double height = 0.5 * width / std::sin(phi) * (1.0 - std::cos(phi));
    ASSERT_GT(height, 0.15 * width);
    ASSERT_LT(phi, 1.2);
    std::vector<double> errors;
    for (const int cells : {4, 8, 16, 32}) {
      const Grid grid{cells + 1, 2 * cells + 1, width, length};
      const Sheet sheet(cloth_of_grid(grid, Diagonals::alternating).value(), membrane.model);
      Boundary boundary;
      boundary.held = nodes_where(sheet.cloth.mesh, [&](double u, double v) {
        return u == 0.0 || v == 0.0 || u > width - 1e-9 || v > length - 1e-9;
      });
      boundary.pressed = sheet.cloth.mesh.triangles;
      Loads loads;
      loads.pressure_Pa = membrane.pressure_Pa;
      State state;
      state.x = placed(sheet.cloth.mesh, [&](double u, double v) {
        const double up = u * (width - u) * v * (length - v) / std::pow(0.25 * width * length, 2);
        return Eigen::Vector3d(u, v, 0.3 * height * up);
      });
      EquilibriumOptions options;
      options.tolerance_N = 1e-9;
      const EquilibriumResult result = solved(sheet, boundary, loads, state, options);
      ASSERT_TRUE(result.is_good(options)) << describe(result, options);
      const double crown = state.x[3 * grid.node(cells / 2, cells) + 2];
      errors.push_back(std::abs(crown - height) / height);
    }
    for (std::size_t i = 1; i < errors.size(); ++i) {
      const double observed = order(errors[i - 1], errors[i]);
      std::printf("bulge, %-20s %2d cells across: error %.2e, order %.2f\n", membrane.name, 4 << i,
                  errors[i], observed);
      EXPECT_NEAR(observed, 2.0, 0.3);
    }
    EXPECT_LT(errors.back(), 2e-3);
  }
}

}  // namespace
}  // namespace tenter::mechanics::testing
