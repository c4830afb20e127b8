// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/job_publisher.h"

#include <algorithm>
#include <cmath>

#include "common/wire/validate.h"

namespace tenter::service {

namespace v1 = wire::v1;

namespace {

constexpr std::size_t kMostEnded = 1000;
constexpr std::size_t kMostPublished = wire::kMaxJobInstances - 256;
constexpr int kMostAtStart = 1000;

v1::JobPhase phase_of(jobs::JobState state) {
  switch (state) {
    case jobs::JobState::queued:
      return v1::QUEUED;
    case jobs::JobState::running:
      return v1::RUNNING;
    case jobs::JobState::succeeded:
      return v1::SUCCEEDED;
    case jobs::JobState::failed:
      return v1::FAILED;
    case jobs::JobState::cancelled:
      return v1::CANCELLED;
  }
  return v1::FAILED;
}

std::uint32_t attempt_of(const jobs::JobEvent& event) {
  return static_cast<std::uint32_t>(std::max(event.attempt, 0));
}

}  // namespace

JobPublisher::JobPublisher(const Context& context, const jobs::JobService& jobs)
    : context_(context), events_(context.participant, wire::job_event_topic(), {}, context.epoch) {
  make_writers();
  for (const auto state : {jobs::JobState::running, jobs::JobState::queued}) {
    jobs::JobFilter filter;
    filter.state = state;
    filter.limit = kMostAtStart;
    auto page = jobs.list(filter);
    if (!page) continue;
    for (const jobs::JobRecord& job : page->jobs) {
      jobs::JobEvent now;
      now.job = job.id;
      now.number = job.revision;
      now.message = job.message;
      now.state = job.state;
      now.attempt = job.attempt;
      now.user = job.user;
      context.participant.loop().run([&] { publish_state(now); });
    }
  }
}

JobPublisher::~JobPublisher() = default;

void JobPublisher::publish(const jobs::JobEvent& event) {
  context_.participant.loop().post([this, event] {
    if (event.what == "progress") return publish_progress(event);
    publish_state(event);
    publish_event(event);
  });
}

void JobPublisher::make_writers() {
  states_ = std::make_unique<wire::Writer<v1::JobState>>(
      context_.participant, wire::job_state_topic(), wire::MatchHandler{}, context_.epoch);
  progress_ = std::make_unique<wire::Writer<v1::FitProgress>>(
      context_.participant, wire::fit_progress_topic(), wire::MatchHandler{}, context_.epoch);
  ended_.clear();
  for (const auto& [job, event] : live_) write_state(event);
}

void JobPublisher::publish_state(const jobs::JobEvent& event) {
  if (event.state == jobs::JobState::running) {
    Running& run = running_[event.job];
    if (run.attempt != event.attempt) run = {event.attempt, Clock::now()};
  } else {
    running_.erase(event.job);
  }
  const bool fresh = live_.count(event.job) == 0 && ended_.count(event.job) == 0;
  const bool full = live_.size() + ended_.size() >= kMostPublished;
  if (ended_.size() >= kMostEnded || (fresh && full && !ended_.empty())) make_writers();
  if (fresh && live_.size() >= kMostPublished) return;
  if (jobs::is_final(event.state)) {
    live_.erase(event.job);
    ended_.insert(event.job);
  } else {
    ended_.erase(event.job);
    live_[event.job] = event;
  }
  write_state(event);
}

void JobPublisher::write_state(const jobs::JobEvent& event) {
  v1::JobState sample;
  sample.server_id(context_.server_id);
  sample.job_id(event.job);
  sample.revision(static_cast<std::uint64_t>(event.number));
  sample.phase(phase_of(event.state));
  sample.attempt(attempt_of(event));
  sample.user(event.user);
  sample.message(wire::clean_text(event.message, v1::MAX_TEXT));
  if (auto sent = states_->write(sample); !sent) context_.log(Level::warning, sent.error().message);
}

void JobPublisher::publish_event(const jobs::JobEvent& event) {
  v1::JobEvent sample;
  sample.server_id(context_.server_id);
  sample.job_id(event.job);
  sample.number(static_cast<std::uint64_t>(event.number));
  sample.time_ms(event.time_ms);
  sample.phase(phase_of(event.state));
  sample.attempt(attempt_of(event));
  sample.kind(wire::clean_text(event.what, v1::MAX_NAME));
  sample.text(wire::clean_text(event.message, v1::MAX_TEXT));
  if (auto sent = events_.write(sample); !sent) context_.log(Level::warning, sent.error().message);
}

void JobPublisher::publish_progress(const jobs::JobEvent& event) {
  if (!event.progress || live_.count(event.job) == 0) return;
  const auto run = running_.find(event.job);
  const jobs::JobProgress& now = *event.progress;
  v1::FitProgress sample;
  sample.server_id(context_.server_id);
  sample.job_id(event.job);
  sample.attempt(attempt_of(event));
  sample.stage(wire::clean_text(now.stage, v1::MAX_NAME));
  sample.detail(wire::clean_text(now.detail, v1::MAX_TEXT));
  sample.iteration(std::max(now.iteration, -1));
  sample.cost(std::isnan(now.cost) ? 0.0 : now.cost);
  sample.fraction(std::isnan(now.fraction) ? -1.0 : std::clamp(now.fraction, -1.0, 1.0));
  sample.elapsed_s(run == running_.end()
                       ? 0.0
                       : std::chrono::duration<double>(Clock::now() - run->second.since).count());
  if (auto sent = progress_->write(sample); !sent)
    context_.log(Level::warning, sent.error().message);
}

}  // namespace tenter::service
