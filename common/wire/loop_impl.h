// SPDX-License-Identifier: Apache-2.0
// The inside of the loop, for the files of this folder that see DDS.
#pragma once

#include <atomic>
#include <condition_variable>
#include <fastdds/dds/core/condition/Condition.hpp>
#include <fastdds/dds/core/condition/GuardCondition.hpp>
#include <fastdds/dds/core/condition/WaitSet.hpp>
#include <map>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "common/wire/loop.h"

namespace tenter::wire {

/// Something with a condition that can be emptied in portions.
class Source {
 public:
  virtual ~Source() = default;
  /// Hands over at most a portion of what is there; true if there may be more.
  virtual bool drain() = 0;
};

class Loop::Impl {
 public:
  using Clock = std::chrono::steady_clock;

  Impl();
  ~Impl();

  void post(Function function);
  TimerId add_timer(std::chrono::milliseconds delay, std::chrono::milliseconds interval,
                    Function function);
  void cancel(TimerId timer);

  // loop thread only
  void attach(eprosima::fastdds::dds::Condition& condition, Source& source);
  void detach(eprosima::fastdds::dds::Condition& condition);

  std::atomic<std::thread::id> thread_id_{};

 private:
  struct Timer {
    Clock::time_point due;
    std::chrono::milliseconds interval{0};  ///< 0: once
    Function function;
  };

  void body();
  void run_posted();
  void run_timers();
  Clock::duration until_next_timer();

  eprosima::fastdds::dds::WaitSet wait_set_;
  eprosima::fastdds::dds::GuardCondition wake_;
  std::map<eprosima::fastdds::dds::Condition*, Source*> sources_;  ///< loop thread only
  std::set<Source*> unfinished_;                                   ///< loop thread only

  std::mutex mutex_;
  std::vector<Function> posted_;
  std::map<TimerId, Timer> timers_;
  TimerId last_timer_ = 0;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace tenter::wire
