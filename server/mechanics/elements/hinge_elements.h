// SPDX-License-Identifier: GPL-3.0-or-later
// Hinges: two triangles that share an edge. They see positions through the dihedral angle.
//
//   theta = 0 where the two triangles are in one plane, positive where both wings leave it against
//   the triangles' normals (a ridge, as in mesh/hinges.h); from -pi to pi
//   E = sum over hinges  area psi(theta)             thesis (3.5): strain (theta - theta_0)/h_0
//
// Derivatives are exact. With e the edge from corner 0 to 1 (length l, unit vector t), p and q the
// corners 2 and 3 seen from corner 0, and for the wing of p: height h over the edge, foot a = p.t,
// in-plane unit vector m across the edge, unit normal n (against the triangle's),
//
//   dtheta/dp    =  n/h
//   dtheta/de    = -(a/l) n/h                                            (+ the same of q)
//   d2theta/dp2  = -T/h^2                                                T = n m' + m n'
//   d2theta/dpde = (a/(l h^2)) T - (1/(l h)) t n'
//   d2theta/de2  = -(1/(2 l^2) + a^2/(l^2 h^2)) T + (a/(l^2 h)) (n t' + t n')   (+ the same of q)
//
// and d2theta/dpdq = 0. A wing whose height or edge length is zero gives numbers that are not
// finite: whoever assembles says so. Nothing allocates; callable from any thread.
#pragma once

#include <array>
#include <vector>

#include "server/mechanics/elements/chunk.h"
#include "server/mechanics/elements/node_matrix.h"

namespace tenter::mechanics {

struct HingeElements {
  std::vector<std::array<int, 4>> nodes;  ///< edge, then the wings' corners: left, right
  std::vector<double> measure;            ///< m^2: the area that a hinge stands for
  std::vector<int> gathered;              ///< nodes again: [corner * padded() + hinge]
  std::vector<int> slots;                 ///< see block_slots

  int count() const { return static_cast<int>(nodes.size()); }
  int padded() const { return (count() + kLanes - 1) / kLanes * kLanes; }
  void add(const std::array<int, 4>& corners, double area_m2);
  /// Call once after the last add.
  void finish();
};

/// theta of `count` hinges from `first` (a multiple of kLanes, count <= kChunk), radians.
void hinge_angles(const HingeElements&, const double* positions, int first, int count,
                  double* theta);

/// How theta changes with displacements `dx` of the nodes, at `positions`.
void hinge_angles_change(const HingeElements&, const double* positions, const double* dx, int first,
                         int count, double* dtheta);

/// gradient += dE/dx from psi' times the area.
void add_gradient(const HingeElements&, const double* positions, int first, int count,
                  const double* psi_theta, double* gradient);

/// matrix += psi'' g g' + psi' d2theta/dx2, both times the area.
void add_stiffness(const HingeElements&, const double* positions, int first, int count,
                   const double* psi_theta, const double* psi_thetatheta, NodeMatrix& matrix);

}  // namespace tenter::mechanics
