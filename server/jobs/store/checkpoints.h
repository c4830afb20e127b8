// SPDX-License-Identifier: GPL-3.0-or-later
// Where long jobs keep what they have done, so that the next attempt need not do it again.
//
//   checkpoints/engine              the worker program that they are of
//   checkpoints/<sha256 of spec>/   a job's own; made by its worker with its first checkpoint
//
// Named by specification, like results: an attempt after a crash, a restart of the daemon, a retry
// or a second job of the same work finds them. Results are the same bytes with and without. Another
// worker program drops them all. They go when the work has succeeded, and the oldest of the others
// go beyond kMostCheckpoints or kMostCheckpointBytes. Losing them costs time, never a result, so
// trouble with them is no error. One thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>

#include "common/base/error.h"

namespace tenter::jobs {

inline constexpr std::size_t kMostCheckpoints = 200;
inline constexpr std::uint64_t kMostCheckpointBytes = 2ull << 30;

class Checkpoints {
 public:
  /// Makes the folder. `engine` names the worker program.
  static Expected<Checkpoints> open(std::filesystem::path folder, const std::string& engine);

  std::filesystem::path of(const std::string& spec_sha256) const { return folder_ / spec_sha256; }
  void drop(const std::string& spec_sha256);
  /// Keeps to the limits; those in `running` stay whatever they take.
  void prune(const std::set<std::string>& running, std::size_t most = kMostCheckpoints,
             std::uint64_t most_bytes = kMostCheckpointBytes);

 private:
  explicit Checkpoints(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path folder_;
};

}  // namespace tenter::jobs
