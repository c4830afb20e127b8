// SPDX-License-Identifier: GPL-3.0-or-later
// Springs and hinges of chunk_strain.h; functions of C are in tensor_strain.cpp.
#include "server/mechanics/assembly/chunk_strain.h"

#include <algorithm>
#include <cmath>

#include "server/mechanics/principal_stretch.h"

namespace tenter::mechanics {
namespace {

class SpringStrain final : public ChunkStrain {
 public:
  SpringStrain() : ChunkStrain(1) {}

  void strains(const double* z, int, int elements, double* value) const override {
    for (int e = 0; e < elements; ++e) value[e] = std::sqrt(z[e]) - 1.0;
  }

  // lambda = sqrt(z):  deps/dz = 1/(2 lambda),  d2eps/dz2 = -1/(4 lambda^3)
  void chain(const double* z, int, const LawBatch& law, const double* measure, double* psi_z,
             double* psi_zz) const override {
    for (int e = 0; e < law.count; ++e) {
      const double lambda = std::max(std::sqrt(z[e]), kCollapsedStretch);
      const double half = 0.5 / lambda;
      psi_z[e] += measure[e] * law.stress[0][e] * half;
      if (psi_zz)
        psi_zz[e] += measure[e] * half * half * (law.tangent[0][0][e] - law.stress[0][e] / lambda);
    }
  }
};

class BendingStrain final : public ChunkStrain {
 public:
  BendingStrain(std::vector<double> rest_angle, const std::vector<double>& height)
      : ChunkStrain(1), rest_angle_(std::move(rest_angle)) {
    for (const double h : height) per_height_.push_back(1.0 / h);
  }

  void strains(const double* z, int first, int elements, double* value) const override {
    const double* rest = rest_angle_.data() + first;
    const double* per_height = per_height_.data() + first;
    for (int e = 0; e < elements; ++e) value[e] = (z[e] - rest[e]) * per_height[e];
  }

  void chain(const double*, int first, const LawBatch& law, const double* measure, double* psi_z,
             double* psi_zz) const override {
    const double* per_height = per_height_.data() + first;
    for (int e = 0; e < law.count; ++e) psi_z[e] += measure[e] * law.stress[0][e] * per_height[e];
    if (!psi_zz) return;
    for (int e = 0; e < law.count; ++e)
      psi_zz[e] += measure[e] * law.tangent[0][0][e] * per_height[e] * per_height[e];
  }

 private:
  std::vector<double> rest_angle_, per_height_;
};

}  // namespace

std::shared_ptr<const ChunkStrain> spring_strain() {
  return std::make_shared<SpringStrain>();
}

std::shared_ptr<const ChunkStrain> bending_strain(std::vector<double> rest_angle_rad,
                                                  const std::vector<double>& height_m) {
  return std::make_shared<BendingStrain>(std::move(rest_angle_rad), height_m);
}

}  // namespace tenter::mechanics
