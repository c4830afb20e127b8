// SPDX-License-Identifier: Apache-2.0
// Holds what OpenMP does for the calling thread to one thread, as long as it lives.
//
// Debian's CHOLMOD opens four OpenMP threads in its supernodal loops whatever OMP_NUM_THREADS says,
// and is several times slower for it on two cores. The one thing that stops it is
// omp_set_max_active_levels(0), which libgomp keeps per calling thread.
#pragma once

// <omp.h> is the compiler's own, and clang's belongs to a runtime that CHOLMOD does not use.
extern "C" int omp_get_max_active_levels();
extern "C" void omp_set_max_active_levels(int levels);

namespace tenter {

class OneThread {
 public:
  OneThread() : levels_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~OneThread() { omp_set_max_active_levels(levels_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int levels_;
};

}  // namespace tenter
