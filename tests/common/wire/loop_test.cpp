// SPDX-License-Identifier: Apache-2.0
#include "common/wire/loop.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace tenter::wire {
namespace {

using std::chrono::milliseconds;

TEST(Loop, RunsWhatIsPostedInOrderAndInItsThread) {
  Loop loop;
  std::vector<int> order;
  for (int i = 0; i < 1000; ++i) loop.post([&, i] { order.push_back(i); });
  bool inside = false;
  loop.run([&] {
    inside = loop.in_thread();
    loop.run([&] { order.push_back(-1); });  // at once in its own thread
  });
  EXPECT_TRUE(inside);
  EXPECT_FALSE(loop.in_thread());
  ASSERT_EQ(order.size(), 1001u);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

TEST(Loop, ManyThreadsMayPost) {
  Loop loop;
  int count = 0;  // only the loop touches it
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 2000; ++i) loop.post([&] { ++count; });
    });
  for (std::thread& thread : threads) thread.join();
  loop.run([] {});
  EXPECT_EQ(count, 8000);
}

TEST(Loop, TimersRunAgainOrOnceAndStopWhenCancelled) {
  Loop loop;
  std::atomic<int> ticks{0}, once{0};
  const auto every = loop.every(milliseconds(5), [&] { ++ticks; });
  loop.after(milliseconds(5), [&] { ++once; });
  const auto never = loop.after(milliseconds(20), [&] { once += 100; });
  loop.cancel(never);
  while (ticks < 5) std::this_thread::sleep_for(milliseconds(1));
  loop.cancel(every);
  loop.run([] {});
  const int then = ticks;
  std::this_thread::sleep_for(milliseconds(40));
  EXPECT_EQ(ticks, then);
  EXPECT_EQ(once, 1);
}

TEST(Loop, EndsWithWorkWaiting) {
  auto loop = std::make_unique<Loop>();
  loop->every(milliseconds(1), [] {});
  for (int i = 0; i < 100; ++i) loop->post([] {});
  loop.reset();
}

}  // namespace
}  // namespace tenter::wire
