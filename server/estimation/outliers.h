// SPDX-License-Identifier: GPL-3.0-or-later
// Isolated readings that no smooth misfit explains: misread digits, lost samples.
//
// Within a block the residuals are put in the order of the imposed strain and each is compared with
// a robust line through its neighbours there, so that neither a smooth error of the model nor a
// pull by fits and starts counts. What is left is scaled by the median absolute deviation, of the
// whole channel or of the neighbourhood, whichever is larger, and never by less than the channel's
// resolution. Readings farther than `threshold` such deviations, and farther than a share of the
// channel's range, that come alone or in threes at most (in time) are outliers, unless the level
// before them differs from the level after them and they lie at one of the two or between: a
// reading beside a step is a good one.
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
  double smallest_share = 0.02;  ///< of the channel's range
  int longest = 3;               ///< readings in a row that may still be misreadings
};

std::vector<Outlier> find_outliers(const DataSet& data, const std::vector<Row>& rows,
                                   const Eigen::VectorXd& residuals, const OutlierOptions& options);

}  // namespace tenter::estimation
