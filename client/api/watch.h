// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>

#include "client/api/client.h"
#include "client/api/connection.h"

namespace tenter::client {

/// Follows a job: asks once, then listens to job_state, job_event and fit_progress; what was missed
/// is asked for.
Expected<JobUpdate> watch(Connection& connection, const std::string& job_id,
                          const WatchCallback& callback, const std::stop_token& stop);

}  // namespace tenter::client
