// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/strain_measure.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace tenter::mechanics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A strain that is linear in c: value = weights . c + constant.
void linear_in_c(const Vector3d& c, const Vector3d& weights, double constant, int i,
                 StrainValue& out) {
  out.value[i] = weights.dot(c) + constant;
  out.by_c[i] = weights;
  out.by_cc[i].setZero();
}

/// A stretch minus one: lambda = sqrt(s), s = weights . c, so
///   d lambda/dc = weights / (2 lambda),   d2 lambda/dc2 = -weights weights' / (4 lambda^3).
void stretch_minus_one(const Vector3d& c, const Vector3d& weights, int i, StrainValue& out) {
  const double length = std::sqrt(std::max(weights.dot(c), 0.0));
  const double lambda = std::max(length, kCollapsedStretch);
  out.value[i] = length - 1.0;
  out.by_c[i] = weights / (2.0 * lambda);
  out.by_cc[i] = -(weights * weights.transpose()) / (4.0 * lambda * lambda * lambda);
}

/// a.C.a = weights . c for the material direction a at an angle from weft towards warp.
Vector3d direction(double angle_rad) {
  const double co = std::cos(angle_rad);
  const double si = std::sin(angle_rad);
  return {co * co, si * si, 2.0 * co * si};
}

constexpr double kDiagonal = std::numbers::pi / 4.0;

void green_u(const Vector3d& c, double, StrainValue& out) {
  linear_in_c(c, {0.5, 0.0, 0.0}, -0.5, 0, out);
}
void green_v(const Vector3d& c, double, StrainValue& out) {
  linear_in_c(c, {0.0, 0.5, 0.0}, -0.5, 0, out);
}
void green_uv(const Vector3d& c, double, StrainValue& out) {
  linear_in_c(c, {0.0, 0.0, 1.0}, 0.0, 0, out);
}
void green_trace(const Vector3d& c, double, StrainValue& out) {
  linear_in_c(c, {0.5, 0.5, 0.0}, -1.0, 0, out);
}
void green_deviator(const Vector3d& c, double, StrainValue& out) {
  linear_in_c(c, {0.5, -0.5, 0.0}, 0.0, 0, out);
  linear_in_c(c, {0.0, 0.0, 1.0}, 0.0, 1, out);
}
void green_pair(const Vector3d& c, double, StrainValue& out) {
  linear_in_c(c, {0.5, 0.0, 0.0}, -0.5, 0, out);
  linear_in_c(c, {0.0, 0.5, 0.0}, -0.5, 1, out);
}
void green_pair_vu(const Vector3d& c, double, StrainValue& out) {
  linear_in_c(c, {0.0, 0.5, 0.0}, -0.5, 0, out);
  linear_in_c(c, {0.5, 0.0, 0.0}, -0.5, 1, out);
}
void green_u_shear(const Vector3d& c, double, StrainValue& out) {
  linear_in_c(c, {0.5, 0.0, 0.0}, -0.5, 0, out);
  linear_in_c(c, {0.0, 0.0, 1.0}, 0.0, 1, out);
}
void green_v_shear(const Vector3d& c, double, StrainValue& out) {
  linear_in_c(c, {0.0, 0.5, 0.0}, -0.5, 0, out);
  linear_in_c(c, {0.0, 0.0, 1.0}, 0.0, 1, out);
}
void stretch_u(const Vector3d& c, double, StrainValue& out) {
  stretch_minus_one(c, {1.0, 0.0, 0.0}, 0, out);
}
void stretch_v(const Vector3d& c, double, StrainValue& out) {
  stretch_minus_one(c, {0.0, 1.0, 0.0}, 0, out);
}
void soft_pair(const Vector3d& c, double, StrainValue& out) {
  stretch_minus_one(c, {1.0, 0.0, 0.0}, 0, out);
  stretch_minus_one(c, {0.0, 1.0, 0.0}, 1, out);
}
void spring_d1(const Vector3d& c, double, StrainValue& out) {
  stretch_minus_one(c, direction(kDiagonal), 0, out);
}
void spring_d2(const Vector3d& c, double, StrainValue& out) {
  stretch_minus_one(c, direction(-kDiagonal), 0, out);
}
void fibre(const Vector3d& c, double angle_rad, StrainValue& out) {
  stretch_minus_one(c, direction(angle_rad), 0, out);
}
void fibre_pair(const Vector3d& c, double angle_rad, StrainValue& out) {
  stretch_minus_one(c, direction(angle_rad), 0, out);
  stretch_minus_one(c, direction(-angle_rad), 1, out);
}
void green_fibre(const Vector3d& c, double angle_rad, StrainValue& out) {
  linear_in_c(c, 0.5 * direction(angle_rad), -0.5, 0, out);
}
void green_fibre_pair(const Vector3d& c, double angle_rad, StrainValue& out) {
  linear_in_c(c, 0.5 * direction(angle_rad), -0.5, 0, out);
  linear_in_c(c, 0.5 * direction(-angle_rad), -0.5, 1, out);
}

