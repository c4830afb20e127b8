// SPDX-License-Identifier: GPL-3.0-or-later
// What damping and internal friction do to a motion.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "server/mechanics/dynamics/damping.h"
#include "server/mechanics/laws/dahl.h"
#include "tests/server/mechanics/dynamics/motions.h"

namespace tenter::mechanics::testing {
namespace {

constexpr double kStiffness_N_m = 40.0;
constexpr double kMass_kg = 0.02;
constexpr double kLength_m = 0.1;
constexpr double kEta = 0.3;                        // N s/m
constexpr double kDahl[] = {0.3, 2.0, 0.0, 0.004};  // a, b, c, tau
constexpr double kStart_m_s = 0.4, kEnd_s = 0.1;

/// A strip of one quad with masses at its lower end: a spring with one strain, u = z/length.
class Bob {
 public:
  explicit Bob(const model::Model& description)
      : strip_(cloth_of_grid({2, 2, kLength_m, kLength_m}, Diagonals::one).value(), description) {
    boundary_.held = {2, 3};
    loads_ = weight(strip_.cloth.mesh, 1e-9);
    loads_.gravity_m_s2.setZero();
    loads_.node_mass_kg[0] = loads_.node_mass_kg[1] = 0.5 * kMass_kg;
  }

  /// Lengthening at the end.
  double moved_m(TimeScheme scheme, double step_s) {
    State state;
    state.x =
        placed(strip_.cloth.mesh, [](double u, double v) { return Eigen::Vector3d(u, 0.0, v); });
    Motion motion = at_rest(boundary_, state);
    motion.velocity_m_s[2] = motion.velocity_m_s[5] = -kStart_m_s;
    auto stepper = TimeStepper::make(strip_.model, boundary_).value();
    StepOptions options;
    options.scheme = scheme;
    options.tolerance_N = 1e-9;
    const Script script = [&](double) { return StepInput{0.0, loads_, {}, {}}; };
    walked(stepper, strip_.parameters, script, kEnd_s, step_s, options, motion);
    EXPECT_NEAR(motion.at.x[0], 0.0, 1e-9);
    return -motion.at.x[2];
  }

 private:
  Sheet strip_;
  Boundary boundary_;
  Loads loads_;
};

model::Model spring() {
  return linear_model({{"soft_v", kStiffness_N_m}, {"soft_u", 1e3}, {"green_uv", 1e3}});
}

/// m u'' = -w (k eps + eta eps' + friction), by many steps of a leapfrog.
double reference_m(double eta, const double* dahl) {
  constexpr int kFine = 400000;
  const double h = kEnd_s / kFine;
  double u = 0.0, v = kStart_m_s, friction = 0.0, before = 0.0;
  const auto acceleration = [&] {
    const double strain = u / kLength_m;
    if (dahl) friction = dahl_step(before, friction, strain, dahl).stress;
    before = strain;
    return -kLength_m / kMass_kg * (kStiffness_N_m * strain + eta * v / kLength_m + friction);
  };
  double a = acceleration();
  for (int k = 0; k < kFine; ++k) {
    v += 0.5 * h * a;
    u += h * v;
    a = acceleration();
    v += 0.5 * h * a;
  }
  return u;
}

TEST(Damping, FollowsTheRateWithTheOrderOfTheScheme) {
  model::Model description = spring();
  const model::Model damped = with_damping(description, kEta / kStiffness_N_m).value();
  ASSERT_EQ(damped.terms.size(), 6u);
  EXPECT_EQ(damped.terms[3].id, "soft_v_damping");
  EXPECT_DOUBLE_EQ(damped.terms[3].law.parameters[0].value, kEta);
  const double free_m = reference_m(0.0, nullptr);
  const double wanted_m = reference_m(kEta, nullptr);
  ASSERT_GT(std::abs(free_m - wanted_m), 0.05 * std::abs(free_m)) << "damping is to be seen";
  Bob bob(damped);
  for (const TimeScheme scheme : {TimeScheme::implicit_euler, TimeScheme::bdf2}) {
    const double coarse = std::abs(bob.moved_m(scheme, 0.001) - wanted_m);
    const double fine = std::abs(bob.moved_m(scheme, 0.0005) - wanted_m);
    EXPECT_NEAR(order(coarse, fine), scheme == TimeScheme::bdf2 ? 2.0 : 1.0, 0.25)
        << coarse << " " << fine;
    EXPECT_LT(fine, 0.01 * kStart_m_s * kEnd_s);
  }
}

TEST(Friction, FollowsItsLawThroughReversals) {
  model::Model description = spring();
  model::Term friction = description.terms[0];
  friction.id = "friction";
  friction.law.name = "dahl";
  friction.law.parameters.clear();
  for (int k = 0; k < 4; ++k) {
    model::Parameter p;
    p.name = std::string(k == 3 ? "tau" : std::string(1, "abc"[k]));
    p.value = kDahl[k];
    friction.law.parameters.push_back(p);
  }
  description.terms.push_back(friction);
  const double free_m = reference_m(0.0, nullptr);
  const double wanted_m = reference_m(0.0, kDahl);
  ASSERT_GT(std::abs(free_m - wanted_m), 0.1 * std::abs(free_m)) << "friction is to be seen";
  Bob bob(description);
  for (const TimeScheme scheme : {TimeScheme::implicit_euler, TimeScheme::bdf2}) {
    const double coarse = std::abs(bob.moved_m(scheme, 0.001) - wanted_m);
    const double fine = std::abs(bob.moved_m(scheme, 0.0005) - wanted_m);
    EXPECT_GT(order(coarse, fine), scheme == TimeScheme::bdf2 ? 1.5 : 0.75)
        << coarse << " " << fine;
    EXPECT_LT(fine, 0.05 * std::abs(free_m - wanted_m) + 0.05 * std::abs(wanted_m));
  }
}

/// Damping knows strains: what turns as a whole keeps turning.
TEST(Damping, LetsRigidMotionsBe) {
  Swing swing;
  const model::Model plain =
      linear_model({{"green_u", 20.0}, {"green_v", 20.0}, {"green_uv", 6.0}});
  const Sheet elastic(swing.sheet.cloth, plain);
  const Sheet damped(swing.sheet.cloth, with_damping(plain, 0.1).value());
  swing.boundary.held.clear();
  swing.loads.gravity_m_s2.setZero();
  double turned[2];
  const Sheet* sheets[] = {&elastic, &damped};
  for (int k = 0; k < 2; ++k) {
    auto stepper = TimeStepper::make(sheets[k]->model, swing.boundary).value();
    Motion motion = at_rest(swing.boundary, swing.flat_state);
    for (Eigen::Index n = 0; n < motion.at.x.size(); n += 3)
      motion.velocity_m_s.segment<3>(n) =
          Eigen::Vector3d(0.0, 0.0, 2.0)
              .cross(Eigen::Vector3d(motion.at.x.segment<3>(n)) - Eigen::Vector3d(0.05, 0.05, 0.0));
    StepOptions options;
    options.tolerance_N = 1e-9;
    walked(stepper, sheets[k]->parameters, swing.constant(), 0.2, 0.005, options, motion);
    turned[k] = momenta(swing.boundary, swing.loads.node_mass_kg, motion).angular_kg_m2_s.z();
  }
  ASSERT_GT(turned[0], 1e-6);
  EXPECT_NEAR(turned[1], turned[0], 1e-3 * turned[0]);
}

}  // namespace
}  // namespace tenter::mechanics::testing
