// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/laws/hidden_laws.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tenter::twin {

namespace {

/// Of one strain: energy of the step, stress, tangent.
struct Part {
  double energy = 0.0, stress = 0.0, tangent = 0.0;
};

double sign(double x) {
  return x < 0.0 ? -1.0 : 1.0;
}

// On one side of zero, moving the way s, with r = s sign(e) and x = |e - e0|,
//   f = p(e) + (f0 - p(e0)) exp(-x / tau),   p(e) = s (a + b |e| - r b tau)
Part friction_on_one_side(double a, double b, double tau, double side, double e0, double e1,
                          double f0) {
  const double s = sign(e1 - e0), r = s * side, x = std::abs(e1 - e0);
  const auto p = [&](double e) { return s * (a + b * std::abs(e) - r * b * tau); };
  const double left = std::exp(-x / tau), start = f0 - p(e0);
  Part part;
  part.stress = p(e1) + start * left;
  part.tangent = s * (s * r * b - start * left / tau);
  part.energy = s * (s * ((a - r * b * tau) * x + 0.5 * b * x * (std::abs(e0) + std::abs(e1))) +
                     start * tau * (1.0 - left));
  return part;
}

Part friction(double a, double b, double tau, double e0, double e1, double f0) {
  if (a == 0.0 && b == 0.0) return {};
  if (e0 * e1 >= 0.0) return friction_on_one_side(a, b, tau, sign(e0 + e1), e0, e1, f0);
  const Part first = friction_on_one_side(a, b, tau, sign(e0), e0, 0.0, f0);
  Part second = friction_on_one_side(a, b, tau, sign(e1), 0.0, e1, first.stress);
  second.energy += first.energy;
  return second;
}

Part viscous(double k, double relaxation_s, double eta, double e0, double e1, double q0,
             double step_s) {
  Part part;
  const double de = e1 - e0;
  if (step_s <= 0.0) {  // no time: the spring alone
    part = {q0 * de + 0.5 * k * de * de, q0 + k * de, k};
  } else {
    const double left = std::exp(-step_s / relaxation_s);
    const double stiff = k * (1.0 - left) * relaxation_s / step_s;
    part = {q0 * left * de + 0.5 * stiff * de * de, q0 * left + stiff * de, stiff};
    part.energy += 0.5 * eta * de * de / step_s;
    part.stress += eta * de / step_s;
    part.tangent += eta / step_s;
  }
  return part;
}

/// Beside the curve's k e: k (e - p) with p growing beyond the threshold.
Part plastic(double share, double k, double yield, double largest, double p0, double e) {
  if (share == 0.0) return {};
  const double threshold = std::max(largest, yield);
  const double beyond = std::max(0.0, e - threshold);
  Part part;
  part.stress = -k * (p0 + share * beyond);
  part.tangent = beyond > 0.0 ? -k * share : 0.0;
  part.energy = -k * (p0 * e + 0.5 * share * beyond * beyond);
  return part;
}

/// Beside the curve's k e: -A k e (1 - exp(-(m - e) / w)) below the largest strain.
Part softened(double share, double k, double width, double largest, double e) {
  if (share == 0.0 || e <= 0.0 || largest <= 0.0) return {};
  const auto integral = [&](double x) {  // of x (1 - exp((x - m) / w))
    return 0.5 * x * x - width * (x - width) * std::exp((x - largest) / width);
  };
  const double up_to = std::min(e, largest);
  Part part;
  part.energy = -share * k * (integral(up_to) - integral(0.0));
  if (e >= largest) return part;
  const double left = std::exp((e - largest) / width);
  part.stress = -share * k * e * (1.0 - left);
  part.tangent = -share * k * (1.0 - left - e * left / width);
  return part;
}

void add_coupled(const HiddenLaws& laws, const Eigen::Vector3d& e, LawValue& value) {
  const double c12 = laws.coupling_N_m, c = laws.cross_stretch_N_m, d = laws.cross_shear_N_m;
  const double u = e[0], v = e[1], g = e[2];
  value.energy += c12 * u * v + 0.5 * c * u * u * v * v + 0.5 * d * (u * u + v * v) * g * g;
  value.stress += Eigen::Vector3d(c12 * v + c * u * v * v + d * u * g * g,
                                  c12 * u + c * v * u * u + d * v * g * g, d * (u * u + v * v) * g);
  Eigen::Matrix3d tangent;
  tangent << c * v * v + d * g * g, c12 + 2.0 * c * u * v, 2.0 * d * u * g,  //
      c12 + 2.0 * c * u * v, c * u * u + d * g * g, 2.0 * d * v * g,         //
      2.0 * d * u * g, 2.0 * d * v * g, d * (u * u + v * v);
  value.tangent += tangent;
}

}  // namespace

