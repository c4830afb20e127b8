// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/certainty/optimum.h"

#include <utility>

#include "server/estimation/least_squares/covariance.h"
#include "server/estimation/staged/resting_frames.h"

namespace tenter::jobs {

std::vector<estimation::Sequence> compared_sequences(const SheetFindings& found, FramesStart start,
                                                     Compared which) {
  std::vector<estimation::Sequence> sequences;
  for (std::size_t i = 0; i < found.inputs.size(); ++i) {
    const SheetInput& input = found.inputs[i];
    if (input.held_out != (which == Compared::held_out)) continue;
    estimation::Sequence sequence =
        estimation::observed({input.role, input.sequence()}, found.options.channels);
    std::vector<int> resting;
    for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
      if (!found.after[i].states[f]) continue;
      if (start == FramesStart::at_rest) sequence.frames[f].start = found.after[i].states[f];
      resting.push_back(static_cast<int>(f));
    }
    estimation::keep_frames(sequence, resting);
    if (!resting.empty()) sequences.push_back(std::move(sequence));
  }
  return sequences;
}

estimation::FitResult optimum(const model::Model& model, const SheetFindings& found, int threads,
                              double tolerance_N) {
  estimation::FitResult result;
  std::vector<estimation::Sequence> sequences = compared_sequences(found);
  if (sequences.empty()) {
    result.message = "no fitted frame has a rest";
    return result;
  }
  estimation::SequenceOptions options;
  options.threads = threads;
  options.tolerance_N = tolerance_N;
  auto evaluator = estimation::SequenceEvaluator::make(model, std::move(sequences), options);
  if (!evaluator) {
    result.message = evaluator.error().message;
    return result;
  }
  result.parameters = estimation::parameter_values(model);
  if (evaluator->evaluate(result.parameters, result.residuals, &result.jacobian) !=
      mechanics::PathStatus::ok) {
    result.message = evaluator->failure();
    return result;
  }
  const auto parameters = estimation::parameters_of(model);
  std::vector<int> free;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (!parameters[k]->fixed) free.push_back(static_cast<int>(k));
  Eigen::VectorXd weights = evaluator->weights();
  if (weights.size() == 0) weights.setOnes(evaluator->row_count());
  result.chi2 = weights.dot(result.residuals.cwiseAbs2());
  estimation::describe_optimum(parameters, free, weights, found.options.loss, evaluator->rows(),
                               result);
  result.usable = true;
  result.converged = found.stages.back().done && found.stages.back().converged;
  result.message = found.stages.back().message;
  return result;
}

}  // namespace tenter::jobs
