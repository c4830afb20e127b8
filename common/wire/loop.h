// SPDX-License-Identifier: Apache-2.0
// One thread that waits for everything: samples that arrived, timers, and functions posted by other
// threads.
//
// All handlers of readers and timers run in it, one after the other, so what only they touch needs
// no lock. They must return soon and must not wait for another sample; long work goes to another
// thread, which posts the answer.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

namespace tenter::wire {

class Loop {
 public:
  using Function = std::function<void()>;
  using TimerId = std::uint64_t;

  Loop();
  ~Loop();  ///< ends the thread; what is posted and not run yet is dropped
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  /// Runs the function in the loop's thread, after what was posted before it. Any thread.
  void post(Function function);
  /// As post, but returns when it ran; at once in the loop's own thread.
  void run(const Function& function);
  bool in_thread() const;

  /// Any thread; the first call comes after one interval.
  TimerId every(std::chrono::milliseconds interval, Function function);
  TimerId after(std::chrono::milliseconds delay, Function function);
  void cancel(TimerId timer);

  class Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenter::wire
