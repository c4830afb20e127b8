// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/fabrics/frame_errors.h"

#include <cmath>

#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/mechanics/law.h"

namespace tenter::twin {

using estimation::Sequence;
using estimation::SequenceEvaluator;

std::vector<FrameError> frame_errors(const Sequence& sequence, const model::Model& model) {
  const Eigen::VectorXd parameters = mechanics::term_parameters(model);
  const int first_force = 3 * static_cast<int>(sequence.points.size());
  std::vector<FrameError> errors;
  for (const auto& frame : sequence.frames) {
    Sequence one = sequence;
    one.frames = {frame};
    if (frame.start) one.start = *frame.start;
    auto evaluator = SequenceEvaluator::make(model, {one}).value();
    FrameError& error = errors.emplace_back();
    Eigen::VectorXd residuals;
    if (evaluator.evaluate(parameters, residuals, nullptr) != mechanics::PathStatus::ok) continue;
    error.rests = true;
    std::vector<double> positions, forces;
    for (int r = 0; r < evaluator.row_count(); ++r)
      (evaluator.rows()[static_cast<std::size_t>(r)].channel < first_force ? positions : forces)
          .push_back(residuals[r]);
    const auto as_vector = [](const std::vector<double>& of) {
      return Eigen::VectorXd(
          Eigen::Map<const Eigen::VectorXd>(of.data(), static_cast<Eigen::Index>(of.size())));
    };
    error.positions = as_vector(positions);
    error.forces = as_vector(forces);
    if (auto folds = estimation::compare_folds(one, 0, evaluator.states()[0][0])) {
      error.has_folds = true;
      error.folds = std::move(*folds);
    }
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
