// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/requests/requests.h"

#include <utility>

#include "server/jobs/sheet_fit/requests/sheet_convexity.h"
#include "server/jobs/sheet_fit/requests/sheet_limits.h"
#include "server/jobs/sheet_fit/requests/sheet_samples.h"
#include "server/jobs/sheet_fit/requests/sheet_starts.h"

namespace tenter::jobs {

Expected<void> fulfil_requests(
    model::Model& model, SheetFindings& found, const RequestWork& work,
    const std::function<Expected<void>(const model::Model&)>& predict_again) {
  const SheetFitOptions& options = found.options;
  if (options.starts > 0) {
    auto starts = sheet_starts(model, found, work);
    if (!starts) return tl::unexpected(starts.error());
    found.requested.starts = std::move(*starts);
    if (found.requested.starts->is_better)
      if (auto ok = predict_again(model); !ok) return ok;
  }
  if (options.convex != ConvexWay::none) {
    auto convex = sheet_convexity(model, found, work);
    if (!convex) return tl::unexpected(convex.error());
    found.requested.convexity = std::move(*convex);
    if (auto ok = predict_again(model); !ok) return ok;
  }
  if (options.samples > 0) {
    auto sampled = sheet_samples(model, found, work);
    if (!sampled) return tl::unexpected(sampled.error());
    found.requested.samples = std::move(sampled->found);
    found.requested.optimum = std::move(sampled->optimum);
    if (found.requested.optimum)
      if (auto ok = predict_again(model); !ok) return ok;
  }
  if (options.limits) {
    auto limited = sheet_limit(model, found, work);
    if (!limited) return tl::unexpected(limited.error());
    found.requested.limit = std::move(limited->found);
    found.requested.optimum = std::move(limited->optimum);
    if (auto ok = predict_again(model); !ok) return ok;
  }
  return {};
}

}  // namespace tenter::jobs
