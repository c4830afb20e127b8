// SPDX-License-Identifier: GPL-3.0-or-later
// A sheet that does not pass through itself: no vertex goes through a triangle, and no edge through
// another.
//
//   E = kappa sum over pairs of m b(d)     b(d) = -(d - h)^2 ln(d/h) for d < h, else 0
//
// d: distance of vertex and triangle or of two edges (pair.h), h: the thickness at which they begin
// to feel each other, kappa (N/m): at h/2 a pair presses with 1.2 kappa h. m is 1 but for edges
// that are nearly parallel, c = |u x v|^2 < e, e = |u|^2 |v|^2/1000 at rest: there
// m = (2 - c/e) c/e, since their d has kinks; a vertex of one is as near then. The barrier (Li and
// others, Incremental Potential Contact, 2020, 4 and 5) grows without bound as d goes to 0, and
// longest_fraction() keeps the steps of a minimisation from jumping over it: where nothing touches
// to begin with, nothing ever passes. Without friction.
//
// As stiffness each pair gives kappa m b'' n n' with each node by itself, 2 |w| of it for the
// weight w in d's slope: never less than its coupled curvature, so that steps go downhill, and no
// new entries in the matrix; they converge linearly, the faster the shorter the time step.
//
//   auto contact = SelfContact::make(mesh, 1e-3, 1.0);
//   if (crossings(mesh, x) > 0) ...                        // crossings.h: it begins the wrong way
//   contact->begin(x);
//   share = contact->longest_fraction(x, x_wanted);        // then evaluate between both
//
// Belongs to one thread at a time. Nothing allocates once its lists have grown.
#pragma once

#include "common/base/error.h"
#include "server/mechanics/conditions/node_energy.h"
#include "server/mechanics/contact/near_pairs.h"

namespace tenter::mechanics {

class SelfContact final : public NodeEnergy {
 public:
  /// bad_input: a thickness that is not positive or above half the smallest height of a triangle
  /// (neighbours would press each other at rest), or a stiffness that is not positive.
  static Expected<SelfContact> make(const SurfaceMesh& mesh, double thickness_m,
                                    double stiffness_N_m);

  /// Pairs around x; add() answers there and on the way that longest_fraction() was asked for last.
  void begin(const Eigen::VectorXd& x);
  double longest_fraction(const Eigen::VectorXd& from, const Eigen::VectorXd& to) override;
  void add(const Eigen::VectorXd& x, const LoadOutput& output,
           double positive_share) const override;
  const std::vector<ClipSpring>& clip_springs() const override { return none_; }

  /// Of all pairs within the thickness; the thickness where there are none.
  double nearest_m(const Eigen::VectorXd& x);

 private:
  NearPairs pairs_;
  double thickness_m_ = 0.0;
  double stiffness_N_m_ = 0.0;
  std::vector<ClipSpring> none_;
};

}  // namespace tenter::mechanics
