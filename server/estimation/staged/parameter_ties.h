// SPDX-License-Identifier: GPL-3.0-or-later
// Parameters that are bound to each other: a fit of few free numbers to a model of many parameters.
//
//   p = T q      p: all parameters of the model, q: the free numbers      dr/dq = dr/dp T
//
// An isotropic fabric has one curve for weft and warp, the springs of both diagonals share theirs,
// and the additive form of St. Venant-Kirchhoff (thesis (4.3)) has four stiffnesses of two numbers.
// The map is linear and constant, so the Jacobian goes through it exactly.
//
//   ParameterTies ties = tie_terms(model, {{"weft", "warp"}}).value();
//   FitResult result = fit_tied(evaluator, ties, options);
//   store(result, model);
//
// Bounds are those of q; where a row of T has negative entries the caller sees to it that p stays
// within its own. Values and pure functions.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/estimation/fit.h"

namespace tenter::estimation {

struct ParameterTies {
  std::vector<model::Parameter> free;  ///< q: values, bounds and what is fixed
  RowMatrix map;                       ///< T: parameters of the model x free

  Eigen::VectorXd all(const Eigen::VectorXd& q) const { return map * q; }
  Eigen::VectorXd values() const;  ///< of q
};

/// Every parameter is free, or fixed, by itself.
ParameterTies no_ties(const model::Model& model);

/// The terms of a group share the parameters of its first one. bad_input where a term is not there
/// or stands in two groups, or the laws of a group differ in name, range, knots or size.
Expected<ParameterTies> tie_terms(const model::Model& model,
                                  const std::vector<std::vector<std::string>>& groups);

/// The residuals of `inner` over q.
class TiedFunction final : public ResidualFunction {
 public:
  /// Both must outlive it.
  TiedFunction(ResidualFunction& inner, const ParameterTies& ties) : inner_(inner), ties_(ties) {}

  int parameter_count() const override { return static_cast<int>(ties_.map.cols()); }
  const std::vector<Row>& rows() const override { return inner_.rows(); }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& q, Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;
  void set_accuracy(Accuracy accuracy) override { inner_.set_accuracy(accuracy); }
  Eigen::VectorXd weights() const override { return inner_.weights(); }
  /// Of all parameters, from the last evaluation that wanted one.
  const RowMatrix& inner_jacobian() const { return inner_jacobian_; }

 private:
  ResidualFunction& inner_;
  const ParameterTies& ties_;
  RowMatrix inner_jacobian_;
};

/// fit() over q (whose values go where the last argument points), started from the values of
/// `ties.free`; the result is over p: standard errors and correlations are those of T q, and a
/// parameter that hangs on one number has that number's state. Places of frictions in `options` are
/// among p.
FitResult fit_tied(ResidualFunction& evaluator, const ParameterTies& ties,
                   const FitOptions& options, Eigen::VectorXd* q = nullptr);

}  // namespace tenter::estimation
