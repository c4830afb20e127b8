// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_service.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include "tests/server/jobs/job_service_fixture.h"

namespace tenter::jobs {
namespace {

using namespace std::chrono_literals;

TEST_F(ServiceTest, AJobRunsAndItsResultIsFoundByHash) {
  open();
  const JobId job = submit("a", R"({"sleep_ms": 250})");
  const JobRecord record = ended(job);
  ASSERT_EQ(record.state, JobState::succeeded) << record.message;
  EXPECT_EQ(record.attempt, 1);
  EXPECT_FALSE(record.from_store);
  EXPECT_GE(record.ended_ms, record.started_ms);
  const StoredFile result = MUST(service_->result(job));
  EXPECT_EQ(sha256_hex(bytes_of(result.path)), result.sha256);
  EXPECT_NE(bytes_of(result.path).find(record.spec_sha256), std::string::npos);
  EXPECT_EQ(bytes_of(MUST(service_->residuals(job)).path).size(), 1024u + 64u);
  EXPECT_NE(MUST(service_->log(job)).text.find("fake worker runs"), std::string::npos);
  ASSERT_TRUE(
      wait_until([&] { return !heard(job).empty() && heard(job).back().what == "succeeded"; }));
  std::vector<std::string> told;
  int progress = 0;
  for (const auto& event : heard(job)) {
    if (event.what == "progress") {
      ++progress;
    } else {
      told.push_back(event.what);
      EXPECT_EQ(event.number, static_cast<std::int64_t>(told.size()));
    }
  }
  EXPECT_EQ(told, (std::vector<std::string>{"submitted", "started", "succeeded"}));
  EXPECT_GE(progress, 2);
  EXPECT_LE(progress, 8);  // ten a second at most, besides the changes of stage
}

TEST_F(ServiceTest, TheSameWorkIsTakenFromTheStoreWithTheSameBytes) {
  open();
  const JobId first = submit("same");
  ASSERT_EQ(ended(first).state, JobState::succeeded);
  const auto again = MUST(
      service_->submit({.user = "bob", .request_id = "other", .spec_json = spec_text("same")}));
  EXPECT_FALSE(again.repeated);
  EXPECT_NE(again.job.id, first);
  EXPECT_EQ(again.job.state, JobState::succeeded);  // at once
  EXPECT_TRUE(again.job.from_store);
  EXPECT_EQ(again.job.result_sha256, MUST(service_->show(first)).result_sha256);
}

TEST_F(ServiceTest, TwinsSubmittedTogetherRunOnce) {
  open();
  const std::string spec = spec_text("twins", R"({"sleep_ms": 100})");
  const JobId one = submit({.user = "ada", .request_id = "1", .spec_json = spec});
  const JobId two = submit({.user = "bob", .request_id = "2", .spec_json = spec});
  EXPECT_EQ(ended(one).state, JobState::succeeded);
  EXPECT_EQ(ended(two).state, JobState::succeeded);
  EXPECT_TRUE(ended(two).from_store);
  EXPECT_EQ(ended(one).result_sha256, ended(two).result_sha256);
}

TEST_F(ServiceTest, EndingsAreToldApart) {
  open();
  const JobId failed = submit("f", R"({"fail": "the capture has no force"})");
  const JobId crashed = submit({.user = "ada",
                                .request_id = "c",
                                .spec_json = spec_text("c", R"({"crash": true})"),
                                .max_attempts = 1});
  const JobId late = submit({.user = "ada",
                             .request_id = "t",
                             .spec_json = spec_text("t", R"({"sleep_ms": 20000})"),
                             .time_limit_s = 0.3});
  const JobId deaf =
      submit({.user = "ada",
              .request_id = "d",
              .spec_json = spec_text("d", R"({"sleep_ms": 20000, "ignore_stop": true})"),
              .time_limit_s = 0.3});
  const JobId empty = submit("n", R"({"no_result": true})");
  EXPECT_EQ(ended(failed).error->message, "the capture has no force");
  EXPECT_EQ(ended(failed).error->kind, ErrorKind::bad_input);
  EXPECT_NE(ended(crashed).message.find("signal 6"), std::string::npos) << ended(crashed).message;
  EXPECT_NE(ended(late).message.find("out of time: its limit is 0.3 s"), std::string::npos)
      << ended(late).message;
  EXPECT_NE(ended(deaf).message.find("out of time"), std::string::npos) << ended(deaf).message;
  EXPECT_NE(ended(empty).message.find("left no result.json"), std::string::npos)
      << ended(empty).message;
  for (const JobId job : {failed, crashed, late, deaf, empty})
    EXPECT_EQ(ended(job).state, JobState::failed);
}

#if !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)  // they cannot live within a memory limit
TEST_F(ServiceTest, MemoryBeyondTheLimitIsToldAsSuch) {
  open();
  const JobId greedy = submit({.user = "ada",
                               .request_id = "m",
                               .spec_json = spec_text("m", R"({"allocate_mb": 400})"),
                               .memory_limit_bytes = 100u << 20});
  const JobId modest = submit({.user = "ada",
                               .request_id = "m2",
                               .spec_json = spec_text("m2", R"({"allocate_mb": 50})"),
                               .memory_limit_bytes = 100u << 20});
  EXPECT_EQ(ended(greedy).state, JobState::failed);
  EXPECT_NE(ended(greedy).message.find("out of memory: its limit is 100 MiB"), std::string::npos)
      << ended(greedy).message;
  EXPECT_EQ(ended(modest).state, JobState::succeeded) << ended(modest).message;
}
#endif

TEST_F(ServiceTest, AKilledWorkersJobRunsAgain) {
  open();
  const JobId job = submit("k", R"({"sleep_ms": 3000})");
  const int pid = worker_pid(job);
  ASSERT_GT(pid, 0);
  ASSERT_EQ(::kill(pid, SIGKILL), 0);
  const JobRecord record = ended(job);
  EXPECT_EQ(record.state, JobState::succeeded) << record.message;
  EXPECT_EQ(record.attempt, 2);
  EXPECT_EQ(record.worker_deaths, 1);
  const auto events = MUST(service_->events(job));
  EXPECT_NE(events[2].message.find("was killed by signal 9"), std::string::npos)
      << events[2].message;
}

TEST_F(ServiceTest, CheckpointsOutliveAttemptsAndTheDaemonAndGoWithSuccess) {
  open();
  const std::filesystem::path home = folder_.path() / "store" / "checkpoints";
  const auto kept = [&](JobId job) { return home / MUST(service_->show(job)).spec_sha256; };
  const JobId counted = submit("counted", R"({"count_to": 3})");
  ASSERT_EQ(ended(counted).state, JobState::succeeded);
  EXPECT_EQ(ended(counted).attempt, 3);
  EXPECT_TRUE(wait_until([&] { return !std::filesystem::exists(kept(counted)); }));

  const JobId slow = submit("slow", R"({"count_to": 1, "sleep_ms": 60000})");
  EXPECT_TRUE(wait_until([&] { return std::filesystem::exists(kept(slow) / "count"); }));
  open();  // the next daemon starts it again, and the worker finds its count
  EXPECT_TRUE(wait_until([&] { return bytes_of(kept(slow) / "count") == "2"; }));
  MUST(service_->cancel("ada", slow));
  EXPECT_TRUE(becomes(slow, JobState::cancelled));
  // kept for who asks again, until another worker program comes
  EXPECT_TRUE(std::filesystem::exists(kept(slow)));
  ServiceConfig other = fake_config(folder_.path() / "store");
  other.worker = folder_.path() / "other-worker";
  std::filesystem::copy_file(TENTER_FAKE_WORKER, other.worker);
  std::ofstream(other.worker, std::ios::app) << "another build";
  open(other);
  EXPECT_FALSE(std::filesystem::exists(kept(slow)));
}

TEST_F(ServiceTest, AJobThatKillsItsWorkerThreeTimesIsPutIntoQuarantine) {
  open();
  const JobId poison = submit("p", R"({"crash": true})");
  const JobId unlucky = submit("u", R"({"abort_below_deaths": 2, "deaths_file": ")" +
                                        (folder_.path() / "deaths").string() + "\"}");
  EXPECT_EQ(ended(poison).state, JobState::failed);
  EXPECT_EQ(ended(poison).attempt, 3);
  EXPECT_NE(ended(poison).message.find("in quarantine: its worker died 3 times"),
            std::string::npos);
  EXPECT_EQ(ended(unlucky).state, JobState::succeeded);
  EXPECT_EQ(ended(unlucky).attempt, 3);
}

TEST_F(ServiceTest, AWorkerPausedPastItsLeaseIsRefusedAndReplaced) {
  ServiceConfig config = fake_config(folder_.path() / "store");
  config.lease = 500ms;
  config.heartbeat = 100ms;
  open(config);
  const JobId job = submit("pause", R"({"sleep_ms": 900})");
  const int pid = worker_pid(job);
  ASSERT_EQ(::kill(pid, SIGSTOP), 0);
  const JobRecord record = ended(job);
  EXPECT_EQ(record.state, JobState::succeeded)
      << record.message;  // 900 ms of work outlive a lease of 500 ms
  EXPECT_EQ(record.attempt, 2);
  EXPECT_NE(MUST(service_->events(job))[2].message.find("silent for 500 ms"), std::string::npos);
  EXPECT_TRUE(wait_until([&] { return ::kill(pid, 0) != 0; }));  // the paused one is gone
}

TEST_F(ServiceTest, CancelInEveryStateTwice) {
  ServiceConfig config = fake_config(folder_.path() / "store");
  config.parallel = 1;
  open(config);
  const JobId running = submit("run", R"({"sleep_ms": 60000, "ignore_stop": true})");
  const JobId queued = submit("wait", R"({"sleep_ms": 60001})");
  const int pid = worker_pid(running);
  for (int twice = 0; twice < 2; ++twice) {
    EXPECT_EQ(MUST(service_->cancel("ada", queued)).state, JobState::cancelled);
    EXPECT_EQ(MUST(service_->cancel("ada", running)).state, JobState::cancelled);
  }
  EXPECT_EQ(MUST(service_->show(running)).revision, 3);  // the second cancel changed nothing
  EXPECT_TRUE(wait_until([&] { return ::kill(pid, 0) != 0; }));
  const JobId done = submit("done");
  EXPECT_EQ(ended(done).state, JobState::succeeded);  // the slot is free again
  EXPECT_EQ(service_->cancel("ada", done).error().kind, ErrorKind::refused);
  const JobId failed = submit("failed", R"({"fail": "no"})");
  EXPECT_EQ(ended(failed).state, JobState::failed);
  EXPECT_EQ(service_->cancel("ada", failed).error().kind, ErrorKind::refused);
  EXPECT_EQ(service_->cancel("bob", done).error().kind, ErrorKind::refused);
  EXPECT_EQ(service_->cancel("ada", 999).error().kind, ErrorKind::not_found);
  EXPECT_EQ(MUST(service_->retry("ada", "again", queued)).state, JobState::queued);
}

TEST_F(ServiceTest, AStoppedDaemonGivesItsJobsBack) {
  open();
  const JobId job = submit("stop", R"({"sleep_ms": 300})");
  ASSERT_TRUE(becomes(job, JobState::running));
  open();  // stops the first
  const JobRecord record = ended(job);
  EXPECT_EQ(record.state, JobState::succeeded);
  EXPECT_EQ(record.attempt, 2);
  EXPECT_EQ(record.worker_deaths, 0);
}

TEST_F(ServiceTest, TwoDaemonsDoNotShareAStore) {
  open();
  const auto second = JobService::open(fake_config(folder_.path() / "store"));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, ErrorKind::refused);
}

