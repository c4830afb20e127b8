// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/sit.h"

#include <atomic>
#include <cstddef>
#include <mutex>
#include <thread>

namespace tenter::exam {

std::vector<Entry> sit(const std::vector<Question>& questions, int threads,
                       const std::function<void(const Entry&)>& done) {
  std::vector<Entry> entries(questions.size());
  std::atomic<std::size_t> next = 0;
  std::mutex telling;
  const auto work = [&] {
    for (std::size_t i = next++; i < questions.size(); i = next++) {
      Entry& entry = entries[i];
      entry.question = questions[i];
      entry.answer = ask(entry.question);
      entry.mark = mark(entry.question, entry.answer);
      const std::lock_guard lock(telling);
      done(entry);
    }
  };
  std::vector<std::jthread> pool;
  for (int t = 1; t < threads; ++t) pool.emplace_back(work);
  work();
  pool.clear();
  return entries;
}

}  // namespace tenter::exam
