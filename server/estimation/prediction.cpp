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
  evaluator.term_parameters_ = evaluator.point_->parameter_count();
  evaluator.parameter_count_ = evaluator.term_parameters_;
  static constexpr const char* kTypes[] = {"offset", "gain", "drift", "delay", "clip_slip"};
  for (const model::SensorCorrection& description : model.corrections) {
    Correction correction;
    const auto* type = std::find(std::begin(kTypes), std::end(kTypes), description.type);
    if (type == std::end(kTypes))
      return bad_input("no sensor correction is called \"" + description.type + "\"");
    correction.type = static_cast<Correction::Type>(type - std::begin(kTypes));
    correction.capture = description.capture;
    for (int i = 0; i < 3; ++i)
      if (description.component == component_name(i)) correction.component = i;
    correction.first_parameter = evaluator.parameter_count_;
    evaluator.parameter_count_ += static_cast<int>(description.parameters.size());
    evaluator.corrections_.push_back(correction);
  }
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

// Corrections compose in the order of the instrument: what the cloth does, seen late, amplified,
// shifted.
void Evaluator::show(const Curves& curves, const mechanics::PathResponse& response, int component,
                     int frame, const Eigen::VectorXd& parameters, bool sensitivities,
                     Shown& shown) const {
  const auto row = [&](int f) { return response.stress_by_p.row(3 * f + component); };
  shown.value = response.stress[static_cast<std::size_t>(frame)][component];
  if (sensitivities) {
    shown.by_p.setZero(parameter_count_);
    shown.by_p.head(term_parameters_) = row(frame);
  }
  const auto applies = [&](const Correction& c) {
    return (c.component < 0 || c.component == component) &&
           (c.capture.empty() || c.capture == curves.id);
  };
  for (const Correction& c : corrections_) {
    if (c.type != Correction::Type::delay || !applies(c)) continue;
    const auto f = static_cast<std::size_t>(frame);
    const int run = curves.blocks[static_cast<std::size_t>(curves.block_of[f])].run;
    const int first = curves.runs[static_cast<std::size_t>(run)].first;
    const double when = curves.clock_s[f] - parameters[c.first_parameter];
    const int last = curves.runs[static_cast<std::size_t>(run)].last;
    if (last - first < 2) continue;
    int later = std::clamp(frame, first + 1, last - 1);
    while (later > first + 1 && curves.clock_s[static_cast<std::size_t>(later - 1)] > when) --later;
    while (later < last - 1 && curves.clock_s[static_cast<std::size_t>(later)] < when) ++later;
    const auto l = static_cast<std::size_t>(later);
    const double span = curves.clock_s[l] - curves.clock_s[l - 1];
    if (!(span > 0.0)) continue;
    const double place = (when - curves.clock_s[l - 1]) / span;
    const double w =
        std::clamp(place, 0.0, 1.0);  // before its first and after its last frame a run shows these
    const double p0 = response.stress[l - 1][component];
    const double p1 = response.stress[l][component];
    shown.value = (1.0 - w) * p0 + w * p1;
    if (sensitivities) {
      shown.by_p.head(term_parameters_) = (1.0 - w) * row(later - 1) + w * row(later);
      shown.by_p[c.first_parameter] = place == w ? -(p1 - p0) / span : 0.0;
    }
  }
  for (const Correction& c : corrections_) {
    if (c.type != Correction::Type::gain || !applies(c)) continue;
    const double gain = parameters[c.first_parameter];
    if (sensitivities) {
      shown.by_p *= gain;
      shown.by_p[c.first_parameter] = shown.value;
    }
    shown.value *= gain;
  }
  for (const Correction& c : corrections_) {
    if (!applies(c)) continue;
    double column = 0.0;
    if (c.type == Correction::Type::offset) column = 1.0;
    if (c.type == Correction::Type::drift)
      column = curves.clock_s[static_cast<std::size_t>(frame)] - curves.clock_s.front();
    if (c.type == Correction::Type::clip_slip) {
      // the step belongs to the run that holds its frame; at_frame counts the capture's frames,
      // thinned or not
      const int at = static_cast<int>(parameters[c.first_parameter + 1]);
      const auto f = static_cast<std::size_t>(frame);
      const int run = curves.blocks[static_cast<std::size_t>(curves.block_of[f])].run;
      const CurveRun& own = curves.runs[static_cast<std::size_t>(run)];
      const bool in_run = at >= curves.origin[static_cast<std::size_t>(own.first)] &&
                          (run + 1 == static_cast<int>(curves.runs.size()) ||
                           at < curves.origin[static_cast<std::size_t>(own.last)]);
      column = in_run && curves.origin[f] >= at ? 1.0 : 0.0;
    }
    if (c.type == Correction::Type::gain || c.type == Correction::Type::delay) continue;
    shown.value += parameters[c.first_parameter] * column;
    if (sensitivities) shown.by_p[c.first_parameter] = column;
  }
}

mechanics::PathStatus Evaluator::evaluate(const Eigen::VectorXd& parameters,
                                          Eigen::VectorXd& residuals, RowMatrix* jacobian) {
  const Eigen::VectorXd law_parameters = parameters.head(term_parameters_);
  for (std::size_t i = 0; i < data_->curves.size(); ++i) {
    const auto status = point_->follow(data_->curves[i].path, law_parameters, jacobian != nullptr,
                                       scratch_, responses_[i]);
    if (status != mechanics::PathStatus::ok) return status;
  }
  residuals.resize(row_count());
  if (jacobian) jacobian->resize(row_count(), parameter_count_);
  Shown shown;
  for (int r = 0; r < row_count(); ++r) {
    const Row& row = rows_[static_cast<std::size_t>(r)];
    const Curves& curves = data_->curves[static_cast<std::size_t>(row.curve)];
    const ObservedChannel& channel = curves.channels[static_cast<std::size_t>(row.channel)];
    const mechanics::PathResponse& response = responses_[static_cast<std::size_t>(row.curve)];
    if (channel.is_stress) {
      show(curves, response, channel.component, row.frame, parameters, jacobian != nullptr, shown);
    } else {
      shown.value = response.q[static_cast<std::size_t>(row.frame)][channel.component];
      if (jacobian) {
        shown.by_p.setZero(parameter_count_);
        shown.by_p.head(term_parameters_) = response.q_by_p.row(3 * row.frame + channel.component);
      }
    }
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
