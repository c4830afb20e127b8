// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/fabrics/frame_errors.h"

#include <cmath>

#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/mechanics/assembly/mesh_model.h"
#include "server/mechanics/law.h"

namespace tenter::twin {

using estimation::Sequence;
using estimation::SequenceEvaluator;

namespace {

/// Rows of one frame of an evaluation, and its folds.
FrameError error_of(const SequenceEvaluator& evaluator, const Eigen::VectorXd& residuals,
                    const Sequence& sequence, std::size_t frame) {
  const int first_force = 3 * static_cast<int>(sequence.points.size());
  FrameError error;
  error.rests = true;
  std::vector<double> positions, forces;
  for (int r = 0; r < evaluator.row_count(); ++r) {
    const auto& row = evaluator.rows()[static_cast<std::size_t>(r)];
    if (row.frame == static_cast<int>(frame))
      (row.channel < first_force ? positions : forces).push_back(residuals[r]);
  }
  const auto as_vector = [](const std::vector<double>& of) {
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(of.data(), static_cast<Eigen::Index>(of.size())));
  };
  error.positions = as_vector(positions);
  error.forces = as_vector(forces);
  if (auto folds = estimation::compare_folds(sequence, frame, evaluator.states()[0][frame])) {
    error.has_folds = true;
    error.folds = std::move(*folds);
  }
  return error;
}

}  // namespace

std::vector<FrameError> frame_errors(const Sequence& sequence, const model::Model& model) {
  const Eigen::VectorXd parameters = mechanics::term_parameters(model);
  std::vector<FrameError> errors(sequence.frames.size());
  Eigen::VectorXd residuals;
  if (mechanics::MeshModel::make(model, sequence.cloth).value().history_count() > 0) {
    auto whole = SequenceEvaluator::make(model, {sequence}).value();
    if (whole.evaluate(parameters, residuals, nullptr) == mechanics::PathStatus::ok)
      for (std::size_t f = 0; f < errors.size(); ++f)
        errors[f] = error_of(whole, residuals, sequence, f);
    return errors;
  }
  for (std::size_t f = 0; f < errors.size(); ++f) {
    Sequence one = sequence;
    one.frames = {sequence.frames[f]};
    if (one.frames.front().start) one.start = *one.frames.front().start;
    auto evaluator = SequenceEvaluator::make(model, {one}).value();
    if (evaluator.evaluate(parameters, residuals, nullptr) == mechanics::PathStatus::ok)
      errors[f] = error_of(evaluator, residuals, one, 0);
  }
  return errors;
}

MeanErrors mean_errors(const std::vector<FrameError>& frames) {
  struct Mean {
    double squares = 0.0;
    Eigen::Index count = 0;
    void add(const Eigen::VectorXd& values) {
      squares += values.squaredNorm();
      count += values.size();
    }
    double root() const { return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.; }
  };
  MeanErrors errors;
  Mean position, meaningful, force;
  for (const FrameError& frame : frames) {
    if (!frame.rests) {
      ++errors.lost;
      continue;
    }
    position.add(frame.positions);
    force.add(frame.forces);
    if (frame.means_something())
      meaningful.add(frame.positions);
    else
      ++errors.meaningless;
  }
  errors.position = position.root();
  errors.position_where_meaningful = meaningful.root();
  errors.force = force.root();
  return errors;
}

}  // namespace tenter::twin
