// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/store/uploads.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <thread>

#include "common/base/crc32c.h"
#include "tests/server/jobs/jobs_fixture.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;

std::string random_bytes(std::size_t size, unsigned seed) {
  std::mt19937_64 random(seed);
  std::string bytes(size, 0);
  for (auto& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

std::string_view chunk(const std::string& bytes, std::uint64_t index) {
  return std::string_view(bytes).substr(index * Uploads::kChunkBytes, Uploads::kChunkBytes);
}

TEST(Uploads, ChunksInAnyOrderMakeTheFile) {
  const TemporaryFolder folder;
  auto uploads = MUST(Uploads::open(folder.path()));
  const std::string bytes = random_bytes(5 * Uploads::kChunkBytes + 777, 1);
  const auto state = MUST(uploads->open_transfer({"ada", sha256_hex(bytes), bytes.size()}));
  ASSERT_EQ(state.chunks, 6u);
  std::vector<std::uint64_t> order(6);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  for (const auto index : order)
    MUST(uploads->write_chunk(state.transfer, index, chunk(bytes, index)));
  EXPECT_EQ(MUST(uploads->write_chunk(state.transfer, 2, chunk(bytes, 2))).received,
            6u);  // a repeat
  const auto file = MUST(uploads->finish(state.transfer));
  EXPECT_EQ(read(file.path), bytes);
  EXPECT_EQ(file.request.user, "ada");
  MUST(uploads->finish(state.transfer));  // a commit may be repeated
  MUST(uploads->drop(state.transfer));
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Uploads, ARestartKnowsTheDurableChunksAndOnlyThose) {
  const TemporaryFolder folder;
  const std::string bytes = random_bytes(20 * Uploads::kChunkBytes, 2);
  const UploadRequest request{"ada", sha256_hex(bytes), bytes.size()};
  const pid_t child = ::fork();
  if (child == 0) {  // a daemon that is killed in mid-transfer
    auto uploads = MUST(Uploads::open(folder.path()));
    const auto state = MUST(uploads->open_transfer(request));
    for (std::uint64_t i = 0; i < 7; ++i)
      MUST(uploads->write_chunk(state.transfer, i, chunk(bytes, i)));
    MUST(uploads->sync(state.transfer));
    MUST(uploads->write_chunk(state.transfer, 7, chunk(bytes, 7)));
    ::raise(SIGKILL);
  }
  ::waitpid(child, nullptr, 0);
  auto uploads = MUST(Uploads::open(folder.path()));
  const auto state = MUST(uploads->open_transfer(request));
  EXPECT_EQ(std::count(state.present.begin(), state.present.end(), true), 7);
  EXPECT_TRUE(state.present[6]);
  for (std::uint64_t i = 7; i < 20; ++i)
    MUST(uploads->write_chunk(state.transfer, i, chunk(bytes, i)));
  EXPECT_EQ(read(MUST(uploads->finish(state.transfer)).path), bytes);
}

TEST(Uploads, WrongInputIsRefusedWithASentence) {
  const TemporaryFolder folder;
  auto uploads = MUST(Uploads::open(folder.path()));
  const std::string bytes = random_bytes(Uploads::kChunkBytes + 5, 3);
  EXPECT_EQ(uploads->open_transfer({"ada", "xyz", 5}).error().kind, ErrorKind::bad_input);
  EXPECT_EQ(uploads->open_transfer({"ada", sha256_hex(""), 0}).error().kind, ErrorKind::bad_input);
  const auto huge = uploads->open_transfer({"ada", sha256_hex("x"), Uploads::kLargestBytes});
  EXPECT_EQ(huge.error().kind, ErrorKind::no_space)
      << huge.error().message;  // no disk here has a TiB free
  EXPECT_TRUE(fs::is_empty(folder.path()));
  const auto state = MUST(uploads->open_transfer({"ada", sha256_hex(bytes), bytes.size()}));
  EXPECT_EQ(uploads->write_chunk("nothing", 0, "").error().kind, ErrorKind::not_found);
  EXPECT_EQ(uploads->write_chunk(state.transfer, 2, chunk(bytes, 0)).error().kind,
            ErrorKind::bad_input);
  EXPECT_EQ(uploads->write_chunk(state.transfer, 0, "short").error().kind, ErrorKind::bad_input);
  MUST(uploads->write_chunk(state.transfer, 0, chunk(bytes, 0)));
  const auto early = uploads->finish(state.transfer);
  EXPECT_EQ(early.error().kind, ErrorKind::refused);
  EXPECT_EQ(early.error().message, "1 of 2 chunks are missing, the first is 1");
  MUST(uploads->write_chunk(state.transfer, 1, "wrong"));
  const auto wrong = uploads->finish(state.transfer);
  EXPECT_EQ(wrong.error().kind, ErrorKind::bad_input);
  EXPECT_NE(wrong.error().message.find("instead of the promised"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder.path()));  // and forgotten
}

std::string checksums_of(const std::string& bytes) {
  std::string list;
  for (std::uint64_t i = 0; i * Uploads::kChunkBytes < bytes.size(); ++i) {
    const auto crc = crc32c(chunk(bytes, i).data(), chunk(bytes, i).size());
    for (int shift = 0; shift < 32; shift += 8) list += static_cast<char>(crc >> shift);
  }
  return sha256_hex(list);
}

TEST(Uploads, AConfirmedTransferNeedsNoPromisedHashAlsoAfterARestart) {
  const TemporaryFolder folder;
  const std::string bytes = random_bytes(3 * Uploads::kChunkBytes + 9, 5);
  const UploadRequest request{"ada", sha256_hex("a stand-in"), bytes.size()};
  {
    auto uploads = MUST(Uploads::open(folder.path()));
    const auto state = MUST(uploads->open_transfer(request));
    for (std::uint64_t i = 0; i < 3; ++i)
      MUST(uploads->write_chunk(state.transfer, i, chunk(bytes, i)));
    EXPECT_EQ(uploads->confirm(state.transfer, checksums_of(bytes)).error().kind,
              ErrorKind::refused);  // one is missing
    MUST(uploads->write_chunk(state.transfer, 3, chunk(bytes, 3)));
    ASSERT_TRUE(uploads->confirm(state.transfer, checksums_of(bytes)));
  }
  auto uploads = MUST(Uploads::open(folder.path()));
  const auto state = MUST(uploads->open_transfer(request));
  EXPECT_EQ(std::count(state.present.begin(), state.present.end(), true), 4);
  ASSERT_TRUE(uploads->confirm(state.transfer, checksums_of(bytes)));
  EXPECT_EQ(MUST(uploads->finish(state.transfer)).request.sha256, sha256_hex(bytes));
}

TEST(Uploads, ChunksOfAnotherFileAreNotConfirmed) {
  const TemporaryFolder folder;
  auto uploads = MUST(Uploads::open(folder.path()));
  const std::string bytes = random_bytes(2 * Uploads::kChunkBytes, 6);
  const std::string other = bytes.substr(0, Uploads::kChunkBytes) + random_bytes(1u << 20, 7);
  const auto state = MUST(uploads->open_transfer({"ada", sha256_hex("x"), bytes.size()}));
  MUST(uploads->write_chunk(state.transfer, 0, chunk(other, 0)));
  MUST(uploads->write_chunk(state.transfer, 1, chunk(other, 1)));
  const auto refused = uploads->confirm(state.transfer, checksums_of(bytes));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::bad_input);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Uploads, AByteThatChangedOnTheDiskIsFoundBeforeTheFileGetsItsName) {
  const TemporaryFolder folder;
  auto uploads = MUST(Uploads::open(folder.path()));
  const std::string bytes = random_bytes(2 * Uploads::kChunkBytes + 100, 8);
  const auto state = MUST(uploads->open_transfer({"ada", sha256_hex("x"), bytes.size()}));
  for (std::uint64_t i = 0; i < 3; ++i)
    MUST(uploads->write_chunk(state.transfer, i, chunk(bytes, i)));
  ASSERT_TRUE(uploads->confirm(state.transfer, checksums_of(bytes)));
  const auto file = MUST(uploads->seal(state.transfer));
  {
    std::fstream damaged(file, std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(Uploads::kChunkBytes + 300'000);
    damaged.put(static_cast<char>(bytes[Uploads::kChunkBytes + 300'000] ^ 1));
  }
  const auto refused = uploads->finish(state.transfer);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("chunk 1 is not on the disk as it was received"),
            std::string::npos)
      << refused.error().message;
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Uploads, DamagedAndOldTransfersAreDropped) {
  const TemporaryFolder folder;
  {
    auto uploads = MUST(Uploads::open(folder.path()));
    for (const char* user : {"a", "b", "c"})
      MUST(uploads->open_transfer({user, sha256_hex("x"), 3'000'000}));
    EXPECT_EQ(uploads->pending_bytes("a"), 3'000'000u);
    EXPECT_EQ(uploads->pending_bytes("a", sha256_hex("x")), 0u);
  }
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder.path())) found.push_back(entry.path());
  ASSERT_EQ(found.size(), 3u);
  fs::resize_file(found[0] / "data", 5);
  fs::last_write_time(found[1] / "chunks",
                      fs::file_time_type::clock::now() - std::chrono::hours(24 * 8));
  MUST(Uploads::open(folder.path()));
  EXPECT_FALSE(fs::exists(found[0]));
  EXPECT_FALSE(fs::exists(found[1]));
  EXPECT_TRUE(fs::exists(found[2]));
}

TEST(Uploads, TwoTransfersAtOnceFromTwoThreads) {
  const TemporaryFolder folder;
  auto uploads = MUST(Uploads::open(folder.path()));
  const auto send = [&](unsigned seed) {
    const std::string bytes = random_bytes(24 * Uploads::kChunkBytes + seed, seed);
    const auto state = MUST(uploads->open_transfer({"ada", sha256_hex(bytes), bytes.size()}));
    for (std::uint64_t i = 0; i < state.chunks; ++i) {
      MUST(uploads->write_chunk(state.transfer, i, chunk(bytes, i)));
    }
    MUST(uploads->finish(state.transfer));
  };
  std::jthread one([&] { send(10); });
  std::jthread two([&] { send(11); });
}

}  // namespace
}  // namespace tenter::jobs
