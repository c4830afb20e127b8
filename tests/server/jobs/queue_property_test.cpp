// SPDX-License-Identifier: GPL-3.0-or-later
// Random sequences of everything that can happen to a queue, by users, workers, clocks and
// restarts, checked against a model of what was acknowledged.
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "server/jobs/queue/queue.h"
#include "server/jobs/store/store.h"
#include "tests/server/jobs/queue_fixture.h"

namespace tenter::jobs {
namespace {

class QueueProperty : public QueueTest, public ::testing::WithParamInterface<unsigned> {
 protected:
  int pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  JobId any_job() { return 1 + pick(static_cast<int>(jobs_)); }
  std::string any_user() { return std::string(1, static_cast<char>('a' + pick(3))); }

  void step() {
    const int dice = pick(100);
    if (dice < 30 || jobs_ == 0) return submit_something();
    if (dice < 50) return claim_something();
    if (dice < 75) return end_something();
    if (dice < 82) return cancel_something();
    if (dice < 90) return retry_something();
    if (dice < 97) return clock_.pass(pick(20000));
    if (dice < 99) return expire();
    restart();
  }

  void submit_something() {
    SubmitRequest request{
        .user = any_user(), .request_id = "q" + std::to_string(pick(400)), .priority = pick(5)};
    if (jobs_ > 0 && pick(3) == 0) request.depends_on = {any_job()};
    const std::string nonce = std::to_string(pick(60));
    const auto key = std::make_pair(request.user, request.request_id);
    const auto submitted = try_submit(request, nonce);
    const auto known = requests_.find(key);
    if (!submitted) return;  // a dependency that failed, or the id of another specification
    if (known != requests_.end()) {
      EXPECT_TRUE(submitted->repeated);
      EXPECT_EQ(submitted->job.id, known->second);
    } else {
      EXPECT_FALSE(submitted->repeated);
      requests_[key] = submitted->job.id;
      EXPECT_EQ(submitted->job.id, ++jobs_);  // none lost, none twice
    }
  }
  void claim_something() {
    if (auto claimed = MUST(queue_->claim())) {
      EXPECT_GT(claimed->epoch, epochs_[claimed->id]);
      epochs_[claimed->id] = claimed->epoch;
      claims_.push_back({claimed->id, claimed->epoch});  // kept after its end: late workers
    }
  }
  void end_something() {
    if (claims_.empty()) return;
    const ClaimKey claim =
        claims_[static_cast<std::size_t>(pick(static_cast<int>(claims_.size())))];
    const JobRecord before = MUST(queue_->show(claim.job));
    const bool wanted = before.state == JobState::running && before.epoch == claim.epoch;
    Expected<void> done;
    switch (pick(6)) {
      case 0:
        done = queue_->heartbeat(claim);
        break;
      case 1:
        done = queue_->fail(claim, {ErrorKind::job_failed, "no"});
        break;
      case 2:
        done = queue_->worker_died(claim, "crash");
        break;
      case 3:
        done = queue_->release(claim, "stop");
        break;
      default: {
        const std::string bytes = "result of " + before.spec_sha256;
        const std::string sha256 = MUST(store_->put(bytes));
        done = queue_->complete(claim, {sha256, bytes.size(), "", 0});
      }
    }
    EXPECT_EQ(done.has_value(), wanted);
    if (!done) {
      EXPECT_EQ(done.error().kind, ErrorKind::refused);
      EXPECT_EQ(MUST(queue_->show(claim.job)).revision, before.revision);
    }
  }
  void cancel_something() {
    const JobRecord before = MUST(queue_->show(any_job()));
    const auto done = queue_->cancel(before.user, before.id);
    EXPECT_EQ(done.has_value(), !is_final(before.state) || before.state == JobState::cancelled);
  }
  void retry_something() {
    const JobRecord before = MUST(queue_->show(any_job()));
    const auto done = queue_->retry(before.user, "retry" + std::to_string(++retries_), before.id);
    if (done) {
      EXPECT_TRUE(before.state == JobState::failed || before.state == JobState::cancelled);
      EXPECT_EQ(done->state, JobState::queued);
    }
  }
  void expire() {
    for (const ClaimKey claim : MUST(queue_->expire())) {
      EXPECT_GT(MUST(queue_->show(claim.job)).epoch, claim.epoch);
    }
  }
  void restart() {
    open();
    EXPECT_EQ(MUST(queue_->numbers()).running, 0);
    EXPECT_TRUE(queue_->findings().empty());
  }

  void check() {
    const QueueNumbers numbers = MUST(queue_->numbers());
    EXPECT_EQ(
        numbers.queued + numbers.running + numbers.succeeded + numbers.failed + numbers.cancelled,
        jobs_);
    std::map<std::string, std::string> results;
    std::map<std::string, int> running;
    for (JobId id = 1; id <= jobs_; ++id) {
      const JobRecord job = MUST(queue_->show(id));
      const auto events = MUST(queue_->events(id, 0, 1000));
      ASSERT_EQ(static_cast<std::int64_t>(events.size()), job.revision);
      for (std::size_t i = 0; i < events.size(); ++i)
        EXPECT_EQ(events[i].number, std::int64_t(i) + 1);
      EXPECT_EQ(events.back().state, job.state);
      EXPECT_GE(job.epoch, epochs_[id]);
      EXPECT_EQ(job.state == JobState::failed || job.state == JobState::cancelled,
                job.error.has_value());
      if (job.state == JobState::succeeded) {
        EXPECT_TRUE(store_->path(job.result_sha256)) << id;
        const auto same = results.emplace(job.spec_sha256, job.result_sha256).first;
        EXPECT_EQ(same->second, job.result_sha256);
      }
      const bool runs = job.state == JobState::running;
      EXPECT_LE(running[job.spec_sha256] += runs, 1);  // no twins at once
      for (const JobId need : job.depends_on) {
        const JobState needed = MUST(queue_->show(need)).state;
        if (job.state == JobState::running || job.state == JobState::succeeded) {
          EXPECT_EQ(needed, JobState::succeeded);
        }
      }
    }
  }

  std::mt19937 random_{GetParam()};
  TemporaryFolder objects_{memory_folder()};
  std::unique_ptr<Store> store_ = MUST(Store::open(objects_.path()));
  std::int64_t jobs_ = 0;
  int retries_ = 0;
  std::map<std::pair<std::string, std::string>, JobId> requests_;
  std::map<JobId, std::int64_t> epochs_;
  std::vector<ClaimKey> claims_;
};

TEST_P(QueueProperty, WhateverHappensNothingIsLostOrDoneTwice) {
  for (int i = 1; i <= 1000 && !HasFailure(); ++i) {
    step();
    if (i % 100 == 0) check();
  }
  EXPECT_GT(jobs_, 50);
  EXPECT_GT(MUST(queue_->numbers()).succeeded, 8);
}

INSTANTIATE_TEST_SUITE_P(Seeds, QueueProperty, ::testing::Values(1u, 2u, 3u, 4u, 5u, 6u));

}  // namespace
}  // namespace tenter::jobs
