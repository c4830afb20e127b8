// SPDX-License-Identifier: GPL-3.0-or-later
// Which effects could explain what the fit left over? All of the catalogue at once, without
// refitting.
//
// With the whitened residuals r and Jacobian J of the fit and Z_c the derivative of the prediction
// by the parameters of effect c, switched off, at one point of the grid of what enters nonlinearly:
//
//   P = I - J (J'J)^-1 J'      T_c = r'P Z (Z'P Z)^-1 Z'P r       the expected fall of chi2
//   (design, step 4)
//
// One evaluation of one model that holds every candidate term gives all Z. The threshold comes from
// null twins: noise drawn in blocks from the repeats (white where there are none), screened the
// same way; u_c = T_c over its own 95th null percentile, and the threshold is the 95th percentile
// of the largest u over the catalogue.
#pragma once

#include <memory>

#include "server/diagnosis/screening/candidate.h"
#include "server/estimation/fit.h"
#include "server/estimation/noise.h"

namespace tenter::diagnosis {

using DataPointer = std::shared_ptr<const estimation::DataSet>;

Screen screen(const model::Model& fitted, const estimation::FitResult& fit, const DataPointer& data,
              const estimation::Noise& noise, const Excitation& excitation,
              const ScreenOptions& options);

}  // namespace tenter::diagnosis
