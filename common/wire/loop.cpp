// SPDX-License-Identifier: Apache-2.0
#include "common/wire/loop.h"

#include <algorithm>
#include <future>
#include <optional>

#include "common/wire/loop_impl.h"

namespace tenter::wire {

namespace dds = eprosima::fastdds::dds;

Loop::Impl::Impl() {
  wait_set_.attach_condition(wake_);
  thread_ = std::thread([this] { body(); });
}

Loop::Impl::~Impl() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.set_trigger_value(true);
  thread_.join();
  wait_set_.detach_condition(wake_);
}

void Loop::Impl::post(Function function) {
  {
    std::lock_guard lock(mutex_);
    posted_.push_back(std::move(function));
    if (posted_.size() > 1) return;  // whoever posted the first one woke the thread
  }
  wake_.set_trigger_value(true);
}

Loop::TimerId Loop::Impl::add_timer(std::chrono::milliseconds delay,
                                    std::chrono::milliseconds interval, Function function) {
  TimerId id;
  {
    std::lock_guard lock(mutex_);
    id = ++last_timer_;
    timers_[id] = Timer{Clock::now() + delay, interval, std::move(function)};
  }
  if (std::this_thread::get_id() != thread_id_.load()) wake_.set_trigger_value(true);
  return id;
}

void Loop::Impl::cancel(TimerId timer) {
  std::lock_guard lock(mutex_);
  timers_.erase(timer);
}

void Loop::Impl::attach(dds::Condition& condition, Source& source) {
  sources_[&condition] = &source;
  wait_set_.attach_condition(condition);
}

void Loop::Impl::detach(dds::Condition& condition) {
  wait_set_.detach_condition(condition);
  const auto found = sources_.find(&condition);
  if (found == sources_.end()) return;
  unfinished_.erase(found->second);
  sources_.erase(found);
}

void Loop::Impl::body() {
  thread_id_ = std::this_thread::get_id();
  dds::ConditionSeq active;
  for (;;) {
    run_posted();
    run_timers();
    {
      std::lock_guard lock(mutex_);
      if (stop_) return;
    }
    const auto pause = unfinished_.empty() ? until_next_timer() : Clock::duration::zero();
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(pause).count();
    active.clear();
    wait_set_.wait(active,
                   eprosima::fastrtps::Duration_t(static_cast<std::int32_t>(ns / 1000000000),
                                                  static_cast<std::uint32_t>(ns % 1000000000)));
    std::set<Source*> ready = unfinished_;
    for (dds::Condition* condition : active) {
      if (condition == &wake_) {
        wake_.set_trigger_value(false);
        continue;
      }
      const auto found = sources_.find(condition);
      if (found != sources_.end()) ready.insert(found->second);
    }
    for (Source* source : ready) {
      const bool more = source->drain();
      if (more)
        unfinished_.insert(source);
      else
        unfinished_.erase(source);
    }
  }
}

void Loop::Impl::run_posted() {
  std::vector<Function> functions;
  {
    std::lock_guard lock(mutex_);
    functions.swap(posted_);
  }
  for (Function& function : functions) function();
}

void Loop::Impl::run_timers() {
  const auto now = Clock::now();
  std::vector<TimerId> due;
  {
    std::lock_guard lock(mutex_);
    for (const auto& [id, timer] : timers_)
      if (timer.due <= now) due.push_back(id);
  }
  for (TimerId id : due) {
    Function function;
    {
      std::lock_guard lock(mutex_);
      const auto found = timers_.find(id);
      if (found == timers_.end()) continue;  // cancelled by an earlier one of this round
      if (found->second.interval.count() > 0) {
        function = found->second.function;
        found->second.due = Clock::now() + found->second.interval;
      } else {
        function = std::move(found->second.function);
        timers_.erase(found);
      }
    }
    function();
  }
}

Loop::Impl::Clock::duration Loop::Impl::until_next_timer() {
  std::lock_guard lock(mutex_);
  if (!posted_.empty()) return Clock::duration::zero();
  Clock::duration pause = std::chrono::seconds(10);
  const auto now = Clock::now();
  for (const auto& [id, timer] : timers_) pause = std::min(pause, timer.due - now);
  return std::max(pause, Clock::duration::zero());
}

Loop::Loop() : impl_(std::make_unique<Impl>()) {}
Loop::~Loop() = default;

void Loop::post(Function function) {
  impl_->post(std::move(function));
}

void Loop::run(const Function& function) {
  if (in_thread()) return function();
  std::promise<void> done;
  impl_->post([&] {
    function();
    done.set_value();
  });
  done.get_future().wait();
}

bool Loop::in_thread() const {
  return std::this_thread::get_id() == impl_->thread_id_.load();
}

Loop::TimerId Loop::every(std::chrono::milliseconds interval, Function function) {
  return impl_->add_timer(interval, interval, std::move(function));
}

Loop::TimerId Loop::after(std::chrono::milliseconds delay, Function function) {
  return impl_->add_timer(delay, std::chrono::milliseconds(0), std::move(function));
}

void Loop::cancel(TimerId timer) {
  impl_->cancel(timer);
}

}  // namespace tenter::wire
