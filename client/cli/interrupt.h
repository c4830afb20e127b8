// SPDX-License-Identifier: Apache-2.0
// Ctrl-C as a stop token: the first asks the work at hand to stop, the second ends the process.
//
// Make one before any other thread is started (the signals are blocked in threads made later), one
// at a time.
#pragma once

#include <stop_token>
#include <thread>

namespace tenter::cli {

class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  std::stop_token token() const { return source_.get_token(); }
  bool interrupted() const { return source_.stop_requested(); }

 private:
  std::stop_source source_;
  std::jthread watcher_;
};

}  // namespace tenter::cli
