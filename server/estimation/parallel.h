// SPDX-License-Identifier: GPL-3.0-or-later
// Independent pieces of work on as many threads as wanted, with the same result for any number.
//
//   in_parallel(threads, count, [&](int thread, int i) { results[i] = ...; });
//
// Each piece writes only what is its own; which thread takes it is left to chance, so `thread`
// (from 0) may choose scratch but no number that is kept. Threads end before the call does.
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace tenter::estimation {

inline void in_parallel(int threads, int count, const std::function<void(int, int)>& work) {
  std::atomic<int> next{0};
  const auto loop = [&](int thread) {
    for (int i = next++; i < count; i = next++) work(thread, i);
  };
  std::vector<std::thread> others;
  for (int t = 1; t < std::min(threads, count); ++t) others.emplace_back(loop, t);
  loop(0);
  for (std::thread& other : others) other.join();
}

}  // namespace tenter::estimation
