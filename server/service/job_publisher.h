// SPDX-License-Identifier: GPL-3.0-or-later
// Tells everyone who listens how jobs go: job_state, job_event, fit_progress.
//
// job_state holds the jobs that wait and run and up to a thousand that ended lately. When there are
// more, both writers with keys are made anew with what waits and runs: letting single instances go
// is not reliable in this version of Fast DDS. A job that finds no place is not published; who
// watches it asks now and then.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <set>

#include "common/wire/endpoint.h"
#include "server/jobs/job_service.h"
#include "server/service/context.h"

namespace tenter::service {

class JobPublisher {
 public:
  /// Publishes the queued and running jobs at once.
  JobPublisher(const Context& context, const jobs::JobService& jobs);
  ~JobPublisher();

  /// Any thread; returns at once.
  void publish(const jobs::JobEvent& event);

 private:
  using Clock = std::chrono::steady_clock;
  struct Running {
    int attempt = 0;
    Clock::time_point since;
  };
  // loop thread
  void publish_state(const jobs::JobEvent& event);
  void publish_event(const jobs::JobEvent& event);
  void publish_progress(const jobs::JobEvent& event);
  void write_state(const jobs::JobEvent& event);
  void make_writers();

  const Context context_;
  wire::Writer<wire::v1::JobEvent> events_;
  std::unique_ptr<wire::Writer<wire::v1::JobState>> states_;
  std::unique_ptr<wire::Writer<wire::v1::FitProgress>> progress_;
  std::map<jobs::JobId, jobs::JobEvent>
      live_;                     ///< last event of each published job that has not ended
  std::set<jobs::JobId> ended_;  ///< published by these writers
  std::map<jobs::JobId, Running> running_;
};

}  // namespace tenter::service
