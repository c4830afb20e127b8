// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/queue/queue.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "tests/server/jobs/queue_fixture.h"

namespace tenter::jobs {
namespace {

TEST_F(QueueTest, ARepeatedRequestGetsTheSameJob) {
  const auto first = MUST(try_submit({.request_id = "same"}, "a"));
  const auto again = MUST(try_submit({.request_id = "same"}, "a"));
  EXPECT_FALSE(first.repeated);
  EXPECT_TRUE(again.repeated);
  EXPECT_EQ(first.job.id, again.job.id);
  EXPECT_EQ(MUST(queue_->list({})).total, 1);
  const auto other = try_submit({.request_id = "same"}, "b");
  EXPECT_EQ(other.error().kind, ErrorKind::refused);
  EXPECT_NE(MUST(try_submit({.user = "bob", .request_id = "same"}, "a")).job.id, first.job.id);
  finish(claim());
  open();  // and after the end, and after a restart
  EXPECT_EQ(MUST(try_submit({.request_id = "same"}, "a")).job.id, first.job.id);
}

TEST_F(QueueTest, RequestsAreKeptADayAndTheNewestAlways) {
  submit("a", {.request_id = "old"});
  clock_.pass(25 * 3600 * 1000);
  open();  // prunes, but never the newest
  EXPECT_TRUE(MUST(try_submit({.request_id = "old"}, "a")).repeated);
}

TEST_F(QueueTest, BadRequestsAreRefusedWithASentence) {
  const auto kind = [&](SubmitRequest request) {
    return try_submit(std::move(request), "x").error().kind;
  };
  EXPECT_EQ(kind({.user = "no spaces"}), ErrorKind::bad_input);
  EXPECT_EQ(kind({.request_id = std::string(129, 'r')}), ErrorKind::bad_input);
  EXPECT_EQ(kind({.priority = 101}), ErrorKind::bad_input);
  EXPECT_EQ(kind({.depends_on = {77}}), ErrorKind::not_found);
  EXPECT_EQ(kind({.time_limit_s = 0.0}), ErrorKind::bad_input);
  EXPECT_EQ(kind({.time_limit_s = std::numeric_limits<double>::quiet_NaN()}), ErrorKind::bad_input);
  EXPECT_EQ(kind({.memory_limit_bytes = 5}), ErrorKind::bad_input);
  EXPECT_EQ(kind({.max_attempts = 0}), ErrorKind::bad_input);
  const auto unknown =
      queue_->submit({.user = "ada", .request_id = "u"},
                     MUST(parse_spec(spec_text("u", "{}", sha256_hex("no such capture")))));
  EXPECT_EQ(unknown.error().kind, ErrorKind::not_found);
  EXPECT_EQ(queue_->list({.limit = 0}).error().kind, ErrorKind::bad_input);
  EXPECT_EQ(queue_->list({.limit = 1001}).error().kind, ErrorKind::bad_input);
  EXPECT_EQ(MUST(queue_->list({})).total, 0);  // nothing half-done stays
}

TEST_F(QueueTest, EveryChangeIsAnEventWithTheRowsRevision) {
  const JobId job = submit("a");
  const JobRecord first = claim();
  MUST(queue_->worker_died(key(first), "its worker crashed"));
  finish(claim());
  const auto events = MUST(queue_->events(job, 0, 100));
  std::vector<std::string> what;
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].number, static_cast<std::int64_t>(i + 1));
    what.push_back(events[i].what);
  }
  EXPECT_EQ(what,
            (std::vector<std::string>{"submitted", "started", "requeued", "started", "succeeded"}));
  EXPECT_EQ(MUST(queue_->show(job)).revision, 5);
  EXPECT_EQ(queue_->take_events().size(), 5u);
  EXPECT_TRUE(queue_->take_events().empty());
  EXPECT_EQ(MUST(queue_->events(job, 3, 100)).size(), 2u);
}

TEST_F(QueueTest, PagesGoThroughAllJobsOnceNewestFirst) {
  for (int i = 0; i < 25; ++i)
    submit("n" + std::to_string(i), {.user = i % 5 == 0 ? "bob" : "ada"});
  JobFilter filter{.limit = 10};
  std::set<JobId> seen;
  JobId last = 1000;
  int pages = 0;
  for (;;) {
    const auto page = MUST(queue_->list(filter));
    EXPECT_EQ(page.total, 25);
    for (const auto& job : page.jobs) {
      EXPECT_LT(job.id, last);
      last = job.id;
      EXPECT_TRUE(seen.insert(job.id).second);
      EXPECT_EQ(job.captures, std::vector<std::string>{kCapture});
    }
    ++pages;
    if (page.next_before == 0) break;
    filter.before = page.next_before;
  }
  EXPECT_EQ(pages, 3);
  EXPECT_EQ(seen.size(), 25u);
  EXPECT_EQ(MUST(queue_->list({.user = "bob"})).total, 5);
  EXPECT_EQ(MUST(queue_->list({.state = JobState::running})).total, 0);
  EXPECT_EQ(MUST(queue_->list({.kind = "fit", .capture = kCapture})).total, 25);
  EXPECT_EQ(MUST(queue_->list({.capture = sha256_hex("none")})).total, 0);
}

