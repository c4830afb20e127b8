// SPDX-License-Identifier: GPL-3.0-or-later
// Energy limits of one element in equilibrium, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/server/mechanics/assembly/model_checks.h"
#include "tests/server/mechanics/assembly/solid_bodies.h"

namespace tenter::mechanics {
namespace {

/// A cube of one hexahedron of 0.1 m, stretched along x with its sides held: x = diag(s, 1, 1) X.
/// One unknown, pulled by a force on the end.
class Bar {
 public:
  explicit Bar(const model::Model& description)
      : mesh_(box_hexahedra(1, 1, 1, {kSide, kSide, kSide}).value()),
        model_(MeshModel::make(description, mesh_).value()),
        parameters_(term_parameters(description)),
        matrix_(model_.matrix()) {
    limits_.multiplier.setZero(model_.limited_count());
    along_ = affine(mesh_, Eigen::Vector3d(1.0, 0.0, 0.0).asDiagonal());
  }

  struct Energy {
    double value, slope, curvature;  ///< over the volume, by s
  };
  Energy at(double s, bool enforced = true) {
    Answer answer;
    EXPECT_EQ(
        model_.evaluate(position(s), parameters_, {&answer.energy, &answer.gradient, &matrix_},
                        enforced ? &limits_ : nullptr),
        AssemblyStatus::ok);
    Eigen::VectorXd product = Eigen::VectorXd::Zero(along_.size());
    matrix_.multiply_add(along_.data(), product.data());
    const double volume = kSide * kSide * kSide;
    return {answer.energy / volume, answer.gradient.dot(along_) / volume,
            along_.dot(product) / volume};
  }

  /// Minimum of the energy less stress x s, by Newton's method with a line search.
  double pull(double stress, double s) {
    for (int iteration = 0; iteration < 200; ++iteration) {
      const Energy here = at(s);
      const double slope = here.slope - stress;
      if (std::abs(slope) <= 1e-12 * stress) break;
      double step = -slope / std::abs(here.curvature);
      const auto lower = [&] {
        return at(s + step).value - stress * (s + step) < here.value - stress * s;
      };
      while (std::abs(step) > 1e-15 && !lower()) step *= 0.5;
      s += step;
    }
    return s;
  }

  /// Turns until the multipliers rest; returns s.
  double equilibrium(double stress, double penalty) {
    limits_.penalty = penalty;
    double s = 1.0;
    for (turns_ = 1; turns_ < 100; ++turns_) {
      s = pull(stress, s);
      if (update_multipliers(excess(s), limits_) < 1e-10) break;
    }
    return s;
  }

  Eigen::VectorXd excess(double s) const {
    Eigen::VectorXd result;
    EXPECT_EQ(model_.limit_excess(position(s), parameters_, result), AssemblyStatus::ok);
    return result;
  }
  EnergyLimitState& limits() { return limits_; }
  int turns() const { return turns_; }

 private:
  static constexpr double kSide = 0.1;
  Eigen::VectorXd position(double s) const {
    return affine(mesh_, Eigen::Vector3d(s, 1.0, 1.0).asDiagonal());
  }