TEST_F(ServiceTest, AFloodingWorkerDoesNotHurt) {
  open();
  const JobId job = submit("flood", R"({"flood": true})");
  EXPECT_EQ(ended(job).state, JobState::succeeded);
}

TEST_F(ServiceTest, DamagedObjectsAreReportedAndReplaced) {
  open();
  const JobId job = submit("dmg");
  ASSERT_EQ(ended(job).state, JobState::succeeded);
  const auto result = MUST(service_->result(job));
  const std::string before = bytes_of(result.path);
  service_.reset();
  std::filesystem::permissions(result.path, std::filesystem::perms::owner_write,
                               std::filesystem::perm_options::add);
  std::ofstream(result.path, std::ios::trunc) << "short";
  open();
  ASSERT_EQ(service_->findings().size(), 1u);
  EXPECT_NE(service_->findings()[0].find("result of job 1"), std::string::npos)
      << service_->findings()[0];
  EXPECT_EQ(service_->result(job).error().kind, ErrorKind::internal);
  // the same work again finds no sound result, runs, and puts the same bytes in place
  const JobId again = submit({.user = "ada", .request_id = "dmg2", .spec_json = spec_text("dmg")});
  EXPECT_EQ(ended(again).state, JobState::succeeded);
  EXPECT_FALSE(ended(again).from_store);
  EXPECT_EQ(bytes_of(MUST(service_->result(job)).path), before);
}

