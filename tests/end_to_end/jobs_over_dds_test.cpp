// SPDX-License-Identifier: GPL-3.0-or-later
// Jobs from submission to result, through a real daemon: submit, watch, cancel, retry, fetch,
// restart.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "common/base/sha256.h"
#include "tests/end_to_end/support/captures.h"
#include "tests/end_to_end/support/daemon.h"

namespace tenter::test {
namespace {

using client::Client;
using client::JobState;
using client::JobUpdate;
using client::Link;
using nlohmann::json;

class JobsOverDds : public ::testing::Test {
 protected:
  void SetUp() override {
    auto connected = daemon_.connect();
    ASSERT_TRUE(connected) << connected.error().message;
    client_.emplace(std::move(*connected));
    const auto file = daemon_.folder() / "small.h5";
    write_noise_capture(file, 100, 1);
    auto upload = client_->upload_capture(file);
    ASSERT_TRUE(upload) << upload.error().message;
    capture_ = upload->sha256;
  }

  std::string submit(const std::string& fake_options, const std::string& request_id = "") {
    client::SubmitRequest request;
    request.spec_json = fake_job(capture_, fake_options);
    request.request_id = request_id;
    auto done = client_->submit(request);
    EXPECT_TRUE(done) << done.error().message;
    return done ? done->job_id : "0";
  }

