// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/chunk_strain.h"

#include <algorithm>
#include <cmath>

#include "server/mechanics/strain_measure.h"

namespace tenter::mechanics {
namespace {

/// Entries of the upper triangle of a 3 x 3 matrix, row by row.
constexpr int kUpper[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};

/// S_ij, of which the batch holds the upper triangle.
const double* tangent_of(const LawBatch& law, int i, int j) {
  return i <= j ? law.tangent[i][j] : law.tangent[j][i];
}

Eigen::Vector3d c_of(const double* z, int e) {
  return {z[e], z[kChunk + e], z[2 * kChunk + e]};
}

/// eps_i = b_i . z + constant.
class LinearMembraneStrain final : public ChunkStrain {
 public:
  explicit LinearMembraneStrain(const StrainMeasure& measure) : ChunkStrain(measure.count()) {
    StrainValue at_zero;
    measure.evaluate(Eigen::Vector3d::Zero(), at_zero);
    for (int i = 0; i < count(); ++i) {
      b_[i] = at_zero.by_c[i];
      constant_[i] = at_zero.value[i];
    }
  }

  void strains(const double* z, int, int elements, double* value) const override {
    for (int i = 0; i < count(); ++i)
      for (int e = 0; e < elements; ++e)
        value[i * kChunk + e] = b_[i][0] * z[e] + b_[i][1] * z[kChunk + e] +
                                b_[i][2] * z[2 * kChunk + e] + constant_[i];
  }

  void chain(const double*, int, const LawBatch& law, const double* measure, double* psi_z,
             double* psi_zz) const override {
    for (int i = 0; i < count(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const double b = b_[i][k];
        if (b == 0.0) continue;
        for (int e = 0; e < law.count; ++e)
          psi_z[k * kChunk + e] += b * measure[e] * law.stress[i][e];
      }
    }
    if (!psi_zz) return;
    for (int i = 0; i < count(); ++i) {
      for (int j = 0; j < count(); ++j) {
        const double* tangent = tangent_of(law, i, j);
        for (int row = 0; row < 6; ++row) {
          const double bb = b_[i][kUpper[row][0]] * b_[j][kUpper[row][1]];
          if (bb == 0.0) continue;
          for (int e = 0; e < law.count; ++e)
            psi_zz[row * kChunk + e] += bb * measure[e] * tangent[e];
        }
      }
    }
  }

 private:
  Eigen::Vector3d b_[kMaxStrains];
  double constant_[kMaxStrains] = {};
};

class MembraneStrain final : public ChunkStrain {
 public:
  explicit MembraneStrain(const StrainMeasure& measure)
      : ChunkStrain(measure.count()), measure_(measure) {}

  void strains(const double* z, int, int elements, double* value) const override {
    StrainValue strain;
    for (int e = 0; e < elements; ++e) {
      measure_.evaluate(c_of(z, e), strain);
      for (int i = 0; i < count(); ++i) value[i * kChunk + e] = strain.value[i];
    }
  }

  void chain(const double* z, int, const LawBatch& law, const double* measure, double* psi_z,
             double* psi_zz) const override {
    StrainValue strain;
    for (int e = 0; e < law.count; ++e) {
      measure_.evaluate(c_of(z, e), strain);
      double stress[kMaxStrains] = {};
      double tangent[kMaxStrains][kMaxStrains] = {};
      Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
      Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
      for (int i = 0; i < count(); ++i) {
        stress[i] = law.stress[i][e];
        gradient += stress[i] * strain.by_c[i];
      }
      for (int k = 0; k < 3; ++k) psi_z[k * kChunk + e] += measure[e] * gradient[k];
      if (!psi_zz) continue;
      for (int i = 0; i < count(); ++i) {
        hessian += stress[i] * strain.by_cc[i];
        for (int j = 0; j < count(); ++j) {
          tangent[i][j] = tangent_of(law, i, j)[e];
          hessian += tangent[i][j] * strain.by_c[i] * strain.by_c[j].transpose();
        }
      }
      add_near_pairs(strain.near, strain.near_count, strain.value, stress, tangent, hessian);
      for (int row = 0; row < 6; ++row)
        psi_zz[row * kChunk + e] += measure[e] * hessian(kUpper[row][0], kUpper[row][1]);
    }
  }

 private:
  StrainMeasure measure_;
};

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

Expected<std::shared_ptr<const ChunkStrain>> membrane_strain(
    const model::StrainMeasure& description) {
  auto measure = StrainMeasure::make(description);
  if (!measure) return tl::unexpected(measure.error());
  std::shared_ptr<const ChunkStrain> strain;
  if (measure->is_linear())
    strain = std::make_shared<LinearMembraneStrain>(*measure);
  else
    strain = std::make_shared<MembraneStrain>(*measure);
  return strain;
}

std::shared_ptr<const ChunkStrain> spring_strain() {
  return std::make_shared<SpringStrain>();
}

std::shared_ptr<const ChunkStrain> bending_strain(std::vector<double> rest_angle_rad,
                                                  const std::vector<double>& height_m) {
  return std::make_shared<BendingStrain>(std::move(rest_angle_rad), height_m);
}

}  // namespace tenter::mechanics
