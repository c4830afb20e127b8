// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/solid_strain.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

namespace tenter::mechanics {
namespace {

/// A strain that is linear in z: value = weights . z + constant.
void linear_in_z(const Vector6d& z, const Vector6d& weights, double constant, int i,
                 SolidStrainValue& out) {
  out.value[i] = weights.dot(z) + constant;
  out.by_z[i] = weights;
  out.by_zz[i].setZero();
}

/// Entry `kEntry` of z as a Green strain: (C_ii - 1)/2 on the diagonal, C_ij beside it.
template <int kEntry>
void green(const Vector6d& z, const Vector6d&, SolidStrainValue& out) {
  const bool normal = kEntry < 3;
  linear_in_z(z, (normal ? 0.5 : 1.0) * Vector6d::Unit(kEntry), normal ? -0.5 : 0.0, 0, out);
}
void green_normal(const Vector6d& z, const Vector6d&, SolidStrainValue& out) {
  for (int i = 0; i < 3; ++i) linear_in_z(z, 0.5 * Vector6d::Unit(i), -0.5, i, out);
}
void green_shear(const Vector6d& z, const Vector6d&, SolidStrainValue& out) {
  for (int i = 0; i < 3; ++i) linear_in_z(z, Vector6d::Unit(3 + i), 0.0, i, out);
}
void green_trace(const Vector6d& z, const Vector6d&, SolidStrainValue& out) {
  linear_in_z(z, (Vector6d() << 0.5, 0.5, 0.5, 0.0, 0.0, 0.0).finished(), -1.5, 0, out);
}

// tr E^2 = sum_i E_ii^2 + 2 sum_(i<j) E_ij^2 = sum_i ((C_ii - 1)/2)^2 + 1/2 sum_(i<j) C_ij^2
void green_square(const Vector6d& z, const Vector6d&, SolidStrainValue& out) {
  Vector6d e = z;
  e.head<3>() = 0.5 * (z.head<3>().array() - 1.0);
  out.value[0] = e.head<3>().squaredNorm() + 0.5 * e.tail<3>().squaredNorm();
  out.by_z[0] = e;
  out.by_zz[0].setZero();
  out.by_zz[0].diagonal() << 0.5, 0.5, 0.5, 1.0, 1.0, 1.0;
}

/// A scalar function of the invariants: value, gradient and Hessian by (I_1, I_2, I_3).
struct OfInvariants {
  double value = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

// With z = (a, b, c, d, e, f): I_1 = a + b + c, I_2 = ab + bc + ca - d^2 - e^2 - f^2,
// I_3 = abc + 2def - a d^2 - b e^2 - c f^2; composed with f(I_1, I_2, I_3) by the chain rule.
template <OfInvariants (*kFunction)(double i1, double i2, double i3)>
void of_invariants(const Vector6d& z, const Vector6d&, SolidStrainValue& out) {
  const double a = z[0], b = z[1], c = z[2], d = z[3], e = z[4], f = z[5];
  Eigen::Matrix<double, 3, 6> by_z;
  by_z << 1.0, 1.0, 1.0, 0.0, 0.0, 0.0,                                    //
      b + c, a + c, a + b, -2.0 * d, -2.0 * e, -2.0 * f,                   //
      b * c - d * d, a * c - e * e, a * b - f * f, 2.0 * (e * f - a * d),  //
      2.0 * (d * f - b * e), 2.0 * (d * e - c * f);
  const double i1 = a + b + c;
  const double i2 = a * b + b * c + c * a - d * d - e * e - f * f;
  const double i3 = a * (b * c - d * d) + 2.0 * d * e * f - b * e * e - c * f * f;
  const OfInvariants g = kFunction(i1, i2, i3);
  out.value[0] = g.value;
  out.by_z[0] = by_z.transpose() * g.first;
  Matrix6d& h = out.by_zz[0];
  h = by_z.transpose() * g.second * by_z;
  const auto add = [&h](int row, int column, double value) {
    h(row, column) += value;
    if (row != column) h(column, row) += value;
  };
  const double g2 = g.first[1];
  const double g3 = g.first[2];
  add(0, 1, g2 + g3 * c);
  add(0, 2, g2 + g3 * b);
  add(1, 2, g2 + g3 * a);
  add(3, 3, -2.0 * (g2 + g3 * a));
  add(4, 4, -2.0 * (g2 + g3 * b));
  add(5, 5, -2.0 * (g2 + g3 * c));
  add(0, 3, -2.0 * g3 * d);
  add(1, 4, -2.0 * g3 * e);
  add(2, 5, -2.0 * g3 * f);
  add(3, 4, 2.0 * g3 * f);
  add(3, 5, 2.0 * g3 * e);
  add(4, 5, 2.0 * g3 * d);
}

/// I_3 of a solid that is not collapsed.
double safe(double i3) {
  return std::max(i3, kCollapsedStretch * kCollapsedStretch);
}

OfInvariants first_invariant(double i1, double, double) {
  OfInvariants f;
  f.value = i1 - 3.0;
  f.first[0] = 1.0;
  return f;
}
OfInvariants second_invariant(double, double i2, double) {
  OfInvariants f;
  f.value = i2 - 3.0;
  f.first[1] = 1.0;
  return f;
}

/// I_n I_3^p - 3, with n = 0 or 1 for the first or second invariant.
OfInvariants isochoric(int n, double invariant, double i3, double p) {
  i3 = safe(i3);
  const double scale = std::pow(i3, p);
  OfInvariants f;
  f.value = invariant * scale - 3.0;
  f.first[n] = scale;
  f.first[2] = p * invariant * scale / i3;
  f.second(n, 2) = f.second(2, n) = p * scale / i3;
  f.second(2, 2) = p * (p - 1.0) * invariant * scale / (i3 * i3);
  return f;
}
OfInvariants isochoric_1(double i1, double, double i3) {
  return isochoric(0, i1, i3, -1.0 / 3.0);
}
OfInvariants isochoric_2(double, double i2, double i3) {
  return isochoric(1, i2, i3, -2.0 / 3.0);
}
OfInvariants log_volume(double, double, double i3) {
  i3 = safe(i3);
  OfInvariants f;
  f.value = 0.5 * std::log(i3);
  f.first[2] = 0.5 / i3;
  f.second(2, 2) = -0.5 / (i3 * i3);
  return f;
}
OfInvariants volume(double, double, double i3) {
  i3 = safe(i3);
  const double j = std::sqrt(i3);
  OfInvariants f;
  f.value = j - 1.0;
  f.first[2] = 0.5 / j;
  f.second(2, 2) = -0.25 / (i3 * j);
  return f;
}
OfInvariants neo_hookean(double i1, double i2, double i3) {
  OfInvariants f = log_volume(i1, i2, i3);
  f.value = i1 - 3.0 - 2.0 * f.value;
  f.first *= -2.0;
  f.first[0] = 1.0;
  f.second *= -2.0;
  return f;
}

void principal(const Vector6d& z, const Vector6d&, SolidStrainValue& out) {
  out.near_count = principal_stretches<3>(z, out.value, out.by_z, out.by_zz, out.near);
}

// lambda = sqrt(s), s = a.C.a: d lambda/dz = w/(2 lambda), d2 lambda/dz2 = -w w'/(4 lambda^3)
void fibre_stretch(const Vector6d& z, const Vector6d& weights, SolidStrainValue& out) {
  const double length = std::sqrt(std::max(weights.dot(z), 0.0));
  const double lambda = std::max(length, kCollapsedStretch);
  out.value[0] = length - 1.0;
  out.by_z[0] = weights / (2.0 * lambda);
  out.by_zz[0] = -(weights * weights.transpose()) / (4.0 * lambda * lambda * lambda);
}
void green_fibre(const Vector6d& z, const Vector6d& weights, SolidStrainValue& out) {
  linear_in_z(z, 0.5 * weights, -0.5, 0, out);
}

struct SolidRow {
  std::string_view name;
  int count;
  bool is_linear;
  SolidStrain::Function function;
};

constexpr SolidRow kSolidRows[] = {
    {"solid_green_xx", 1, true, green<0>},
    {"solid_green_yy", 1, true, green<1>},
    {"solid_green_zz", 1, true, green<2>},
    {"solid_green_yz", 1, true, green<3>},
    {"solid_green_xz", 1, true, green<4>},
    {"solid_green_xy", 1, true, green<5>},
    {"solid_green_normal", 3, true, green_normal},
    {"solid_green_shear", 3, true, green_shear},
    {"solid_green_trace", 1, true, green_trace},
    {"solid_green_square", 1, false, green_square},
    {"solid_invariant_1", 1, true, of_invariants<first_invariant>},
    {"solid_invariant_2", 1, false, of_invariants<second_invariant>},
    {"solid_isochoric_1", 1, false, of_invariants<isochoric_1>},
    {"solid_isochoric_2", 1, false, of_invariants<isochoric_2>},
    {"solid_log_volume", 1, false, of_invariants<log_volume>},
    {"solid_volume", 1, false, of_invariants<volume>},
    {"solid_neo_hookean", 1, false, of_invariants<neo_hookean>},
    {"solid_principal_stretches", 3, false, principal},
    {"solid_fibre", 1, false, fibre_stretch},
    {"solid_green_fibre", 1, true, green_fibre},
};

}  // namespace

Expected<SolidStrain> SolidStrain::make(const model::StrainMeasure& description) {
  for (const SolidRow& row : kSolidRows) {
    if (row.name != description.name) continue;
    SolidStrain measure;
    measure.function_ = row.function;
    measure.count_ = row.count;
    measure.is_linear_ = row.is_linear;
    const double level = std::cos(description.elevation_rad);
    const Eigen::Vector3d a(level * std::cos(description.angle_rad),
                            level * std::sin(description.angle_rad),
                            std::sin(description.elevation_rad));
    measure.fibre_ = pair_by_z<3>(a, a);
    return measure;
  }
  return bad_input("no strain measure of solids is called \"" + description.name + "\"");
}

}  // namespace tenter::mechanics