  Daemon daemon_;
  std::optional<Client> client_;
  std::string capture_;
};

std::string content(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

TEST_F(JobsOverDds, SubmitWatchAndFetch) {
  const std::string job = submit(R"({"sleep_ms": 400, "residual_kb": 3000})");
  std::vector<JobUpdate> updates;
  auto last = client_->watch(job, [&](const JobUpdate& update) { updates.push_back(update); });
  ASSERT_TRUE(last) << last.error().message;
  EXPECT_EQ(last->state, JobState::succeeded) << last->message;
  ASSERT_GE(updates.size(), 4u);
  EXPECT_TRUE(std::is_sorted(updates.begin(), updates.end(),
                             [](const auto& a, const auto& b) { return a.revision < b.revision; }));
  const bool progress = std::any_of(updates.begin(), updates.end(), [](const JobUpdate& update) {
    return update.stage == "sleep" && update.iteration > 0 && update.fraction > 0;
  });
  EXPECT_TRUE(progress);

  const auto shown = json::parse(client_->show_job(job).value());
  EXPECT_EQ(shown["state"], "succeeded");
  EXPECT_EQ(shown["history"].size(), 3u);  // submitted, started, succeeded
  const auto result = daemon_.folder() / "out.json";
  ASSERT_TRUE(client_->fetch_result(job, result));
  EXPECT_EQ(sha256_hex(content(result)), shown["result_sha256"]);
  EXPECT_EQ(json::parse(content(result))["captures"][0], capture_);
  const auto residuals = daemon_.folder() / "out.h5";
  auto bytes = client_->fetch_residuals(job, residuals);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_GT(*bytes, 3000u * 1024u);
  EXPECT_EQ(sha256_hex(content(residuals)), shown["residuals_sha256"]);

  // watching what has ended returns at once with one update
  updates.clear();
  last = client_->watch(job, [&](const JobUpdate& update) { updates.push_back(update); });
  EXPECT_EQ(last->state, JobState::succeeded);
  EXPECT_EQ(updates.size(), 1u);
}

TEST_F(JobsOverDds, TheSameRequestGivesTheSameJob) {
  const std::string first = submit("{}", "once");
  EXPECT_EQ(submit("{}", "once"), first);
  EXPECT_EQ(json::parse(client_->list_jobs().value())["total"], 1);
}

TEST_F(JobsOverDds, FailureComesWithItsSentence) {
  auto last = client_->watch(submit(R"({"fail": "no convergence in stage 2"})"), {});
  ASSERT_TRUE(last);
  EXPECT_EQ(last->state, JobState::failed);
  EXPECT_NE(last->message.find("no convergence in stage 2"), std::string::npos) << last->message;
}

TEST_F(JobsOverDds, CancelTwiceAndRetry) {
  const std::string job = submit(R"({"sleep_ms": 60000})");
  bool cancelled = false;
  auto last = client_->watch(job, [&](const JobUpdate& update) {
    if (update.stage != "sleep" || cancelled) return;
    cancelled = true;
    EXPECT_TRUE(client_->cancel(job));
  });
  ASSERT_TRUE(last);
  EXPECT_EQ(last->state, JobState::cancelled);
  EXPECT_TRUE(client_->cancel(job));
  auto again = client_->retry(job);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(json::parse(*again)["state"], "queued");
  EXPECT_TRUE(client_->cancel(job));
}

TEST_F(JobsOverDds, WatchSurvivesKillMinusNineOfTheDaemon) {
  const std::string job = submit(R"({"sleep_ms": 1500})");
  std::thread breaker([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    daemon_.kill();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    daemon_.start();
  });
  int attempts = 0;
  auto last = client_->watch(job, [&](const JobUpdate& update) { attempts = update.attempt; });
  breaker.join();
  ASSERT_TRUE(last) << last.error().message;
  EXPECT_EQ(last->state, JobState::succeeded) << last->message;
  EXPECT_EQ(attempts, 2);
}

TEST_F(JobsOverDds, WatchTellsWhenTheServerIsLost) {
  const std::string job = submit(R"({"sleep_ms": 60000})");
  std::stop_source stop;
  std::vector<Link> links;
  auto start = std::chrono::steady_clock::now();
  double lost_after_s = 0;
  bool killed = false;
  auto last = client_->watch(
      job,
      [&](const JobUpdate& update) {
        if (links.empty() || links.back() != update.link) links.push_back(update.link);
        if (update.state == JobState::running && !killed) {
          killed = true;
          daemon_.kill();
          start = std::chrono::steady_clock::now();
        }
        if (update.link == Link::lost) {
          lost_after_s =
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
          stop.request_stop();
        }
      },
      stop.get_token());
  ASSERT_TRUE(last) << last.error().message;
  EXPECT_EQ(links, (std::vector<Link>{Link::connected, Link::lost}));
  std::printf("a killed server was reported as lost after %.1f s\n", lost_after_s);
  EXPECT_LT(lost_after_s, 12.0);
  EXPECT_EQ(last->state, JobState::running);
}

TEST_F(JobsOverDds, AThousandJobsComeInOneList) {
  for (int i = 0; i < 1000; ++i) submit(R"({"sleep_ms": 60000, "n": )" + std::to_string(i) + "}");
  client::JobFilter filter;
  filter.limit = 1000;
  const auto start = std::chrono::steady_clock::now();
  auto list = client_->list_jobs(filter);
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  ASSERT_TRUE(list) << list.error().message;
  EXPECT_EQ(json::parse(*list)["jobs"].size(), 1000u);
  RecordProperty("list_1000_ms", std::to_string(ms));
  std::printf("1000 jobs listed in %.1f ms\n", ms);
}

TEST_F(JobsOverDds, UnknownThingsAreNotFound) {
  EXPECT_EQ(client_->show_job("999").error().kind, ErrorKind::not_found);
  EXPECT_EQ(client_->watch("999", {}).error().kind, ErrorKind::not_found);
  EXPECT_EQ(client_->watch("x", {}).error().kind, ErrorKind::bad_input);
  EXPECT_EQ(client_->show_capture(std::string(64, 'a')).error().kind, ErrorKind::not_found);
  const auto nowhere = daemon_.folder() / "nothing";
  EXPECT_EQ(client_->fetch_result("999", nowhere).error().kind, ErrorKind::not_found);
  EXPECT_FALSE(std::filesystem::exists(nowhere));
  client::SubmitRequest request;
  request.spec_json = fake_job(std::string(64, 'a'));
  EXPECT_FALSE(client_->submit(request));
}

}  // namespace
}  // namespace tenter::test
