// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/certainty/sheet_profiles.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "server/estimation/staged/resting_frames.h"
#include "server/jobs/sheet_fit/certainty/optimum.h"

namespace tenter::jobs {
namespace {

using estimation::ParameterState;
using estimation::Profile;
using estimation::SequenceEvaluator;

/// First and last frame, and others evenly between them.
void thin(estimation::Sequence& sequence) {
  const int count = static_cast<int>(sequence.frames.size());
  if (count <= kProfileFrames) return;
  std::vector<int> kept;
  kept.reserve(kProfileFrames);
  for (int k = 0; k < kProfileFrames; ++k) kept.push_back(k * (count - 1) / (kProfileFrames - 1));
  estimation::keep_frames(sequence, kept);
}

}  // namespace

Expected<std::vector<Profile>> sheet_profiles(const model::Model& model, const SheetFindings& found,
                                              const ProfileEffort& effort,
                                              const std::function<void(const JobProgress&)>& report,
                                              const std::stop_token& stop) {
  std::vector<Profile> all;
  if (!found.optimum.usable) return all;
  std::vector<estimation::Sequence> sequences = compared_sequences(found);
  for (estimation::Sequence& sequence : sequences) thin(sequence);
  const auto make_with = [&](int threads) -> std::unique_ptr<SequenceEvaluator> {
    estimation::SequenceOptions options;
    options.threads = threads;
    options.tolerance_N = effort.tolerance_N;
    auto made = SequenceEvaluator::make(model, sequences, options);
    return made ? std::make_unique<SequenceEvaluator>(std::move(*made)) : nullptr;
  };
  estimation::FitOptions options;
  options.loss = found.options.loss;
  // a start that is not quite the optimum would be taken for a second basin
  options.max_iterations = 40;
  options.tolerance = 1e-8;
  options.on_iteration = [&](int, double) { return !stop.stop_requested(); };
  const auto evaluator = make_with(effort.threads);
  if (!evaluator) return all;
  const estimation::FitResult best = estimation::fit(*evaluator, model, options);
  if (stop.stop_requested()) return fail(ErrorKind::cancelled, "the fit was stopped");
  if (!best.usable) return all;

  const auto names = estimation::parameter_names(model);
  std::vector<int> wanted;
  for (std::size_t k = 0; k < best.states.size(); ++k)
    if (best.states[k] != ParameterState::fixed && best.states[k] != ParameterState::zero_gradient)
      wanted.push_back(static_cast<int>(k));
  // as many at a time as there are threads, to hear of a stop
  for (std::size_t k = 0; k < wanted.size();) {
    if (stop.stop_requested()) return fail(ErrorKind::cancelled, "the fit was stopped");
    report({"profiles", names[static_cast<std::size_t>(wanted[k])], 0, 0.0, 0.96});
    estimation::ProfileOptions how;
    how.threads = effort.threads;
    how.reach = 3.0;
    how.scan = 1;
    const std::size_t end = std::min(wanted.size(), k + static_cast<std::size_t>(effort.threads));
    for (; k < end; ++k) how.parameters.push_back(wanted[k]);
    for (Profile& profile :
         estimation::profiles([&] { return make_with(1); }, model, best, options, how))
      all.push_back(std::move(profile));
  }
  return all;
}

}  // namespace tenter::jobs
