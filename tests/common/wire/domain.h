// SPDX-License-Identifier: Apache-2.0
// A DDS domain that no other test on this machine has, held by a lock on a file for the object's
// life.
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace tenter::test {

class Domain {
 public:
  Domain() {
    const auto folder = std::filesystem::temp_directory_path();
    for (int number = 60; number <= 230; ++number) {
      const auto file = folder / ("tenter-test-domain-" + std::to_string(number));
      const int lock = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
      if (lock < 0) continue;
      if (::flock(lock, LOCK_EX | LOCK_NB) == 0) {
        number_ = number;
        lock_ = lock;
        return;
      }
      ::close(lock);
    }
    std::abort();
  }
  ~Domain() { ::close(lock_); }
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

  int number() const { return number_; }

 private:
  int number_ = -1;
  int lock_ = -1;
};

}  // namespace tenter::test
