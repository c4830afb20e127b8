// SPDX-License-Identifier: GPL-3.0-or-later
// Threads that do what the loop must not wait for, fairly between those who ask.
//
// Work comes with a key (a client, a transfer). Of one key at most one piece runs at a time, in
// order; keys take turns. Both the pieces of one key and the pieces of all are bounded: beyond that
// add() refuses, and the caller tells the client so.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace tenter::service {

class WorkQueue {
 public:
  struct Limits {
    int threads = 2;
    std::size_t per_key = 32;
    std::size_t total = 1024;
  };
  explicit WorkQueue(Limits limits);
  ~WorkQueue();  ///< waits for what runs, drops what waits
  WorkQueue(const WorkQueue&) = delete;
  WorkQueue& operator=(const WorkQueue&) = delete;

  bool add(const std::string& key, std::function<void()> work);
  std::size_t waiting() const;

 private:
  struct Lane {
    std::deque<std::function<void()>> work;
    bool running = false;
  };
  void body();

  const Limits limits_;
  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::map<std::string, Lane> lanes_;
  std::deque<std::string> turns_;  ///< keys with work and nothing running
  std::size_t waiting_ = 0;
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace tenter::service
