// SPDX-License-Identifier: GPL-3.0-or-later
// The model that tests of internal friction estimate: one strain, linear stiffness, Dahl's law.
//
//   sigma = (k1 + k2 |eps|) eps + sigma_f,   d sigma_f / d eps = (sigma_max - s sigma_f) / tau,
//   sigma_max = a + b |eps|                                        (thesis 5.2, 5.3.2)
//
// A step of friction turns no work into heat, but heat into work, where b tau > 2 sigma_max
// (architecture.md); that is at strains below the value that `gains_below` gives.
//
//   model::Model model = friction_model("green_v");
//   model = with_values(model, {135.6, 64.03, 2.22, 3.16, 0.006});
//
// Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "common/model/model.h"

namespace tenter::estimation {

/// Places of the parameters in flat order.
enum FrictionParameter { kK1 = 0, kK2, kA, kB, kC, kTau, kFrictionParameters };

struct FrictionValues {
  double k1 = 0.0;   ///< N/m; bending: N m
  double k2 = 0.0;   ///< N/m; bending: N m^2
  double a = 0.0;    ///< N/m; bending: N
  double b = 0.0;    ///< N/m; bending: N m
  double tau = 0.0;  ///< 1; bending: 1/m
};

/// Terms "elastic" and "friction" on a strain measure of the catalogue (green_v, bend_v, ...); c is
/// fixed at zero.
model::Model friction_model(std::string_view strain_measure);

model::Model with_values(model::Model model, const FrictionValues& values);
FrictionValues values_of(const Eigen::VectorXd& parameters);

/// In flat order.
Eigen::VectorXd flat(const FrictionValues& values);

/// The strain below which a step may gain work; zero where it never does, and negative never.
double gains_below(const FrictionValues& values);

}  // namespace tenter::estimation
