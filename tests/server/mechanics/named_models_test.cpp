// SPDX-License-Identifier: GPL-3.0-or-later
// Named models as sums of terms against their textbook forms, written here from F.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "common/model/presets.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/point_energy.h"
#include "tests/server/mechanics/random_solids.h"

namespace tenter::mechanics {
namespace {

using testing::Comparison;
using testing::energy_at;
using testing::model_of;
using testing::Numbers;
using testing::random_solid;
using testing::stress_of;
using testing::z_of;

using Matrix3 = Eigen::Matrix3d;
constexpr double kLambda = 2.3e5;
constexpr double kMu = 0.7e5;

/// The shipped model with these parameter values, in order.
model::Model preset_with(const char* name, const std::vector<double>& values) {
  model::Model model = model::preset(name).value();
  std::size_t k = 0;
  for (model::Term& term : model.terms)
    for (model::Parameter& p : term.law.parameters) p.value = values.at(k++);
  EXPECT_EQ(k, values.size());
  return model;
}

struct Textbook {
  double energy;
  Matrix3 stress;  ///< dPsi/dF
};

template <class Form>
void expect_textbook(const model::Model& model, Form form) {
  Numbers numbers(21);
  Comparison energy(model.name + ": energy"), stress(model.name + ": stress");
  for (int sample = 0; sample < 100; ++sample) {
    const Matrix3 f = random_solid(numbers);
    const auto sum = energy_at<6>(model, z_of(f));
    const Textbook expected = form(f);
    energy.add(sum.energy, expected.energy);
    const Matrix3 p = stress_of(f, sum);
    for (int i = 0; i < 9; ++i) stress.add(p.data()[i], expected.stress.data()[i]);
  }
  energy.judge(1e-13, 1e3);
  stress.judge(1e-13, 1e4);
}

TEST(NamedModels, SaintVenantKirchhoffSolid) {
  expect_textbook(preset_with("solid_stvk", {kLambda, kMu}), [](const Matrix3& f) {
    const Matrix3 e = 0.5 * (f.transpose() * f - Matrix3::Identity());
    const Matrix3 s = kLambda * e.trace() * Matrix3::Identity() + 2.0 * kMu * e;
    return Textbook{0.5 * kLambda * std::pow(e.trace(), 2) + kMu * (e * e).trace(), f * s};
  });
}

TEST(NamedModels, NeoHookeanSolid) {
  expect_textbook(preset_with("solid_neo_hookean", {0.5 * kMu, kLambda}), [](const Matrix3& f) {
    const double j = f.determinant();
    const Matrix3 inverse = f.inverse().transpose();
    return Textbook{0.5 * kMu * (f.squaredNorm() - 3.0) - kMu * std::log(j) +
                        0.5 * kLambda * std::pow(std::log(j), 2),
                    kMu * (f - inverse) + kLambda * std::log(j) * inverse};
  });
}

TEST(NamedModels, MooneyRivlinSolid) {
  constexpr double k10 = 0.4e5, k01 = 0.15e5, kBulk = 3e5;
  expect_textbook(preset_with("solid_mooney_rivlin", {k10, k01, kBulk}), [&](const Matrix3& f) {
    const double j = f.determinant();
    const Matrix3 c = f.transpose() * f;
    const Matrix3 inverse = f.inverse().transpose();
    const double i1 = c.trace();
    const double i2 = 0.5 * (i1 * i1 - (c * c).trace());
    const double first = std::pow(j, -2.0 / 3.0);
    const double second = std::pow(j, -4.0 / 3.0);
    const Matrix3 by_f_1 = 2.0 * first * (f - i1 / 3.0 * inverse);
    const Matrix3 by_f_2 = 2.0 * second * (i1 * f - f * c - 2.0 / 3.0 * i2 * inverse);
    return Textbook{
        k10 * (i1 * first - 3.0) + k01 * (i2 * second - 3.0) + 0.5 * kBulk * std::pow(j - 1.0, 2),
        k10 * by_f_1 + k01 * by_f_2 + kBulk * (j - 1.0) * j * inverse};
  });
}

TEST(NamedModels, OgdenSolid) {
  constexpr double kMu1 = 0.6e5, kAlpha1 = 1.3, kMu2 = -0.1e5, kAlpha2 = -2.0;
  expect_textbook(
      preset_with("solid_ogden", {kMu1, kAlpha1, kMu2, kAlpha2, kLambda}), [&](const Matrix3& f) {
        const Eigen::JacobiSVD<Matrix3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const double log_j = std::log(f.determinant());
        double energy = 0.5 * kLambda * log_j * log_j - (kMu1 + kMu2) * log_j;
        Eigen::Vector3d stress;
        for (int i = 0; i < 3; ++i) {
          const double l = svd.singularValues()[i];
          energy += kMu1 / kAlpha1 * (std::pow(l, kAlpha1) - 1.0) +
                    kMu2 / kAlpha2 * (std::pow(l, kAlpha2) - 1.0);
          stress[i] = kMu1 * std::pow(l, kAlpha1 - 1.0) + kMu2 * std::pow(l, kAlpha2 - 1.0) -
                      (kMu1 + kMu2) / l + kLambda * log_j / l;
        }
        return Textbook{energy, svd.matrixU() * stress.asDiagonal() * svd.matrixV().transpose()};
      });
}

TEST(NamedModels, OgdenOfAlphaTwoIsNeoHookean) {
  const model::Model neo = model_of({{"solid_neo_hookean", "constant_stress", {0.5 * kMu}}});
  const model::Model ogden = model_of({{"solid_principal_stretches", "ogden", {kMu, 2.0}}});
  Numbers numbers(22);
  Comparison hessian("Ogden against neo-Hookean: Hessian");
  for (int sample = 0; sample < 60; ++sample) {
    Matrix3 f = random_solid(numbers);
    if (sample < 20) f = Matrix3::Identity() + std::pow(10.0, -sample) * f;
    const auto a = energy_at<6>(ogden, z_of(f));
    const auto b = energy_at<6>(neo, z_of(f));
    EXPECT_NEAR(a.energy, b.energy, 1e-10 * kMu);
    EXPECT_NEAR((a.by_z - b.by_z).norm(), 0.0, 1e-12 * kMu);
    for (int i = 0; i < 36; ++i) hessian.add(a.by_zz.data()[i], b.by_zz.data()[i]);
  }
  hessian.judge(1e-9, kMu);
}

Eigen::Matrix2d random_membrane(Numbers& numbers) {
  Eigen::Matrix2d f;
  f << numbers.between(0.7, 1.6), numbers.between(-0.3, 0.3), numbers.between(-0.3, 0.3),
      numbers.between(0.7, 1.6);
  return f;
}

/// Psi and dPsi/dF of a membrane from E and a stiffness matrix on (E_uu, E_vv, 2 E_uv).
void expect_membrane(const model::Model& model, const Eigen::Matrix3d& stiffness) {
  Numbers numbers(23);
  Comparison energy(model.name + ": energy"), stress(model.name + ": stress");
  for (int sample = 0; sample < 100; ++sample) {
    const Eigen::Matrix2d f = random_membrane(numbers);
    const Eigen::Matrix2d c = f.transpose() * f;
    const Eigen::Matrix2d e = 0.5 * (c - Eigen::Matrix2d::Identity());
    const Eigen::Vector3d strain(e(0, 0), e(1, 1), 2.0 * e(0, 1));
    const Eigen::Vector3d s = stiffness * strain;
    Eigen::Matrix2d second;
    second << s[0], s[2], s[2], s[1];
    const Eigen::Matrix2d expected = f * second;
    const auto sum = energy_at<3>(model, Eigen::Vector3d(c(0, 0), c(1, 1), c(0, 1)));
    const Eigen::Matrix2d p = stress_of(f, sum);
    energy.add(sum.energy, 0.5 * strain.dot(s));
    for (int i = 0; i < 4; ++i) stress.add(p.data()[i], expected.data()[i]);
  }
  energy.judge(1e-13, 1.0);
  stress.judge(1e-13, 10.0);
}

// Thesis 4.3: (lambda/2 + mu) eps_1^2 + (lambda/2 + mu) eps_2^2 + lambda eps_1 eps_2 + 2 mu
// eps_12^2
TEST(NamedModels, SaintVenantKirchhoffMembraneInItsThreeAdditiveForms) {
  constexpr double kL = 60.0, kM = 45.0;
  Eigen::Matrix3d stiffness;
  stiffness << kL + 2.0 * kM, kL, 0.0, kL, kL + 2.0 * kM, 0.0, 0.0, 0.0, kM;
  expect_membrane(preset_with("stvk_orthotropic", {kL + 2.0 * kM, kL + 2.0 * kM, kL, kM}),
                  stiffness);
  expect_membrane(preset_with("stvk_isotropic", {kL + kM, kM}), stiffness);
  expect_membrane(
      model_of({{"green_trace", "linear", {kL}}, {"green_square", "constant_stress", {kM}}}),
      stiffness);
}

TEST(NamedModels, OrthotropicSaintVenantKirchhoffMembrane) {
  Eigen::Matrix3d stiffness;
  stiffness << 140.0, 35.0, 0.0, 35.0, 80.0, 0.0, 0.0, 0.0, 22.0;
  expect_membrane(preset_with("stvk_orthotropic", {140.0, 80.0, 35.0, 22.0}), stiffness);
}

}  // namespace
}  // namespace tenter::mechanics
