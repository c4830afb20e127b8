// SPDX-License-Identifier: GPL-3.0-or-later
// What a model says that the channels should have shown: residuals and their exact Jacobian over
// all curves.
//
//   r = (predicted - measured) / sigma        one row per frame and channel that has weight and a
//   measured value
//
// Parameters are those of the model's terms, then those of its sensor corrections, flat, in
// document order; what a sensor correction does is said by sensor_chain.h.
//
// An Evaluator is built once per model and set of curves; `evaluate` is then called thousands of
// times.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/estimation/curves.h"
#include "server/estimation/residual_function.h"
#include "server/estimation/sensor_chain.h"
#include "server/mechanics/material_point.h"

namespace tenter::estimation {

/// Curves with the noise that a fit gives them, sigma[curve][channel] in SI, and the readings that
/// it leaves out, left_out[curve][channel][frame].
struct DataSet {
  std::vector<Curves> curves;
  std::vector<std::vector<double>> sigma;
  std::vector<std::vector<std::vector<bool>>> left_out;

  int block_count() const;
  /// Rows in the order of every residual vector: curve, channel, frame.
  std::vector<Row> rows() const;
  /// Standard deviation of one row (SI).
  double sigma_of(const Row& row) const;
};

class Evaluator final : public ResidualFunction {
 public:
  static Expected<Evaluator> make(const model::Model& model, std::shared_ptr<const DataSet> data);

  int parameter_count() const override { return chain_.parameter_count(); }
  const std::vector<Row>& rows() const override { return rows_; }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;

  /// Predicted value (SI) of every row, from residuals that `evaluate` gave.
  std::vector<double> predicted(const Eigen::VectorXd& residuals) const;
  double measured(int row) const { return measured_[static_cast<std::size_t>(row)]; }
  double sigma(int row) const { return sigma_[static_cast<std::size_t>(row)]; }
  /// Stretches that the model gave in the last evaluation, per curve and frame.
  const std::vector<mechanics::PathResponse>& responses() const { return responses_; }

 private:
  std::shared_ptr<const DataSet> data_;
  std::shared_ptr<const mechanics::MaterialPoint> point_;
  SensorChain chain_;
  std::vector<Row> rows_;
  std::vector<double> measured_;
  std::vector<double> sigma_;
  std::vector<mechanics::PathResponse> responses_;
  mechanics::MaterialPoint::Workspace scratch_;
};

/// All parameters of a model in flat order: terms first, then corrections.
std::vector<model::Parameter*> parameters_of(model::Model& model);
std::vector<const model::Parameter*> parameters_of(const model::Model& model);
/// "term.parameter" of each.
std::vector<std::string> parameter_names(const model::Model& model);
Eigen::VectorXd parameter_values(const model::Model& model);

}  // namespace tenter::estimation
