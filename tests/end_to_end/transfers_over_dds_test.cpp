// SPDX-License-Identifier: GPL-3.0-or-later
// Captures on their way through a real daemon: up, down, twice, broken off, refused.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/sha256.h"
#include "tests/end_to_end/support/captures.h"
#include "tests/end_to_end/support/daemon.h"
#include "tests/end_to_end/support/process.h"

namespace tenter::test {
namespace {

using nlohmann::json;

TEST(TransfersOverDds, UpTwiceAndDown) {
  Daemon daemon;
  auto client = daemon.connect().value();
  const auto file = daemon.folder() / "pull.h5";
  write_noise_capture(file, 100000, 5);
  std::uint64_t reported = 0;
  auto first = client.upload_capture(file, [&](const client::TransferProgress& progress) {
    EXPECT_GE(progress.bytes_done, reported);
    reported = progress.bytes_done;
  });
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_FALSE(first->already_stored);
  EXPECT_EQ(first->bytes_resumed, 0u);
  EXPECT_EQ(reported, std::filesystem::file_size(file));
  EXPECT_EQ(first->sha256, sha256_file(file).value());
  EXPECT_EQ(json::parse(first->summary_json)["summary"]["frames"], 100000);

  auto second = client.upload_capture(file);
  ASSERT_TRUE(second);
  EXPECT_TRUE(second->already_stored);
  const auto list = json::parse(client.list_captures().value());
  EXPECT_EQ(list["total"], 1);
  EXPECT_EQ(list["captures"][0]["id"], first->sha256);
  EXPECT_EQ(json::parse(client.show_capture(first->sha256).value())["title"], "noise 1");

  const auto back = daemon.folder() / "back.h5";
  auto bytes = client.download_capture(first->sha256, back);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(sha256_file(back).value(), first->sha256);
  for (const auto& entry : std::filesystem::directory_iterator(daemon.folder()))
    EXPECT_EQ(entry.path().string().find(".part-"), std::string::npos);
}

TEST(TransfersOverDds, ABadCaptureIsRefusedWithItsSentence) {
  Daemon daemon;
  auto client = daemon.connect().value();
  const auto file = daemon.folder() / "bad.h5";
  std::ofstream(file) << "this is not a capture";
  auto refused = client.upload_capture(file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::bad_input);
  EXPECT_NE(refused.error().message.find("the capture"), std::string::npos)
      << refused.error().message;
  EXPECT_EQ(refused.error().message.find(daemon.store().string()), std::string::npos);
  EXPECT_EQ(json::parse(client.list_captures().value())["total"], 0);

  // truncated in the middle: nothing half of it stays either
  write_noise_capture(file, 20000, 5);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  refused = client.upload_capture(file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::bad_input);
  EXPECT_EQ(json::parse(client.list_captures().value())["total"], 0);
}

TEST(TransfersOverDds, AnUploadOfAKilledClientResumes) {
  Daemon daemon;
  const auto file = daemon.folder() / "large.h5";
  write_noise_capture(file, 400000, 12);
  const std::uint64_t size = std::filesystem::file_size(file);
  {
    Process client(test_client(daemon.domain(), "ada", "upload", file.string()));
    ASSERT_EQ(client.line(), "ready");
    for (;;) {
      const auto line = client.line();
      ASSERT_TRUE(line) << "the upload ended before it could be killed";
      if (std::stoull(*line) > size / 4) break;
    }
    client.send_signal(SIGKILL);
  }
  auto client = daemon.connect().value();
  auto resumed = client.upload_capture(file);
  ASSERT_TRUE(resumed) << resumed.error().message;
  EXPECT_GE(resumed->bytes_resumed, size / 4);
  EXPECT_LT(resumed->bytes_resumed, size);
}

TEST(TransfersOverDds, AnUploadSurvivesKillMinusNineOfTheDaemon) {
  Daemon daemon;
  const auto file = daemon.folder() / "large.h5";
  write_noise_capture(file, 400000, 12);
  const std::uint64_t size = std::filesystem::file_size(file);
  auto client = daemon.connect("ada", std::chrono::seconds(30)).value();
  bool killed = false;
  std::thread restarter;
  auto done = client.upload_capture(file, [&](const client::TransferProgress& progress) {
    if (killed || progress.bytes_done < size / 3) return;
    killed = true;
    daemon.kill();
    restarter = std::thread([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      daemon.start();
    });
  });
  if (restarter.joinable()) restarter.join();
  ASSERT_TRUE(killed);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(json::parse(client.list_captures().value())["captures"][0]["id"], done->sha256);
}

TEST(TransfersOverDds, WhatWasStoredSurvivesKillMinusNineOfTheDaemon) {
  Daemon daemon;
  const auto file = daemon.folder() / "large.h5";
  write_noise_capture(file, 100000, 12);
  auto client = daemon.connect("ada", std::chrono::seconds(30)).value();
  bool killed = false;
  std::thread restarter;
  auto done = client.upload_capture(file, [&](const client::TransferProgress& progress) {
    if (killed || !progress.stored) return;
    killed = true;
    daemon.kill();
    std::filesystem::rename(file, daemon.folder() / "gone.h5");  // the server has it
    restarter = std::thread([&] { daemon.start(); });
  });
  if (restarter.joinable()) restarter.join();
  ASSERT_TRUE(killed);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(done->sha256, sha256_file(daemon.folder() / "gone.h5").value());
  EXPECT_EQ(json::parse(client.list_captures().value())["captures"][0]["id"], done->sha256);
  auto again = client.upload_capture(daemon.folder() / "gone.h5");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(again->already_stored);
  EXPECT_EQ(again->sha256, done->sha256);
}

TEST(TransfersOverDds, AFileThatIsThereIsNotSentToItsEndWhereSendingIsSlow) {
  Daemon daemon;
  const auto file = daemon.folder() / "large.h5";
  write_noise_capture(file, 400000, 12);
  auto client = daemon.connect().value();
  auto first = client.upload_capture(file);
  ASSERT_TRUE(first) << first.error().message;
  std::uint64_t sent = 0;
  auto second = client.upload_capture(file, [&](const client::TransferProgress& progress) {
    if (progress.stored) return;
    sent = progress.bytes_done;
    std::this_thread::sleep_for(std::chrono::milliseconds(250));  // all of it would take 9 s
  });
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_TRUE(second->already_stored);
  EXPECT_EQ(second->sha256, first->sha256);
  EXPECT_GT(sent, 0u);
  EXPECT_LT(sent, std::filesystem::file_size(file) * 3 / 4);
  const std::filesystem::path left = daemon.store() / "uploads";
  EXPECT_TRUE(std::filesystem::is_empty(left));
}

TEST(TransfersOverDds, ChunksOfAnOlderVersionOfTheFileAreSentAgain) {
  Daemon daemon;
  const auto file = daemon.folder() / "large.h5";
  write_noise_capture(file, 400000, 12);
  const std::uint64_t size = std::filesystem::file_size(file);
  const auto time = std::filesystem::last_write_time(file);
  const auto right = sha256_file(file).value();
  const auto flip = [&] {  // its size, time and ends stay: it goes by the same name
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekg(static_cast<std::streamoff>(size / 8));
    const int old = bytes.get();
    bytes.seekp(static_cast<std::streamoff>(size / 8));
    bytes.put(static_cast<char>(old ^ 1));
    bytes.close();
    std::filesystem::last_write_time(file, time);
  };
  flip();
  {
    Process client(test_client(daemon.domain(), "ada", "upload", file.string()));
    ASSERT_EQ(client.line(), "ready");
    for (;;) {
      const auto line = client.line();
      ASSERT_TRUE(line) << "the upload ended before it could be killed";
      if (std::stoull(*line) > size / 4) break;
    }
    client.send_signal(SIGKILL);
  }
  flip();
  ASSERT_EQ(sha256_file(file).value(), right);
  auto client = daemon.connect().value();
  auto resumed = client.upload_capture(file);
  ASSERT_TRUE(resumed) << resumed.error().message;
  EXPECT_GE(resumed->bytes_resumed, size / 4);  // so it believed at first
  EXPECT_EQ(resumed->sha256, right);
}

TEST(TransfersOverDds, ManyAtOnce) {
  Daemon daemon;
  std::vector<std::thread> users;
  for (std::uint32_t i = 0; i < 4; ++i)
    users.emplace_back([&, i] {
      const auto file = daemon.folder() / ("c" + std::to_string(i) + ".h5");
      write_noise_capture(file, 50000, 5, i + 1);
      auto client = daemon.connect("user" + std::to_string(i % 2));
      ASSERT_TRUE(client) << client.error().message;
      auto up = client->upload_capture(file);
      ASSERT_TRUE(up) << up.error().message;
      const auto back = daemon.folder() / ("b" + std::to_string(i) + ".h5");
      auto down = client->download_capture(up->sha256, back);
      ASSERT_TRUE(down) << down.error().message;
    });
  for (std::thread& user : users) user.join();
}

TEST(TransfersOverDds, SixtyOneAfterTheOther) {
  Daemon daemon;
  auto client = daemon.connect().value();
  const auto file = daemon.folder() / "c.h5";
  const auto start = std::chrono::steady_clock::now();
  for (std::uint32_t i = 0; i < 60;
       ++i) {  // more than the instances of the topic of acknowledgements
    write_noise_capture(file, 100, 1, i + 1);
    auto up = client.upload_capture(file);
    ASSERT_TRUE(up) << i << ": " << up.error().message;
    auto down = client.download_capture(up->sha256, daemon.folder() / "back.h5");
    ASSERT_TRUE(down) << i << ": " << down.error().message;
  }
  std::printf("60 small captures up and down in %.1f s\n",
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

TEST(TransfersOverDds, MissingAndEmptyFilesAreTheCallersFault) {
  Daemon daemon;
  auto client = daemon.connect().value();
  EXPECT_EQ(client.upload_capture(daemon.folder() / "none").error().kind, ErrorKind::not_found);
  const auto empty = daemon.folder() / "empty.h5";
  std::ofstream(empty).close();
  EXPECT_EQ(client.upload_capture(empty).error().kind, ErrorKind::bad_input);
}

}  // namespace
}  // namespace tenter::test
