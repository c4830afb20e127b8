// SPDX-License-Identifier: GPL-3.0-or-later
// A child process whose standard output a test reads line by line; killed with the object.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace tenter::test {

class Process {
 public:
  explicit Process(std::vector<std::string> words);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// The next line without its end; none at the end of the output or after `patience`.
  std::optional<std::string> line(std::chrono::milliseconds patience = std::chrono::seconds(20));
  void send_signal(int signal);
  /// The exit code, or minus the signal.
  int wait();

 private:
  pid_t pid_ = -1;
  int output_ = -1;
  std::string rest_;
};

/// The words that start a test client on this domain.
std::vector<std::string> test_client(int domain, const std::string& user, const std::string& what,
                                     const std::string& argument = "");

}  // namespace tenter::test
