// SPDX-License-Identifier: GPL-3.0-or-later
// How large is the noise, and what does it look like? From repeats first (design: the variance
// between repeats is the pure error), else from the sensor's declared standard deviation, else from
// the scatter of neighbouring samples.
//
// Repeats are runs of one group on one specimen; they are aligned block by block along the imposed
// strain (along time in a hold) on the residuals of the current fit, so that small differences of
// the path do not count. The first run of a group with three or more is kept apart: what it shows
// alone is a finding, not noise.
//
// A run whose deviation from the point-wise median is twice as loud as is usual had an accident (a
// slip): it has no say in the mean that the others are compared with, and its own deviation is
// brought down to twice the usual. White noise is unbiased: with k runs in the mean the squares of
// their deviations are divided by 1 - 1/k, of others' by 1 + 1/k.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/estimation/prediction.h"

namespace tenter::estimation {

enum class NoiseSource { declared, repeats, scatter, guess };

struct ChannelNoise {
  double sigma = 0.0;  ///< SI; what residuals are divided by
  NoiseSource source = NoiseSource::scatter;
  double repeat_sigma = 0.0;  ///< SI; between repeats, 0 where there are none
  double scatter_sigma =
      0.0;  ///< SI; of neighbouring samples: what is left when everything smooth is taken away
  double floor_sigma =
      0.0;  ///< SI; what no model of the mean can be asked to meet: repeats, specimens or sigma
};

struct Noise {
  std::vector<std::vector<ChannelNoise>> channels;  ///< [curve][channel]
  /// Deviations between repeats over whole blocks, whitened by the channel's sigma: the pool that
  /// null twins draw from.
  std::vector<std::vector<double>> sequences;
};

/// `sigma` of the data set is what `residuals` were divided by; it need not be right.
Noise estimate_noise(const DataSet& data, const std::vector<Row>& rows,
                     const Eigen::VectorXd& residuals);

/// How many repeats the largest group has, its first run kept apart where there are three or more.
int later_repeats(const DataSet& data);

/// One repeat as the model of another: the whitened residuals of the repeat with number `which` of
/// every group less those of the next (of the first after the last) at the same strain, over the
/// square root of what white noise makes of that. NaN on all rows that have no partner.
Eigen::VectorXd repeat_difference(const DataSet& data, const std::vector<Row>& rows,
                                  const Eigen::VectorXd& residuals, int which);

const char* noise_source_words(NoiseSource source);

}  // namespace tenter::estimation
