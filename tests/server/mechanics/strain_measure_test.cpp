// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/strain_measure.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/model/catalogue.h"
#include "server/mechanics/homogeneous_strain.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::mechanics {
namespace {

using testing::Comparison;
using testing::difference;
using testing::Numbers;

constexpr double kAngle = 0.6;

StrainMeasure measure_of(std::string_view name, double angle_rad = kAngle) {
  model::StrainMeasure description;
  description.name = name;
  description.angle_rad = angle_rad;
  const auto measure = StrainMeasure::make(description);
  EXPECT_TRUE(measure) << name;
  return *measure;
}

/// Rows that a piece of membrane answers.
std::vector<model::StrainRow> membrane_rows() {
  std::vector<model::StrainRow> rows;
  for (const model::StrainRow& row : model::strain_catalogue())
    if (row.at_point) rows.push_back(row);
  EXPECT_GE(rows.size(), 20U);
  return rows;
}

/// Large strains, shear included, never near collapse.
Eigen::Matrix2d random_deformation(Numbers& numbers) {
  Eigen::Matrix2d f;
  f << numbers.between(0.7, 1.6), numbers.between(-0.3, 0.3), numbers.between(-0.3, 0.3),
      numbers.between(0.7, 1.6);
  return f;
}

Eigen::Vector3d cauchy_green(const Eigen::Matrix2d& f) {
  const Eigen::Matrix2d c = f.transpose() * f;
  return {c(0, 0), c(1, 1), c(0, 1)};
}

StrainValue value_at(const StrainMeasure& measure, const Eigen::Vector3d& c) {
  StrainValue value;
  measure.evaluate(c, value);
  return value;
}

TEST(StrainMeasure, EveryRowOfTheCatalogueHasOne) {
  for (const model::StrainRow& row : membrane_rows()) {
    EXPECT_EQ(measure_of(row.name).count(), row.strains) << row.name;
    EXPECT_TRUE(row.domain == model::Domain::membrane || row.domain == model::Domain::edge);
  }
}

TEST(StrainMeasure, UnknownNamesAreRefused) {
  model::StrainMeasure description;
  description.name = "no_such_strain";
  EXPECT_FALSE(StrainMeasure::make(description));
  for (const char* elsewhere : {"bend_u", "ring2_v", "solid_volume"}) {
    description.name = elsewhere;
    EXPECT_FALSE(StrainMeasure::make(description)) << elsewhere;
  }
}

TEST(StrainMeasure, VanishesAtRest) {
  for (const model::StrainRow& row : membrane_rows()) {
    const StrainValue rest = value_at(measure_of(row.name), {1.0, 1.0, 0.0});
    for (int i = 0; i < row.strains; ++i) EXPECT_NEAR(rest.value[i], 0.0, 1e-15) << row.name;
  }
}

TEST(StrainMeasure, DerivativesAreThoseOfTheValue) {
  constexpr double kStep = 1e-4;
  for (const model::StrainRow& row : membrane_rows()) {
    const StrainMeasure measure = measure_of(row.name);
    Numbers numbers(1);
    Comparison first(std::string(row.name) + " by c");
    Comparison second(std::string(row.name) + " by c, twice");
    bool curved = false;
    for (int sample = 0; sample < 50; ++sample) {
      const Eigen::Vector3d c = cauchy_green(random_deformation(numbers));
      const StrainValue at = value_at(measure, c);
      for (int i = 0; i < row.strains; ++i) {
        EXPECT_NEAR((at.by_cc[i] - at.by_cc[i].transpose()).norm(), 0.0, 1e-14) << row.name;
        for (int k = 0; k < 3; ++k) {
          const auto moved = [&](double x) {
            Eigen::Vector3d d = c;
            d[k] = x;
            return value_at(measure, d);
          };
          first.add(at.by_c[i][k],
                    difference([&](double x) { return moved(x).value[i]; }, c[k], kStep));
          for (int l = 0; l < 3; ++l) {
            second.add(at.by_cc[i](k, l),
                       difference([&](double x) { return moved(x).by_c[i][l]; }, c[k], kStep));
            curved = curved || at.by_cc[i](k, l) != 0.0;
          }
        }
      }
    }
    first.judge(1e-6, 0.1);
    second.judge(1e-6, curved ? 1e-3 : 0.0);
    EXPECT_EQ(measure.is_linear(), !curved) << row.name;
  }
}

TEST(StrainMeasure, AnswersACollapsedMembraneWithFiniteNumbers) {
  for (const model::StrainRow& row : membrane_rows()) {
    for (const Eigen::Vector3d& c : {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(1.0, 0.0, 0.0),
                                     Eigen::Vector3d(1.0, 1.0, 1.0), Eigen::Vector3d(1, 1, -1)}) {
      const StrainValue at = value_at(measure_of(row.name), c);
      for (int i = 0; i < row.strains; ++i) {
        EXPECT_TRUE(std::isfinite(at.value[i])) << row.name;
        EXPECT_TRUE(at.by_c[i].allFinite()) << row.name;
        EXPECT_TRUE(at.by_cc[i].allFinite()) << row.name;
      }
    }
  }
}

TEST(StrainMeasure, DoesNotSeeRotations) {
  for (const model::StrainRow& row : membrane_rows()) {
    const StrainMeasure measure = measure_of(row.name);
    Numbers numbers(2);
    Comparison compared(std::string(row.name) + " of RF");
    for (int sample = 0; sample < 50; ++sample) {
      const Eigen::Matrix2d f = random_deformation(numbers);
      const Eigen::Rotation2Dd turn(numbers.between(-std::numbers::pi, std::numbers::pi));
      const StrainValue plain = value_at(measure, cauchy_green(f));
      const StrainValue turned = value_at(measure, cauchy_green(turn.toRotationMatrix() * f));
      for (int i = 0; i < row.strains; ++i) compared.add(turned.value[i], plain.value[i]);
    }
    compared.judge(1e-13, 0.05);
  }
}

// Definitions of the catalogue, from F itself.
TEST(StrainMeasure, MeansWhatItsNameSays) {
  Numbers numbers(3);
  for (int sample = 0; sample < 20; ++sample) {
    const Eigen::Matrix2d f = random_deformation(numbers);
    const Eigen::Vector3d c = cauchy_green(f);
    const auto of = [&](const char* name, int i = 0) {
      return value_at(measure_of(name), c).value[i];
    };
    const Eigen::Vector2d u = f.col(0);
    const Eigen::Vector2d v = f.col(1);
    const Eigen::Vector2d plus = f * Eigen::Vector2d(std::cos(kAngle), std::sin(kAngle));
    const Eigen::Vector2d minus = f * Eigen::Vector2d(std::cos(kAngle), -std::sin(kAngle));
    const Eigen::Vector2d diagonal = f * Eigen::Vector2d(1.0, 1.0).normalized();
    const Eigen::Vector2d other = f * Eigen::Vector2d(1.0, -1.0).normalized();
    constexpr double kRounding = 1e-14;
    EXPECT_NEAR(of("green_u"), 0.5 * (u.squaredNorm() - 1.0), kRounding);
    EXPECT_NEAR(of("green_v"), 0.5 * (v.squaredNorm() - 1.0), kRounding);
    EXPECT_NEAR(of("green_uv"), u.dot(v), kRounding);
    EXPECT_NEAR(of("green_trace"), of("green_u") + of("green_v"), kRounding);
    EXPECT_NEAR(of("green_deviator", 0), of("green_u") - of("green_v"), kRounding);
    EXPECT_NEAR(of("green_deviator", 1), u.dot(v), kRounding);
    EXPECT_NEAR(of("green_pair", 0), of("green_u"), kRounding);
    EXPECT_NEAR(of("green_pair", 1), of("green_v"), kRounding);
    EXPECT_NEAR(of("soft_u"), u.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("soft_v"), v.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("soft_pair", 0), u.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("soft_pair", 1), v.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("spring_u"), u.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("spring_v"), v.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("spring_d1"), diagonal.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("spring_d2"), other.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("fibre"), plus.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("fibre_pair", 1), minus.norm() - 1.0, kRounding);
    EXPECT_NEAR(of("green_fibre"), 0.5 * (plus.squaredNorm() - 1.0), kRounding);
    EXPECT_NEAR(of("green_fibre_pair", 1), 0.5 * (minus.squaredNorm() - 1.0), kRounding);
    EXPECT_NEAR(of("area"), f.determinant() - 1.0, kRounding);
    const Eigen::Matrix2d e = 0.5 * (f.transpose() * f - Eigen::Matrix2d::Identity());
    EXPECT_NEAR(of("green_square"), (e * e).trace(), kRounding);
    const Eigen::Vector2d stretches = Eigen::JacobiSVD<Eigen::Matrix2d>(f).singularValues();
    EXPECT_NEAR(of("principal_stretches", 0), stretches[0] - 1.0, kRounding);
    EXPECT_NEAR(of("principal_stretches", 1), stretches[1] - 1.0, kRounding);
  }
}

TEST(HomogeneousStrain, IsTheCauchyGreenTensorInMaterialAxes) {
  Numbers numbers(4);
  for (int sample = 0; sample < 50; ++sample) {
    const double angle = numbers.between(-3.0, 3.0);
    const Eigen::Vector3d q(numbers.between(0.7, 1.6), numbers.between(0.7, 1.6),
                            numbers.between(-0.4, 0.4));
    Eigen::Matrix2d f;
    f << q[0], q[2], 0.0, q[1];
    // the weft, in test axes, is turned back by the angle from the weft to the test's x axis
    const Eigen::Matrix2d axes = Eigen::Rotation2Dd(-angle).toRotationMatrix();
    const Eigen::Vector3d expected = cauchy_green(f * axes);
    const HomogeneousStrain kinematics(angle);
    EXPECT_NEAR((kinematics.c(q) - expected).norm(), 0.0, 1e-14);
  }
}

TEST(HomogeneousStrain, DerivativesAreThoseOfTheValue) {
  Numbers numbers(5);
  Comparison first("c by q");
  Comparison second("c by q, twice");
  for (int sample = 0; sample < 20; ++sample) {
    const HomogeneousStrain kinematics(numbers.between(-3.0, 3.0));
    const Eigen::Vector3d q(numbers.between(0.7, 1.6), numbers.between(0.7, 1.6),
                            numbers.between(-0.4, 0.4));
    const Eigen::Matrix3d by_q = kinematics.c_by_q(q);
    for (int k = 0; k < 3; ++k) {
      const auto moved = [&](double x) {
        Eigen::Vector3d d = q;
        d[k] = x;
        return d;
      };
      const Eigen::Vector3d slope =
          difference([&](double x) { return kinematics.c(moved(x)); }, q[k], 1e-3);
      const Eigen::Matrix3d bend =
          difference([&](double x) { return kinematics.c_by_q(moved(x)); }, q[k], 1e-3);
      for (int i = 0; i < 3; ++i) {
        first.add(by_q(i, k), slope[i]);
        for (int l = 0; l < 3; ++l) second.add(kinematics.c_by_qq(i)(l, k), bend(i, l));
      }
    }
  }
  first.judge(1e-9, 1.0);
  second.judge(1e-9, 1.0);
}

}  // namespace
}  // namespace tenter::mechanics
