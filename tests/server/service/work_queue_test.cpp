// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/work_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <map>

namespace tenter::service {
namespace {

using std::chrono::milliseconds;

void wait_until_empty(const WorkQueue& queue, const std::atomic<int>& done, int count) {
  for (int i = 0; i < 5000 && (done < count || queue.waiting() > 0); ++i)
    std::this_thread::sleep_for(milliseconds(1));
}

TEST(WorkQueue, OneKeyRunsInOrderAndNeverTwiceAtATime) {
  std::atomic<int> done{0}, together{0}, overlaps{0};
  std::vector<int> order;
  WorkQueue queue({.threads = 4, .per_key = 100, .total = 100});
  for (int i = 0; i < 100; ++i)
    ASSERT_TRUE(queue.add("a", [&, i] {
      if (++together > 1) ++overlaps;
      order.push_back(i);
      --together;
      ++done;
    }));
  wait_until_empty(queue, done, 100);
  ASSERT_EQ(order.size(), 100u);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  EXPECT_EQ(overlaps, 0);
}

TEST(WorkQueue, ABusyKeyDoesNotHoldUpTheOthers) {
  std::promise<void> gate;
  std::atomic<int> done{0};
  WorkQueue queue({.threads = 2, .per_key = 100, .total = 1000});
  const auto opened = gate.get_future().share();
  for (int i = 0; i < 50; ++i) queue.add("slow", [&, opened] { opened.wait(); });
  for (int i = 0; i < 20; ++i) queue.add("quick", [&] { ++done; });
  for (int i = 0; i < 5000 && done < 20; ++i) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(done, 20);
  gate.set_value();
}

TEST(WorkQueue, KeysTakeTurns) {
  std::promise<void> gate;
  const auto opened = gate.get_future().share();
  std::vector<std::string> order;
  std::atomic<int> done{0};
  WorkQueue queue({.threads = 1, .per_key = 100, .total = 1000});
  queue.add("first", [&] { opened.wait(); });
  for (const char* key : {"a", "a", "a", "b", "b"})
    queue.add(key, [&, key] {
      order.push_back(key);
      ++done;
    });
  gate.set_value();
  wait_until_empty(queue, done, 5);
  EXPECT_EQ(order, (std::vector<std::string>{"a", "b", "a", "b", "a"}));
}

TEST(WorkQueue, RefusesBeyondItsBounds) {
  std::promise<void> gate;
  const auto opened = gate.get_future().share();
  WorkQueue queue({.threads = 1, .per_key = 3, .total = 5});
  ASSERT_TRUE(queue.add("running", [&] { opened.wait(); }));
  while (queue.waiting() > 0) std::this_thread::sleep_for(milliseconds(1));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.add("a", [] {}));
  EXPECT_FALSE(queue.add("a", [] {}));
  EXPECT_TRUE(queue.add("b", [] {}));
  EXPECT_TRUE(queue.add("c", [] {}));
  EXPECT_FALSE(queue.add("d", [] {}));
  gate.set_value();
}

TEST(WorkQueue, EndsWithWorkWaiting) {
  WorkQueue queue({.threads = 2, .per_key = 100, .total = 1000});
  for (int i = 0; i < 100; ++i)
    queue.add("a", [] { std::this_thread::sleep_for(milliseconds(2)); });
}

}  // namespace
}  // namespace tenter::service
