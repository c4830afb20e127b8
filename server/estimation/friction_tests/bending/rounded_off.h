// SPDX-License-Identifier: GPL-3.0-or-later
// What a smooth curve rounds off a strip: by how much the curvatures and torques that are read off
// the spline of a contour (profile_curve.h) differ from those of the contour itself.
//
// A strip that snaps, or that curls where friction starts to hold, bends sharply; a spline through
// its points does not. So a contour of given curvature is laid out, with as many points as the
// measured one and no noise, a spline of as many intervals goes through them, and what it says is
// compared with what is known:
//
//   strain_k = 3 (theta~(hi) - theta~(lo)) / h - mean_q 3 kappa(s_kq)      (1/m)
//   torque_kq = T~(s_kq) - T(s_kq)                                        (N)
//
// with ~ for the spline's, k the kept samples and s_kq their places (torque_samples.h).
//
//   const auto off = rounded_off(profile, 3 kappa at the middles of rounding_cells(profile) cells);
//   if (off) strain -= off->strain;
//
// Pure; any thread. Cost: that of one spline of known intervals, 2 ms.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "server/estimation/friction_tests/bending/torque_samples.h"

namespace tenter::estimation {

struct RoundedOff {
  Eigen::VectorXd strain;  ///< one a sample
  Eigen::VectorXd torque;  ///< kTorquesPerSample a sample
};

/// Even cells along the strip.
int rounding_cells(const ProfileSamples& profile);

/// `strain`: 3 kappa in each cell. None where no spline follows the contour.
std::optional<RoundedOff> rounded_off(const ProfileSamples& profile, const Eigen::VectorXd& strain);

}  // namespace tenter::estimation
