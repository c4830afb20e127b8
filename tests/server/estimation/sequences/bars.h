// SPDX-License-Identifier: GPL-3.0-or-later
// Small sequences of a square of cloth between two bars, measured with noise.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "common/model/model.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::estimation::testing {

model::Model cloth_model(const Eigen::VectorXd& values);
Eigen::VectorXd true_values();

/// A square between two bars, `moved` over five frames by the second one; 3 x 3 points and one
/// force.
Sequence between_bars(const std::string& name, bool along_weft, const Eigen::Vector3d& moved);

/// Measured values of points and the force from another minimiser than the fit's, with noise.
void measure(Sequence& sequence, const Eigen::VectorXd& truth, std::mt19937& random);

/// Weft, warp and shear.
std::vector<Sequence> measured_sequences(unsigned seed);

}  // namespace tenter::estimation::testing
