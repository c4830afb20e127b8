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

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "server/diagnosis/effect.h"
#include "server/estimation/fit.h"
#include "server/estimation/noise.h"

namespace tenter::diagnosis {

using DataPointer = std::shared_ptr<const estimation::DataSet>;

struct Candidate {
  const Effect* effect = nullptr;
  Variant variant;                  ///< without its grids
  Setting point;                    ///< of the grid
  Setting setting;                  ///< grid point, then the amplitudes that the screen expects
  const Variant* source = nullptr;  ///< within the screen only: the variant with its grids
  double gain = 0.0;                ///< T
  int df = 0;
  double ratio = 0.0;         ///< u over the threshold; above one it is no false alarm
  Eigen::VectorXd direction;  ///< what it would take from the residuals (whitened rows)
};

struct ScreenRow {
  const Effect* effect = nullptr;
  std::string status;  ///< "screened", "not excited: ...", "hides in the model's own parameters",
                       ///< "in the model"
  double gain = 0.0;
  int df = 0;
  double ratio = 0.0;
  Setting grid;
};

struct Screen {
  std::vector<Candidate>
      candidates;  ///< largest ratio first; several variants and grid points an effect
  std::vector<ScreenRow> table;  ///< one row an effect, largest ratio first
  double lack_of_fit = 0.0;      ///< chi2 of r over the 95th percentile of the null twins' chi2
  double expected_chi2 = 0.0;    ///< mean chi2 of the null twins
};

struct ScreenOptions {
  int null_twins = 1000;
  unsigned long long seed = 1;
};

Screen screen(const model::Model& fitted, const estimation::FitResult& fit, const DataPointer& data,
              const estimation::Noise& noise, const Excitation& excitation,
              const ScreenOptions& options);

}  // namespace tenter::diagnosis
