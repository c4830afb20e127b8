// SPDX-License-Identifier: GPL-3.0-or-later
// Strain measures of a membrane: what a term looks at.
//
// A measure maps the right Cauchy-Green tensor in material axes, c = (C_uu, C_vv, C_uv) with u =
// weft, v = warp, to one or two scalar strains, with exact first and second derivatives by c. Being
// functions of C they are objective by construction; C_uu = |w_u|^2, C_vv = |w_v|^2, C_uv = w_u .
// w_v in the notation of thesis 3.3.1.
//
//   green_u, green_v     (C_ii - 1)/2   (3.3)      soft_u, soft_v      sqrt(C_ii) - 1   (3.4)
//   green_uv             C_uv           (3.3)      spring_u, spring_v  sqrt(C_ii) - 1   (3.1)
//   green_trace          (C_uu + C_vv)/2 - 1       spring_d1, d2       edge at +45, -45 degrees
//   green_deviator       ((C_uu - C_vv)/2, C_uv)   fibre(theta)        sqrt(a.C.a) - 1
//   green_pair           (green_u, green_v)        fibre_pair(theta)   at +theta and -theta
//   green_square         tr E^2                    green_fibre, _pair  (a.C.a - 1)/2
//   area                 sqrt(det C) - 1
//   principal_stretches  both minus one, larger first (see principal_stretch.h for near ones)
//
// A stretch or an area below kCollapsedStretch keeps its derivatives at that: finite answers.
//
// Stateless; callable from any thread; no allocation.
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/mechanics/principal_stretch.h"

namespace tenter::mechanics {

constexpr int kMaxStrains = 3;  ///< the principal stretches of a solid

/// Strains of one measure at one state. Rows of `by_c` and entries of `by_cc` belong to the
/// strains.
struct StrainValue {
  double value[kMaxStrains] = {0.0, 0.0, 0.0};
  Eigen::Vector3d by_c[kMaxStrains];
  Eigen::Matrix3d by_cc[kMaxStrains];
  int near_count = 0;  ///< for add_near_pairs; zero but for principal stretches
  NearPair<3> near[1];
};

class StrainMeasure {
 public:
  using Function = void (*)(const Eigen::Vector3d& c, double angle_rad, StrainValue& out);

  /// bad_input for a name that is not in the catalogue.
  static Expected<StrainMeasure> make(const model::StrainMeasure& description);

  int count() const { return count_; }
  /// Linear in c: by_c is the same at every strain and by_cc is zero.
  bool is_linear() const { return is_linear_; }
  void evaluate(const Eigen::Vector3d& c, StrainValue& out) const {
    out.near_count = 0;
    function_(c, angle_rad_, out);
  }

 private:
  Function function_ = nullptr;
  int count_ = 1;
  bool is_linear_ = false;
  double angle_rad_ = 0.0;
};

}  // namespace tenter::mechanics
