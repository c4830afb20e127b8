// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/field_gain.h"

#include <algorithm>
#include <cmath>

#include "server/diagnosis/field/prepare_sheet.h"

namespace tenter::diagnosis {
namespace {

using estimation::ObservationKind;
using estimation::Row;

/// What a row measured, in its unit, and what about it counts as signal.
struct Reading {
  ObservationKind kind = ObservationKind::other;
  double sigma = 0.0;
  double measured = 0.0;
  double signal = 0.0;  ///< forces as they are; positions about their mean over the frames
};

std::vector<Reading> readings_of(const FieldData& data, const std::vector<Row>& rows) {
  std::vector<Reading> readings(rows.size());
  std::vector<estimation::Observations> seen;
  seen.reserve(data.sequences.size());
  for (const auto& sequence : data.sequences) seen.emplace_back(sequence);
  std::size_t first = 0;
  while (first < rows.size()) {  // one channel of one sequence
    std::size_t last = first;
    const auto s = static_cast<std::size_t>(rows[first].curve);
    double sum = 0.0;
    while (last < rows.size() && rows[last].curve == rows[first].curve &&
           rows[last].channel == rows[first].channel) {
      Reading& r = readings[last];
      const auto& sequence = data.sequences[s];
      r.kind = seen[s].kind(sequence, rows[last].channel);
      r.sigma = seen[s].sigma(sequence, rows[last].channel);
      r.measured = seen[s].measured(sequence.frames[static_cast<std::size_t>(rows[last].frame)],
                                    rows[last].channel);
      sum += r.measured;
      ++last;
    }
    const double mean = sum / static_cast<double>(last - first);
    for (std::size_t k = first; k < last; ++k)
      readings[k].signal = readings[k].kind == ObservationKind::position
                               ? readings[k].measured - mean
                               : readings[k].measured;
    first = last;
  }
  return readings;
}

/// Forces, or positions where there are none among them.
ObservationKind scored_kind(const std::vector<Row>& rows, const std::vector<Reading>& readings,
                            int sequence) {
  for (std::size_t r = 0; r < rows.size(); ++r)
    if ((sequence < 0 || rows[r].curve == sequence) && readings[r].kind == ObservationKind::force)
      return ObservationKind::force;
  return ObservationKind::position;
}

double rms_of_points(const std::vector<Row>& rows, const std::vector<Reading>& readings,
                     const Eigen::VectorXd& residuals, int sequence) {
  double sum = 0.0;
  double n = 0.0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r].curve != sequence || readings[r].kind != ObservationKind::position) continue;
    sum += std::pow(residuals[static_cast<Eigen::Index>(r)] * readings[r].sigma, 2);
    n += 1.0;
  }
  return n > 0.0 ? std::sqrt(sum / n) : 0.0;
}

/// sigma over signal, rms over rms.
double floor_of(const std::vector<Row>& rows, const std::vector<Reading>& readings, int sequence) {
  const ObservationKind kind = scored_kind(rows, readings, sequence);
  double noise = 0.0;
  double power = 0.0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if ((sequence >= 0 && rows[r].curve != sequence) || readings[r].kind != kind) continue;
    noise += readings[r].sigma * readings[r].sigma;
    power += readings[r].signal * readings[r].signal;
  }
  return power > 0.0 ? std::sqrt(noise / power) : 0.0;
}

void add_scores(const FieldData& data, const FieldFit& before, const FieldFit& after, bool held_out,
                std::vector<SheetScore>& scores) {
  const auto readings = readings_of(data, before.rows);
  for (int s = 0; s < static_cast<int>(data.sequences.size()); ++s) {
    SheetScore score;
    score.before = score_of_forces(data, before, s);
    score.after = score_of_forces(data, after, s);
    score.points_before_m = rms_of_points(before.rows, readings, before.at.fit.residuals, s);
    score.points_after_m = rms_of_points(after.rows, readings, after.at.fit.residuals, s);
    score.noise_floor = floor_of(before.rows, readings, s);
    score.held_out = held_out;
    scores.push_back(score);
  }
}

