// SPDX-License-Identifier: Apache-2.0
#include "client/cli/submit.h"

#include <CLI/CLI.hpp>

#include "client/cli/names.h"
#include "client/cli/output.h"

namespace tenter::cli {

void add_submit_options(CLI::App& command, SubmitOptions& options) {
  command.add_option("--priority", options.priority, "-100 to 100, higher runs first. Default: 0.")
      ->type_name("N")
      ->check(CLI::Range(-100, 100));
  command
      .add_option("--after", options.after, "Wait until this job has succeeded; may be repeated.")
      ->type_name("JOB")
      ->expected(1)
      ->take_all();
  command
      .add_option("--time-limit", options.time_limit_s, "Stop the job after this long, in seconds.")
      ->type_name("SECONDS")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--memory-limit", options.memory_limit_mb, "Memory that the job may have, in MB.")
      ->type_name("MB")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--max-attempts", options.max_attempts,
                  "How often the job may be started if its worker dies.")
      ->type_name("N")
      ->check(CLI::Range(1, 100));
  command
      .add_option("--request-id", options.request_id,
                  "A name of your own for this request; the same again returns the same job.")
      ->type_name("ID");
}

Expected<client::SubmitResult> submit_job(client::Client& client, const std::string& spec_json,
                                          const SubmitOptions& options) {
  client::SubmitRequest request;
  request.spec_json = spec_json;
  request.request_id = options.request_id;
  request.priority = options.priority;
  for (const std::string& name : options.after) {
    const Expected<std::string> job = resolve_job(client, name);
    if (!job) return tl::unexpected(job.error());
    request.depends_on.push_back(*job);
  }
  if (options.time_limit_s > 0.0) request.time_limit_s = options.time_limit_s;
  if (options.memory_limit_mb > 0.0)
    request.memory_limit_bytes = static_cast<std::uint64_t>(options.memory_limit_mb * 1e6);
  if (options.max_attempts > 0) request.max_attempts = options.max_attempts;
  return client.submit(request);
}

void print_submitted(const Context& context, const client::SubmitResult& job) {
  if (context.json) {
    Json value = {
        {"job_id", job.job_id}, {"repeated", job.repeated}, {"from_store", job.from_store}};
    const Json shown = Json::parse(job.job_json, nullptr, false);
    if (!shown.is_discarded()) value["job"] = shown;
    print_json(value);
    return;
  }
  if (job.from_store)
    print_text("job " + job.job_id + " was done before: its result is there (tenter report " +
               job.job_id + ")\n");
  else
    print_text("job " + job.job_id + " submitted (tenter job watch " + job.job_id + ")\n");
}

}  // namespace tenter::cli
