// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/daemon_config.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace tenter::service {
namespace {

class Config : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(file_); }
  Expected<void> read(const std::string& text) {
    std::ofstream(file_) << text;
    return read_daemon_config(file_, config_);
  }
  std::string complaint(const std::string& text) {
    auto done = read(text);
    EXPECT_FALSE(done) << text;
    return done ? "" : done.error().message;
  }

  const std::filesystem::path file_ =
      std::filesystem::temp_directory_path() /
      ("tenter-config-test-" + std::to_string(::getpid()) + ".json");
  DaemonConfig config_;
};

TEST_F(Config, EveryKey) {
  ASSERT_TRUE(read(R"({
    // comments are allowed
    "domain": 7, "name": "lab", "interfaces": ["127.0.0.1"], "workers": 3, "log_level": "debug",
    "limits": {"default_time_s": 60, "max_time_s": 600, "default_memory_bytes": 2000000,
               "max_memory_bytes": 3000000, "capture_bytes": 1000, "attempts": 2},
    "quota": {"queued": 10, "running": 2, "stored_bytes": 5000}})"));
  EXPECT_EQ(config_.domain, 7);
  EXPECT_EQ(config_.name, "lab");
  EXPECT_EQ(config_.interfaces, std::vector<std::string>{"127.0.0.1"});
  EXPECT_EQ(config_.log_level, "debug");
  EXPECT_EQ(config_.jobs.parallel, 3);
  EXPECT_EQ(config_.jobs.default_time_limit_s, 60);
  EXPECT_EQ(config_.jobs.max_memory_limit_bytes, 3000000u);
  EXPECT_EQ(config_.jobs.max_capture_bytes, 1000u);
  EXPECT_EQ(config_.jobs.max_attempts, 2);
  EXPECT_EQ(config_.jobs.default_quota.max_queued, 10);
  EXPECT_EQ(config_.jobs.default_quota.max_stored_bytes, 5000u);
}

TEST_F(Config, WhatIsLeftOutKeepsItsDefault) {
  const DaemonConfig before;
  ASSERT_TRUE(read("{}"));
  EXPECT_EQ(config_.domain, std::nullopt);
  EXPECT_EQ(config_.jobs.max_attempts, before.jobs.max_attempts);
}

TEST_F(Config, ComplaintsNameFileAndKey) {
  EXPECT_NE(complaint("{\"domian\": 1}").find("domian is not a known key"), std::string::npos);
  EXPECT_NE(complaint("{\"domian\": 1}").find(file_.string()), std::string::npos);
  EXPECT_NE(complaint("{\"domain\": 233}").find("domain is not a whole number from 0 to 232"),
            std::string::npos);
  EXPECT_NE(complaint("{\"limits\": {\"attempts\": \"x\"}}").find("limits.attempts"),
            std::string::npos);
  EXPECT_NE(complaint("{\"limits\": {\"max_time_s\": -1}}").find("limits.max_time_s"),
            std::string::npos);
  EXPECT_NE(complaint("{\"quota\": 3}").find("quota is not an object"), std::string::npos);
  EXPECT_NE(complaint("{\"interfaces\": [1]}").find("interfaces"), std::string::npos);
  EXPECT_NE(complaint("[]").find("not an object"), std::string::npos);
  EXPECT_NE(complaint("{").find("JSON"), std::string::npos);
  std::filesystem::remove(file_);
  EXPECT_FALSE(read_daemon_config(file_, config_));
}

}  // namespace
}  // namespace tenter::service
