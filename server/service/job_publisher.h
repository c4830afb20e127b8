// SPDX-License-Identifier: GPL-3.0-or-later
// Tells everyone who listens how jobs go: job_state, job_event, fit_progress.
//
// Ended jobs stay in job_state for a minute, then they are let go: who asks later, asks by request.
// The same happens earlier when thousands are there, so that running jobs always have a place.
#pragma once

#include <chrono>
#include <deque>
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
  /// Loop thread, now and then.
  void tidy();

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
  void let_go(jobs::JobId job);

  const Context context_;
  wire::Writer<wire::v1::JobState> states_;
  wire::Writer<wire::v1::JobEvent> events_;
  wire::Writer<wire::v1::FitProgress> progress_;
  std::set<jobs::JobId> published_;
  std::set<jobs::JobId> with_progress_;
  std::deque<std::pair<Clock::time_point, jobs::JobId>> ended_;
  std::map<jobs::JobId, Running> running_;
};

}  // namespace tenter::service