TEST_F(QueueTest, DependenciesWaitAndFailWithTheReason) {
  const JobId base = submit("base");
  const JobId next = submit("next", {.priority = 50, .depends_on = {base}});
  const JobId last = submit("last", {.depends_on = {next, base}});
  JobRecord running = claim();
  EXPECT_EQ(running.id, base);
  EXPECT_TRUE(nothing_to_claim());
  finish(running);
  running = claim();
  EXPECT_EQ(running.id, next);
  MUST(queue_->fail(key(running), {ErrorKind::job_failed, "no"}));
  EXPECT_EQ(state(last), JobState::failed);
  EXPECT_EQ(MUST(queue_->show(last)).message, "job 2, which it waits for, failed");
  EXPECT_EQ(try_submit({.depends_on = {next}}, "more").error().kind, ErrorKind::refused);
  EXPECT_EQ(queue_->retry("ada", "q1", last).error().kind, ErrorKind::refused);
  MUST(queue_->retry("ada", "q2", next));
  MUST(queue_->retry("ada", "q3", last));
  finish(claim());
  EXPECT_EQ(claim().id, last);
  const JobId head = submit("head"), tail = submit("tail", {.depends_on = {head}});
  MUST(queue_->cancel("ada", head));
  EXPECT_EQ(MUST(queue_->show(tail)).message,
            "job " + std::to_string(head) + ", which it waits for, was cancelled");
}

TEST_F(QueueTest, RetryIsLimitedAndIdempotent) {
  QueueConfig limited = config();
  limited.max_retries = 2;
  open(limited);
  const JobId job = submit("a");
  EXPECT_EQ(queue_->retry("ada", "x", job).error().kind, ErrorKind::refused);  // it is queued
  MUST(queue_->fail(key(claim()), {ErrorKind::bad_input, "no"}));
  EXPECT_EQ(MUST(queue_->retry("ada", "x", job)).state, JobState::queued);
  EXPECT_EQ(MUST(queue_->retry("ada", "x", job)).retries, 1);  // the same request again
  MUST(queue_->fail(key(claim()), {ErrorKind::bad_input, "no"}));
  EXPECT_EQ(queue_->retry("bob", "y", job).error().kind, ErrorKind::refused);
  MUST(queue_->retry("ada", "y", job));
  MUST(queue_->fail(key(claim()), {ErrorKind::bad_input, "no"}));
  EXPECT_EQ(queue_->retry("ada", "z", job).error().kind, ErrorKind::refused);
  EXPECT_EQ(MUST(queue_->show(job)).attempt, 3);
}

TEST_F(QueueTest, QuotasHold) {
  MUST(queue_->set_quota("ada", {.max_queued = 2, .max_running = 1, .max_stored_bytes = 1000}));
  submit("a");
  submit("b");
  EXPECT_EQ(try_submit({}, "c").error().kind, ErrorKind::refused);
  submit("c", {.user = "bob"});
  EXPECT_EQ(claim().user, "ada");
  EXPECT_EQ(claim().user, "bob");
  EXPECT_TRUE(nothing_to_claim());  // ada has one running already
  const Usage usage = MUST(queue_->usage("ada"));
  EXPECT_EQ(usage.queued, 1);
  EXPECT_EQ(usage.running, 1);
  EXPECT_EQ(usage.stored_bytes, kCaptureBytes.size());
  EXPECT_EQ(usage.quota.max_stored_bytes, 1000u);
}

TEST_F(QueueTest, AStoredResultAnswersTheSameWorkOfTheSameEngineOnly) {
  submit("a");
  const JobRecord first = claim();
  finish(first);
  const auto again = MUST(try_submit({.user = "bob"}, "a"));
  EXPECT_EQ(again.job.state, JobState::succeeded);
  EXPECT_TRUE(again.job.from_store);
  EXPECT_EQ(again.job.result_sha256, result_of(first).result_sha256);
  EXPECT_EQ(MUST(queue_->usage("bob")).stored_bytes, 0u);
  QueueConfig newer = config();
  newer.engine = "engine-2";
  open(newer);
  EXPECT_EQ(MUST(try_submit({}, "a")).job.state, JobState::queued);
  QueueConfig damaged = config();
  damaged.result_is_sound = [](const std::string&) { return false; };
  open(damaged);
  EXPECT_EQ(MUST(try_submit({.user = "eve"}, "a")).job.state, JobState::queued);
}

TEST_F(QueueTest, TheServersEpochGrowsAndItsNameStays) {
  const auto epoch = queue_->server_epoch();
  const std::string id = queue_->server_id();
  open();
  EXPECT_EQ(queue_->server_epoch(), epoch + 1);
  EXPECT_EQ(queue_->server_id(), id);
  EXPECT_EQ(id.size(), 32u);
}

TEST_F(QueueTest, CapturesAreListedNewestFirst) {
  for (int i = 0; i < 5; ++i) {
    const auto added =
        MUST(queue_->add_capture({sha256_hex(std::to_string(i)), "t" + std::to_string(i),
                                  i % 2 ? "tracked_points" : "homogeneous_strain", "bob", 0, 7,
                                  i == 3 ? "not json" : R"({"frames":1})"}));
    EXPECT_TRUE(added.created);
  }
  EXPECT_FALSE(
      MUST(queue_->add_capture({sha256_hex("1"), "again", "", "eve", 0, 7, "{}"})).created);
  const auto page = MUST(queue_->captures({.user = "bob", .kind = {}, .offset = 1, .limit = 2}));
  EXPECT_EQ(page.total, 5);
  ASSERT_EQ(page.captures.size(), 2u);
  EXPECT_EQ(page.captures[0].title, "t3");
  EXPECT_EQ(page.captures[0].summary_json, "{}");
  EXPECT_EQ(MUST(queue_->captures({.user = {}, .kind = "tracked_points"})).total, 2);
  EXPECT_EQ(queue_->capture(sha256_hex("none")).error().kind, ErrorKind::not_found);
}

}  // namespace
}  // namespace tenter::jobs
