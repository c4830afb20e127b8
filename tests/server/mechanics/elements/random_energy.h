// SPDX-License-Identifier: GPL-3.0-or-later
// An energy for each element, different for all of them: psi = a . z + z'h z / 2.
#pragma once

#include <vector>

#include "server/mechanics/elements/gradient_elements.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::mechanics {

class RandomEnergy {
 public:
  RandomEnergy(int elements, int entries, unsigned seed) : entries_(entries) {
    testing::Numbers numbers(seed);
    for (int i = 0; i < elements * entries; ++i) a_.push_back(numbers.between(-1.0, 1.0));
    for (int i = 0; i < elements * entries * (entries + 1) / 2; ++i)
      h_.push_back(numbers.between(-1.0, 1.0));
  }

  /// psi, psi_z and psi_zz of `count` elements from `first`, times their measure, in chunk layout.
  double evaluate(const std::vector<double>& measure, int first, int count, const double* z,
                  double* psi_z, double* psi_zz) const {
    double energy = 0.0;
    for (int e = 0; e < count; ++e) {
      const auto element = static_cast<std::size_t>(first + e);
      const double m = measure[element];
      std::size_t at = element * static_cast<std::size_t>(entries_ * (entries_ + 1) / 2);
      for (int k = 0; k < entries_; ++k) {
        const double a =
            a_[element * static_cast<std::size_t>(entries_) + static_cast<std::size_t>(k)];
        psi_z[k * kChunk + e] = m * a;
        energy += m * a * z[k * kChunk + e];
      }
      int row = 0;
      for (int k = 0; k < entries_; ++k) {
        for (int l = k; l < entries_; ++l, ++row, ++at) {
          const double h = m * h_[at];
          const double zk = z[k * kChunk + e];
          const double zl = z[l * kChunk + e];
          psi_zz[row * kChunk + e] = h;
          energy += (k == l ? 0.5 : 1.0) * h * zk * zl;
          psi_z[k * kChunk + e] += h * zl;
          if (k != l) psi_z[l * kChunk + e] += h * zk;
        }
      }
    }
    return energy;
  }

 private:
  int entries_;
  std::vector<double> a_, h_;
};

}  // namespace tenter::mechanics
