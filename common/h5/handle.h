// SPDX-License-Identifier: Apache-2.0
// Private to this folder: identifiers of HDF5 that close themselves, and the lock that every call
// takes.
#pragma once

#include <hdf5.h>

#include <mutex>
#include <utility>

namespace tenter::h5 {

/// One lock for all use of HDF5 in the process. Recursive, because destructors close handles under
/// it.
std::recursive_mutex& library_lock();

/// In a fresh child of fork(), made while the caller held the lock: gives the child a free one. (A
/// recursive mutex knows its owner by thread number, which is another one there, so it could not be
/// unlocked.)
void renew_library_lock_in_child();

/// Owns one identifier of any type.
class Handle {
 public:
  explicit Handle(hid_t id = -1) : id_(id) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  hid_t get() const { return id_; }
  hid_t release() { return std::exchange(id_, -1); }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_;
};

}  // namespace tenter::h5
