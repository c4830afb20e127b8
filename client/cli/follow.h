// SPDX-License-Identifier: Apache-2.0
// Following a job from the terminal until it ends, and fetching what it left.
#pragma once

#include <string>

#include "client/api/client.h"
#include "client/cli/context.h"
#include "client/cli/interrupt.h"
#include "common/base/error.h"

namespace tenter::cli {

/// Shows progress until the job has ended. A failed job is an Error (job_failed) with its reason, a
/// cancelled one and Ctrl-C are `cancelled`; after Ctrl-C the job goes on and the message says how
/// to follow it.
Expected<client::JobUpdate> follow_job(client::Client& client, Context& context,
                                       const std::string& job_id, Interrupt& interrupt);

/// The result document of a succeeded job as text. With `keep` the file stays there under that
/// name.
Expected<std::string> fetch_result_text(client::Client& client, const std::string& job_id,
                                        const std::string& keep = "");

}  // namespace tenter::cli
