// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by the tests of server/jobs: a folder of one's own, specifications, a clock that obeys.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "common/base/sha256.h"
#include "server/jobs/queue/queue.h"

namespace tenter::jobs {

inline const std::string kCaptureBytes = "the bytes of a capture";
inline const std::string kCapture = sha256_hex(kCaptureBytes);

inline std::string read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Prints the Error when the value is missing.
template <class T>
T must(Expected<T> value, const char* where) {
  if (!value) {
    ADD_FAILURE() << where << ": " << value.error().message;
    std::abort();
  }
  if constexpr (!std::is_void_v<T>) return *std::move(value);
}
#define TENTER_TEXT2(x) #x
#define TENTER_TEXT(x) TENTER_TEXT2(x)
#define MUST(expression) ::tenter::jobs::must((expression), __FILE__ ":" TENTER_TEXT(__LINE__))

/// Where fsync costs nothing, for tests that are about logic: a thousand commits in a second.
inline std::filesystem::path memory_folder() {
  return ::access("/dev/shm", W_OK) == 0 ? "/dev/shm" : std::filesystem::temp_directory_path();
}

class TemporaryFolder {
 public:
  explicit TemporaryFolder(
      const std::filesystem::path& parent = std::filesystem::temp_directory_path()) {
    std::string pattern = (parent / "tenter-jobs-XXXXXX").string();
    if (!::mkdtemp(pattern.data())) std::abort();
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// `fake` is a JSON object for tests/server/jobs/fake_worker.cpp; `nonce` makes the work unique.
inline std::string spec_text(const std::string& nonce, const std::string& fake = "{}",
                             const std::string& capture = kCapture) {
  return R"({"schema":"tenter.job","version":1,"kind":"fit","captures":[")" + capture +
         R"("],"model":{},"options":{"nonce":")" + nonce + R"(","fake":)" + fake + "}}";
}

struct TestClock {
  std::shared_ptr<std::int64_t> wall = std::make_shared<std::int64_t>(1'800'000'000'000);
  std::shared_ptr<std::int64_t> monotonic = std::make_shared<std::int64_t>(1000);
  Clock clock() const {
    return {[w = wall] { return *w; }, [m = monotonic] { return *m; }};
  }
  void pass(std::int64_t ms) {
    *wall += ms;
    *monotonic += ms;
  }
};

inline bool wait_until(const std::function<bool()>& condition,
                       std::chrono::milliseconds limit = std::chrono::seconds(30)) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace tenter::jobs
