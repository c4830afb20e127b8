// SPDX-License-Identifier: GPL-3.0-or-later
// The cloth of the twins: stress along a strain history, by small steps of the laws' differential
// equations.
//
// It shares nothing with server/: no closed forms over a frame, no strain or law catalogue.
// Material axes: u (weft) and v (warp), Green strains Eu, Ev, Euv, second Piola stresses Su, Sv,
// Suv (N/m):
//
//   cross-modal the derivatives of  c/2 Eu^2 Ev^2 + d/2 (Eu^2 + Ev^2) (2 Euv)^2
//   elastic     Su = s_u C11 (Eu - pu) + C12 (Ev - pv) + k_u Eu^3,   Suv = 2 C33 Euv  (v likewise)
//   taut        T_u max(0, Eu - limit) more
//   friction    d sigma / d e = (a + b |e| - sign(de) sigma) / tau   on fibres e = n.E n
//   Maxwell     dq/dt = k dE/dt - q / T                               Kelvin-Voigt  eta dE/dt
//   plastic     dp = alpha dE while E passes both its yield strain and its largest value so far
//   creep       dD/dt = r (E / 8 %)^4 / (1 - D)^4 to failure; the elastic stress is 1 - D of it
//   softening   s = 1 - A (1 - exp(-(m - E) / w)),  m = largest E so far
//
// Equations (5.1), (5.2) of the thesis give the friction law. Integration: trapezoidal rule in each
// small step.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace tenter::twin {

struct Elastic {
  double c11 = 600.0, c22 = 800.0, c12 = 150.0, c33 = 100.0;  ///< N/m
};

/// A direction of the material with Dahl friction.
struct FrictionFibre {
  double angle_rad = 0.0;  ///< from u towards v
  double a = 0.0;          ///< N/m
  double b = 0.0;          ///< N/m
  double tau = 0.01;       ///< strain
};

/// Everything constant of one cloth. Pairs are {u, v}.
struct Cloth {
  Elastic elastic;
  std::array<double, 2> cubic = {0.0, 0.0};  ///< N/m
  std::array<double, 2> taut = {0.0, 0.0};   ///< N/m more beyond the strain limit
  double strain_limit = 0.06;
  double cross_stretch = 0.0;  ///< c, N/m
  double cross_shear = 0.0;    ///< d, N/m
  std::vector<FrictionFibre> friction;
  std::array<double, 2> maxwell = {0.0, 0.0};  ///< N/m
  double relaxation_time_s = 5.0;
  std::array<double, 2> kelvin_voigt = {0.0, 0.0};  ///< N s/m
  std::array<double, 2> plastic_share = {0.0, 0.0};
  double yield_strain = 0.01;
  std::array<double, 2> softening = {0.0, 0.0};
  double softening_width = 0.005;

  double creep_per_s = 0.0;  ///< of damage, at 8 % strain and none yet

  std::vector<double> specimen_factors;  ///< on all forces of specimen 1, 2, ...; empty: all alike
  double factor_of(int specimen) const {
    const auto i = static_cast<std::size_t>(specimen);
    return specimen > 0 && i <= specimen_factors.size() ? specimen_factors[i - 1] : 1.0;
  }

  bool remembers() const;  ///< false: stress is a function of the strain alone
};

/// What the cloth remembers. Starts virgin.
struct ClothState {
  std::array<double, 3> green = {0.0, 0.0, 0.0};  ///< Eu, Ev, Euv
  std::vector<double> friction;                   ///< N/m, one per fibre
  std::array<double, 2> maxwell = {0.0, 0.0};
  std::array<double, 2> plastic = {0.0, 0.0};
  std::array<double, 2> largest = {0.0, 0.0};
  std::array<double, 2> damage = {0.0, 0.0};  ///< share of the stiffness that is gone
};

/// Deformation in test axes: F = [[x, shear], [0, y]].
struct Deformation {
  double x = 1.0, y = 1.0, shear = 0.0;
};

/// Nominal stresses dPsi/dF in test axes, N/m.
struct Nominal {
  double x = 0.0, y = 0.0, shear = 0.0;
};

/// One small step of `dt_s` to `next` in test axes at `angle_rad` from u; `state` goes from the
/// start of the step to its end. dt_s = 0 means no time passes (only for cloth without rate
/// effects).
Nominal step(const Cloth& cloth, double angle_rad, const Deformation& next, double dt_s,
             ClothState& state);

/// As step(), with stretch x or y found so that its nominal stress vanishes; `next` holds the start
/// value and gets the answer.
Nominal step_free(const Cloth& cloth, double angle_rad, bool free_x, Deformation& next, double dt_s,
                  ClothState& state);

}  // namespace tenter::twin
