// SPDX-License-Identifier: GPL-3.0-or-later
// What the kill test and its daemon say to each other: one command per line in, one reply per line
// out.
//
//   submit REQUEST NONCE SLEEP_MS   -> submitted REQUEST JOB         (or: error ...)
//   upload SEED SIZE                -> uploaded SHA256
//   kill_worker                     -> killed PID                    (0: none was running)
//   worker                          -> worker PID                    (0: none is running)
//   drain                           -> drained                       once nothing is queued or
//   running dump                            -> job JOB STATE SPEC RESULT ATTEMPT ..., capture
//   SHA256 ..., end
#pragma once

#include <cstdint>
#include <random>
#include <string>

namespace tenter::fault {

/// The bytes that `upload SEED SIZE` stands for.
inline std::string bytes_of_seed(unsigned seed, std::size_t size) {
  std::mt19937_64 random(seed);
  std::string bytes(size, 0);
  for (std::size_t i = 0; i + 8 <= size; i += 8) {
    const std::uint64_t word = random();
    for (std::size_t b = 0; b < 8; ++b) bytes[i + b] = static_cast<char>(word >> (8 * b));
  }
  return bytes;
}

}  // namespace tenter::fault
