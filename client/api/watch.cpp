// SPDX-License-Identifier: Apache-2.0
// Changes of a job are numbered without gaps, so what is heard is either the next one, or old, or a
// gap; a gap is filled by asking. Listening starts before the first question, so nothing falls
// between them. Every few seconds without news the job is asked for anyway: a server with more jobs
// than the topic holds does not publish them all.
#include "client/api/watch.h"

#include <charconv>
#include <cmath>
#include <deque>
#include <variant>

#include "client/api/json_body.h"
#include "common/wire/validate.h"

namespace tenter::client {

namespace v1 = wire::v1;
using Clock = std::chrono::steady_clock;

namespace {

constexpr auto kMatch = std::chrono::milliseconds(500);
constexpr auto kTick = std::chrono::milliseconds(250);
constexpr auto kAskAfter = std::chrono::seconds(5);

std::optional<JobState> state_named(const std::string& name) {
  for (const auto state : {JobState::queued, JobState::running, JobState::succeeded,
                           JobState::failed, JobState::cancelled})
    if (job_state_name(state) == name) return state;
  return std::nullopt;
}

JobState state_of(v1::JobPhase phase) {
  switch (phase) {
    case v1::QUEUED:
      return JobState::queued;
    case v1::RUNNING:
      return JobState::running;
    case v1::SUCCEEDED:
      return JobState::succeeded;
    case v1::FAILED:
      return JobState::failed;
    case v1::CANCELLED:
      return JobState::cancelled;
  }
  return JobState::failed;
}

double number_at(const json& object, const char* key, double otherwise) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : otherwise;
}

/// What is heard of one change, from whichever topic or reply.
struct Change {
  std::uint64_t number = 0;
  JobState state = JobState::queued;
  int attempt = 0;
  std::string message;
};

class Watch {
 public:
  Watch(Connection& connection, const std::string& job_id, const WatchCallback& callback,
        const std::stop_token& stop)
      : connection_(connection), job_id_(job_id), callback_(callback), stop_(stop) {}
  Expected<JobUpdate> run();

 private:
  using Heard = std::variant<Change, v1::FitProgress>;

  Expected<void> listen();
  Expected<void> ask_all();
  Expected<void> fill_gap();
  Expected<void> take(const Heard& heard);
  void apply(const Change& change);
  void apply(const v1::FitProgress& progress);
  void hear(std::int64_t job, const wire::Uuid& server, Heard heard);
  void check_link();
  void tell() {
    if (callback_) callback_(now_);
  }

  Connection& connection_;
  const std::string job_id_;
  const WatchCallback& callback_;
  const std::stop_token stop_;
  std::int64_t number_ = 0;
  JobUpdate now_;

