// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/prediction.h"

#include <algorithm>
#include <cmath>

namespace tenter::estimation {

int DataSet::block_count() const {
  int count = 0;
  for (const Curves& c : curves) count += static_cast<int>(c.blocks.size());
  return count;
}

std::vector<Row> DataSet::rows() const {
  std::vector<Row> rows;
  int first_block = 0;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    for (std::size_t c = 0; c < curves[i].channels.size(); ++c) {
      for (std::size_t f = 0; f < curves[i].frame_count(); ++f) {
        if (left_out[i][c][f] || !std::isfinite(curves[i].channels[c].measured[f])) continue;
        rows.push_back({static_cast<int>(i), static_cast<int>(c), static_cast<int>(f),
                        first_block + curves[i].block_of[f]});
      }
    }
    first_block += static_cast<int>(curves[i].blocks.size());
  }
  return rows;
}

double DataSet::sigma_of(const Row& row) const {
  const auto i = static_cast<std::size_t>(row.curve);
  const auto c = static_cast<std::size_t>(row.channel);
  return sigma[i][c];
}

Expected<Evaluator> Evaluator::make(const model::Model& model,
                                    std::shared_ptr<const DataSet> data) {
  Evaluator evaluator;
  auto point = mechanics::MaterialPoint::make(model);
  if (!point) return tl::unexpected(point.error());
  evaluator.point_ = std::make_shared<const mechanics::MaterialPoint>(std::move(*point));
  auto chain = SensorChain::make(model, data->curves, evaluator.point_->parameter_count());
  if (!chain) return tl::unexpected(chain.error());
  evaluator.chain_ = std::move(*chain);
  evaluator.rows_ = data->rows();
  for (const Row& row : evaluator.rows_) {
    const Curves& curves = data->curves[static_cast<std::size_t>(row.curve)];
    evaluator.measured_.push_back(curves.channels[static_cast<std::size_t>(row.channel)]
                                      .measured[static_cast<std::size_t>(row.frame)]);
    evaluator.sigma_.push_back(data->sigma_of(row));
  }
  evaluator.responses_.resize(data->curves.size());
  evaluator.data_ = std::move(data);
  return evaluator;
}

mechanics::PathStatus Evaluator::evaluate(const Eigen::VectorXd& parameters,
                                          Eigen::VectorXd& residuals, RowMatrix* jacobian) {
  const Eigen::VectorXd law_parameters = parameters.head(point_->parameter_count());
  for (std::size_t i = 0; i < data_->curves.size(); ++i) {
    const auto status = point_->follow(data_->curves[i].path, law_parameters, jacobian != nullptr,
                                       scratch_, responses_[i]);
    if (status != mechanics::PathStatus::ok) return status;
  }
  residuals.resize(row_count());
  if (jacobian) jacobian->resize(row_count(), parameter_count());
  Shown shown;
  for (int r = 0; r < row_count(); ++r) {
    const Row& row = rows_[static_cast<std::size_t>(r)];
    const Curves& curves = data_->curves[static_cast<std::size_t>(row.curve)];
    const ObservedChannel& channel = curves.channels[static_cast<std::size_t>(row.channel)];
    const mechanics::PathResponse& response = responses_[static_cast<std::size_t>(row.curve)];
    if (channel.is_stress)
      chain_.show_stress(curves, row.curve, response, channel.component, row.frame, parameters,
                         jacobian != nullptr, shown);
    else
      chain_.show_stretch(curves, response, channel.component, row.frame, parameters,
                          jacobian != nullptr, shown);
    const double weight = 1.0 / sigma(r);
    residuals[r] = (shown.value - measured(r)) * weight;
    if (jacobian) jacobian->row(r) = shown.by_p * weight;
  }
  if (!residuals.allFinite()) return mechanics::PathStatus::not_finite;
  return mechanics::PathStatus::ok;
}

std::vector<double> Evaluator::predicted(const Eigen::VectorXd& residuals) const {
  std::vector<double> values(static_cast<std::size_t>(row_count()));
  for (int r = 0; r < row_count(); ++r)
    values[static_cast<std::size_t>(r)] = measured(r) + residuals[r] * sigma(r);
  return values;
}

std::vector<model::Parameter*> parameters_of(model::Model& model) {
  std::vector<model::Parameter*> all;
  for (model::Term& term : model.terms)
    for (model::Parameter& p : term.law.parameters) all.push_back(&p);
  for (model::SensorCorrection& correction : model.corrections)
    for (model::Parameter& p : correction.parameters) all.push_back(&p);
  return all;
}

std::vector<const model::Parameter*> parameters_of(const model::Model& model) {
  std::vector<const model::Parameter*> all;
  for (const model::Term& term : model.terms)
    for (const model::Parameter& p : term.law.parameters) all.push_back(&p);
  for (const model::SensorCorrection& correction : model.corrections)
    for (const model::Parameter& p : correction.parameters) all.push_back(&p);
  return all;
}

std::vector<std::string> parameter_names(const model::Model& model) {
  std::vector<std::string> names;
  for (const model::Term& term : model.terms)
    for (const model::Parameter& p : term.law.parameters) names.push_back(term.id + "." + p.name);
  for (const model::SensorCorrection& c : model.corrections)
    for (const model::Parameter& p : c.parameters) names.push_back(c.id + "." + p.name);
  return names;
}

Eigen::VectorXd parameter_values(const model::Model& model) {
  const auto all = parameters_of(model);
  Eigen::VectorXd values(static_cast<Eigen::Index>(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) values[static_cast<Eigen::Index>(i)] = all[i]->value;
  return values;
}

}  // namespace tenter::estimation
