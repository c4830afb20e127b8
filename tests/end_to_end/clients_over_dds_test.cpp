// SPDX-License-Identifier: GPL-3.0-or-later
// Several clients at a time: two users, one that is stopped, one that is killed, many that come and
// go.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/end_to_end/support/captures.h"
#include "tests/end_to_end/support/daemon.h"
#include "tests/end_to_end/support/process.h"

namespace tenter::test {
namespace {

using client::Client;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Longest of `count` requests, in ms.
double slowest_request(Client& client, int count) {
  double slowest = 0;
  for (int i = 0; i < count; ++i) {
    const auto start = Clock::now();
    EXPECT_TRUE(client.list_jobs());
    slowest = std::max(slowest, ms_since(start));
  }
  return slowest;
}

std::string upload_small(const Daemon& daemon, Client& client, std::uint32_t seed) {
  const auto file = daemon.folder() / ("small" + std::to_string(seed) + ".h5");
  write_noise_capture(file, 100, 1, seed);
  auto done = client.upload_capture(file);
  EXPECT_TRUE(done) << done.error().message;
  return done ? done->sha256 : "";
}

TEST(ClientsOverDds, TwoUsersAtOnce) {
  Daemon daemon;
  std::atomic<int> succeeded{0};
  const auto use = [&](const std::string& user, std::uint32_t seed) {
    auto client = daemon.connect(user);
    ASSERT_TRUE(client) << client.error().message;
    const std::string capture = upload_small(daemon, *client, seed);
    for (int i = 0; i < 5; ++i) {
      client::SubmitRequest request;
      request.spec_json = fake_job(capture, "{\"sleep_ms\": 20, \"n\": " + std::to_string(i) + "}");
      auto job = client->submit(request);
      ASSERT_TRUE(job) << job.error().message;
      auto last = client->watch(job->job_id, {});
      ASSERT_TRUE(last) << last.error().message;
      succeeded += last->state == client::JobState::succeeded;
    }
    client::JobFilter own;
    own.user = user;
    const auto list = json::parse(client->list_jobs(own).value());
    EXPECT_EQ(list["total"], 5);
    for (const json& job : list["jobs"]) EXPECT_EQ(job["user"], user);
  };
  std::thread ada(use, "ada", 1), ben(use, "ben", 2);
  ada.join();
  ben.join();
  EXPECT_EQ(succeeded, 10);
}

TEST(ClientsOverDds, OneMayNotCancelTheOthersJob) {
  Daemon daemon;
  auto ada = daemon.connect("ada").value();
  auto ben = daemon.connect("ben").value();
  client::SubmitRequest request;
  request.spec_json = fake_job(upload_small(daemon, ada, 1), "{\"sleep_ms\": 60000}");
  const auto job = ada.submit(request).value().job_id;
  auto refused = ben.cancel(job);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::refused);
  EXPECT_TRUE(ada.cancel(job));
}

// Stopped in the middle of asking and of watching, of the same user and topics as the others.
TEST(ClientsOverDds, AStoppedClientDelaysNobody) {
  Daemon daemon;
  auto client = daemon.connect("ada").value();
  const std::string capture = upload_small(daemon, client, 1);
  client::SubmitRequest request;
  request.spec_json = fake_job(capture, "{\"sleep_ms\": 60000, \"n\": 0}");
  const auto running = client.submit(request).value().job_id;
  Process asking(test_client(daemon.domain(), "ada", "ask"));
  Process watching(test_client(daemon.domain(), "ada", "watch", running));
  ASSERT_EQ(asking.line(), "ready");
  ASSERT_EQ(watching.line(), "ready");
  ASSERT_TRUE(watching.line());
  asking.send_signal(SIGSTOP);
  watching.send_signal(SIGSTOP);

  const double slowest = slowest_request(client, 500);
  std::printf("slowest of 500 requests beside two stopped clients: %.1f ms\n", slowest);
  EXPECT_LT(slowest, 1000.0);
  for (int i = 1; i <= 30; ++i) {
    request.spec_json = fake_job(capture, "{\"sleep_ms\": 1, \"n\": " + std::to_string(i) + "}");
    const auto start = Clock::now();
    auto last = client.watch(client.submit(request).value().job_id, {});
    ASSERT_TRUE(last) << last.error().message;
    EXPECT_EQ(last->state, client::JobState::succeeded);
    EXPECT_LT(ms_since(start), 5000.0);
  }
  const auto file = daemon.folder() / "large.h5";
  write_noise_capture(file, 200000, 8, 7);
  auto upload = client.upload_capture(file);
  ASSERT_TRUE(upload) << upload.error().message;
  const auto back = daemon.folder() / "back.h5";
  auto download = client.download_capture(upload->sha256, back);
  EXPECT_TRUE(download) << download.error().message;

  // and when it goes on, it is served again
  asking.send_signal(SIGCONT);
  watching.send_signal(SIGCONT);
  EXPECT_TRUE(client.cancel(running));
  EXPECT_EQ(watching.wait(), 0);
}

TEST(ClientsOverDds, AKilledClientIsForgotten) {
  Daemon daemon;
  auto client = daemon.connect("ada").value();
  const auto connected = [&] {
    return json::parse(client.server_status().value())["clients_connected"].get<int>();
  };
  {
    Process other(test_client(daemon.domain(), "ben", "ask"));
    ASSERT_EQ(other.line(), "ready");
    while (connected() < 2) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const auto start = Clock::now();
  while (connected() > 1 && ms_since(start) < 15000)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(connected(), 1);
  std::printf("a killed client was forgotten after %.1f s\n", ms_since(start) / 1000);
}

TEST(ClientsOverDds, ManyComeAndGo) {
  Daemon daemon;
  for (int i = 0; i < 300; ++i) {  // more than the instances of one user's topics
    auto client = daemon.connect("ada");
    ASSERT_TRUE(client) << i << ": " << client.error().message;
    ASSERT_TRUE(client->server_status()) << i;
  }
}

TEST(ClientsOverDds, TwentyAtOnce) {
  Daemon daemon;
  std::vector<std::thread> clients;
  clients.reserve(20);
  std::atomic<int> done{0};
  for (int i = 0; i < 20; ++i)
    clients.emplace_back([&, i] {
      auto client = daemon.connect("user" + std::to_string(i % 5));
      ASSERT_TRUE(client) << client.error().message;
      slowest_request(*client, 50);
      ++done;
    });
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(done, 20);
}

TEST(ClientsOverDds, WithLossOnTheWire) {
  DaemonOptions lossy;
  lossy.environment = {"TENTER_DDS_LOST_PERCENT=5"};
  Daemon daemon(lossy);
  auto client = daemon.connect("ada", std::chrono::seconds(30));
  ASSERT_TRUE(client) << client.error().message;
  slowest_request(*client, 200);
  const auto file = daemon.folder() / "c.h5";
  write_noise_capture(file, 50000, 5, 3);
  auto up = client->upload_capture(file);
  ASSERT_TRUE(up) << up.error().message;
  auto down = client->download_capture(up->sha256, daemon.folder() / "back.h5");
  EXPECT_TRUE(down) << down.error().message;
}

}  // namespace
}  // namespace tenter::test