/// Zero but on rows of one kind.
Eigen::VectorXd share_of(const std::vector<Reading>& readings, ObservationKind kind) {
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(readings.size()));
  double power = 0.0;
  for (std::size_t r = 0; r < readings.size(); ++r) {
    if (readings[r].kind != kind) continue;
    power += readings[r].signal * readings[r].signal;
    scale[static_cast<Eigen::Index>(r)] = readings[r].sigma;
  }
  if (power > 0.0) scale /= std::sqrt(power);
  return scale;
}

}  // namespace

Score score_of_residuals(const FieldData& data, const std::vector<Row>& rows,
                         const Eigen::VectorXd& residuals, int sequence) {
  const auto readings = readings_of(data, rows);
  const ObservationKind kind = scored_kind(rows, readings, sequence);
  double error = 0.0;
  double power = 0.0;
  double sum = 0.0;
  double n = 0.0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double x = residuals[static_cast<Eigen::Index>(r)];
    if ((sequence >= 0 && rows[r].curve != sequence) || readings[r].kind != kind ||
        !std::isfinite(x))
      continue;
    error += std::pow(x * readings[r].sigma, 2);
    power += readings[r].signal * readings[r].signal;
    sum += readings[r].signal;
    n += 1.0;
  }
  const double spread = power - sum * sum / std::max(1.0, n);
  Score score;
  score.error = power > 0.0 ? std::sqrt(error / power) : 0.0;
  score.r2 = spread > 0.0 ? 1.0 - error / spread : 0.0;
  return score;
}

Score score_of_forces(const FieldData& data, const FieldFit& fit, int sequence) {
  return score_of_residuals(data, fit.rows, fit.at.fit.residuals, sequence);
}

SizeInterval sheet_effect_size(const FieldData& data, const FieldFit& without, const FieldFit& with,
                               unsigned long long seed) {
  const auto readings = readings_of(data, with.rows);
  return effect_size(
      with.rows, data.block_count(),
      {share_of(readings, ObservationKind::force), share_of(readings, ObservationKind::position)},
      without.at.fit, with.at.fit, seed);
}

void measure_sheet_gain(SheetDiagnosis& d, const SheetRequest& request, const Control& control) {
  d.before = score_of_forces(d.data, d.baseline);
  d.after = score_of_forces(d.data, d.extended);
  d.noise_floor = floor_of(d.baseline.rows, readings_of(d.data, d.baseline.rows), -1);
  add_scores(d.data, d.baseline, d.extended, false, d.scores);
  if (!d.held_out.sequences.empty()) {
    auto after = predict_field(d.extended.at.model, d.held_out, d.held_out_baseline.states,
                               field_options(control));
    if (!after) {
      d.checklist.push_back(
          {"WARNING", "The extended model does not reach what is held out", after.error().message});
      return;
    }
    d.held_out_extended = std::move(*after);
    d.held_out_kind = "captures";
    d.held_out_before = score_of_forces(d.held_out, d.held_out_baseline);
    d.held_out_after = score_of_forces(d.held_out, d.held_out_extended);
    add_scores(d.held_out, d.held_out_baseline, d.held_out_extended, true, d.scores);
    return;
  }
  if (request.options.leave_out == "none" || control.stop.stop_requested()) return;
  const estimation::Folds folds = telling_folds(d.extended, d.baseline, d.data);
  if (folds.training.empty()) return;
  const auto options = field_options(control);
  const auto before = cross_validate_field(d.baseline, d.data, folds, options);
  const auto after = cross_validate_field(d.extended, d.data, folds, options);
  if (!before.usable || !after.usable) return;
  d.held_out_kind = folds.kind;
  d.held_out_before = score_of_residuals(d.data, d.baseline.rows, before.residuals);
  d.held_out_after = score_of_residuals(d.data, d.extended.rows, after.residuals);
}

}  // namespace tenter::diagnosis
