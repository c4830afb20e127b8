// SPDX-License-Identifier: GPL-3.0-or-later
// Errors on data that a fit did not see.
//
// Folds are left-out protocols (all runs of one group), left-out repeats (the k-th run of every
// group), left-out runs or left-out blocks; the first is the hardest test and the last the mildest.
// All folds of one comparison are the same for both models.
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
/// Row weights that leave members out in turn: `member_of` has each row's, 0 to members - 1.
/// Members that follow each other are spread over at most `most` folds. No fold where leaving one
/// out would say little (fewer than two members, three protocols).
Folds folds_of(const std::string& kind, const std::vector<int>& member_of, int members, int most);

Folds make_folds(const DataSet& data, const std::vector<Row>& rows, const std::string& kind);

/// Drops the folds without which the data cannot tell the added parameters: their joint information
/// (Wald, at the fitted values, all other parameters free) must keep at least a sixth of what it is
/// on all rows, and no one of them, as that of one specimen, may act on left-out rows alone. A bad
/// score on a fold that alone shows an effect would say nothing of the effect.
void keep_determined(Folds& folds, const FitResult& larger, const std::vector<std::size_t>& added);

/// Parameters of the larger model that the smaller one does not have.
std::vector<std::size_t> added_parameters(const model::Model& larger, const model::Model& smaller);

struct HeldOut {
  bool usable = false;
  int failed_fold = -1;  ///< the first whose refit failed: nothing is said of it and later ones
  double chi2 = 0.0;
  Eigen::VectorXd residuals;  ///< whitened, each row from the fit that did not see it; NaN where no
                              ///< fold left it out
  Eigen::VectorXd left_out;   ///< 1 on the rows that some fold left out, else 0
};

/// Refits without each fold, starting from the model's values.
HeldOut cross_validate(ResidualFunction& evaluator, const model::Model& model, const Folds& folds,
                       const FitOptions& options);

}  // namespace tenter::estimation
