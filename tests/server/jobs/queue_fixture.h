// SPDX-License-Identifier: GPL-3.0-or-later
// A Queue on a file of its own, with a clock that the test moves.
#pragma once

#include "server/jobs/spec.h"
#include "tests/server/jobs/jobs_fixture.h"

namespace tenter::jobs {

class QueueTest : public ::testing::Test {
 protected:
  void SetUp() override { open(); }

  QueueConfig config() const {
    QueueConfig config;
    config.file = folder_.path() / "queue.sqlite";
    config.engine = "engine-1";
    config.clock = clock_.clock();
    return config;
  }
  void open() { open(config()); }
  void open(QueueConfig config) {
    queue_.reset();
    queue_ = MUST(Queue::open(std::move(config)));
    MUST(queue_->add_capture(
        {kCapture, "pull", "homogeneous_strain", "ada", 0, kCaptureBytes.size(), "{}"}));
  }
  Expected<Submitted> try_submit(SubmitRequest request, const std::string& nonce) {
    if (request.user.empty()) request.user = "ada";
    if (request.request_id.empty()) request.request_id = "r-" + std::to_string(++requests_);
    return queue_->submit(request, MUST(parse_spec(spec_text(nonce))));
  }
  JobId submit(const std::string& nonce, SubmitRequest request = {}) {
    return MUST(try_submit(std::move(request), nonce)).job.id;
  }
  JobRecord claim() {
    auto claimed = MUST(queue_->claim());
    if (!claimed) ADD_FAILURE() << "nothing to claim";
    return claimed.value_or(JobRecord{});
  }
  bool nothing_to_claim() { return !MUST(queue_->claim()).has_value(); }
  static ClaimKey key(const JobRecord& job) { return {job.id, job.epoch}; }
  static StoredResult result_of(const JobRecord& job) {
    return {sha256_hex("result of " + job.spec_sha256), 10,
            sha256_hex("residuals of " + job.spec_sha256), 20};
  }
  void finish(const JobRecord& job) { MUST(queue_->complete(key(job), result_of(job))); }
  JobState state(JobId job) { return MUST(queue_->show(job)).state; }

  TemporaryFolder folder_{memory_folder()};
  TestClock clock_;
  std::unique_ptr<Queue> queue_;
  int requests_ = 0;
};

}  // namespace tenter::jobs
