// SPDX-License-Identifier: Apache-2.0
#include "common/capture/file/capture_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <random>
#include <thread>

#include "common/h5/writer.h"
#include "tests/common/capture/support.h"

// HDF5's core driver does not free its buffer where making or closing a file fails for want of
// space
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}

namespace tenter::capture {
namespace {

using test::bytes_of;
using test::get_file;
using test::message_of;
using test::put_file;
using test::small_capture;
using test::TempFolder;

TEST(CaptureFile, ReadsWhatItWrote) {
  const TempFolder folder;
  const Capture written = small_capture();
  ASSERT_TRUE(write_capture(written, folder.path("c.h5")));
  std::vector<std::string> ignored;
  const auto read = read_capture_guarded(folder.path("c.h5"), &ignored);
  ASSERT_TRUE(read) << message_of(read);
  EXPECT_TRUE(ignored.empty());
  EXPECT_EQ(read->title, written.title);
  EXPECT_EQ(read->specimen.mass_kg, written.specimen.mass_kg);
  EXPECT_FALSE(read->specimen.length_m);
  EXPECT_EQ(read->protocol.phases[0].nominal_rate_per_s, 0.02);
  EXPECT_FALSE(read->protocol.phases[1].nominal_rate_per_s);
  EXPECT_EQ(read->branch, written.branch);
  EXPECT_EQ(read->frame, written.frame);
  EXPECT_EQ(read->channels.size(), written.channels.size());
  EXPECT_EQ(read->channels[0].name, "force");
  EXPECT_EQ(read->channels[0].values, written.channels[0].values);
  EXPECT_TRUE(std::isnan(read->channels[2].values[2]));
  EXPECT_EQ(bytes_of(*read), bytes_of(written));
}

TEST(CaptureFile, EqualCapturesAreEqualBytes) {
  const std::string first = bytes_of(small_capture());
  EXPECT_EQ(first, bytes_of(small_capture()));
  Capture other = small_capture();
  other.channels[0].values[1] += 1e-12;
  EXPECT_NE(first, bytes_of(other));
}

TEST(CaptureFile, LongCapturesSpanChunks) {
  Capture c = small_capture();
  const int n = 40000;
  c.runs = {{1, ""}};
  c.frame.clear();
  c.time_s.clear();
  for (int i = 0; i < n; ++i) c.frame.push_back(i);
  c.run.assign(n, 0);
  c.phase.assign(n, 0);
  c.branch.assign(n, Branch::load);
  std::mt19937 generator(3);
  for (Channel& channel : c.channels) {
    channel.sigma_per_frame.clear();
    channel.values.clear();
    for (int i = 0; i < n; ++i) channel.values.push_back(1.0 + 1e-9 * generator());
  }
  const TempFolder folder;
  ASSERT_TRUE(write_capture(c, folder.path("c.h5")));
  const auto read = read_capture(folder.path("c.h5"));
  ASSERT_TRUE(read) << message_of(read);
  EXPECT_EQ(read->channels[3].values, c.channels[3].values);
  EXPECT_TRUE(read->time_s.empty());
}

TEST(CaptureFile, WritesNothingThatDoesNotValidate) {
  const TempFolder folder;
  Capture c = small_capture();
  c.specimen.width_m = -1.0;
  const auto done = write_capture(c, folder.path("c.h5"));
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message,
            folder.path("c.h5") + ": specimen.width must be positive, not -1.000000.");
  EXPECT_EQ(folder.file_count(), 0U);
}

TEST(CaptureFile, AFullDiskLeavesNothingAndKeepsTheOldFile) {
  const TempFolder folder;
  put_file(folder.path("c.h5"), "old");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{4096, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto done = write_capture(small_capture(), folder.path("c.h5"));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::no_space) << done.error().message;
  EXPECT_EQ(folder.file_count(), 1U);
  EXPECT_EQ(get_file(folder.path("c.h5")), "old");
}

TEST(CaptureFile, AMissingFolderIsTheCallersError) {
  const auto done = write_capture(small_capture(), "/nowhere/at/all/c.h5");
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::bad_input);
  EXPECT_EQ(done.error().message,
            "/nowhere/at/all/c.h5: creating the file failed: No such file or directory.");
}

TEST(CaptureFile, OtherFilesAreNamedAsWhatTheyAre) {
  const TempFolder folder;
  EXPECT_EQ(read_capture(folder.path("none.h5")).error().kind, ErrorKind::not_found);
  EXPECT_EQ(read_capture(folder.folder()).error().message,
            folder.folder() + ": is not a regular file.");
  put_file(folder.path("t.h5"), "just text");
  EXPECT_EQ(read_capture_guarded(folder.path("t.h5")).error().message,
            folder.path("t.h5") + ": is not an HDF5 file (or is truncated at its start).");
  put_file(folder.path("e.h5"), "");
  EXPECT_FALSE(read_capture_guarded(folder.path("e.h5")));
  h5::H5Writer other(folder.path("o.h5"));
  other.group("/", "NXroot");
  ASSERT_TRUE(std::move(other).save());
  EXPECT_EQ(
      read_capture(folder.path("o.h5")).error().message,
      folder.path("o.h5") + ": /: has no attribute \"schema\"; it is not a capture of Tenter.");
}

// The allocator of the address sanitizer has locks that a child of a threaded process may find held
// (glibc's has not), so under it the threads read without a child.
#ifdef __SANITIZE_ADDRESS__
constexpr int kGuardedThreads = 0;
#else
constexpr int kGuardedThreads = 2;
#endif

TEST(CaptureFile, ManyThreadsReadAtOnce) {
  const TempFolder folder;
  ASSERT_TRUE(write_capture(small_capture(), folder.path("c.h5")));
  std::atomic<int> good{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 10; ++i) {
        const auto read = t < kGuardedThreads ? read_capture_guarded(folder.path("c.h5"))
                                              : read_capture(folder.path("c.h5"));
        if (read && read->channels.size() == 7) ++good;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 40);
}

}  // namespace
}  // namespace tenter::capture
