// SPDX-License-Identifier: Apache-2.0
#include "client/cli/follow.h"

#include <unistd.h>

#include <iostream>

#include "client/cli/progress.h"
#include "client/cli/scratch.h"
#include "common/base/text_file.h"

namespace tenter::cli {

namespace {

constexpr std::size_t kMaxResultBytes = 512u << 20;

}  // namespace

Expected<client::JobUpdate> follow_job(client::Client& client, Context& context,
                                       const std::string& job_id, Interrupt& interrupt) {
  context.details["job_id"] = job_id;
  ProgressDisplay display(std::cerr, isatty(STDERR_FILENO) == 1, terminal_width(STDERR_FILENO));
  const bool quiet = context.quiet;
  Expected<client::JobUpdate> last = client.watch(
      job_id,
      [&display, quiet](const client::JobUpdate& update) {
        if (!quiet) display.show(update);
      },
      interrupt.token());
  display.finish();
  if (!last) return last;
  if (last->state == client::JobState::failed)
    return fail(ErrorKind::job_failed,
                "job " + job_id +
                    " failed: " + (last->message.empty() ? "no reason given" : last->message) +
                    " (its log: tenter job log " + job_id + ")");
  if (last->state == client::JobState::cancelled)
    return fail(ErrorKind::cancelled, "job " + job_id + " was cancelled" +
                                          (last->message.empty() ? "" : ": " + last->message));
  if (!client::is_final(last->state))
    return fail(ErrorKind::cancelled, "stopped watching; job " + job_id +
                                          " goes on (tenter job watch " + job_id +
                                          ", tenter job cancel " + job_id + ")");
  return last;
}

Expected<std::string> fetch_result_text(client::Client& client, const std::string& job_id,
                                        const std::string& keep) {
  if (!keep.empty()) {
    if (const auto fetched = client.fetch_result(job_id, keep); !fetched)
      return tl::unexpected(fetched.error());
    return read_text_file(keep, kMaxResultBytes);
  }
  const Expected<ScratchFolder> scratch = ScratchFolder::make();
  if (!scratch) return tl::unexpected(scratch.error());
  const std::filesystem::path file = scratch->path() / "result.json";
  if (const auto fetched = client.fetch_result(job_id, file); !fetched)
    return tl::unexpected(fetched.error());
  return read_text_file(file.string(), kMaxResultBytes);
}

}  // namespace tenter::cli
