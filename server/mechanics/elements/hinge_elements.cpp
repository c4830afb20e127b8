// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/elements/hinge_elements.h"

#include <algorithm>

#include "server/mechanics/elements/arc_tangent.h"
#include "server/mechanics/elements/scatter.h"

namespace tenter::mechanics {
namespace {

/// One side of the hinge, in the symbols of the header.
struct Wing {
  Lanes3 m, n;
  Lanes height;
  Lanes foot;
};

struct Hinge8 {
  Lanes3 t;
  Lanes length;
  Wing wing[2];
};

/// `side` is -1 for the left wing, 1 for the right: both normals are those of the triangles,
/// reversed.
TENTER_INLINE Wing wing_of(const Lanes3& corner, const Lanes3& t, double side) {
  Wing w;
  w.foot = dot(corner, t);
  const Lanes3 across = corner - w.foot * t;
  w.height = root(dot(across, across));
  w.m = (1.0 / w.height) * across;
  w.n = (side + 0.0 * w.foot) * cross(t, w.m);
  return w;
}

TENTER_INLINE Hinge8 hinge_of(const HingeElements& hinges, const double* positions, int e) {
  const int stride = hinges.padded();
  const int* nodes = hinges.gathered.data() + e;
  const Lanes3 origin = gather(positions, nodes);
  const Lanes3 edge = gather(positions, nodes + stride) - origin;
  Hinge8 h;
  h.length = root(dot(edge, edge));
  h.t = (1.0 / h.length) * edge;
  h.wing[0] = wing_of(gather(positions, nodes + 2 * stride) - origin, h.t, -1.0);
  h.wing[1] = wing_of(gather(positions, nodes + 3 * stride) - origin, h.t, 1.0);
  return h;
}

/// Derivatives of theta by (e, p, q).
TENTER_INLINE void angle_gradient(const Hinge8& h, Lanes3 (&g)[3]) {
  g[1] = (1.0 / h.wing[0].height) * h.wing[0].n;
  g[2] = (1.0 / h.wing[1].height) * h.wing[1].n;
  const Lanes3 sum = (h.wing[0].foot / h.length) * g[1] + (h.wing[1].foot / h.length) * g[2];
  g[0] = (0.0 * h.length - 1.0) * sum;
}

/// a b' + b a': the entries of the lower triangle.
struct Symmetric {
  Lanes xx, yx, zx, yy, zy, zz;
};

TENTER_INLINE Symmetric symmetric_product(const Lanes3& a, const Lanes3& b) {
  return {2.0 * a.x * b.x, a.y * b.x + a.x * b.y, a.z * b.x + a.x * b.z,
          2.0 * a.y * b.y, a.z * b.y + a.y * b.z, 2.0 * a.z * b.z};
}

/// block += s k
TENTER_INLINE void add_symmetric(Lanes33& block, const Lanes& s, const Symmetric& k) {
  const Lanes yx = s * k.yx, zx = s * k.zx, zy = s * k.zy;
  block.v[0] += s * k.xx;
  block.v[1] += yx;
  block.v[2] += zx;
  block.v[3] += yx;
  block.v[4] += s * k.yy;
  block.v[5] += zy;
  block.v[6] += zx;
  block.v[7] += zy;
  block.v[8] += s * k.zz;
}

// Places in the lower triangle of 4 x 4 blocks.
constexpr int kPairs = 10;
constexpr int pair(int a, int b) {
  return a * (a + 1) / 2 + b;
}

/// Adds a block of (e, p, q) coordinates, corners 1 to 3.
TENTER_INLINE void blocks_of(const Hinge8& h, const Lanes& psi_theta, const Lanes& psi_thetatheta,
                             Lanes33 (&blocks)[kPairs]) {
  Lanes3 g[3];
  angle_gradient(h, g);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b <= a; ++b) add_outer(blocks[pair(a + 1, b + 1)], psi_thetatheta * g[a], g[b]);
  const Lanes per_length = 1.0 / h.length;
  for (int side = 0; side < 2; ++side) {
    const Wing& w = h.wing[side];
    const Lanes per_height = 1.0 / w.height;
    const Lanes a_over_l = w.foot * per_length;
    const Lanes t_pp = psi_theta * per_height * per_height;
    const Symmetric t_nm = symmetric_product(w.n, w.m);
    add_symmetric(blocks[pair(side + 2, side + 2)], -t_pp, t_nm);
    add_symmetric(blocks[pair(side + 2, 1)], a_over_l * t_pp, t_nm);
    add_outer(blocks[pair(side + 2, 1)], (-psi_theta * per_length * per_height) * h.t, w.n);
    add_symmetric(blocks[pair(1, 1)],
                  -(0.5 * psi_theta * per_length * per_length + a_over_l * a_over_l * t_pp), t_nm);
    add_symmetric(blocks[pair(1, 1)], psi_theta * a_over_l * per_length * per_height,
                  symmetric_product(w.n, h.t));
  }
}

/// Corner 0 moves against the other three.
TENTER_INLINE void complete(Lanes33 (&blocks)[kPairs]) {
  for (int a = 1; a < 4; ++a) {
    Lanes33& column = blocks[pair(a, 0)];
    for (int c = 1; c < 4; ++c) {
      const Lanes33& k = blocks[a >= c ? pair(a, c) : pair(c, a)];
      for (int col = 0; col < 3; ++col)
        for (int r = 0; r < 3; ++r)
          column.v[3 * col + r] -= a >= c ? k.v[3 * col + r] : k.v[3 * r + col];
    }
    for (int q = 0; q < 9; ++q) blocks[0].v[q] -= column.v[q];
  }
}

}  // namespace

