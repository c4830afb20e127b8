// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers of the twins: the same seed gives the same capture with every standard library.
//
// std::mt19937_64 is fixed by the standard, std::normal_distribution is not; so the transforms are
// ours.
//
//   Random noise(stream_seed(seed, "noise"));
//   double reading = force + sigma * noise.normal();
#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace tenter::twin {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  explicit Random(const std::mt19937_64& engine) : engine_(engine) {}

  /// Uniform in [0, 1), 53 bits.
  double uniform();
  double uniform(double lo, double hi) { return lo + (hi - lo) * uniform(); }
  /// Uniform in the logarithm; lo, hi > 0.
  double log_uniform(double lo, double hi);
  /// Integer in [0, count).
  int below(int count);
  /// -1 or +1.
  double sign() { return uniform() < 0.5 ? -1.0 : 1.0; }
  /// Standard normal (Box-Muller; both values of a pair are used).
  double normal();

 private:
  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// Seed of one named stream of a case: streams of one seed are independent of each other.
std::uint64_t stream_seed(std::uint64_t seed, std::string_view stream);

}  // namespace tenter::twin
