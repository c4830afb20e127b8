// SPDX-License-Identifier: GPL-3.0-or-later
// A word and an interval for each parameter by profile likelihood (uncertainty/profile.h), at the
// end of a sheet's fit.
//
// All parameters are refitted together first, as stages and tied curves need not end at the least
// cost of what is compared here. Refits are many: of each capture at most kProfileFrames frames,
// evenly spread, are compared, so that intervals are rather too wide than too narrow, and one place
// beyond each end is searched for other basins.
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "server/jobs/results/run_job.h"
#include "server/jobs/sheet_fit/sheet_findings.h"

namespace tenter::jobs {

inline constexpr int kProfileFrames = 6;

struct ProfileEffort {
  int threads = 1;
  double tolerance_N = 1e-7;
};

/// Of parameters that are free or at a bound; none where the optimum is not usable. `cancelled`
/// where stopped.
Expected<std::vector<estimation::Profile>> sheet_profiles(
    const model::Model& model, const SheetFindings& found, const ProfileEffort& effort,
    const std::function<void(const JobProgress&)>& report, const std::stop_token& stop);

}  // namespace tenter::jobs
