// SPDX-License-Identifier: Apache-2.0
// Submitting a job with what the queue needs to know of it: priority, limits, what it waits for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/api/client.h"
#include "client/cli/context.h"
#include "common/base/error.h"

namespace CLI {
class App;
}

namespace tenter::cli {

struct SubmitOptions {
  int priority = 0;
  std::vector<std::string> after;  ///< jobs that must succeed first
  double time_limit_s = 0.0;       ///< 0: the server's default
  double memory_limit_mb = 0.0;    ///< 0: the server's default
  int max_attempts = 0;            ///< 0: the server's default
  std::string request_id;
};

/// --priority, --after, --time-limit, --memory-limit, --max-attempts, --request-id
void add_submit_options(CLI::App& command, SubmitOptions& options);

Expected<client::SubmitResult> submit_job(client::Client& client, const std::string& spec_json,
                                          const SubmitOptions& options);

/// "job 17 submitted", and how to go on; with --json the job.
void print_submitted(const Context& context, const client::SubmitResult& job);

}  // namespace tenter::cli
