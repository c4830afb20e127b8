// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/requests/sheet_starts.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "server/estimation/staged/resting_frames.h"
#include "server/jobs/sheet_fit/certainty/optimum.h"

namespace tenter::jobs {
namespace {

using estimation::FitOptions;
using estimation::Sequence;
using estimation::StartOutcome;

FitOptions fit_options(const SheetFindings& found, const RequestWork& work) {
  FitOptions options;
  options.method = estimation::FitMethod::bounded_marquardt;
  options.max_iterations = 30;  // as a stage's fits
  options.tolerance = 1e-3;
  options.loss = found.options.loss;
  options.on_iteration = [&work](int, double) { return !work.stop.stop_requested(); };
  return options;
}

/// All frames, from the best start's values. False where that has no equilibrium.
bool take(const Eigen::VectorXd& parameters, const SheetFindings& found, const RequestWork& work,
          model::Model& model) {
  model::Model start = model;
  const auto all = estimation::parameters_of(start);
  for (std::size_t k = 0; k < all.size(); ++k)
    all[k]->value = parameters[static_cast<Eigen::Index>(k)];
  auto evaluator = estimation::SequenceEvaluator::make(
      start, compared_sequences(found, FramesStart::as_measured), sequence_options(work));
  if (!evaluator) return false;
  const auto fitted = estimation::fit(*evaluator, start, fit_options(found, work));
  if (!fitted.usable) return false;
  estimation::store(fitted, start);
  model = std::move(start);
  return true;
}

}  // namespace

Expected<StartsFound> sheet_starts(model::Model& model, const SheetFindings& found,
                                   const RequestWork& work) {
  StartsFound result;
  result.count = found.options.starts;
  result.seed = static_cast<std::uint64_t>(found.options.seed);
  result.widest = kWidest;
  result.share = kShare;
  std::vector<Sequence> sequences = compared_sequences(found, FramesStart::as_measured);
  for (Sequence& sequence : sequences) {
    const int frames = static_cast<int>(sequence.frames.size());
    estimation::keep_frames(sequence, estimation::even_frames(frames, kStartFrames));
    result.frames = std::max(result.frames, static_cast<int>(sequence.frames.size()));
  }
  if (sequences.empty()) return fail(ErrorKind::refused, "no fitted frame has a rest");

  const estimation::ParameterTies ties = estimation::no_ties(model);
  std::vector<Eigen::VectorXd> starts =
      estimation::random_starts(ties, result.count, kWidest, result.seed);
  starts.insert(starts.begin(), ties.values());
  estimation::MultiStartOptions options;
  options.threads = work.threads;
  options.fit = fit_options(found, work);
  options.tolerance_N = work.tolerance_N;
  // as many at a time as there are threads, to tell how many are done
  const auto tell = [&](std::size_t done) {
    work.report({"starts", std::to_string(done) + " of " + std::to_string(starts.size()), 0, 0.0,
                 work.fraction});
  };
  result.outcomes = work.starts.load();
  for (std::size_t first = result.outcomes.size(); first < starts.size();) {
    const std::size_t end =
        std::min(starts.size(), first + static_cast<std::size_t>(std::max(1, work.threads)));
    tell(first);
    const std::vector<Eigen::VectorXd> some(starts.begin() + static_cast<std::ptrdiff_t>(first),
                                            starts.begin() + static_cast<std::ptrdiff_t>(end));
    auto outcomes = estimation::multi_start(model, ties, sequences, some, options);
    if (!outcomes) return tl::unexpected(outcomes.error());
    if (work.stop.stop_requested()) return fail(ErrorKind::cancelled, "the fit was stopped");
    for (StartOutcome& outcome : *outcomes) {
      outcome.start += static_cast<int>(first);
      result.outcomes.push_back(std::move(outcome));
    }
    work.starts.save(result.outcomes);
    first = end;
  }
  tell(starts.size());
  if (work.stop.stop_requested()) return fail(ErrorKind::cancelled, "the fit was stopped");
  std::sort(result.outcomes.begin(), result.outcomes.end(),
            [](const StartOutcome& a, const StartOutcome& b) {
              return a.cost != b.cost ? a.cost < b.cost : a.start < b.start;
            });
  for (const StartOutcome& outcome : result.outcomes)
    if (outcome.start == 0) result.cost_of_fit = outcome.cost;
  result.in_best_basin = estimation::in_best_basin(result.outcomes, kShare);
  const StartOutcome& best = result.outcomes.front();
  if (best.usable && best.cost < (1.0 - kShare) * result.cost_of_fit)
    result.is_better = take(best.parameters, found, work, model);
  return result;
}

}  // namespace tenter::jobs
