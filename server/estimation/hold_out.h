// SPDX-License-Identifier: GPL-3.0-or-later
// Errors on data that a fit did not see.
//
// Folds are left-out protocols (all runs of one group), left-out repeats (the k-th run of every group), left-out runs or
// left-out blocks; the first is the hardest test and the last the mildest. All folds of one comparison are the same for
// both models.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/estimation/fit.h"

namespace tenter::estimation {

struct Folds {
  std::string kind;  ///< "protocols", "repeats", "runs", "blocks"; "" where nothing can be left out
  std::vector<Eigen::VectorXd> training;  ///< row weights of each fold: 0 on what is left out
};

/// Kinds of folds, hardest first.
const std::vector<std::string>& fold_kinds();
/// Empty where the data have too few members of the kind: three protocols, two of the others.
Folds make_folds(const DataSet& data, const std::vector<Row>& rows, const std::string& kind);

/// What each fold leaves out can be predicted from the rest: the standard error of the prediction, with the misfit of
/// the fit as its unit, stays below a third of the signal. Where it does not, a bad score says nothing of the model.
bool folds_determine(const DataSet& data, const std::vector<Row>& rows, const FitResult& fit, const Folds& folds);

struct HeldOut {
  bool usable = false;
  double chi2 = 0.0;
  Eigen::VectorXd residuals;  ///< whitened, each row from the fit that did not see it
};

/// Refits without each fold, starting from the model's values.
HeldOut cross_validate(Evaluator& evaluator, const model::Model& model, const Folds& folds,
                       const FitOptions& options);

}  // namespace tenter::estimation
