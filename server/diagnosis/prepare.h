// SPDX-License-Identifier: GPL-3.0-or-later
// From captures to what is fitted: curves, outliers set aside, thinned, whitened by their noise,
// and the baseline fit.
#pragma once

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

/// Noise from the residuals of a fit, and the data set with its sigmas; the residuals must be of
/// `data`.
std::pair<estimation::Noise, DataPointer> reweigh(const DataPointer& data,
                                                  const std::vector<estimation::Row>& rows,
                                                  const Eigen::VectorXd& residuals);

/// Fits the model and keeps what later steps compare with.
Expected<Reference> make_reference(const model::Model& start, const DataPointer& data,
                                   const estimation::FitOptions& options);

}  // namespace tenter::diagnosis
