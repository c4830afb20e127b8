// SPDX-License-Identifier: GPL-3.0-or-later
// The bound that keeps a fitted friction from gaining work: b tau <= 2 a, or with a curved maximum
// the b up to which 2 sigma_max >= tau sigma_max' at every strain (mechanics/friction/dahl_work.h),
//
//   b_max(a, c, tau) = 2 a / tau                         where that is at least c tau, or c = 0
//                    = sqrt(4 a c - c^2 tau^2)           else (0 where that is none)
//
// It is no box: the fit sees b only up to there, and beyond it moves along the bound with a, c and
// tau. A fit that ends there starts again from inside as long as the cost falls with b.
//
//   FitOptions options;
//   options.friction = friction_places(model);
//   FitResult found = fit(evaluator, model, options);      // holds, or says at_bound of b
//
// A b that the document fixes is left alone. Pure; one thread.
#pragma once

#include <vector>

#include "server/estimation/fit.h"
#include "server/estimation/residual_function.h"

namespace tenter::estimation {

/// Those of every term with the law "dahl", in flat order.
std::vector<FrictionPlaces> friction_places(const model::Model& model);

/// b_max and its derivatives.
struct GrowthBound {
  double b = 0.0, by_a = 0.0, by_c = 0.0, by_tau = 0.0;
};
GrowthBound growth_bound(double a, double c, double tau);

/// Another residual function with every b at most at its bound.
class DissipativeFunction final : public ResidualFunction {
 public:
  DissipativeFunction(ResidualFunction& inner, std::vector<FrictionPlaces> places)
      : inner_(inner), places_(std::move(places)) {}

  int parameter_count() const override { return inner_.parameter_count(); }
  const std::vector<Row>& rows() const override { return inner_.rows(); }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;
  void set_accuracy(Accuracy accuracy) override { inner_.set_accuracy(accuracy); }
  Eigen::VectorXd weights() const override { return inner_.weights(); }

  Eigen::VectorXd bounded(Eigen::VectorXd parameters) const;
  /// Places whose b is beyond its bound: one for each b, the tightest.
  std::vector<FrictionPlaces> beyond(const Eigen::VectorXd& parameters) const;

 private:
  ResidualFunction& inner_;
  std::vector<FrictionPlaces> places_;
};

}  // namespace tenter::estimation
