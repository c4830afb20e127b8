// SPDX-License-Identifier: GPL-3.0-or-later
// What concerns one name (a transfer) happens once at a time; other names do not wait.
//
//   const Turns::Turn turn(turns, transfer);   // held to the end of the block
#pragma once

#include <condition_variable>
#include <mutex>
#include <set>
#include <string>
#include <utility>

namespace tenter::jobs {

class Turns {
 public:
  class Turn {
   public:
    Turn(Turns& turns, std::string name) : turns_(turns), name_(std::move(name)) {
      std::unique_lock lock(turns_.mutex_);
      turns_.ended_.wait(lock, [this] { return turns_.held_.insert(name_).second; });
    }
    ~Turn() {
      {
        const std::lock_guard lock(turns_.mutex_);
        turns_.held_.erase(name_);
      }
      turns_.ended_.notify_all();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Turns& turns_;
    const std::string name_;
  };

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
  std::set<std::string> held_;
};

}  // namespace tenter::jobs
