// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/requests/sheet_limits.h"

#include <algorithm>
#include <utility>

#include "server/jobs/sheet_fit/certainty/optimum.h"

namespace tenter::jobs {

Expected<LimitedModel> sheet_limit(model::Model& model, const SheetFindings& found,
                                   const RequestWork& work) {
  LimitedModel result;
  model::EnergyLimit& limit = model.limits.front();
  result.found.id = limit.id;
  result.found.given = limit.energy_max;
  estimation::LimitFitOptions options;
  options.sequences.threads = work.threads;
  options.sequences.tolerance_N = work.tolerance_N;
  options.fit.loss = found.options.loss;
  options.fit.tolerance = 1e-5;
  options.fit.max_iterations = 40;
  options.fit.on_iteration = [&](int iteration, double cost) {
    work.report({"limits", limit.id, iteration, cost, work.fraction});
    return !work.stop.stop_requested();
  };
  auto fitted = estimation::fit_limit(model, compared_sequences(found, FramesStart::at_rest),
                                      limit.id, options);
  if (work.stop.stop_requested()) return fail(ErrorKind::cancelled, "the fit was stopped");
  if (!fitted) {
    result.found.message = fitted.error().message;
    return result;
  }
  result.found.message = fitted->message;
  estimation::store(fitted->elastic, model);
  // a limit that nothing reaches must not act: above the largest density, whatever was given
  limit.energy_max =
      fitted->is_reached ? fitted->energy_max : std::max(limit.energy_max, fitted->energy_max);
  if (fitted->is_reached) result.optimum = std::move(fitted->elastic);
  result.found.fit = std::move(*fitted);
  result.found.fit.elastic = {};
  return result;
}

}  // namespace tenter::jobs
