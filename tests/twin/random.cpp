// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/random.h"

#include <cmath>
#include <numbers>

namespace tenter::twin {

double Random::uniform() {
  return static_cast<double>(engine_() >> 11) * 0x1.0p-53;
}

double Random::log_uniform(double lo, double hi) {
  return lo * std::pow(hi / lo, uniform());
}

int Random::below(int count) {
  return static_cast<int>(uniform() * count);
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  const double angle = 2.0 * std::numbers::pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

// FNV-1a over the name, then two rounds of the splitmix64 finaliser
std::uint64_t stream_seed(std::uint64_t seed, std::string_view stream) {
  std::uint64_t h = 0xcbf29ce484222325ULL ^ (seed * 0x9e3779b97f4a7c15ULL);
  for (const char c : stream) {
    h ^= static_cast<unsigned char>(c);
    h *= 0x100000001b3ULL;
  }
  for (int round = 0; round < 2; ++round) {
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    h ^= h >> 31;
  }
  return h;
}

}  // namespace tenter::twin
