// SPDX-License-Identifier: GPL-3.0-or-later
// Isolated readings that no smooth misfit explains: misread digits, lost samples.
//
// A residual is compared with the median of its neighbours in the same block, so that a smooth error of the model does
// not count; what is left is scaled by its own median absolute deviation (never below the channel's resolution).
// Readings farther than `threshold` such deviations that come alone or in threes at most are outliers.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/prediction.h"

namespace tenter::estimation {

struct Outlier {
  int curve = 0;
  int channel = 0;
  int frame = 0;
  double deviation = 0.0;  ///< measured minus what the neighbours suggest, SI
  double score = 0.0;      ///< in robust standard deviations
};

struct OutlierOptions {
  int half_window = 4;
  double threshold = 7.0;
  int longest = 3;  ///< readings in a row that may still be misreadings
};

std::vector<Outlier> find_outliers(const DataSet& data, const std::vector<Row>& rows,
                                   const Eigen::VectorXd& residuals, const OutlierOptions& options);

}  // namespace tenter::estimation
