// SPDX-License-Identifier: GPL-3.0-or-later
// All that a fit to captures of a sheet found, before it becomes documents.
#pragma once

#include <vector>

#include "server/estimation/fit.h"
#include "server/estimation/uncertainty/profile.h"
#include "server/jobs/sheet_fit/requests/found.h"
#include "server/jobs/sheet_fit/sheet_input.h"
#include "server/jobs/sheet_fit/sheet_prediction.h"

namespace tenter::jobs {

struct SheetFindings {
  SheetFitOptions options;
  std::vector<SheetInput> inputs;
  model::Model start;
  model::Model fitted;  ///< with errors and intervals of `optimum`
  std::vector<estimation::StageRecord> stages;
  std::vector<std::vector<std::string>> stage_terms;  ///< ids of the terms that each stage fitted
  Requested requested;
  estimation::FitResult optimum;              ///< of all parameters together, at the fitted values
  std::vector<estimation::Profile> profiles;  ///< of free parameters, where asked for
  std::vector<Prediction> before;             ///< one an input, by `start`
  std::vector<Prediction> after;              ///< by `fitted`
};

}  // namespace tenter::jobs