double HiddenLaws::stiffer_at(const Eigen::Vector2d& material_m) const {
  if (patch_share == 0.0) return 1.0;
  return 1.0 + patch_share * std::exp(-(material_m - patch_m).squaredNorm() /
                                      (patch_reach_m * patch_reach_m));
}

LawValue hidden_at(const HiddenLaws& laws, const LawHistory& history, const Eigen::Vector3d& from,
                   const Eigen::Vector3d& to, const Eigen::Vector2d& k, double step_s) {
  LawValue value;
  add_coupled(laws, to, value);
  const double expanded =
      laws.expansion == 0.0
          ? 0.0
          : laws.expansion * std::sin(2.0 * std::numbers::pi * (history.clock_s + step_s) /
                                          laws.expansion_period_s +
                                      laws.expansion_phase_rad);
  const auto add = [&](Eigen::Index m, const Part& part) {
    value.energy += part.energy;
    value.stress[m] += part.stress;
    value.tangent(m, m) += part.tangent;
  };
  for (Eigen::Index m = 0; m < 3; ++m) {
    const auto i = static_cast<std::size_t>(m);
    const double e = to[m], q = laws.cubic_N_m[i];
    add(m, {0.25 * q * e * e * e * e, q * e * e * e, 3.0 * q * e * e});
    add(m, friction(laws.friction_N_m[i], laws.friction_growth_N_m[i], laws.friction_reach, from[m],
                    e, history.friction[i]));
    if (m == 2) break;
    add(m, {-k[m] * expanded * e, -k[m] * expanded, 0.0});
    if (laws.maxwell_N_m[i] != 0.0 || laws.kelvin_voigt_N_s_m[i] != 0.0)
      add(m, viscous(laws.maxwell_N_m[i], laws.relaxation_s, laws.kelvin_voigt_N_s_m[i], from[m], e,
                     history.maxwell[i], step_s));
    add(m, plastic(laws.plastic_share[i], k[m], laws.yield_strain, history.largest[i],
                   history.plastic[i], e));
    add(m, softened(laws.softening[i], k[m], laws.softening_width, history.largest[i], e));
  }
  return value;
}

LawHistory advance(const HiddenLaws& laws, const LawHistory& history, const Eigen::Vector3d& from,
                   const Eigen::Vector3d& to, double step_s) {
  LawHistory next = history;
  next.clock_s += step_s;
  for (Eigen::Index m = 0; m < 3; ++m) {
    const auto i = static_cast<std::size_t>(m);
    next.friction[i] = friction(laws.friction_N_m[i], laws.friction_growth_N_m[i],
                                laws.friction_reach, from[m], to[m], history.friction[i])
                           .stress;
    if (m == 2) break;
    next.maxwell[i] = viscous(laws.maxwell_N_m[i], laws.relaxation_s, 0.0, from[m], to[m],
                              history.maxwell[i], step_s)
                          .stress;
    next.plastic[i] += laws.plastic_share[i] *
                       std::max(0.0, to[m] - std::max(history.largest[i], laws.yield_strain));
    next.largest[i] = std::max(history.largest[i], to[m]);
  }
  return next;
}

}  // namespace tenter::twin
