// SPDX-License-Identifier: GPL-3.0-or-later
// Strain measures of a solid: what a term on tetrahedra and hexahedra looks at.
//
// A measure maps z = (C_xx, C_yy, C_zz, C_yz, C_xz, C_xy), the right Cauchy-Green tensor F'F in
// rest axes, to one to three scalar strains with exact first and second derivatives by z; all are
// without unit and zero at rest. With I_1 = tr C, I_2 = (I_1^2 - tr C^2)/2, I_3 = det C = J^2:
//
//   solid_green_xx, _yy, _zz   (C_ii - 1)/2              solid_invariant_1, _2   I_1 - 3, I_2 - 3
//   solid_green_yz, _xz, _xy   C_ij                      solid_isochoric_1       I_1 J^(-2/3) - 3
//   solid_green_normal         the three C_ii            solid_isochoric_2       I_2 J^(-4/3) - 3
//   solid_green_shear          the three C_ij            solid_log_volume        ln J
//   solid_green_trace          tr E, E = (C - I)/2       solid_volume            J - 1
//   solid_green_square         tr E^2                    solid_neo_hookean       I_1 - 3 - 2 ln J
//   solid_fibre                |F a| - 1                 solid_green_fibre       (|F a|^2 - 1)/2
//   solid_principal_stretches  lambda_i - 1, falling     (see principal_stretch.h for near ones)
//
// a = (cos e cos t, cos e sin t, sin e) with t = angle_rad, e = elevation_rad. J is the positive
// root: whether an element is turned inside out is seen by det F only, which the assembly checks. A
// collapsed element (J or a stretch below kCollapsedStretch) gives finite numbers.
//
// Stateless; callable from any thread; no allocation.
//
//   auto measure = SolidStrain::make({"solid_log_volume"});
//   SolidStrainValue strain;
//   measure->evaluate(z, strain);  // value[i], by_z[i], by_zz[i] for i < measure->count()
#pragma once

#include <Eigen/Core>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/mechanics/principal_stretch.h"
#include "server/mechanics/strain_measure.h"

namespace tenter::mechanics {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct SolidStrainValue {
  double value[kMaxStrains] = {0.0, 0.0, 0.0};
  Vector6d by_z[kMaxStrains];
  Matrix6d by_zz[kMaxStrains];
  int near_count = 0;  ///< for add_near_pairs; zero but for principal stretches
  NearPair<6> near[3];
};

class SolidStrain {
 public:
  using Function = void (*)(const Vector6d& z, const Vector6d& fibre, SolidStrainValue& out);

  /// bad_input for a name that is no solid measure.
  static Expected<SolidStrain> make(const model::StrainMeasure& description);

  int count() const { return count_; }
  /// Linear in z: by_z is the same at every strain and by_zz is zero.
  bool is_linear() const { return is_linear_; }
  void evaluate(const Vector6d& z, SolidStrainValue& out) const {
    out.near_count = 0;
    function_(z, fibre_, out);
  }

 private:
  Function function_ = nullptr;
  int count_ = 1;
  bool is_linear_ = false;
  Vector6d fibre_ = Vector6d::Zero();  ///< weights of z in a.C.a
};

}  // namespace tenter::mechanics
