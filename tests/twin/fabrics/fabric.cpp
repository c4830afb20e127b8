// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/fabric.h"

#include <cstdlib>

namespace tenter::twin {

namespace {

using Curves = std::array<StiffnessCurve, kModes>;

/// Even in the strain: control points from rest to the end, mirrored.
StiffnessCurve both_ways(double end, const std::vector<double>& from_rest) {
  StiffnessCurve curve{-end, end, {}};
  curve.k.assign(from_rest.rbegin(), from_rest.rend());
  curve.k.insert(curve.k.end(), from_rest.begin() + 1, from_rest.end());
  return curve;
}

StiffnessCurve constant(double k) {
  return {0.0, 0.0, {k}};
}

/// Turns are smoothed over a twentieth of the stretch, a few degrees of shear, a wide curve.
std::array<Loop, kModes> loops(double ratio, double stretch_u_end, double stretch_v_end) {
  constexpr double kShare = 0.05, kShear = 0.015, kCurvature_1_m = 4.0;
  return {Loop{ratio, kShare * stretch_u_end},
          Loop{ratio, kShare * stretch_v_end},
          Loop{ratio, kShear},
          Loop{ratio, kCurvature_1_m},
          Loop{ratio, kCurvature_1_m},
          Loop{ratio, kCurvature_1_m}};
}

Fabric satin() {
  const StiffnessCurve stretch{0.0, 0.035, {2500.0, 4500.0, 8000.0, 10000.0}};
  return {.id = "4",
          .name = "cotton satin",
          .mass_kg = 1.2e-3,
          .curves = Curves{stretch, stretch, both_ways(0.4, {28.0, 30.0, 36.0}), constant(4e-6),
                           constant(4e-6), constant(3e-6)},
          .loops = loops(1.5, 0.035, 0.035),
          .limits = {0.03, 0.03, 0.25, 0.007, 0.007, 0.12, 3e-3}};
}

Fabric knit() {
  const StiffnessCurve stretch{0.0, 0.6, {38.0, 38.5, 39.2, 40.0}};
  return {.id = "12",
          .name = "rayon/spandex knit",
          .mass_kg = 3.1e-3,
          .curves = Curves{stretch, stretch, constant(20.0), constant(2.5e-6), constant(2.5e-6),
                           constant(1.9e-6)},
          .loops = loops(1.4, 0.6, 0.6),
          .limits = {0.45, 0.45, 0.15, 0.1, 0.1, 0.25, 8e-3}};
}

Fabric denim() {
  return {
      .id = "14",
      .name = "cotton denim",
      .mass_kg = 4.6e-3,
      .curves = Curves{StiffnessCurve{0.0, 0.05, {1500.0, 3000.0, 5000.0, 6500.0}},
                       StiffnessCurve{0.0, 0.05, {1700.0, 3300.0, 5400.0, 6900.0}},
                       both_ways(0.4, {300.0, 320.0, 400.0}),
                       both_ways(120.0, {1.98e-4, 1.9e-4, 1.7e-4}), constant(6e-6), constant(8e-5)},
      .loops = loops(1.8, 0.05, 0.05),
      .limits = {0.045, 0.045, 0.12, 0.02, 0.02, 0.1, 3e-3}};
}

Fabric wool() {
  return {.id = "18",
          .name = "wool/cotton blend",
          .mass_kg = 2.4e-3,
          .curves = Curves{StiffnessCurve{0.0, 0.05, {800.0, 2000.0, 4500.0, 6000.0}},
                           StiffnessCurve{0.0, 0.3, {80.0, 200.0, 450.0, 600.0}},
                           both_ways(0.4, {28.0, 30.0, 40.0}), constant(6.5e-5), constant(5e-6),
                           constant(2.6e-5)},
          .loops = loops(1.6, 0.05, 0.3),
          .limits = {0.045, 0.24, 0.2, 0.012, 0.05, 0.12, 3e-3}};
}

/// Another piece of the same cloth: every curve times its factor.
Fabric second(Fabric fabric, const std::array<double, kModes>& factors, double mass_factor) {
  fabric.id += ".2";
  fabric.mass_kg *= mass_factor;
  for (std::size_t m = 0; m < fabric.curves.size(); ++m)
    for (double& k : fabric.curves[m].k) k *= factors[m];
  return fabric;
}

}  // namespace

std::vector<std::string> fabric_ids() {
  return {"4", "12", "14", "18", "4.2", "12.2", "14.2", "18.2"};
}

Fabric fabric(const std::string& id) {
  if (id == "4") return satin();
  if (id == "12") return knit();
  if (id == "14") return denim();
  if (id == "18") return wool();
  // #12 and #14 are very similar between specimens, #4 and #18 less so (thesis 3.5)
  if (id == "4.2") return second(satin(), {0.88, 0.9, 1.2, 1.12, 1.08, 1.1}, 1.02);
  if (id == "12.2") return second(knit(), {1.03, 0.98, 1.02, 0.97, 1.03, 1.02}, 0.99);
  if (id == "14.2") return second(denim(), {0.98, 1.02, 1.03, 1.03, 0.97, 1.0}, 1.01);
  if (id == "18.2") return second(wool(), {1.1, 0.9, 1.25, 0.9, 1.12, 1.1}, 0.98);
  std::abort();
}

Fabric without_friction(Fabric fabric) {
  for (Loop& loop : fabric.loops) loop.ratio = 1.0;
  return fabric;
}

}  // namespace tenter::twin
