// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "server/jobs/queue/queue.h"
#include "tests/server/jobs/queue_fixture.h"

namespace tenter::jobs {
namespace {

TEST_F(QueueTest, PriorityThenAgeWithinAUser) {
  const JobId low = submit("low", {.priority = -5});
  const JobId first = submit("first");
  const JobId second = submit("second");
  const JobId high = submit("high", {.priority = 9});
  for (const JobId expected : {high, first, second, low}) EXPECT_EQ(claim().id, expected);
}

TEST_F(QueueTest, UsersTakeTurnsWhateverTheyAskFor) {
  for (int i = 0; i < 6; ++i) submit("a" + std::to_string(i), {.priority = 100});
  submit("b0", {.user = "bob"});
  submit("b1", {.user = "bob"});
  std::string order;
  for (int i = 0; i < 4; ++i) order += claim().user[0];
  EXPECT_EQ(order, "abab");  // fewest running first
}

TEST_F(QueueTest, RecentUseDecidesBetweenEquals) {
  submit("a0");
  submit("a1");
  submit("b0", {.user = "bob"});
  const JobRecord used = claim();
  EXPECT_EQ(used.user, "ada");
  clock_.pass(60000);
  finish(used);
  EXPECT_NEAR(MUST(queue_->usage("ada")).recent_use_s, 60, 0.1);
  EXPECT_EQ(claim().user, "bob");  // although ada's job is older
  clock_.pass(3600 * 1000);
  EXPECT_NEAR(MUST(queue_->usage("ada")).recent_use_s, 30, 0.1);
}

TEST_F(QueueTest, ALateWorkerIsRefused) {
  submit("a");
  const JobRecord late = claim();
  clock_.pass(29999);
  EXPECT_TRUE(MUST(queue_->expire()).empty());
  clock_.pass(1);
  const auto expired = MUST(queue_->expire());
  ASSERT_EQ(expired.size(), 1u);
  EXPECT_EQ(expired[0], key(late));
  const JobRecord rescuer = claim();  // the rescuer against the late one's completion
  EXPECT_GT(rescuer.epoch, late.epoch);
  EXPECT_EQ(queue_->heartbeat(key(late)).error().kind, ErrorKind::refused);
  EXPECT_EQ(queue_->complete(key(late), result_of(late)).error().kind, ErrorKind::refused);
  EXPECT_EQ(queue_->fail(key(late), {}).error().kind, ErrorKind::refused);
  EXPECT_EQ(queue_->worker_died(key(late), "").error().kind, ErrorKind::refused);
  EXPECT_EQ(queue_->release(key(late), "").error().kind, ErrorKind::refused);
  EXPECT_EQ(state(late.id), JobState::running);
  finish(rescuer);
  EXPECT_EQ(queue_->complete(key(rescuer), result_of(late)).error().kind,
            ErrorKind::refused);  // once
}

TEST_F(QueueTest, AHeartbeatExtendsTheLease) {
  submit("a");
  const JobRecord job = claim();
  for (int i = 0; i < 10; ++i) {
    clock_.pass(10000);
    MUST(queue_->heartbeat(key(job)));
    EXPECT_TRUE(MUST(queue_->expire()).empty());
  }
  EXPECT_EQ(MUST(queue_->next_expiry_ms()), *clock_.monotonic + 30000);
}

TEST_F(QueueTest, JumpsOfTheWallClockExpireNothing) {
  submit("a");
  const JobRecord job = claim();
  *clock_.wall += 400ll * 24 * 3600 * 1000;
  EXPECT_TRUE(MUST(queue_->expire()).empty());
  *clock_.wall -= 800ll * 24 * 3600 * 1000;
  EXPECT_TRUE(MUST(queue_->expire()).empty());
  MUST(queue_->heartbeat(key(job)));
  finish(job);
  EXPECT_GE(MUST(queue_->usage("ada")).recent_use_s, 0);
  submit("b");
  EXPECT_EQ(claim().user, "ada");
}

TEST_F(QueueTest, SilenceCountsAsDeathAndThreeArePoison) {
  const JobId job = submit("a");
  for (int death = 1; death <= 3; ++death) {
    claim();
    clock_.pass(30000);
    EXPECT_EQ(MUST(queue_->expire()).size(), 1u);
    EXPECT_EQ(state(job), death < 3 ? JobState::queued : JobState::failed);
  }
  EXPECT_NE(MUST(queue_->show(job)).message.find("in quarantine"), std::string::npos);
  MUST(queue_->retry("ada", "again", job));  // a person may insist
  finish(claim());
  EXPECT_EQ(state(job), JobState::succeeded);
}

TEST_F(QueueTest, ARestartRunsRunningJobsAgainWithoutBlame) {
  const JobId job = submit("a");
  JobRecord before = claim();
  for (int restart = 0; restart < 5; ++restart) {
    *clock_.monotonic = 5;  // a new boot
    open();
    EXPECT_EQ(state(job), JobState::queued);
    const JobRecord after = claim();
    EXPECT_GT(after.epoch, before.epoch);
    EXPECT_EQ(after.worker_deaths, 0);
    EXPECT_EQ(queue_->complete(key(before), result_of(before)).error().kind, ErrorKind::refused);
    before = after;
  }
  EXPECT_EQ(before.attempt, 6);
  finish(before);
}

TEST_F(QueueTest, CancelBeatsALateCompletion) {
  const JobId job = submit("a");
  const JobRecord running = claim();
  EXPECT_EQ(MUST(queue_->cancel("ada", job)).state, JobState::cancelled);
  EXPECT_EQ(queue_->complete(key(running), result_of(running)).error().kind, ErrorKind::refused);
  EXPECT_EQ(state(job), JobState::cancelled);
  EXPECT_EQ(MUST(queue_->cancel("ada", job)).revision, MUST(queue_->show(job)).revision);
}

TEST_F(QueueTest, ATwinWaitsForTheRunningOneAndTakesItsResult) {
  const JobId one = submit("same"), two = submit("same", {.user = "bob"});
  const JobRecord running = claim();
  EXPECT_EQ(running.id, one);
  EXPECT_TRUE(nothing_to_claim());
  finish(running);
  EXPECT_TRUE(nothing_to_claim());  // settles the twin on the way
  EXPECT_EQ(state(two), JobState::succeeded);
  EXPECT_TRUE(MUST(queue_->show(two)).from_store);
}

}  // namespace
}  // namespace tenter::jobs
