// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/convexity.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "common/model/presets.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/law_checks.h"
#include "tests/server/mechanics/point_energy.h"
#include "tests/server/mechanics/random_solids.h"

namespace tenter::mechanics {
namespace {

using testing::difference;
using testing::energy_at;
using testing::law_with;
using testing::model_of;
using testing::Numbers;
using testing::values_of;

std::vector<double> values_of_model(const model::Model& model) {
  std::vector<double> values;
  for (const model::Term& term : model.terms)
    for (const model::Parameter& p : term.law.parameters) values.push_back(p.value);
  return values;
}

std::shared_ptr<const Law> made(const model::Law& law, int strains) {
  const auto result = make_law(law, strains);
  EXPECT_TRUE(result);
  return *result;
}

TEST(LawConvexity, FindsTheSmallestTangentAndItsStrain) {
  // tangent of k eps exp(beta eps^2) is smallest at rest
  const model::Law fibre = law_with("exponential_fibre", {80.0, 6.0});
  const Convexity at = law_convexity(*made(fibre, 1), values_of(fibre).data(), -0.2, 0.4, 61);
  EXPECT_NEAR(at.smallest, 80.0, 1e-9);
  EXPECT_NEAR(at.strain[0], 0.0, 1e-12);
  EXPECT_EQ(at.sample, 20);
  EXPECT_GT(at.largest, 200.0);
}

TEST(LawConvexity, OfABilinearLawIsMinusItsCoefficient) {
  const model::Law coupling = law_with("bilinear", {35.0});
  const Convexity at = law_convexity(*made(coupling, 2), values_of(coupling).data(), -0.1, 0.1, 5);
  EXPECT_NEAR(at.smallest, -35.0, 1e-12);
  EXPECT_NEAR(at.largest, 35.0, 1e-12);
}

TEST(LawConvexity, ConvexSplinesAreConvexForAllNonNegativeParameters) {
  Numbers numbers(51);
  double largest = 0.0;
  int hermite_concave = 0;
  for (int sample = 0; sample < 200; ++sample) {
    std::vector<double> values(static_cast<std::size_t>(2 + sample % 9));
    for (double& value : values)
      value = numbers.between(0.0, 1.0) < 0.4 ? 0.0 : numbers.between(0.0, 500.0);
    const model::Law convex = law_with("convex_spline", values, -0.1, 0.3);
    const Convexity at = law_convexity(*made(convex, 1), values.data(), -0.3, 0.6, 301);
    EXPECT_GE(at.smallest, -1e-12 * std::max(at.largest, 1.0)) << sample;
    largest = std::max(largest, at.largest);
    const model::Law hermite = law_with("hermite_stiffness", values, -0.1, 0.3);
    if (law_convexity(*made(hermite, 1), values.data(), -0.3, 0.6, 301).smallest < -1.0)
      ++hermite_concave;
  }
  EXPECT_GT(largest, 300.0);
  EXPECT_GT(hermite_concave, 20);  // the same check does see energies that are not
}

/// d2Psi/dF2 by differences of the energy's gradient.
TEST(ModelConvexity, IsTheSmallestEigenvalueOfTheHessianByF) {
  model::Model model = model::preset("solid_mooney_rivlin").value();
  const model::Model ogden = model::preset("solid_ogden").value();
  model.terms.insert(model.terms.end(), ogden.terms.begin(), ogden.terms.end());
  const std::vector<double> values = values_of_model(model);
  Numbers numbers(52);
  double least = 0.0;
  for (int sample = 0; sample < 10; ++sample) {
    const Eigen::Matrix3d f = testing::random_solid(numbers);
    Eigen::Matrix<double, 9, 9> hessian;
    for (int k = 0; k < 9; ++k) {
      const Eigen::Matrix3d column = difference(
          [&](double x) -> Eigen::Matrix3d {
            Eigen::Matrix3d moved = f;
            moved.data()[k] = x;
            return testing::stress_of(moved, energy_at<6>(model, testing::z_of(moved)));
          },
          f.data()[k], 1e-4);
      hessian.col(k) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(column.data());
    }
    const double expected =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (hessian + hessian.transpose()))
            .eigenvalues()[0];
    const auto at = model_convexity(model, Body::solid, values, {f});
    ASSERT_TRUE(at) << at.error().message;
    EXPECT_NEAR(at->smallest, expected, 1e-7 * hessian.norm());
    least = std::min(least, at->smallest);
  }
  EXPECT_LT(least, -1e3);  // energies of F are not convex at large rotations and compressions
}

TEST(ModelConvexity, SeesALargeNegativeLambda) {
  // thesis 4.2.3: stable at rest where lambda + mu >= 0 in two dimensions
  const auto smallest = [](double coupling) {
    const model::Model model = model_of({{"green_u", "linear", {100.0}},
                                         {"green_v", "linear", {100.0}},
                                         {"green_pair", "bilinear", {coupling}},
                                         {"green_uv", "linear", {40.0}}});
    const auto at = model_convexity(model, Body::membrane, values_of_model(model),
                                    {Eigen::Matrix2d::Identity()});
    EXPECT_TRUE(at);
    return at->smallest;
  };
  EXPECT_NEAR(smallest(-90.0), 0.0, 1e-12);  // only the rotation costs nothing
  EXPECT_NEAR(smallest(-120.0), -20.0, 1e-10);
}

TEST(ModelConvexity, ACompressedMembraneBucklesOutOfItsPlaneOnly) {
  const model::Model model = model::preset("stvk_orthotropic").value();
  const std::vector<double> values = values_of_model(model);
  const Eigen::MatrixXd pressed = Eigen::Vector2d(0.98, 1.0).asDiagonal();
  const auto flat = model_convexity(model, Body::membrane, values, {pressed});
  const auto free = model_convexity(model, Body::membrane, values, {pressed}, -1, false);
  ASSERT_TRUE(flat && free);
  // the weft's stress 100 (0.98^2 - 1)/2 is the stiffness against moving out of the plane
  EXPECT_NEAR(free->smallest, 0.5 * 100.0 * (0.98 * 0.98 - 1.0), 1e-9);
  EXPECT_GT(flat->smallest, free->smallest + 0.1);
}

TEST(ModelConvexity, LooksAtOneTermAndRefusesTheOtherBody) {
  const model::Model model = model::preset("stvk_orthotropic").value();
  const std::vector<double> values = values_of_model(model);
  const std::vector<Eigen::MatrixXd> stretched = {Eigen::Matrix2d::Identity() * 1.1};
  const auto weft = model_convexity(model, Body::membrane, values, stretched, 0);
  ASSERT_TRUE(weft);
  EXPECT_EQ(weft->sample, 0);
  EXPECT_GE(weft->smallest, -1e-9);
  const auto coupling = model_convexity(model, Body::membrane, values, stretched, 2);
  ASSERT_TRUE(coupling);
  EXPECT_LT(coupling->smallest, -5.0);
  EXPECT_FALSE(model_convexity(model, Body::solid, values, {Eigen::Matrix3d::Identity()}));
  EXPECT_FALSE(model_convexity(model, Body::membrane, values, {Eigen::Matrix3d::Identity()}));
  EXPECT_FALSE(model_convexity(model, Body::membrane, {1.0}, stretched));
}

}  // namespace
}  // namespace tenter::mechanics
