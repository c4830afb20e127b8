// SPDX-License-Identifier: GPL-3.0-or-later
// Errors on data that a fit did not see.
//
// Folds are left-out protocols (all runs of one group) where there are at least three of them and every parameter stays
// determined without any one of them; else left-out repeats (the k-th run of every group); else left-out runs; else
// left-out blocks. All folds of one comparison are the same for both models.
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

/// `fit` is a fit of the larger of the models that are compared.
Folds make_folds(const DataSet& data, const std::vector<Row>& rows, const FitResult& fit);
/// One kind only, whatever it determines; empty where the data have fewer than two members of it.
Folds folds_of_kind(const DataSet& data, const std::vector<Row>& rows, const std::string& kind);

struct HeldOut {
  bool usable = false;
  double chi2 = 0.0;
  Eigen::VectorXd residuals;  ///< whitened, each row from the fit that did not see it
};

/// Refits without each fold, starting from the model's values.
HeldOut cross_validate(Evaluator& evaluator, const model::Model& model, const Folds& folds,
                       const FitOptions& options);

}  // namespace tenter::estimation
