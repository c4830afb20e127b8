// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/worker/worker_protocol.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <random>

#include "tests/server/jobs/jobs_fixture.h"

namespace tenter::jobs {
namespace {

TEST(WorkerProtocol, AnOrderComesBackAsItWent) {
  const TemporaryFolder folder;
  WorkOrder order;
  order.claim = {12, 34};
  order.spec_json = spec_text("a");
  order.captures = {{kCapture, "/store/objects/ab/cd"}};
  order.folder = folder.path();
  order.checkpoints = folder.path() / "kept";
  order.time_limit_s = 1.5;
  order.memory_limit_bytes = 1ull << 40;
  order.heartbeat = std::chrono::milliseconds(250);
  std::ofstream(folder.path() / "order.json") << write_order(order, 77);
  const ReceivedOrder received = MUST(read_order(folder.path() / "order.json"));
  EXPECT_EQ(received.parent, 77);
  EXPECT_EQ(received.order.claim, order.claim);
  EXPECT_EQ(received.order.spec_json, order.spec_json);
  EXPECT_EQ(received.order.captures, order.captures);
  EXPECT_EQ(received.order.folder, order.folder);
  EXPECT_EQ(received.order.checkpoints, order.checkpoints);
  EXPECT_EQ(received.order.time_limit_s, order.time_limit_s);
  EXPECT_EQ(received.order.memory_limit_bytes, order.memory_limit_bytes);
  EXPECT_EQ(received.order.heartbeat, order.heartbeat);
  std::ofstream(folder.path() / "order.json") << "{}";
  EXPECT_EQ(read_order(folder.path() / "order.json").error().kind, ErrorKind::bad_input);
  EXPECT_EQ(read_order(folder.path() / "none").error().kind, ErrorKind::not_found);
}

TEST(WorkerProtocol, LinesComeBackAsTheyWent) {
  const auto progress =
      std::get<JobProgress>(*read_line(write_line(JobProgress{"refit", "dahl", 7, 2.5, 0.25})));
  EXPECT_EQ(progress.stage, "refit");
  EXPECT_EQ(progress.detail, "dahl");
  EXPECT_EQ(progress.iteration, 7);
  EXPECT_EQ(progress.cost, 2.5);
  EXPECT_EQ(progress.fraction, 0.25);
  const auto error =
      std::get<Error>(*read_line(write_line(Error{ErrorKind::bad_input, "no force"})));
  EXPECT_EQ(error.kind, ErrorKind::bad_input);
  EXPECT_EQ(error.message, "no force");
  EXPECT_TRUE(std::holds_alternative<Heartbeat>(*read_line(write_line(Heartbeat{}))));
}

TEST(WorkerProtocol, ABrokenWorkerIsNotBelieved) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto wild =
      std::get<JobProgress>(*read_line(write_line(JobProgress{"\xff\xfe", "", -9, infinity, 7})));
  EXPECT_EQ(wild.iteration, -1);
  EXPECT_EQ(wild.cost, 0);
  EXPECT_EQ(wild.fraction, 1);
  for (const char* text :
       {"", "{}", "[]", "null", "{\"progress\":3}", "{\"error\":[]}", "\xff", "{\"progress\":"}) {
    EXPECT_FALSE(read_line(text)) << text;
  }
  EXPECT_EQ(std::get<Error>(*read_line(R"({"error":{"kind":"odd","message":5}})")).kind,
            ErrorKind::internal);
  std::mt19937 random(5);
  const std::string sound = write_line(JobProgress{"refit", "dahl", 7, 2.5, 0.25});
  for (int i = 0; i < 3000; ++i) {
    std::string text = sound;
    for (int flips = 0; flips < 3; ++flips)
      text[random() % text.size()] = static_cast<char>(random());
    if (const auto line = read_line(text); line && std::holds_alternative<JobProgress>(*line)) {
      EXPECT_LE(std::get<JobProgress>(*line).fraction, 1);
    }
  }
}

}  // namespace
}  // namespace tenter::jobs
