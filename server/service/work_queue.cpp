// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/work_queue.h"

#include <utility>

namespace tenter::service {

WorkQueue::WorkQueue(Limits limits) : limits_(limits) {
  for (int i = 0; i < limits.threads; ++i) threads_.emplace_back([this] { body(); });
}

WorkQueue::~WorkQueue() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
  }
  ready_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

bool WorkQueue::add(const std::string& key, std::function<void()> work) {
  {
    std::lock_guard lock(mutex_);
    if (stop_ || waiting_ >= limits_.total) return false;
    Lane& lane = lanes_[key];
    if (lane.work.size() >= limits_.per_key) return false;
    lane.work.push_back(std::move(work));
    ++waiting_;
    if (lane.running || lane.work.size() > 1) return true;
    turns_.push_back(key);
  }
  ready_.notify_one();
  return true;
}

std::size_t WorkQueue::waiting() const {
  std::lock_guard lock(mutex_);
  return waiting_;
}

void WorkQueue::body() {
  std::unique_lock lock(mutex_);
  for (;;) {
    ready_.wait(lock, [this] { return stop_ || !turns_.empty(); });
    if (stop_) return;
    const std::string key = std::move(turns_.front());
    turns_.pop_front();
    Lane& lane = lanes_[key];
    std::function<void()> work = std::move(lane.work.front());
    lane.work.pop_front();
    --waiting_;
    lane.running = true;
    lock.unlock();
    work();
    work = nullptr;
    lock.lock();
    lane.running = false;  // the lane stayed: only this thread erases it, below
    if (lane.work.empty()) {
      lanes_.erase(key);
    } else {
      turns_.push_back(key);
      ready_.notify_one();
    }
  }
}

}  // namespace tenter::service