TEST_F(ServiceTest, ACaptureOfBadContentIsRefusedAndForgotten) {
  ServiceConfig config = fake_config(folder_.path() / "store");
  config.inspect_capture = [](const std::filesystem::path& file) -> Expected<CaptureSummary> {
    if (bytes_of(file) != kCaptureBytes) return bad_input("not a capture");
    return CaptureSummary{"title", "homogeneous_strain", R"({"frames": 3})"};
  };
  open(config);
  EXPECT_EQ(MUST(service_->capture(kCapture)).title, "title");
  const std::string bad = "something else";
  const auto state = MUST(service_->upload_open({"ada", sha256_hex(bad), bad.size()}));
  MUST(service_->upload_chunk(state.transfer, 0, bad));
  const auto committed = service_->upload_commit(state.transfer);
  ASSERT_FALSE(committed);
  EXPECT_EQ(committed.error().message, "not a capture");
  EXPECT_EQ(service_->capture(sha256_hex(bad)).error().kind, ErrorKind::not_found);
  EXPECT_EQ(service_->upload_chunk(state.transfer, 0, bad).error().kind, ErrorKind::not_found);
  EXPECT_EQ(service_
                ->submit({.user = "ada",
                          .request_id = "x",
                          .spec_json = spec_text("x", "{}", sha256_hex(bad))})
                .error()
                .kind,
            ErrorKind::not_found);
}

TEST_F(ServiceTest, ACommitAskedForTwiceGivesTheSameAnswer) {
  open();
  const std::string bytes = "more bytes";
  const auto state = MUST(service_->upload_open({"ada", sha256_hex(bytes), bytes.size()}));
  MUST(service_->upload_chunk(state.transfer, 0, bytes));
  EXPECT_TRUE(MUST(service_->upload_commit(state.transfer)).created);
  const auto again = MUST(service_->upload_commit(state.transfer));
  EXPECT_FALSE(again.created);
  EXPECT_EQ(again.capture.sha256, sha256_hex(bytes));
  EXPECT_TRUE(MUST(service_->upload_open({"bob", sha256_hex(bytes), bytes.size()})).already_stored);
}

}  // namespace
}  // namespace tenter::jobs
