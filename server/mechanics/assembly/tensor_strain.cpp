// SPDX-License-Identifier: GPL-3.0-or-later
// Strains of chunk_strain.h that are functions of C: those of membranes (3 entries of z) and of
// solids (6), from strain_measure.h and solid_strain.h.
#include "server/mechanics/assembly/chunk_strain.h"
#include "server/mechanics/solid_strain.h"
#include "server/mechanics/strain_measure.h"

namespace tenter::mechanics {
namespace {

/// The names of a measure's derivatives, and how many entries C has.
struct Membrane {
  static constexpr int kZ = 3;
  using Measure = StrainMeasure;
  using Value = StrainValue;
  static const Eigen::Vector3d& first(const Value& v, int i) { return v.by_c[i]; }
  static const Eigen::Matrix3d& second(const Value& v, int i) { return v.by_cc[i]; }
};
struct Solid {
  static constexpr int kZ = 6;
  using Measure = SolidStrain;
  using Value = SolidStrainValue;
  static const Vector6d& first(const Value& v, int i) { return v.by_z[i]; }
  static const Matrix6d& second(const Value& v, int i) { return v.by_zz[i]; }
};

/// S_ij, of which the batch holds the upper triangle.
const double* tangent_of(const LawBatch& law, int i, int j) {
  return i <= j ? law.tangent[i][j] : law.tangent[j][i];
}

/// eps_i = b_i . z + constant.
template <class Kind>
class LinearStrain final : public ChunkStrain {
 public:
  explicit LinearStrain(const typename Kind::Measure& measure) : ChunkStrain(measure.count()) {
    typename Kind::Value at_zero;
    measure.evaluate(Vector::Zero(), at_zero);
    for (int i = 0; i < count(); ++i) {
      b_[i] = Kind::first(at_zero, i);
      constant_[i] = at_zero.value[i];
    }
  }

  void strains(const double* z, int, int elements, double* value) const override {
    for (int i = 0; i < count(); ++i) {
      for (int e = 0; e < elements; ++e) {
        double sum = b_[i][0] * z[e];
        for (int k = 1; k < kZ; ++k) sum += b_[i][k] * z[k * kChunk + e];
        value[i * kChunk + e] = sum + constant_[i];
      }
    }
  }

  void chain(const double*, int, const LawBatch& law, const double* measure, double* psi_z,
             double* psi_zz) const override {
    for (int i = 0; i < count(); ++i) {
      for (int k = 0; k < kZ; ++k) {
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
        double* row = psi_zz;
        for (int k = 0; k < kZ; ++k) {
          for (int l = k; l < kZ; ++l, row += kChunk) {
            const double bb = b_[i][k] * b_[j][l];
            if (bb == 0.0) continue;
            for (int e = 0; e < law.count; ++e) row[e] += bb * measure[e] * tangent[e];
          }
        }
      }
    }
  }

 private:
  static constexpr int kZ = Kind::kZ;
  using Vector = Eigen::Matrix<double, kZ, 1>;
  Vector b_[kMaxStrains];
  double constant_[kMaxStrains] = {};
};

template <class Kind>
class TensorStrain final : public ChunkStrain {
 public:
  explicit TensorStrain(const typename Kind::Measure& measure)
      : ChunkStrain(measure.count()), measure_(measure) {}

  void strains(const double* z, int, int elements, double* value) const override {
    typename Kind::Value strain;
    for (int e = 0; e < elements; ++e) {
      measure_.evaluate(entries(z, e), strain);
      for (int i = 0; i < count(); ++i) value[i * kChunk + e] = strain.value[i];
    }
  }

  void chain(const double* z, int, const LawBatch& law, const double* measure, double* psi_z,
             double* psi_zz) const override {
    typename Kind::Value strain;
    for (int e = 0; e < law.count; ++e) {
      measure_.evaluate(entries(z, e), strain);
      double stress[kMaxStrains] = {};
      double tangent[kMaxStrains][kMaxStrains] = {};
      Vector gradient = Vector::Zero();
      Matrix hessian = Matrix::Zero();
      for (int i = 0; i < count(); ++i) {
        stress[i] = law.stress[i][e];
        gradient += stress[i] * Kind::first(strain, i);
      }
      for (int k = 0; k < kZ; ++k) psi_z[k * kChunk + e] += measure[e] * gradient[k];
      if (!psi_zz) continue;
      for (int i = 0; i < count(); ++i) {
        hessian += stress[i] * Kind::second(strain, i);
        for (int j = 0; j < count(); ++j) {
          tangent[i][j] = tangent_of(law, i, j)[e];
          hessian += tangent[i][j] * Kind::first(strain, i) * Kind::first(strain, j).transpose();
        }
      }
      add_near_pairs(strain.near, strain.near_count, strain.value, stress, tangent, hessian);
      double* row = psi_zz + e;
      for (int k = 0; k < kZ; ++k)
        for (int l = k; l < kZ; ++l, row += kChunk) *row += measure[e] * hessian(k, l);
    }
  }

 private:
  static constexpr int kZ = Kind::kZ;
  using Vector = Eigen::Matrix<double, kZ, 1>;
  using Matrix = Eigen::Matrix<double, kZ, kZ>;

  static Vector entries(const double* z, int e) {
    Vector c;
    for (int k = 0; k < kZ; ++k) c[k] = z[k * kChunk + e];
    return c;
  }

  typename Kind::Measure measure_;
};

template <class Kind>
Expected<std::shared_ptr<const ChunkStrain>> make(const model::StrainMeasure& description) {
  const auto measure = Kind::Measure::make(description);
  if (!measure) return tl::unexpected(measure.error());
  std::shared_ptr<const ChunkStrain> strain;
  if (measure->is_linear())
    strain = std::make_shared<LinearStrain<Kind>>(*measure);
  else
    strain = std::make_shared<TensorStrain<Kind>>(*measure);
  return strain;
}

}  // namespace

Expected<std::shared_ptr<const ChunkStrain>> membrane_strain(
    const model::StrainMeasure& description) {
  return make<Membrane>(description);
}

Expected<std::shared_ptr<const ChunkStrain>> solid_strain(const model::StrainMeasure& description) {
  return make<Solid>(description);
}

}  // namespace tenter::mechanics
