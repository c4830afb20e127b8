// SPDX-License-Identifier: Apache-2.0
// Where a job stands, as a watching client sees it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tenter::client {

enum class JobState { queued, running, succeeded, failed, cancelled };

/// "queued", "running", "succeeded", "failed", "cancelled".
std::string_view job_state_name(JobState state);
inline bool is_final(JobState state) {
  return state != JobState::queued && state != JobState::running;
}

enum class Link {
  connected,  ///< the server is there
  lost,  ///< the server has been silent for longer than its lease; the rest is what was known last
};

struct JobUpdate {
  std::string job_id;
  JobState state = JobState::queued;
  std::uint64_t revision = 0;  ///< grows with every change of the job's row
  int attempt = 0;             ///< 1 in the first run
  Link link = Link::connected;

  std::string stage;            ///< what the worker does now: "read", "screen", "refit", ...
  std::string detail;           ///< within the stage: a term, a capture
  std::int64_t iteration = -1;  ///< of the solver, in this stage; -1: none
  double cost = 0.0;            ///< the solver's, when iteration >= 0
  double fraction = -1.0;       ///< 0..1 of the whole job; -1: not known
  double elapsed_s = 0.0;       ///< since this attempt started, by the server's clock
  std::string message;          ///< why it failed, was cancelled, waits
};

}  // namespace tenter::client
