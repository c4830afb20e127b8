// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/sheet_prediction.h"

#include <cmath>
#include <numeric>

#include "server/estimation/prediction.h"
#include "server/estimation/sequences/sequence_evaluator.h"

namespace tenter::jobs {
namespace {

using estimation::ObservationKind;
using estimation::Observations;
using estimation::Sequence;

/// `kept`: the sequence's frames that `part` holds. False where a frame of it has no rest.
bool fill(const model::Model& model, const Sequence& part, const std::vector<int>& kept,
          int threads, double tolerance_N, Prediction& prediction) {
  estimation::SequenceOptions options;
  options.threads = threads;
  options.tolerance_N = tolerance_N;
  auto evaluator = estimation::SequenceEvaluator::make(model, {part}, options);
  Eigen::VectorXd residuals;
  if (!evaluator || evaluator->evaluate(estimation::parameter_values(model), residuals, nullptr) !=
                        mechanics::PathStatus::ok)
    return false;
  const Observations channels(part);
  const auto frame_of = [&](int frame) { return kept[static_cast<std::size_t>(frame)]; };
  for (std::size_t r = 0; r < evaluator->rows().size(); ++r) {
    const estimation::Row& row = evaluator->rows()[r];
    const auto& frame = part.frames[static_cast<std::size_t>(row.frame)];
    prediction.value(row.channel, frame_of(row.frame)) =
        channels.measured(frame, row.channel) +
        residuals[static_cast<Eigen::Index>(r)] * channels.sigma(part, row.channel);
  }
  // points that a frame did not see have a place in the model all the same
  const Eigen::VectorXd no_forces = Eigen::VectorXd::Zero(part.start.x.size());
  estimation::Observation seen;
  for (std::size_t f = 0; f < part.frames.size(); ++f) {
    const mechanics::State& state = evaluator->states()[0][f];
    const auto b = static_cast<std::size_t>(part.frames[f].boundary);
    const int frame = frame_of(static_cast<int>(f));
    for (int c = 0; c < static_cast<int>(3 * part.points.size()); ++c) {
      if (!std::isnan(prediction.value(c, frame))) continue;
      channels.observe(part, c, {part.boundaries[b], state, no_forces}, seen);
      prediction.value(c, frame) = seen.value;
    }
    prediction.states[static_cast<std::size_t>(frame)] = state;
  }
  return true;
}

}  // namespace

Expected<Prediction> predict(const model::Model& model, const Sequence& sequence, int threads,
                             double tolerance_N) {
  Prediction prediction;
  const auto frames = static_cast<Eigen::Index>(sequence.frames.size());
  prediction.value.setConstant(Observations(sequence).count(), frames, std::nan(""));
  prediction.states.resize(sequence.frames.size());
  std::vector<int> all(sequence.frames.size());
  std::iota(all.begin(), all.end(), 0);
  if (fill(model, sequence, all, threads, tolerance_N, prediction)) return prediction;

  auto rest =
      estimation::resting_frames(model, sequence, estimation::parameter_values(model), tolerance_N);
  if (!rest) return tl::unexpected(rest.error());
  prediction.restless = rest->restless;
  if (rest->resting.empty()) return prediction;
  Sequence part = sequence;
  for (std::size_t k = 0; k < rest->resting.size(); ++k)
    part.frames[static_cast<std::size_t>(rest->resting[k])].start = rest->states[k];
  estimation::keep_frames(part, rest->resting);
  if (!fill(model, part, rest->resting, threads, tolerance_N, prediction)) {
    for (const int frame : rest->resting)
      prediction.restless.push_back({frame, "its rest was found once and not again"});
  }
  return prediction;
}

Misfit& Misfit::operator+=(const Misfit& other) {
  rows += other.rows;
  square += other.square;
  square_sigmas += other.square_sigmas;
  sigma_square += other.sigma_square;
  return *this;
}

Misfit misfit(const Sequence& sequence, const Prediction& prediction, ObservationKind kind,
              std::size_t frame) {
  const estimation::SequenceFrame& at = sequence.frames[frame];
  const auto values = prediction.value.col(static_cast<Eigen::Index>(frame));
  Misfit sum;
  const auto add = [&sum](double left, double sigma) {
    if (!std::isfinite(left)) return;
    ++sum.rows;
    sum.square += left * left;
    sum.square_sigmas += left * left / (sigma * sigma);
    sum.sigma_square += sigma * sigma;
  };
  // channels are x, y and z of each point, then forces (observations.h)
  const auto points = static_cast<Eigen::Index>(sequence.points.size());
  if (kind == ObservationKind::position)
    for (Eigen::Index k = 0; k < points; ++k)
      for (Eigen::Index c = 0; c < 3; ++c)
        add(at.points_m(c, k) - values[3 * k + c],
            sequence.points[static_cast<std::size_t>(k)].sigma_m);
  if (kind == ObservationKind::force)
    for (Eigen::Index k = 0; k < at.forces_N.size(); ++k)
      add(at.forces_N[k] - values[3 * points + k],
          sequence.forces[static_cast<std::size_t>(k)].sigma_N);
  return sum;
}

Misfit misfit(const Sequence& sequence, const Prediction& prediction, ObservationKind kind) {
  Misfit sum;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f)
    sum += misfit(sequence, prediction, kind, f);
  return sum;
}

}  // namespace tenter::jobs
