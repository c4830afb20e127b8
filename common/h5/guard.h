// SPDX-License-Identifier: Apache-2.0
// Runs a reading function in a child process with limits first, so that a file that crashes or
// hangs HDF5 costs a child and becomes an Error.
//
//   Expected<void> safe = run_guarded(path, [&]() -> Expected<void> { ... read everything ... });
//
// The child is a fork of the caller: it inherits the caller's memory, takes at most `memory_bytes`
// more (not under a sanitizer, which reserves terabytes), `cpu_seconds` of processor and
// `wall_seconds` of time. An Error of the function comes back as it is. May be called from any
// thread of a threaded process: HDF5's lock of this program is held across the fork.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/base/error.h"

namespace tenter::h5 {

struct GuardLimits {
  std::uint64_t memory_bytes = std::uint64_t{3} << 30;
  unsigned cpu_seconds = 20;
  unsigned wall_seconds = 40;
};

Expected<void> run_guarded(const std::string& path, const std::function<Expected<void>()>& read,
                           const GuardLimits& limits = {});

}  // namespace tenter::h5
