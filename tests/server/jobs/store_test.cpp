// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/store/store.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "common/base/sha256.h"
#include "server/jobs/store/checkpoints.h"
#include "tests/server/jobs/jobs_fixture.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;

std::size_t files_in(const fs::path& folder) {
  std::size_t count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    count += entry.is_regular_file();
  return count;
}

TEST(Store, KeepsBytesUnderTheirHash) {
  const TemporaryFolder folder;
  auto store = MUST(Store::open(folder.path()));
  const std::string sha256 = MUST(store->put("hello"));
  EXPECT_EQ(sha256, sha256_hex("hello"));
  const fs::path path = MUST(store->path(sha256));
  EXPECT_EQ(path, folder.path() / "objects" / sha256.substr(0, 2) / sha256.substr(2));
  EXPECT_EQ(read(path), "hello");
  EXPECT_EQ(MUST(store->put("hello")), sha256);  // twice is once
  EXPECT_EQ(files_in(folder.path()), 1u);
  EXPECT_TRUE(store->contains(sha256));
  EXPECT_FALSE(store->contains(sha256_hex("other")));
  EXPECT_EQ(store->path("../../etc/passwd").error().kind, ErrorKind::bad_input);
  EXPECT_EQ(store->path(sha256_hex("other")).error().kind, ErrorKind::not_found);
}

TEST(Store, AdoptsAFileByMovingIt) {
  const TemporaryFolder folder;
  auto store = MUST(Store::open(folder.path() / "store"));
  const fs::path file = folder.path() / "result.json";
  std::ofstream(file) << "{}";
  EXPECT_EQ(MUST(store->adopt(file)), sha256_hex("{}"));
  EXPECT_FALSE(fs::exists(file));
  std::ofstream(file) << "{}";
  EXPECT_EQ(MUST(store->adopt(file)), sha256_hex("{}"));  // there already
  EXPECT_FALSE(fs::exists(file));
  fs::create_symlink("/etc/passwd", file);  // a worker is not trusted with what it leaves
  EXPECT_EQ(store->adopt(file).error().kind, ErrorKind::bad_input);
}

TEST(Store, AFlippedBitIsFoundAndTheObjectSetAside) {
  const TemporaryFolder folder;
  auto store = MUST(Store::open(folder.path()));
  const std::string sha256 = MUST(store->put("some bytes"));
  const fs::path path = MUST(store->path(sha256));
  fs::permissions(path, fs::perms::owner_write, fs::perm_options::add);
  std::ofstream(path) << "some butes";
  EXPECT_TRUE(store->check_present(sha256, 10));  // the size is right
  const auto found = store->path(sha256);         // although it was sound a moment ago
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("is damaged"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder.path() / "damaged" / sha256));
  EXPECT_FALSE(store->contains(sha256));
  EXPECT_EQ(MUST(store->put("some bytes")), sha256);  // heals
  EXPECT_EQ(read(MUST(store->path(sha256))), "some bytes");
}

TEST(Store, LeavingsOfAKilledWriterAreRemovedAtStartUp) {
  const TemporaryFolder folder;
  MUST(Store::open(folder.path()));
  std::ofstream(folder.path() / "tmp" / "1-1") << "half";
  MUST(Store::open(folder.path()));
  EXPECT_EQ(files_in(folder.path()), 0u);
}

// A limit on file size stands for a full disk: the write fails the same way, for root too.
TEST(Store, AWriteThatFailsLeavesNothingBehind) {
  const TemporaryFolder folder;
  auto store = MUST(Store::open(folder.path()));
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{4096, 4096};
    ::setrlimit(RLIMIT_FSIZE, &small);
    const auto put = store->put(std::string(100000, 'x'));
    const bool right =
        !put && put.error().kind == ErrorKind::no_space && store->put("small").has_value();
    ::_exit(right ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(files_in(folder.path()), 1u);  // "small"
  EXPECT_TRUE(store->contains(sha256_hex("small")));
}

TEST(CheckpointsTest, TheOldestGoAndTheRunningStay) {
  const TemporaryFolder folder;
  const std::filesystem::path home = folder.path() / "checkpoints";
  Checkpoints checkpoints = MUST(Checkpoints::open(home, "engine a"));
  std::vector<std::string> specs;
  for (int i = 0; i < 5; ++i) {
    specs.push_back(sha256_hex(std::to_string(i)));
    std::filesystem::create_directories(checkpoints.of(specs.back()));
    const std::filesystem::path file = checkpoints.of(specs.back()) / "state.json";
    std::ofstream(file) << std::string(1000, 'x');
    const auto old = std::filesystem::file_time_type::clock::now() - std::chrono::hours(10 - i);
    std::filesystem::last_write_time(file, old);
    std::filesystem::last_write_time(checkpoints.of(specs.back()), old);
  }
  const auto there = [&] {
    std::string found;
    for (std::size_t i = 0; i < specs.size(); ++i)
      if (std::filesystem::exists(checkpoints.of(specs[i]))) found += std::to_string(i);
    return found;
  };
  checkpoints.prune({specs[0]}, 4);
  EXPECT_EQ(there(), "0234");
  checkpoints.prune({specs[0]}, 4, 2500);
  EXPECT_EQ(there(), "04");
  checkpoints.drop("../queue.sqlite");
  checkpoints = MUST(Checkpoints::open(home, "engine a"));
  EXPECT_EQ(there(), "04");
  checkpoints = MUST(Checkpoints::open(home, "engine b"));
  EXPECT_EQ(there(), "");
}

}  // namespace
}  // namespace tenter::jobs
