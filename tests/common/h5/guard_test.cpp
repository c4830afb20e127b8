// SPDX-License-Identifier: Apache-2.0
#include "common/h5/guard.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <vector>

namespace tenter::h5 {
namespace {

std::string message(const std::function<Expected<void>()>& read, const GuardLimits& limits = {}) {
  const Expected<void> result = run_guarded("f.h5", read, limits);
  return result ? "" : result.error().message;
}

TEST(Guard, PassesSuccessAndErrorsThrough) {
  EXPECT_EQ(message([]() -> Expected<void> { return {}; }), "");
  const auto result = run_guarded(
      "f.h5", []() -> Expected<void> { return fail(ErrorKind::not_found, "f.h5: is gone."); });
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::not_found);
  EXPECT_EQ(result.error().message, "f.h5: is gone.");
}

TEST(Guard, ACrashIsAnError) {
  EXPECT_EQ(message([]() -> Expected<void> {
              ::kill(::getpid(), SIGKILL);
              return {};
            }),
            "f.h5: the HDF5 library crashed while reading it (signal 9); the file is damaged.");
}

TEST(Guard, ASleeperAndABusyLoopTimeOut) {
  const std::string timed_out =
      "f.h5: the HDF5 library timed out while reading it; the file is damaged.";
  EXPECT_EQ(message(
                []() -> Expected<void> {
                  ::sleep(60);
                  return {};
                },
                {.wall_seconds = 1}),
            timed_out);
  EXPECT_EQ(message(
                []() -> Expected<void> {
                  std::uint64_t state = 1;
                  while (state != 0) state = state * 6364136223846793005U | 1U;
                  return {};
                },
                {.cpu_seconds = 1, .wall_seconds = 30}),
            timed_out);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(Guard, MemoryHasALimit) {
  EXPECT_EQ(message(
                []() -> Expected<void> {
                  std::vector<char> large(std::size_t{1} << 30, 'x');
                  return large.back() == 'x' ? Expected<void>() : bad_input("?");
                },
                {.memory_bytes = std::uint64_t{1} << 26}),
            "f.h5: reading it needs more memory than allowed.");
}
#endif

}  // namespace
}  // namespace tenter::h5