  SolidMesh mesh_;
  MeshModel model_;
  Eigen::VectorXd parameters_;
  NodeMatrix matrix_;
  EnergyLimitState limits_;
  Eigen::VectorXd along_;
  int turns_ = 0;
};

/// Zero of a function that rises from lo to hi.
double root(const std::function<double(double)>& f, double lo, double hi) {
  EXPECT_LT(f(lo), 0.0);
  EXPECT_GT(f(hi), 0.0);
  for (int k = 0; k < 200; ++k) (f(0.5 * (lo + hi)) < 0.0 ? lo : hi) = 0.5 * (lo + hi);
  return 0.5 * (lo + hi);
}

// mu/2 (I_1 - 3 - 2 ln J) and lambda/2 (ln J)^2 at J = s. Pulled beyond the limit on either or
// both, the bar stops where psi = psi_max and the multiplier makes up for the missing stress:
// P = psi_total' + l psi_limited'.
TEST(EnergyLimit, ABarStopsAtItsLimit) {
  const model::Model plain = model::preset("solid_neo_hookean").value();
  const double mu = 2.0 * term_parameters(plain)[0];
  const double lambda = term_parameters(plain)[1];
  const auto shape = [&](double s) { return 0.5 * mu * (s * s - 1.0) - mu * std::log(s); };
  const auto volume = [&](double s) { return 0.5 * lambda * std::log(s) * std::log(s); };
  const auto shape_slope = [&](double s) { return mu * (s - 1.0 / s); };
  const auto volume_slope = [&](double s) { return lambda * std::log(s) / s; };
  struct Case {
    std::vector<std::string> terms;
    double shape, volume;  ///< 1 where limited
  };
  const Case cases[] = {{{"shape"}, 1.0, 0.0}, {{"volume"}, 0.0, 1.0}, {{}, 1.0, 1.0}};
  for (const Case& c : cases) {
    const auto psi = [&](double s) { return c.shape * shape(s) + c.volume * volume(s); };
    const auto slope = [&](double s) {
      return c.shape * shape_slope(s) + c.volume * volume_slope(s);
    };
    const double s_max = 1.3;
    const double psi_max = psi(s_max);
    for (const double load : {1.2, 2.0, 5.0}) {
      SCOPED_TRACE((c.terms.empty() ? "all" : c.terms[0]) + " x " + std::to_string(load));
      model::Model description = plain;
      description.limits = {limit_of(description, c.terms)};
      description.limits[0].energy_max = psi_max;
      Bar bar(description);
      const double free_slope = shape_slope(s_max) + volume_slope(s_max);
      const double stress = load * free_slope;
      const double expected = (stress - free_slope) / slope(s_max);
      EXPECT_GT(expected, 0.1);
      const double s = bar.equilibrium(stress, 10.0 * (1.0 + expected) / psi_max);
      EXPECT_NEAR(s, s_max, 1e-7);
      EXPECT_LE(psi(s), psi_max * (1.0 + 1e-6));
      const Eigen::VectorXd excess = bar.excess(s);
      ASSERT_EQ(excess.size(), 8);
      for (int k = 0; k < 8; ++k) {
        EXPECT_NEAR(excess[k], psi(s) - psi_max, 1e-12 * psi_max);
        EXPECT_NEAR(bar.limits().multiplier[k], expected, 1e-6 * expected);
      }
      EXPECT_LT(bar.turns(), 30);
    }
    // pulled less, the limit is not felt
    model::Model description = plain;
    description.limits = {limit_of(description, c.terms)};
    description.limits[0].energy_max = psi_max;
    Bar bar(description);
    const double stress = 0.8 * (shape_slope(s_max) + volume_slope(s_max));
    const double s = bar.equilibrium(stress, 10.0 / psi_max);
    const double free =
        root([&](double at) { return shape_slope(at) + volume_slope(at) - stress; }, 1.0, s_max);
    EXPECT_NEAR(s, free, 1e-10);
    EXPECT_EQ(bar.limits().multiplier.maxCoeff(), 0.0);
  }
}

// Where a = 0: energy and slope go through, the curvature jumps by mu psi'^2.
TEST(EnergyLimit, TheSlopeIsContinuousWhereALimitBegins) {
  model::Model description = model::preset("solid_neo_hookean").value();
  description.limits = {limit_of(description, {})};
  description.limits[0].energy_max = 5e3;
  Bar bar(description);
  for (const double multiplier : {0.0, 0.7}) {
    bar.limits().penalty = 2e-3;
    bar.limits().multiplier.setConstant(multiplier);
    const auto a = [&](double s) {
      return multiplier + bar.limits().penalty * bar.excess(s).maxCoeff();
    };
    const double begin = root(a, 1.05, 2.0);
    const double step = 1e-7;
    const Bar::Energy before = bar.at(begin - step), after = bar.at(begin + step);
    const Bar::Energy own = bar.at(begin, false);
    const double part = -0.5 * multiplier * multiplier / bar.limits().penalty;
    EXPECT_NEAR(bar.at(begin - 0.01).value - bar.at(begin - 0.01, false).value, part,
                1e-12 * own.value);
    EXPECT_NEAR(before.value, own.value + part - step * own.slope, 1e-9 * own.value);
    EXPECT_NEAR(after.value, own.value + part + step * own.slope, 1e-9 * own.value);
    EXPECT_NEAR(before.slope, own.slope, 1e-5 * own.slope);
    EXPECT_NEAR(after.slope, own.slope, 1e-4 * own.slope);
    const double jump = bar.limits().penalty * own.slope * own.slope;
    EXPECT_GT(jump, 10.0 * own.curvature);
    EXPECT_NEAR(before.curvature, own.curvature, 1e-5 * own.curvature);
    EXPECT_NEAR(after.curvature - before.curvature, jump, 1e-4 * jump);
  }
}

}  // namespace
}  // namespace tenter::mechanics
