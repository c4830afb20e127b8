// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/solid_strain.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <string>
#include <vector>

#include "common/model/catalogue.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/random_solids.h"

namespace tenter::mechanics {
namespace {

using testing::Comparison;
using testing::difference;
using testing::Numbers;
using testing::random_rotation;
using testing::random_solid;
using testing::z_of;

constexpr double kAzimuth = 0.6;
constexpr double kElevation = -0.4;

SolidStrain solid_measure_of(std::string_view name) {
  const auto measure = SolidStrain::make({std::string(name), kAzimuth, kElevation});
  EXPECT_TRUE(measure) << name;
  return *measure;
}

std::vector<model::StrainRow> solid_rows() {
  std::vector<model::StrainRow> rows;
  for (const model::StrainRow& row : model::strain_catalogue())
    if (row.domain == model::Domain::solid) rows.push_back(row);
  EXPECT_GE(rows.size(), 20U);
  return rows;
}

SolidStrainValue value_at(const SolidStrain& measure, const Vector6d& z) {
  SolidStrainValue value;
  measure.evaluate(z, value);
  return value;
}

const Vector6d kRest = (Vector6d() << 1.0, 1.0, 1.0, 0.0, 0.0, 0.0).finished();

TEST(SolidStrain, EveryRowOfTheCatalogueHasOne) {
  for (const model::StrainRow& row : solid_rows())
    EXPECT_EQ(solid_measure_of(row.name).count(), row.strains) << row.name;
  EXPECT_FALSE(SolidStrain::make({"green_u", 0.0, 0.0}));
}

TEST(SolidStrain, VanishesAtRest) {
  for (const model::StrainRow& row : solid_rows()) {
    const SolidStrainValue rest = value_at(solid_measure_of(row.name), kRest);
    for (int i = 0; i < row.strains; ++i) EXPECT_NEAR(rest.value[i], 0.0, 1e-15) << row.name;
  }
}

TEST(SolidStrain, DerivativesAreThoseOfTheValue) {
  constexpr double kStep = 1e-4;
  for (const model::StrainRow& row : solid_rows()) {
    const SolidStrain measure = solid_measure_of(row.name);
    Numbers numbers(1);
    Comparison first(std::string(row.name) + " by z");
    Comparison second(std::string(row.name) + " by z, twice");
    bool curved = false;
    for (int sample = 0; sample < 50; ++sample) {
      const Vector6d z = z_of(random_solid(numbers));
      const SolidStrainValue at = value_at(measure, z);
      for (int i = 0; i < row.strains; ++i) {
        EXPECT_NEAR((at.by_zz[i] - at.by_zz[i].transpose()).norm(), 0.0, 1e-12) << row.name;
        for (int k = 0; k < 6; ++k) {
          const auto moved = [&](double x) {
            Vector6d d = z;
            d[k] = x;
            return value_at(measure, d);
          };
          first.add(at.by_z[i][k],
                    difference([&](double x) { return moved(x).value[i]; }, z[k], kStep));
          const Vector6d bend =
              difference([&](double x) -> Vector6d { return moved(x).by_z[i]; }, z[k], kStep);
          for (int l = 0; l < 6; ++l) {
            second.add(at.by_zz[i](l, k), bend[l]);
            curved = curved || at.by_zz[i](l, k) != 0.0;
          }
        }
      }
    }
    first.judge(1e-6, 0.1);
    second.judge(1e-6, curved ? 1e-2 : 0.0);
    EXPECT_EQ(measure.is_linear(), !curved) << row.name;
  }
}

TEST(SolidStrain, DoesNotSeeRotations) {
  for (const model::StrainRow& row : solid_rows()) {
    const SolidStrain measure = solid_measure_of(row.name);
    Numbers numbers(2);
    Comparison compared(std::string(row.name) + " of RF");
    for (int sample = 0; sample < 50; ++sample) {
      const Eigen::Matrix3d f = random_solid(numbers);
      const SolidStrainValue plain = value_at(measure, z_of(f));
      const SolidStrainValue turned = value_at(measure, z_of(random_rotation(numbers) * f));
      for (int i = 0; i < row.strains; ++i) compared.add(turned.value[i], plain.value[i]);
    }
    compared.judge(1e-12, 0.05);
  }
}

// Definitions, from F itself.
TEST(SolidStrain, MeansWhatItsNameSays) {
  Numbers numbers(3);
  for (int sample = 0; sample < 30; ++sample) {
    const Eigen::Matrix3d f = random_solid(numbers);
    const auto of = [&](const char* name, int i = 0) {
      return value_at(solid_measure_of(name), z_of(f)).value[i];
    };
    constexpr double kRounding = 5e-14;
    const Eigen::Matrix3d c = f.transpose() * f;
    const Eigen::Matrix3d e = 0.5 * (c - Eigen::Matrix3d::Identity());
    const Eigen::Matrix3d square = c * c;
    const double j = f.determinant();
    ASSERT_GT(j, 0.05);
    const char* names[] = {"solid_green_xx", "solid_green_yy", "solid_green_zz",
                           "solid_green_yz", "solid_green_xz", "solid_green_xy"};
    const double entries[] = {e(0, 0), e(1, 1), e(2, 2), c(1, 2), c(0, 2), c(0, 1)};
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(of(names[i]), entries[i], kRounding);
      EXPECT_NEAR(of(i < 3 ? "solid_green_normal" : "solid_green_shear", i % 3), entries[i],
                  kRounding);
    }
    const double i1 = c.trace();
    const double i2 = 0.5 * (i1 * i1 - square.trace());
    EXPECT_NEAR(of("solid_green_trace"), e.trace(), kRounding);
    EXPECT_NEAR(of("solid_green_square"), (e * e).trace(), kRounding);
    EXPECT_NEAR(of("solid_invariant_1"), i1 - 3.0, kRounding);
    EXPECT_NEAR(of("solid_invariant_2"), i2 - 3.0, kRounding);
    EXPECT_NEAR(of("solid_isochoric_1"), i1 * std::pow(j, -2.0 / 3.0) - 3.0, kRounding);
    EXPECT_NEAR(of("solid_isochoric_2"), i2 * std::pow(j, -4.0 / 3.0) - 3.0, kRounding);
    EXPECT_NEAR(of("solid_log_volume"), std::log(j), kRounding);
    EXPECT_NEAR(of("solid_volume"), j - 1.0, kRounding);
    EXPECT_NEAR(of("solid_neo_hookean"), i1 - 3.0 - 2.0 * std::log(j), kRounding);
    const Eigen::Vector3d stretches = Eigen::JacobiSVD<Eigen::Matrix3d>(f).singularValues();
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(of("solid_principal_stretches", i), stretches[i] - 1.0, kRounding);
    const Eigen::Vector3d a(std::cos(kElevation) * std::cos(kAzimuth),
                            std::cos(kElevation) * std::sin(kAzimuth), std::sin(kElevation));
    EXPECT_NEAR(of("solid_fibre"), (f * a).norm() - 1.0, kRounding);
    EXPECT_NEAR(of("solid_green_fibre"), 0.5 * ((f * a).squaredNorm() - 1.0), kRounding);
  }
}

TEST(SolidStrain, AnswersCollapsedElementsWithFiniteNumbers) {
  Numbers numbers(4);
  std::vector<Eigen::Matrix3d> flat = {Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity()};
  flat.back()(2, 2) = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    flat.push_back(random_solid(numbers));
    flat.back().col(2) = flat.back().col(0) + (sample % 2) * 1e-13 * flat.back().col(1);
  }
  for (const model::StrainRow& row : solid_rows()) {
    for (const Eigen::Matrix3d& f : flat) {
      const SolidStrainValue at = value_at(solid_measure_of(row.name), z_of(f));
      for (int i = 0; i < row.strains; ++i) {
        EXPECT_TRUE(std::isfinite(at.value[i])) << row.name;
        EXPECT_TRUE(at.by_z[i].allFinite()) << row.name;
        EXPECT_TRUE(at.by_zz[i].allFinite()) << row.name;
      }
    }
  }
}

}  // namespace
}  // namespace tenter::mechanics
