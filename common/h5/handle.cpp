// SPDX-License-Identifier: Apache-2.0
#include "common/h5/handle.h"

#include <new>

namespace tenter::h5 {

std::recursive_mutex& library_lock() {
  // never destroyed: handles of static objects may close after main
  static std::recursive_mutex* const lock = [] {
    H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    return new std::recursive_mutex;
  }();
  // the error stack of a thread-safe build belongs to the thread, so each silences its own; under
  // the lock, as every call: HDF5 has a lock inside that a fork must not meet
  thread_local const herr_t silenced = [] {
    const std::lock_guard held(*lock);
    return H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }();
  static_cast<void>(silenced);
  return *lock;
}

void renew_library_lock_in_child() {
  new (&library_lock()) std::recursive_mutex;
}

}  // namespace tenter::h5
