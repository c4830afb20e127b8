// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sheet/sheet_point.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace tenter::twin {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// cross(a) b = a x b.
Matrix3d cross(const Vector3d& a) {
  Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

double sign_of(double x) {
  return x < 0.0 ? -1.0 : 1.0;
}

/// n, and what its derivatives need.
struct Normal {
  Vector3d unit;
  double length;
};
Normal normal_of(const SurfaceVector& y) {
  const Vector3d product = y.segment<3>(0).cross(y.segment<3>(3));
  const double length = product.norm();
  return {product / length, length};
}

constexpr int kFirstBend = 3;

Eigen::Vector2d stretch_stiffness(const Fabric& fabric) {
  return {fabric.curves[0].stiffness(0.0), fabric.curves[1].stiffness(0.0)};
}
constexpr double kWeight[3] = {1.0, 1.0, 2.0};  // K_uv counts twice

/// Without a share of what makes it negative.
template <class Matrix>
Matrix less_negative(const Matrix& matrix, double share) {
  if (share <= 0.0) return matrix;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(matrix);
  const Matrix positive = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                          eigen.eigenvectors().transpose();
  return matrix + share * (positive - matrix);
}

/// Membrane part: C = Y'Y is quadratic in (x,u x,v), its second derivative weighs the stresses.
void add_membrane(const Eigen::Vector3d& stresses, const Matrix3d& tangents, const SurfaceVector& y,
                  bool wants_hessian, double share, PointEnergy& out) {
  const Vector3d a = y.segment<3>(0), b = y.segment<3>(3);
  Eigen::Matrix<double, 6, 3> by_y = Eigen::Matrix<double, 6, 3>::Zero();
  by_y.col(0).head<3>() = a;
  by_y.col(1).tail<3>() = b;
  by_y.col(2) << b, a;
  out.gradient.head<6>() += by_y * stresses;
  if (!wants_hessian) return;
  out.hessian.topLeftCorner<6, 6>() += by_y * less_negative(tangents, share) * by_y.transpose();
  Eigen::Matrix2d stress;
  stress << stresses[0], stresses[2], stresses[2], stresses[1];
  stress = less_negative(stress, share);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      out.hessian.block<3, 3>(3 * i, 3 * j) += stress(i, j) * Matrix3d::Identity();
}

// K = h . N / |N| with N = x,u x x,v. By N: g = (h - K n) / |N|, and
//   d2K/dN2 = -(K (I - n n') / |N| + n g' + g n') / |N|      d2K/dN dh = (I - n n') / |N|
// N is bilinear: dN = -[x,v] d(x,u) + [x,u] d(x,v), and g . (d(x,u) x d(x,v)) is left over. All
// three curvatures share N, so what is linear in h is done once with the sum of moment times h.
void add_bending(const CurveValue* mode, const SurfaceVector& y, bool wants_hessian, double share,
                 PointEnergy& out) {
  const Vector3d a = y.segment<3>(0), b = y.segment<3>(3);
  const auto [n, length] = normal_of(y);
  Eigen::Matrix<double, 3, 6> by_ab;  // dN
  by_ab << -cross(b), cross(a);
  Vector3d whole = Vector3d::Zero();
  for (int m = 0; m < 3; ++m) {
    const Vector3d h = y.segment<3>(6 + 3 * m);
    whole += kWeight[m] * mode[m].stress * h;
    const Vector3d g = (h - h.dot(n) * n) / length;
    SurfaceVector by_y = SurfaceVector::Zero();
    by_y.head<6>() = kWeight[m] * by_ab.transpose() * g;
    by_y.segment<3>(6 + 3 * m) = kWeight[m] * n;
    out.gradient += mode[m].stress * by_y;
    if (!wants_hessian) continue;
    const double tangent =
        mode[m].tangent + share * (std::max(mode[m].tangent, 0.0) - mode[m].tangent);
    out.hessian += tangent * by_y * by_y.transpose();
  }
  if (!wants_hessian) return;
  const double rest = 1.0 - share;
  const double curvature = whole.dot(n);
  const Vector3d g = (whole - curvature * n) / length;
  const Matrix3d across = Matrix3d::Identity() - n * n.transpose();
  const Matrix3d by_nn =
      -(curvature / length * across + n * g.transpose() + g * n.transpose()) / length;
  Eigen::Matrix<double, 6, 6> membrane = by_ab.transpose() * by_nn * by_ab;
  membrane.topRightCorner<3, 3>() -= cross(g);
  membrane.bottomLeftCorner<3, 3>() += cross(g);
  out.hessian.topLeftCorner<6, 6>() += rest * membrane;
  const Eigen::Matrix<double, 3, 6> mixed = across / length * by_ab;
  for (int m = 0; m < 3; ++m) {
    const double weight = rest * kWeight[m] * mode[m].stress;
    out.hessian.block<3, 6>(6 + 3 * m, 0) += weight * mixed;
    out.hessian.block<6, 3>(0, 6 + 3 * m) += weight * mixed.transpose();
  }
}

}  // namespace

