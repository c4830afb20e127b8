// SPDX-License-Identifier: GPL-3.0-or-later
// The part of an element's stiffness that is never negative, for minimisers far from a minimum.
//
//   d2E/dx2 = sum_kl psi_kl B_k B_l'  +  M (x) I           (elements/gradient_elements.h)
//
// Both summands are made positive semidefinite on their own: the negative eigenvalues of the matrix
// psi_kl and those of M, the stress, are set to zero. For hinges the term of d2theta/dx2 goes and
// psi'' stays where it is positive. In equilibrium without compression nothing changes.
//
// Chunks as in elements/; `count` elements. No allocation; callable from any thread.
#pragma once

#include "server/mechanics/elements/gradient_elements.h"
#include "server/mechanics/elements/hinge_elements.h"

namespace tenter::mechanics {

/// In place. For the stiffness alone: psi_z is no gradient any more.
void take_positive_part(const HingeElements&, int count, double share, double* psi_z,
                        double* psi_zz);
void take_positive_part(const EdgeElements&, int count, double share, double* psi_z,
                        double* psi_zz);
void take_positive_part(const TriangleElements&, int count, double share, double* psi_z,
                        double* psi_zz);
void take_positive_part(const TetrahedronElements&, int count, double share, double* psi_z,
                        double* psi_zz);
void take_positive_part(const HexahedronPoints&, int count, double share, double* psi_z,
                        double* psi_zz);

}  // namespace tenter::mechanics
