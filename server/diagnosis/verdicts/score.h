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

/// Rows that a score is taken over: stresses of one curve (of all for curve < 0), all rows where
/// none is a stress.
std::vector<std::size_t> scored_rows(const estimation::DataSet& data,
                                     const std::vector<estimation::Row>& rows, int curve);
/// Rows that are no stress.
std::vector<std::size_t> stretch_rows(const estimation::DataSet& data,
                                      const std::vector<estimation::Row>& rows);

/// A reading less what its channel shows at rest: a stretch of one, no stress, no shear.
double measured_from_rest(const estimation::DataSet& data, const estimation::Row& row);

}  // namespace tenter::diagnosis
