// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "server/jobs/job_service.h"
#include "server/service/operations.h"

namespace tenter::service {

/// job.submit, job.list, job.show, job.events, job.log, job.cancel, job.retry, capture.list,
/// capture.show.
void add_job_operations(Operations& table, jobs::JobService& jobs);

}  // namespace tenter::service
