// SPDX-License-Identifier: GPL-3.0-or-later
// What a fabric may do beside its curves and loops: the effects that an examination hides in it.
//
// Of the membrane strains e = (E_uu, E_vv, g = x,u . x,v) and their stiffnesses k, all at zero off:
//
//   coupling    C E_uu E_vv           cross-modal  c/2 E_uu^2 E_vv^2 + d/2 (E_uu^2 + E_vv^2) g^2
//   cubic       q_m/4 e_m^4
//   friction    df/d|de| = (sign(de) (a + b |e|) - f) / tau     exact along a step
//   Maxwell     dq/dt = k1 de/dt - q / T                        exact for a constant rate
//   Kelvin      eta de/dt
//   plastic     stress k (e - p), dp = share de while e passes its yield strain and its largest yet
//   softening   k e (1 - A (1 - exp(-(m - e) / w))),  m = largest e so far, e > 0
//   curl        moment -B K0 of a sheet whose rest is curved
//   expansion   stress -k x(t), x(t) = X sin(2 pi t / period + phase): warmth comes and goes
//
// Each step is the minimum of an energy (counted from the start of the step). Needs curves of a
// constant stiffness where plastic or softening. Shares nothing with server/. Pure.
#pragma once

#include <Eigen/Core>
#include <array>

namespace tenter::twin {

/// Triples are {u, v, shear}, pairs {u, v}.
struct HiddenLaws {
  double coupling_N_m = 0.0;
  double cross_stretch_N_m = 0.0, cross_shear_N_m = 0.0;
  std::array<double, 3> cubic_N_m = {};
  std::array<double, 3> friction_N_m = {}, friction_growth_N_m = {};
  double friction_reach = 0.01;
  std::array<double, 2> maxwell_N_m = {}, kelvin_voigt_N_s_m = {};
  double relaxation_s = 5.0;
  std::array<double, 2> plastic_share = {};
  double yield_strain = 0.01;
  std::array<double, 2> softening = {};
  double softening_width = 0.005;
  std::array<double, 2> curl_1_m = {};
  double expansion = 0.0, expansion_period_s = 60.0, expansion_phase_rad = 0.0;
  /// A patch is stiffer along u and v by this share at its middle, and by exp(-r^2 / reach^2).
  double patch_share = 0.0;
  Eigen::Vector2d patch_m = Eigen::Vector2d::Zero();
  double patch_reach_m = 0.02;

  double stiffer_at(const Eigen::Vector2d& material_m) const;  ///< 1 where there is no patch
};

struct LawHistory {
  std::array<double, 3> friction = {};
  std::array<double, 2> maxwell = {}, plastic = {}, largest = {};
  double clock_s = 0.0;
};

struct LawValue {
  double energy = 0.0;
  Eigen::Vector3d stress = Eigen::Vector3d::Zero();
  Eigen::Matrix3d tangent = Eigen::Matrix3d::Zero();
};

/// What the laws add where a step of `step_s` from strains `from` has come to `to`; `k` are the
/// stiffnesses of u and v that plastic and softening take from.
LawValue hidden_at(const HiddenLaws& laws, const LawHistory& history, const Eigen::Vector3d& from,
                   const Eigen::Vector3d& to, const Eigen::Vector2d& k, double step_s);
LawHistory advance(const HiddenLaws& laws, const LawHistory& history, const Eigen::Vector3d& from,
                   const Eigen::Vector3d& to, double step_s);

}  // namespace tenter::twin