  std::mutex mutex_;
  std::condition_variable_any news_;
  std::deque<Heard> heard_;
  std::unique_ptr<wire::Reader<v1::JobState>> states_;
  std::unique_ptr<wire::Reader<v1::JobEvent>> events_;
  std::unique_ptr<wire::Reader<v1::FitProgress>> progress_;
};

void Watch::hear(std::int64_t job, const wire::Uuid& server, Heard heard) {
  if (job != number_ || server != connection_.server().id) return;
  std::lock_guard lock(mutex_);
  // of progress only the latest counts
  if (heard_.size() >= 256 && std::holds_alternative<v1::FitProgress>(heard)) return;
  heard_.push_back(std::move(heard));
  news_.notify_all();
}

Expected<void> Watch::listen() {
  auto server = connection_.wait_for_server(stop_);
  if (!server) return tl::unexpected(server.error());
  auto& participant = connection_.participant();
  const auto wake = [this](const wire::Peer&, bool) {
    std::lock_guard lock(mutex_);
    news_.notify_all();
  };
  wire::ReaderHandlers<v1::JobEvent> on_event;
  on_event.on_match = wake;
  on_event.on_sample = [this](v1::JobEvent& s, const wire::Peer&) {
    hear(s.job_id(), s.server_id(),
         Change{s.number(), state_of(s.phase()), static_cast<int>(s.attempt()), s.text()});
  };
  events_ =
      std::make_unique<wire::Reader<v1::JobEvent>>(participant, wire::job_event_topic(), on_event);
  wire::ReaderHandlers<v1::JobState> on_state;
  on_state.on_match = wake;
  on_state.on_sample = [this](v1::JobState& s, const wire::Peer&) {
    hear(s.job_id(), s.server_id(),
         Change{s.revision(), state_of(s.phase()), static_cast<int>(s.attempt()), s.message()});
  };
  states_ =
      std::make_unique<wire::Reader<v1::JobState>>(participant, wire::job_state_topic(), on_state);
  wire::ReaderHandlers<v1::FitProgress> on_progress;
  on_progress.on_sample = [this](v1::FitProgress& s, const wire::Peer&) {
    hear(s.job_id(), s.server_id(), s);
  };
  progress_ = std::make_unique<wire::Reader<v1::FitProgress>>(
      participant, wire::fit_progress_topic(), on_progress);
  std::unique_lock lock(mutex_);
  news_.wait_for(lock, stop_, kMatch,
                 [&] { return events_->matched(server->peer) && states_->matched(server->peer); });
  return {};
}

Expected<void> Watch::ask_all() {
  auto job = ask(connection_, "job.show", {{"job", job_id_}}, stop_);
  if (!job) return tl::unexpected(job.error());
  const auto state = state_named(text_at(*job, "state"));
  if (!state) return fail(ErrorKind::internal, "the server's reply to job.show is not understood");
  Change change{count_at(*job, "revision"), *state, static_cast<int>(count_at(*job, "attempt")),
                text_at(*job, "message")};
  if (const json error = job->value("error", json()); error.is_object())
    change.message = text_at(error, "message");
  const bool news = now_.revision == 0 || change.number > now_.revision;
  if (!news) return {};
  apply(change);
  if (const json progress = job->value("progress", json()); progress.is_object()) {
    now_.stage = text_at(progress, "stage");
    now_.detail = text_at(progress, "detail");
    now_.iteration = static_cast<std::int64_t>(number_at(progress, "iteration", -1));
    now_.cost = number_at(progress, "cost", 0.0);
    now_.fraction = number_at(progress, "fraction", -1.0);
  }
  tell();
  return {};
}

Expected<void> Watch::fill_gap() {
  auto reply = ask(connection_, "job.events", {{"job", job_id_}, {"after", now_.revision}}, stop_);
  if (!reply) return tl::unexpected(reply.error());
  for (const json& event : reply->value("events", json::array())) {
    const auto state = state_named(text_at(event, "state"));
    const Change change{count_at(event, "number"), state.value_or(JobState::failed),
                        static_cast<int>(count_at(event, "attempt")), text_at(event, "message")};
    if (!state || change.number <= now_.revision) continue;
    apply(change);
    tell();
  }
  return {};
}

void Watch::apply(const Change& change) {
  if (change.attempt != now_.attempt || change.state == JobState::queued) {
    now_.stage.clear();
    now_.detail.clear();
    now_.iteration = -1;
    now_.cost = 0.0;
    now_.fraction = -1.0;
    now_.elapsed_s = 0.0;
  }
  now_.revision = change.number;
  now_.state = change.state;
  now_.attempt = change.attempt;
  now_.message = change.message;
}

void Watch::apply(const v1::FitProgress& progress) {
  now_.stage = progress.stage();
  now_.detail = progress.detail();
  now_.iteration = progress.iteration();
  now_.cost = progress.cost();
  now_.fraction = progress.fraction();
  now_.elapsed_s = progress.elapsed_s();
}

Expected<void> Watch::take(const Heard& heard) {
  if (const auto* progress = std::get_if<v1::FitProgress>(&heard)) {
    const bool current =
        now_.state == JobState::running && static_cast<int>(progress->attempt()) == now_.attempt;
    if (!current) return {};
    apply(*progress);
    tell();
    return {};
  }
  const Change& change = std::get<Change>(heard);
  if (change.number <= now_.revision) return {};
  if (change.number > now_.revision + 1) return fill_gap();
  apply(change);
  tell();
  return {};
}

void Watch::check_link() {
  const Link link = connection_.server().alive ? Link::connected : Link::lost;
  if (link == now_.link) return;
  now_.link = link;
  tell();
}

Expected<JobUpdate> Watch::run() {
  const auto [end, error] =
      std::from_chars(job_id_.data(), job_id_.data() + job_id_.size(), number_);
  if (error != std::errc() || end != job_id_.data() + job_id_.size() || number_ <= 0)
    return bad_input("'" + job_id_ + "' is not the number of a job");
  now_.job_id = job_id_;
  if (auto listening = listen(); !listening) return tl::unexpected(listening.error());
  if (auto first = ask_all(); !first) return tl::unexpected(first.error());

  auto last_news = Clock::now();
  while (!is_final(now_.state) && !stop_.stop_requested()) {
    std::deque<Heard> heard;
    {
      std::unique_lock lock(mutex_);
      news_.wait_for(lock, stop_, kTick, [this] { return !heard_.empty(); });
      heard.swap(heard_);
    }
    const bool was_lost = now_.link == Link::lost;
    check_link();
    if (now_.link == Link::lost) continue;
    if (!heard.empty()) last_news = Clock::now();
    Expected<void> done;
    for (const Heard& one : heard)
      if (done && !is_final(now_.state)) done = take(one);
    if (done && (was_lost || Clock::now() - last_news > kAskAfter)) {
      last_news = Clock::now();
      done = ask_all();
    }
    if (!done && done.error().kind != ErrorKind::unavailable &&
        done.error().kind != ErrorKind::cancelled)
      return tl::unexpected(done.error());
  }
  return now_;
}

}  // namespace

Expected<JobUpdate> watch(Connection& connection, const std::string& job_id,
                          const WatchCallback& callback, const std::stop_token& stop) {
  return Watch(connection, job_id, callback, stop).run();
}

}  // namespace tenter::client
