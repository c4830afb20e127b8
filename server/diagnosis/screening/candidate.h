// SPDX-License-Identifier: GPL-3.0-or-later
// What a screen finds: candidates (a variant of an effect at one point of its grid), and a table
// with a row an effect. Values.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/diagnosis/effect.h"

namespace tenter::diagnosis {

struct Candidate {
  const Effect* effect = nullptr;
  Variant variant;                  ///< without its grids
  Setting point;                    ///< of the grid
  Setting setting;                  ///< grid point, then the amplitudes that the screen expects
  const Variant* source = nullptr;  ///< within the screen only: the variant with its grids
  double gain = 0.0;                ///< T
  double within = 0.0;              ///< of it what a refit within the parameters' bounds can reach
  int df = 0;
  double ratio = 0.0;         ///< u over the threshold; above one it is no false alarm
  Eigen::VectorXd direction;  ///< what it would take from the residuals (whitened rows; of sheets
                              ///< coordinates of the screen's own)
  Eigen::MatrixXd space;      ///< where options.keep_spaces: basis of all that it could take
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
  bool keep_spaces = false;
  std::vector<std::string> effects = {};  ///< ids of those that may be tried; none: all
};

}  // namespace tenter::diagnosis