void HingeElements::add(const std::array<int, 4>& corners, double area_m2) {
  nodes.push_back(corners);
  measure.push_back(area_m2);
}

void HingeElements::finish() {
  if (nodes.empty()) return;
  const auto stride = static_cast<std::size_t>(padded());
  gathered.assign(4 * stride, 0);
  for (std::size_t e = 0; e < stride; ++e)
    for (std::size_t a = 0; a < 4; ++a)
      gathered[a * stride + e] = nodes[std::min(e, nodes.size() - 1)][a];
}

TENTER_KERNEL void hinge_angles(const HingeElements& hinges, const double* positions, int first,
                                int count, double* theta) {
  for (int e = 0; e < count; e += kLanes) {
    const Hinge8 h = hinge_of(hinges, positions, first + e);
    const Lanes cosine = dot(h.wing[0].n, h.wing[1].n);
    const Lanes sine = dot(cross(h.wing[0].n, h.wing[1].n), h.t);
    store(arc_tangent(sine, cosine), theta + e);
  }
}

TENTER_KERNEL void hinge_angles_change(const HingeElements& hinges, const double* positions,
                                       const double* dx, int first, int count, double* dtheta) {
  const int stride = hinges.padded();
  for (int e = 0; e < count; e += kLanes) {
    Lanes3 g[3];
    angle_gradient(hinge_of(hinges, positions, first + e), g);
    const int* nodes = hinges.gathered.data() + first + e;
    const Lanes3 origin = gather(dx, nodes);
    Lanes sum{};
    for (int a = 0; a < 3; ++a) sum += dot(g[a], gather(dx, nodes + (a + 1) * stride) - origin);
    store(sum, dtheta + e);
  }
}

TENTER_KERNEL void add_gradient(const HingeElements& hinges, const double* positions, int first,
                                int count, const double* psi_theta, double* gradient) {
  const int stride = hinges.padded();
  for (int e = 0; e < count; e += kLanes) {
    const Hinge8 h = hinge_of(hinges, positions, first + e);
    Lanes3 g[3];
    angle_gradient(h, g);
    const Lanes psi = load(psi_theta + e);
    Lanes3 force[4];
    for (int a = 0; a < 3; ++a) {
      force[a + 1] = psi * g[a];
      force[0] = force[0] - force[a + 1];
    }
    const int lanes = std::min(kLanes, count - e);
    for (int a = 0; a < 4; ++a) {
      const int* node = hinges.gathered.data() + a * stride + first + e;
      for (int l = 0; l < lanes; ++l) {
        double* target = gradient + 3 * node[l];
        target[0] += force[a].x[l];
        target[1] += force[a].y[l];
        target[2] += force[a].z[l];
      }
    }
  }
}

TENTER_KERNEL void add_stiffness(const HingeElements& hinges, const double* positions, int first,
                                 int count, const double* psi_theta, const double* psi_thetatheta,
                                 NodeMatrix& matrix) {
  for (int e = 0; e < count; e += kLanes) {
    const Hinge8 h = hinge_of(hinges, positions, first + e);
    Lanes33 blocks[kPairs] = {};
    blocks_of(h, load(psi_theta + e), load(psi_thetatheta + e), blocks);
    complete(blocks);
    scatter(blocks, std::min(kLanes, count - e), hinges.slots.data() + (first + e) * kPairs,
            matrix);
  }
}

}  // namespace tenter::mechanics
