// SPDX-License-Identifier: GPL-3.0-or-later
// What brings a time step with friction to its end quickly, and must not change where that is: the
// law linearised ahead, and secants on an old factor.
#include <gtest/gtest.h>

#include "server/mechanics/dynamics/step.h"
#include "server/mechanics/equilibrium/secants.h"
#include "tests/server/mechanics/assembly/solid_bodies.h"
#include "tests/server/mechanics/elements/element_checks.h"
#include "tests/server/mechanics/history/friction.h"
#include "tests/server/mechanics/sparse/matrices.h"

namespace tenter::mechanics {
namespace {

using testing::HeldSheet;

/// A place near `x`, a millimetre at most on each axis.
Eigen::VectorXd moved(Eigen::VectorXd x, double by_m, unsigned seed) {
  tenter::testing::Numbers numbers(seed);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += numbers.between(-by_m, by_m);
  return x;
}

TEST(LookingAhead, IsTheLawAtItsPlaceAndHasNoKink) {
  const HeldSheet sheet(5, testing::rubbing_cloth());
  const MeshModel& model = sheet.model;
  const Eigen::VectorXd rest = moved(sheet.start.x, 1e-3, 9);
  History history = model.never_strained();
  ASSERT_EQ(model.end_of_step(moved(rest, 4e-4, 1), sheet.parameters, history, history.state),
            AssemblyStatus::ok);
  const Eigen::VectorXd end = moved(rest, 4e-4, 2);
  ASSERT_EQ(model.end_of_step(end, sheet.parameters, history, history.ahead), AssemblyStatus::ok);
  const auto evaluate = [&](const Eigen::VectorXd& y, bool is_ahead, NodeMatrix* into) {
    History from = history;
    from.is_ahead = is_ahead;
    Answer answer;
    EXPECT_EQ(model.evaluate(y, sheet.parameters, {&answer.energy, &answer.gradient, into}, nullptr,
                             &from),
              AssemblyStatus::ok);
    return answer;
  };
  const Answer exact = evaluate(end, false, nullptr), ahead = evaluate(end, true, nullptr);
  const double scale = exact.gradient.lpNorm<Eigen::Infinity>();
  ASSERT_GT(scale, 1e-3);
  EXPECT_LT((exact.gradient - ahead.gradient).lpNorm<Eigen::Infinity>(), 1e-12 * scale);
  const Eigen::VectorXd away = moved(rest, 4e-4, 3);
  EXPECT_GT((evaluate(away, false, nullptr).gradient - evaluate(away, true, nullptr).gradient)
                .lpNorm<Eigen::Infinity>(),
            1e-2 * scale)
      << "elsewhere it is not the law";
  // its stiffness is that of its energy where the strains are ahead
  NodeMatrix matrix = model.matrix();
  check_derivatives(
      [&](const Eigen::VectorXd& y, NodeMatrix* into) { return evaluate(y, true, into); }, matrix,
      end, 4e-8, 1e-6);
  // where every strain is what it was at the start the law has its kinks, the linearisation none
  const Eigen::VectorXd kink = moved(rest, 4e-4, 1);
  const Eigen::VectorXd way = moved(Eigen::VectorXd::Zero(kink.size()), 1.0, 5);
  const auto jump = [&](bool is_ahead) {
    Eigen::VectorXd forces = Eigen::VectorXd::Zero(way.size()), other = forces;
    evaluate(kink + 1e-8 * way, is_ahead, &matrix);
    matrix.multiply_add(way.data(), forces.data());
    evaluate(kink - 1e-8 * way, is_ahead, &matrix);
    matrix.multiply_add(way.data(), other.data());
    EXPECT_GT(forces.lpNorm<Eigen::Infinity>(), 10.0);
    return (forces - other).lpNorm<Eigen::Infinity>() / forces.lpNorm<Eigen::Infinity>();
  };
  EXPECT_GT(jump(false), 0.05);
  EXPECT_LT(jump(true), 1e-4);
}

TEST(LookingAhead, DoesNotChangeTheStep) {
  const HeldSheet sheet(7, testing::rubbing_cloth());
  auto stepper = TimeStepper::make(sheet.model, sheet.boundary).value();
  StepInput input;
  input.duration_s = 0.005;
  const auto masses = lumped_masses_kg(sheet.cloth.mesh, 0.2);
  input.loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  input.loads.gravity_m_s2 = {0.0, 0.0, -9.81};
  StepOptions options;
  options.scheme = TimeScheme::implicit_euler;
  options.tolerance_N = 1e-10;
  Motion motion = at_rest(sheet.boundary, sheet.start);
  for (int k = 0; k < 4; ++k) {
    const auto step = stepper.step(sheet.parameters, input, motion, options);
    ASSERT_TRUE(step && step->is_good(options));
  }
  // without a step before there is nothing to go on from, and implicit Euler asks for none
  Motion blind = motion;
  blind.last_step_s = 0.0;
  const Eigen::VectorXd before = motion.at.x;
  for (Motion* from : {&motion, &blind}) {
    const auto step = stepper.step(sheet.parameters, input, *from, options);
    ASSERT_TRUE(step && step->is_good(options));
  }
  const double way = (motion.at.x - before).lpNorm<Eigen::Infinity>();
  ASSERT_GT(way, 1e-5);
  EXPECT_LT((motion.at.x - blind.at.x).lpNorm<Eigen::Infinity>(), 1e-7 * way);
  EXPECT_LT((motion.history - blind.history).lpNorm<Eigen::Infinity>(),
            1e-6 * motion.history.lpNorm<Eigen::Infinity>());
}

// K = the factor's, and another matrix of the same pattern: steps with K^-1 alone do not come to
// the other's solution, with secants they do.
TEST(Secants, LearnWhatTheFactorDoesNotKnow) {
  std::mt19937 random(3);
  const test::TestMatrix old = test::cloth_matrix(4, random);
  test::TestMatrix real = old;
  for (int j = 0; j < real.pattern.size; ++j)  // as friction does: stiffer in places
    if (j % 5 == 0) {
      const auto diagonal =
          static_cast<std::size_t>(real.pattern.column_start[static_cast<std::size_t>(j)]);
      real.values[diagonal] *= 4.0;
    }
  const auto factor = make_factor();
  factor->analyze(old.pattern);
  ASSERT_EQ(factor->factorize(old.values.data()), FactorStatus::ok);
  const int n = old.pattern.size;
  const std::vector<double> load = test::random_vector(n, random);
  const Eigen::Map<const Eigen::VectorXd> b(load.data(), n);
  const auto left_after = [&](int steps, bool learns) {
    Secants secants;
    secants.forget(n);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(n), gradient = -b, next(n), step;
    for (int k = 0; k < steps; ++k) {
      secants.solve(*factor, gradient, step);
      x += step;
      multiply(real.pattern, real.values.data(), x.data(), next.data());
      next -= b;
      if (learns) secants.learn(step, gradient, next);
      gradient = next;
    }
    return gradient.norm() / b.norm();
  };
  EXPECT_GT(left_after(12, false), 0.1);
  EXPECT_LT(left_after(12, true), 1e-2);
  EXPECT_LT(left_after(40, true), 1e-8);
}

}  // namespace
}  // namespace tenter::mechanics
