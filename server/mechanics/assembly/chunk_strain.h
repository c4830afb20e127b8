// SPDX-License-Identifier: GPL-3.0-or-later
// A strain measure on a chunk of elements: from what the elements see (z) to strains, and from
// stresses back to derivatives by z.
//
//   psi_k  += m sum_i sigma_i deps_i/dz_k
//   psi_kl += m sum_i (sigma_i d2eps_i/dz_k dz_l + sum_j S_ij deps_i/dz_k deps_j/dz_l)
//
// z and psi are in the layout of elements/: [row * kChunk + element], psi_kl as the upper triangle,
// row by row. Membranes: z = (C_uu, C_vv, C_uv). Solids: (C_xx, C_yy, C_zz, C_yz, C_xz, C_xy).
// Springs: z = (l/l0)^2. Hinges: z = theta. Near principal stretches have the limit of the pair
// (principal_stretch.h).
//
// Immutable; callable from any thread; no allocation.
#pragma once

#include <memory>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/mechanics/elements/chunk.h"
#include "server/mechanics/law.h"

namespace tenter::mechanics {

class ChunkStrain {
 public:
  virtual ~ChunkStrain() = default;
  int count() const { return count_; }

  /// Strains of `count` elements; value[i * kChunk + e]. `first` is the number of the chunk's first
  /// element.
  virtual void strains(const double* z, int first, int count, double* value) const = 0;

  /// Adds to psi_z, and to psi_zz where it is not null; stresses (and then tangents) are those of
  /// `law`, `measure[e]` is m.
  virtual void chain(const double* z, int first, const LawBatch& law, const double* measure,
                     double* psi_z, double* psi_zz) const = 0;

 protected:
  explicit ChunkStrain(int count) : count_(count) {}

 private:
  int count_;
};

/// Any membrane measure; those linear in z are faster.
Expected<std::shared_ptr<const ChunkStrain>> membrane_strain(const model::StrainMeasure& measure);

/// Any measure of solids; those linear in z are faster.
Expected<std::shared_ptr<const ChunkStrain>> solid_strain(const model::StrainMeasure& measure);

/// l/l0 - 1, thesis (3.1). A collapsed spring keeps its derivatives at kCollapsedStretch.
std::shared_ptr<const ChunkStrain> spring_strain();

/// (theta - theta_0)/h0, thesis (3.5); one entry a hinge.
std::shared_ptr<const ChunkStrain> bending_strain(std::vector<double> rest_angle_rad,
                                                  const std::vector<double>& height_m);

}  // namespace tenter::mechanics