Strains strains_at(const SurfaceVector& y) {
  const Vector3d a = y.segment<3>(0), b = y.segment<3>(3), n = normal_of(y).unit;
  Strains e;
  e << 0.5 * (a.squaredNorm() - 1.0), 0.5 * (b.squaredNorm() - 1.0), a.dot(b),
      y.segment<3>(6).dot(n), y.segment<3>(9).dot(n), 2.0 * y.segment<3>(12).dot(n);
  return e;
}

CurveValue mode_at(const Fabric& fabric, int mode, const PointHistory& history, double strain) {
  const auto m = static_cast<std::size_t>(mode);
  CurveValue value = fabric.curves[m].at(strain);
  if (mode < 2 && history.stiffer != 1.0)
    value = {history.stiffer * value.energy, history.stiffer * value.stress,
             history.stiffer * value.tangent};
  if (mode == kFirstBend || mode == kFirstBend + 1) {
    const double moment_N = fabric.curves[m].stiffness(0.0) *
                            fabric.hidden.curl_1_m[static_cast<std::size_t>(mode - kFirstBend)];
    value.energy -= moment_N * strain;
    value.stress -= moment_N;
  }
  const Loop& loop = fabric.loops[m];
  if (loop.ratio == 1.0) return value;
  const double beta = (loop.ratio - 1.0) / (loop.ratio + 1.0);
  const double from = history.strain[mode];
  const double s = sign_of(strain - from);
  const CurveValue start = fabric.curves[m].at(from);
  const double behind = history.friction[mode] - s * beta * std::abs(start.stress);
  const double left = std::exp(-std::abs(strain - from) / loop.reach);
  CurveValue sum;
  sum.energy = value.energy +
               s * beta * (sign_of(strain) * value.energy - sign_of(from) * start.energy) +
               s * behind * loop.reach * (1.0 - left);
  sum.stress = value.stress + s * beta * std::abs(value.stress) + behind * left;
  sum.tangent = value.tangent * (1.0 + s * beta * sign_of(strain)) - s * behind / loop.reach * left;
  return sum;
}

void evaluate_point(const Fabric& fabric, const PointHistory& history, const SurfaceVector& y,
                    bool wants_hessian, double convex_share, PointEnergy& out) {
  const Strains strain = strains_at(y);
  CurveValue modes[kModes];
  out.energy = 0.0;
  out.gradient.setZero();
  if (wants_hessian) out.hessian.setZero();
  for (int m = 0; m < kModes; ++m) {
    modes[m] = mode_at(fabric, m, history, strain[m]);
    out.energy += modes[m].energy;
  }
  const LawValue hidden = hidden_at(fabric.hidden, history.laws, history.strain.head<3>(),
                                    strain.head<3>(), stretch_stiffness(fabric), history.step_s);
  out.energy += hidden.energy;
  Eigen::Vector3d stresses = hidden.stress;
  Matrix3d tangents = hidden.tangent;
  for (int m = 0; m < kFirstBend; ++m) {
    stresses[m] += modes[m].stress;
    tangents(m, m) += modes[m].tangent;
  }
  add_membrane(stresses, tangents, y, wants_hessian, convex_share, out);
  add_bending(modes + kFirstBend, y, wants_hessian, convex_share, out);
}

PointHistory advance(const Fabric& fabric, const PointHistory& history, const SurfaceVector& y) {
  PointHistory next;
  next.strain = strains_at(y);
  next.laws = advance(fabric.hidden, history.laws, history.strain.head<3>(), next.strain.head<3>(),
                      history.step_s);
  next.stiffer = history.stiffer;
  next.step_s = history.step_s;
  for (int m = 0; m < kModes; ++m)
    next.friction[m] =
        fabric.loops[static_cast<std::size_t>(m)].ratio == 1.0
            ? 0.0
            : mode_at(fabric, m, history, next.strain[m]).stress -
                  fabric.curves[static_cast<std::size_t>(m)].at(next.strain[m]).stress;
  return next;
}

}  // namespace tenter::twin
