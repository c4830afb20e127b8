// SPDX-License-Identifier: GPL-3.0-or-later
// From captures to what is fitted: curves, outliers set aside, thinned, whitened by their noise,
// and the baseline fit.
#pragma once

#include <optional>
#include <utility>

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

struct Prepared {
  std::vector<estimation::Curves> curves;  ///< every frame
  std::vector<estimation::Outlier> outliers;
  DataPointer data;
  estimation::Noise noise;
  Reference baseline;
};

Expected<Prepared> prepare(const Request& request, const Control& control);

/// At most so many frames a block, each the mean of its neighbours but for what is left out.
estimation::DataSet thinned(const estimation::DataSet& full, int max_frames_per_block);

/// Noise from the residuals of a fit, and the data set with its sigmas; the residuals must be of
/// `data`.
std::pair<estimation::Noise, DataPointer> reweigh(const DataPointer& data,
                                                  const std::vector<estimation::Row>& rows,
                                                  const Eigen::VectorXd& residuals);

struct Weighed {
  estimation::Noise noise;
  DataPointer data;
  double quieter = 1.0;  ///< least ratio of what repeats of a channel differ by, to what it was
};

/// What differs from repeat to repeat, as a drift does, passes for noise until it is found. The
/// data weighed by what repeats differ by without it, where that is much less for some channel.
std::optional<Weighed> weigh_without(const DataPointer& data, const estimation::Noise& noise,
                                     const Reference& found);

/// Fits the model and keeps what later steps compare with.
Expected<Reference> make_reference(const model::Model& start, const DataPointer& data,
                                   const estimation::FitOptions& options);

}  // namespace tenter::diagnosis
