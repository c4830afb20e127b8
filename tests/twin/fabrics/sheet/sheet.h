// SPDX-License-Identifier: GPL-3.0-or-later
// A square sheet as one smooth surface: bicubic B-splines over irregular knots, the energy of
// sheet_point.h at Gauss points, and its weight.
//
//   (x, y)(u, v) = sum_ij N_i(u) N_j(v) P_ij        z(u, v) = sum_ij M_i(u) M_j(v) Z_ij
//   Pi = sum over Gauss points  w psi(x,u x,v x,uu x,vv x,uv) + weight
//
// Where a rigid grip ends in the flat sheet, its stretch jumps and its slope does not: the knots
// there are triple for x and y and double for z. So a grip is exactly so many control points, as
// long as clips turn about z only. It has no triangles, hinges or springs, and shares nothing with
// server/: what the fits on meshes are judged by.
//
//   Sheet sheet(fabric, {plane_u, plane_v, height_u, height_v});
//   Eigen::VectorXd x = sheet.flat();                  // 2 numbers each P, then the Z
//   double energy = sheet.evaluate(x, &gradient);
//
// One thread. Data that change are the history of the Gauss points: advance().
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "tests/twin/fabrics/protocols.h"
#include "tests/twin/fabrics/sheet/sheet_point.h"
#include "tests/twin/fabrics/sheet/spline_line.h"

namespace tenter::twin {

constexpr double kGravity_m_s2 = 9.81;

/// Lines for x and y, and for z; the distinct knots of both are the same.
struct SheetLines {
  SplineLine plane_u, plane_v, height_u, height_v;
};

/// Where a rigid grip puts its unknowns.
struct Gripped {
  std::vector<int> plane;   ///< control points of x and y
  std::vector<int> height;  ///< of z
};

inline constexpr int kSpanUnknowns = 48;  ///< of one rectangle between knots: x, then y, then z

class Sheet {
 public:
  Sheet(Fabric fabric, SheetLines lines);

  int unknown_count() const { return 2 * plane_count() + height_count(); }
  int plane_count() const { return lines_.plane_u.count() * lines_.plane_v.count(); }
  int height_count() const { return lines_.height_u.count() * lines_.height_v.count(); }
  /// Place in the vector of unknowns.
  static int x_of(int plane_point) { return 2 * plane_point; }
  int z_of(int height_point) const { return 2 * plane_count() + height_point; }

  Eigen::VectorXd flat() const;  ///< x = u, y = v, z = 0
  Eigen::Vector3d position(const Eigen::VectorXd& x, const Eigen::Vector2d& material_m) const;
  Gripped gripped(const Region& region) const;
  /// (u, v) where the control point of x and y lies in the flat sheet.
  Eigen::Vector2d place(int plane_point) const;

  /// Unknowns of every span: those that its energy couples.
  std::vector<std::array<int, kSpanUnknowns>> spans() const;

  /// Energy (J); not finite where the surface has no normal. Null: not wanted. `slots` says for
  /// every span where each entry of its 48 x 48 matrix, column by column, is added in `values`; -1:
  /// nowhere. `convex_share` as in sheet_point.h.
  double evaluate(const Eigen::VectorXd& x, Eigen::VectorXd* gradient,
                  const std::vector<int>* slots = nullptr, double* values = nullptr,
                  double convex_share = 0.0) const;
  /// How long the next step lasts, for laws that know time.
  void set_step(double step_s);
  /// The state is one that was reached: friction goes on from there.
  void advance(const Eigen::VectorXd& x);

 private:
  using Shape = Eigen::Matrix<double, 16, 5>;  ///< derivatives u, v, uu, vv, uv of 16 functions
  static constexpr int kGaussPoints = 9;       ///< of a span
  struct GaussPoint {
    double area = 0.0;
    Shape plane, height;
  };
  struct Span {
    std::array<int, kSpanUnknowns> unknowns;
    std::array<GaussPoint, kGaussPoints> points;
  };
  static SurfaceVector surface_at(const Span& span, const GaussPoint& point,
                                  const Eigen::VectorXd& x);

  Fabric fabric_;
  SheetLines lines_;
  std::vector<Span> spans_;
  std::vector<PointHistory> history_;  ///< [span * kGaussPoints + point]
  Eigen::VectorXd weight_N_;           ///< of each unknown: of z only
};

}  // namespace tenter::twin
