// SPDX-License-Identifier: GPL-3.0-or-later
// Noise as the repeats show it, drawn again: what the residuals would be if nothing were wrong.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/noise.h"
#include "server/estimation/prediction.h"

namespace tenter::diagnosis {

/// One column per twin, whitened rows. Each block of each channel gets one of the repeats'
/// deviation sequences, stretched to its length, with a random sign and white noise for what the
/// sequences' grid smooths away; without repeats white noise of unit variance.
Eigen::MatrixXd null_twins(const std::vector<estimation::Row>& rows, const estimation::Noise& noise,
                           int count, unsigned long long seed);

}  // namespace tenter::diagnosis
