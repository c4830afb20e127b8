// SPDX-License-Identifier: GPL-3.0-or-later
// Processor time of the calling thread: what a bench counts beside other work on the machine.
#pragma once

#include <ctime>

namespace tenter::timing {

inline double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double thread_cpu_ms() {
  return 1e3 * thread_cpu_seconds();
}

}  // namespace tenter::timing
