// SPDX-License-Identifier: GPL-3.0-or-later
// Errors as a user reads them: relative to what was measured, not to the noise.
#pragma once

#include <vector>

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

/// Over the stress rows of one curve (of all for curve < 0); over all rows where none is a stress.
Score score_of(const estimation::DataSet& data, const std::vector<estimation::Row>& rows,
               const Eigen::VectorXd& residuals, int curve);

/// Noise in the same measure: sigma between repeats where known, else the sigma that weighs the
/// residuals.
double noise_floor_of(const estimation::DataSet& data, const std::vector<estimation::Row>& rows,
                      const estimation::Noise& noise, int curve);

/// Share of the force that lies between two fits, rms over rms, with a 95 % interval over resampled
/// blocks. Of the free stretches instead where the effect leaves the force alone.
struct SizeInterval {
  bool of_force = true;
  double size = 0.0;
  double lo = 0.0;
  double hi = 0.0;
};
SizeInterval size_between(const estimation::DataSet& data, const std::vector<estimation::Row>& rows,
                          const Eigen::VectorXd& without, const Eigen::VectorXd& with,
                          unsigned long long seed);

}  // namespace tenter::diagnosis
