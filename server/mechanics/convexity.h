// SPDX-License-Identifier: GPL-3.0-or-later
// Convexity of energies over a range of strains: the smallest eigenvalue of a Hessian, and where.
//
// Thesis 4.2.3 and 4.11: an energy is convex where the eigenvalues of its Hessian are not negative,
// checked on samples. Two questions are answered:
//
//   law_convexity    d2Psi/deps2 of one law in its own strains (addends of one strain; the
//                    sufficient condition of 4.2.3), on a grid with both ends
//   model_convexity  d2Psi/dF2 of a model, or of one of its terms, at given deformation gradients:
//                    2 x 2 for membranes (columns w_u, w_v, in their plane), 3 x 3 for solids:
//
//     d2Psi/dF2 = G' (d2Psi/dz2) G + sum_k dPsi/dz_k d2z_k/dF2,    G = dz/dF,  z(F) of F'F
//
// Hinges and springs over two edges see no F and are left out, as are path-dependent laws; supports
// other than "everywhere" count with weight one. Energies of F with a rotation are never convex
// under compression, so the second answer is about states, not about a term for ever. Out-of-plane
// directions of a membrane are the stresses themselves: negative under compression, which is
// buckling; `in_plane` leaves them out. Pure; allocates; any thread.
//
//   const Convexity worst = law_convexity(*law, parameters, -0.1, 0.5, 101);
//   if (worst.smallest < 0) ... at worst.strain[0]
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/mechanics/law.h"

namespace tenter::mechanics {

struct Convexity {
  double smallest = std::numeric_limits<double>::infinity();  ///< eigenvalue; unit of the tangent
  double largest = 0.0;  ///< magnitude of any eigenvalue seen: the scale of `smallest`
  int sample = -1;       ///< index of the state of `smallest`; -1 where none was looked at
  double strain[kMaxStrains] = {0.0, 0.0, 0.0};  ///< law_convexity: where `smallest` is
};

/// The law's own Hessian on `samples` >= 2 even strains of [lo, hi], in each of its strains.
Convexity law_convexity(const Law& law, const double* parameters, double lo, double hi,
                        int samples);

/// Where a model lives; terms of the other kind are bad_input.
enum class Body { membrane, solid };

/// `deformations`: F in rest axes, one matrix for each state; 2 x 2 for membranes (in their plane),
/// 3 x 3 for solids. `parameters` in the model's order. `term` is the only term to look at, or -1.
Expected<Convexity> model_convexity(const model::Model& model, Body body,
                                    const std::vector<double>& parameters,
                                    const std::vector<Eigen::MatrixXd>& deformations, int term = -1,
                                    bool in_plane = true);

}  // namespace tenter::mechanics