/// J = sqrt(D), D = C_uu C_vv - C_uv^2: dJ/dc = D_c/(2J), d2J/dc2 = D_cc/(2J) - D_c D_c'/(4 J^3).
void area(const Vector3d& c, double, StrainValue& out) {
  const double determinant = c[0] * c[1] - c[2] * c[2];
  const double root = std::sqrt(std::max(determinant, 0.0));
  const double j = std::max(root, kCollapsedStretch);
  const Vector3d by_c(c[1], c[0], -2.0 * c[2]);
  Matrix3d by_cc = Matrix3d::Zero();
  by_cc(0, 1) = by_cc(1, 0) = 1.0;
  by_cc(2, 2) = -2.0;
  out.value[0] = root - 1.0;
  out.by_c[0] = by_c / (2.0 * j);
  out.by_cc[0] = by_cc / (2.0 * j) - by_c * by_c.transpose() / (4.0 * j * j * j);
}

// tr E^2 = E_uu^2 + E_vv^2 + 2 E_uv^2 with 2 E_uv = C_uv
void green_square(const Vector3d& c, double, StrainValue& out) {
  const Vector3d e(0.5 * (c[0] - 1.0), 0.5 * (c[1] - 1.0), c[2]);
  out.value[0] = e[0] * e[0] + e[1] * e[1] + 0.5 * e[2] * e[2];
  out.by_c[0] = e;
  out.by_cc[0] = Vector3d(0.5, 0.5, 1.0).asDiagonal();
}

void principal(const Vector3d& c, double, StrainValue& out) {
  out.near_count = principal_stretches<2>(c, out.value, out.by_c, out.by_cc, out.near);
}

struct Row {
  std::string_view name;
  int count;
  bool is_linear;
  StrainMeasure::Function function;
};

constexpr Row kRows[] = {
    {"green_u", 1, true, green_u},
    {"green_v", 1, true, green_v},
    {"green_uv", 1, true, green_uv},
    {"green_trace", 1, true, green_trace},
    {"green_pair", 2, true, green_pair},
    {"green_deviator", 2, true, green_deviator},
    {"soft_u", 1, false, stretch_u},
    {"soft_v", 1, false, stretch_v},
    {"spring_u", 1, false, stretch_u},
    {"spring_v", 1, false, stretch_v},
    {"spring_d1", 1, false, spring_d1},
    {"spring_d2", 1, false, spring_d2},
    {"fibre", 1, false, fibre},
    {"fibre_pair", 2, false, fibre_pair},
    {"green_fibre", 1, true, green_fibre},
    {"green_fibre_pair", 2, true, green_fibre_pair},
    {"soft_pair", 2, false, soft_pair},
    {"area", 1, false, area},
    {"green_pair_vu", 2, true, green_pair_vu},
    {"green_u_shear", 2, true, green_u_shear},
    {"green_v_shear", 2, true, green_v_shear},
    {"green_square", 1, false, green_square},
    {"principal_stretches", 2, false, principal},
};

}  // namespace

Expected<StrainMeasure> StrainMeasure::make(const model::StrainMeasure& description) {
  for (const Row& row : kRows) {
    if (row.name != description.name) continue;
    StrainMeasure measure;
    measure.function_ = row.function;
    measure.count_ = row.count;
    measure.is_linear_ = row.is_linear;
    measure.angle_rad_ = description.angle_rad;
    return measure;
  }
  return bad_input("no strain measure is called \"" + description.name + "\"");
}

}  // namespace tenter::mechanics
