// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/cloth.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tenter::twin {
namespace {

constexpr double kCreepStrain = 0.08;
constexpr double kFailed = 0.95;  // of the stiffness: what is left holds the swatch in the clips
constexpr double kStressTolerance = 1e-9;  // N/m

// E_material = R E_test R',  R = [[c, -s], [s, c]]
std::array<double, 3> green_strain(const Deformation& f, double angle) {
  const double exx = 0.5 * (f.x * f.x - 1.0);
  const double eyy = 0.5 * (f.shear * f.shear + f.y * f.y - 1.0);
  const double exy = 0.5 * f.x * f.shear;
  if (angle == 0.0) return {exx, eyy, exy};
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * c * exx + s * s * eyy - 2.0 * c * s * exy,
          s * s * exx + c * c * eyy + 2.0 * c * s * exy,
          c * s * (exx - eyy) + (c * c - s * s) * exy};
}

// P = F S_test,  S_test = R' S_material R
Nominal nominal_stress(const Deformation& f, double angle, const std::array<double, 3>& stress) {
  double sxx = stress[0], syy = stress[1], sxy = stress[2];
  if (angle != 0.0) {
    const double c = std::cos(angle), s = std::sin(angle);
    sxx = c * c * stress[0] + s * s * stress[1] + 2.0 * c * s * stress[2];
    syy = s * s * stress[0] + c * c * stress[1] - 2.0 * c * s * stress[2];
    sxy = c * s * (stress[1] - stress[0]) + (c * c - s * s) * stress[2];
  }
  return {f.x * sxx + f.shear * sxy, f.y * syy, f.x * sxy + f.shear * syy};
}

// trapezoidal rule for d sigma = (sigma_max |de| / tau) sign(de) - sigma |de| / tau
double friction_step(const FrictionFibre& fibre, double e0, double e1, double sigma) {
  const double h = std::abs(e1 - e0) / fibre.tau;
  if (h == 0.0) return sigma;
  const double direction = e1 > e0 ? 1.0 : -1.0;
  const double limit = fibre.a + 0.5 * fibre.b * (std::abs(e0) + std::abs(e1));
  return ((1.0 - 0.5 * h) * sigma + direction * h * limit) / (1.0 + 0.5 * h);
}

}  // namespace

bool Cloth::remembers() const {
  const auto any = [](const std::array<double, 2>& pair) {
    return pair[0] != 0.0 || pair[1] != 0.0;
  };
  return !friction.empty() || any(maxwell) || any(kelvin_voigt) || any(plastic_share) ||
         any(softening) || creep_per_s != 0.0;
}

Nominal step(const Cloth& cloth, double angle, const Deformation& next, double dt,
             ClothState& state) {
  const std::array<double, 3> e = green_strain(next, angle);
  const Elastic& k = cloth.elastic;
  const std::array<double, 2> own = {k.c11, k.c22};
  std::array<double, 3> stress = {0.0, 0.0, 2.0 * k.c33 * e[2]};

  // plastic strain and largest strain first: the elastic part needs them
  std::array<double, 2> strain{};
  for (std::size_t i = 0; i < 2; ++i) {
    const double threshold = std::max(state.largest[i], cloth.yield_strain);
    state.plastic[i] += cloth.plastic_share[i] * std::max(0.0, e[i] - threshold);
    state.largest[i] = std::max(state.largest[i], e[i]);
    strain[i] = e[i] - state.plastic[i];
  }
  for (std::size_t i = 0; i < 2; ++i) {
    // a direction that is compressed was never pulled there: nothing to lose
    const double depth = (state.largest[i] - e[i]) / cloth.softening_width;
    const bool untouched = cloth.softening[i] == 0.0 || e[i] <= 0.0;
    const double soft = untouched ? 1.0 : 1.0 - cloth.softening[i] * (1.0 - std::exp(-depth));
    stress[i] = soft * own[i] * strain[i] + k.c12 * strain[1 - i] +
                cloth.cubic[i] * e[i] * e[i] * e[i] +
                cloth.taut[i] * std::max(0.0, e[i] - cloth.strain_limit);
    if (dt > 0.0 && e[i] > 0.0) {
      const double whole = 1.0 - state.damage[i];
      state.damage[i] += dt * cloth.creep_per_s * std::pow(e[i] / (kCreepStrain * whole), 4);
      state.damage[i] = std::min(state.damage[i], kFailed);
    }
    stress[i] *= 1.0 - state.damage[i];
  }

  const double shear = 2.0 * e[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const double other = e[1 - i];
    stress[i] +=
        cloth.cross_stretch * e[i] * other * other + cloth.cross_shear * e[i] * shear * shear;
    // half of dPsi/dEuv, which counts both off-diagonal entries
    stress[2] += cloth.cross_shear * e[i] * e[i] * shear;
  }

  if (dt > 0.0)
    for (std::size_t i = 0; i < 2; ++i) {
      const double de = e[i] - state.green[i];
      const double h = dt / cloth.relaxation_time_s;
      state.maxwell[i] =
          ((1.0 - 0.5 * h) * state.maxwell[i] + cloth.maxwell[i] * de) / (1.0 + 0.5 * h);
      stress[i] += state.maxwell[i] + cloth.kelvin_voigt[i] * de / dt;
    }
  else
    for (std::size_t i = 0; i < 2; ++i) stress[i] += state.maxwell[i];

  state.friction.resize(cloth.friction.size(), 0.0);
  for (std::size_t i = 0; i < cloth.friction.size(); ++i) {
    const double c = std::cos(cloth.friction[i].angle_rad),
                 s = std::sin(cloth.friction[i].angle_rad);
    const auto along = [&](const std::array<double, 3>& g) {
      return c * c * g[0] + s * s * g[1] + 2.0 * c * s * g[2];
    };
    double& sigma = state.friction[i];
    sigma = friction_step(cloth.friction[i], along(state.green), along(e), sigma);
    stress[0] += c * c * sigma;
    stress[1] += s * s * sigma;
    stress[2] += c * s * sigma;
  }
  state.green = e;
  return nominal_stress(next, angle, stress);
}

// Secant steps on the free stress; where they wander (friction has a kink at every reversal),
// bisection.
Nominal step_free(const Cloth& cloth, double angle, bool free_x, Deformation& next, double dt,
                  ClothState& state) {
  double& unknown = free_x ? next.x : next.y;
  ClothState trial;
  Nominal stress;
  const auto residual = [&](double value) {
    unknown = value;
    trial = state;
    stress = step(cloth, angle, next, dt, trial);
    return free_x ? stress.x : stress.y;
  };
  const double start = unknown;
  double x0 = start, r0 = residual(x0);
  double x1 = start - r0 / (free_x ? cloth.elastic.c11 : cloth.elastic.c22), r1 = r0;
  for (int i = 0; i < 12 && std::abs(r1) > kStressTolerance; ++i) {
    r1 = residual(x1);
    if (std::abs(r1) <= kStressTolerance || r1 == r0) break;
    const double x2 = x1 - r1 * (x1 - x0) / (r1 - r0);
    x0 = x1, r0 = r1, x1 = x2;
  }
  if (std::abs(r1) > kStressTolerance) {
    double lo = start - 0.1, hi = start + 0.1;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (lo + hi);
      (residual(middle) < 0.0 ? lo : hi) = middle;
    }
  }
  state = trial;
  return stress;
}

}  // namespace tenter::twin
