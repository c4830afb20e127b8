// SPDX-License-Identifier: GPL-3.0-or-later
// What a sheet's fit does on request once its stages are done: starts, convexity, samples, a limit,
// in this order, each from what the one before left.
//
//   auto done = fulfil_requests(model, found, work, predict_again);
//
// Model and found.requested are changed; found.after are rests of `model` before and after.
#pragma once

#include <functional>
#include <stop_token>

#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/jobs/results/run_job.h"
#include "server/jobs/sheet_fit/progress/stage_checkpoint.h"
#include "server/jobs/sheet_fit/requests/found.h"
#include "server/jobs/sheet_fit/sheet_findings.h"

namespace tenter::jobs {

struct RequestWork {
  int threads = 1;
  double tolerance_N = 1e-7;
  double fraction = 0.0;  ///< of the whole job that is done
  const std::function<void(const JobProgress&)>& report;
  const std::stop_token& stop;
  const StartCheckpoint& starts;  ///< those that ended in an earlier attempt
};

/// How the requests evaluate sequences.
inline estimation::SequenceOptions sequence_options(const RequestWork& work) {
  estimation::SequenceOptions options;
  options.threads = work.threads;
  options.tolerance_N = work.tolerance_N;
  return options;
}

/// `predict_again` makes found.after of a model. Errors as its and as those of the requests.
Expected<void> fulfil_requests(
    model::Model& model, SheetFindings& found, const RequestWork& work,
    const std::function<Expected<void>(const model::Model&)>& predict_again);

}  // namespace tenter::jobs
