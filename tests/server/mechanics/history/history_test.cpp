// SPDX-License-Identifier: GPL-3.0-or-later
// MeshModel with a history: the energy of a step, its derivatives, and where it ends.
#include "server/mechanics/assembly/history/history.h"

#include <gtest/gtest.h>

#include "server/mechanics/assembly/history/held_step.h"
#include "server/mechanics/material_point.h"
#include "tests/server/mechanics/assembly/solid_bodies.h"
#include "tests/server/mechanics/elements/element_checks.h"
#include "tests/server/mechanics/history/friction.h"

namespace tenter::mechanics {
namespace {

using testing::HeldSheet;

Eigen::VectorXd shaken(Eigen::VectorXd x, double by_m, unsigned seed) {
  tenter::testing::Numbers numbers(seed);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += numbers.between(-by_m, by_m);
  return x;
}

/// A mesh that went through two random states.
History with_a_past(const MeshModel& model, const Eigen::VectorXd& parameters,
                    const Eigen::VectorXd& x, double by_m) {
  History history = model.never_strained();
  for (const unsigned seed : {1U, 2U})
    EXPECT_EQ(model.end_of_step(shaken(x, by_m, seed), parameters, history, history.state),
              AssemblyStatus::ok);
  return history;
}

void check_step(const MeshModel& model, const Eigen::VectorXd& parameters, const Eigen::VectorXd& x,
                double by_m) {
  const History history = with_a_past(model, parameters, x, by_m);
  const Eigen::VectorXd at = shaken(x, by_m, 3);
  const auto evaluate = [&](const Eigen::VectorXd& y, const Eigen::VectorXd& p, const History& from,
                            NodeMatrix* into) {
    Answer answer;
    EXPECT_EQ(model.evaluate(y, p, {&answer.energy, &answer.gradient, into}, nullptr, &from),
              AssemblyStatus::ok);
    return answer;
  };
  const auto end = [&](const Eigen::VectorXd& y, const Eigen::VectorXd& p, const History& from) {
    Eigen::VectorXd state;
    EXPECT_EQ(model.end_of_step(y, p, from, state), AssemblyStatus::ok);
    return state;
  };
  // the tangent jumps where a strain turns: differences are small against what strains moved by
  NodeMatrix matrix = model.matrix();
  check_derivatives([&](const Eigen::VectorXd& y,
                        NodeMatrix* into) { return evaluate(y, parameters, history, into); },
                    matrix, at, 1e-4 * by_m, 1e-6);

  Eigen::MatrixXd by_parameter;
  ASSERT_EQ(model.gradient_by_parameter(at, parameters, by_parameter, nullptr, &history),
            AssemblyStatus::ok);
  tenter::testing::Comparison forces("forces by parameter");
  for (Eigen::Index p = 0; p < parameters.size(); ++p) {
    const auto moved = [&](double value) {
      Eigen::VectorXd changed = parameters;
      changed[p] = value;
      return Eigen::VectorXd(evaluate(at, changed, history, nullptr).gradient);
    };
    const double h = 1e-4 * std::max(std::abs(parameters[p]), 1e-4);
    const Eigen::VectorXd column = tenter::testing::difference(moved, parameters[p], h);
    for (Eigen::Index i = 0; i < column.size(); ++i)
      forces.add(by_parameter(i, p) * parameters[p], column[i] * parameters[p]);
  }
  forces.judge(1e-7);

  // a change of everything at once: of the start, the nodes and two parameters
  tenter::testing::Numbers numbers(7);
  const std::vector<Eigen::Index> columns = {0, parameters.size() - 1};
  Eigen::MatrixXd dh(model.history_count(), 2), dx(at.size(), 2);
  for (Eigen::Index k = 0; k < dh.size(); ++k)
    dh.data()[k] = numbers.between(-1.0, 1.0) * (0.1 * std::abs(history.state[k % dh.rows()]));
  for (Eigen::Index k = 0; k < dx.size(); ++k) dx.data()[k] = by_m * numbers.between(-1.0, 1.0);
  Eigen::MatrixXd by_history = Eigen::MatrixXd::Zero(at.size(), 2);
  ASSERT_EQ(model.add_gradient_by_history(at, parameters, history, dh, by_history),
            AssemblyStatus::ok);
  Eigen::MatrixXd ends = dh;
  ASSERT_EQ(model.carry_history_change(at, parameters, history, dx, columns, ends),
            AssemblyStatus::ok);
  tenter::testing::Comparison by_start("forces by history"), carried("end of the step");
  for (Eigen::Index c = 0; c < 2; ++c) {
    const auto past = [&](double t) {
      History changed = history;
      changed.state += t * dh.col(c);
      return changed;
    };
    const Eigen::VectorXd column = tenter::testing::difference(
        [&](double t) {
          return Eigen::VectorXd(evaluate(at, parameters, past(t), nullptr).gradient);
        },
        0.0, 1e-4);
    for (Eigen::Index i = 0; i < column.size(); ++i) by_start.add(by_history(i, c), column[i]);
    const Eigen::VectorXd change = tenter::testing::difference(
        [&](double t) {
          Eigen::VectorXd p = parameters;
          p[columns[static_cast<std::size_t>(c)]] += t;
          return end(at + t * dx.col(c), p, past(t));
        },
        0.0, 1e-4 * std::min(1.0, std::abs(parameters[columns[static_cast<std::size_t>(c)]])));
    for (Eigen::Index i = 0; i < change.size(); ++i) carried.add(ends(i, c), change[i]);
  }
  by_start.judge(1e-7);
  carried.judge(1e-7);
}

/// One pass over the elements says what the four functions say that each make one.
void check_held_steps(const MeshModel& model, const Eigen::VectorXd& parameters,
                      const Eigen::VectorXd& x, double by_m) {
  const std::vector<Eigen::Index> columns = {parameters.size() - 4, parameters.size() - 1};
  History history = with_a_past(model, parameters, x, by_m), held = history;
  Eigen::MatrixXd change = Eigen::MatrixXd::Zero(model.history_count(), 2), held_change = change;
  const Eigen::MatrixXd still = Eigen::MatrixXd::Zero(x.size(), 2);
  for (const unsigned seed : {3U, 4U}) {
    const Eigen::VectorXd at = shaken(x, by_m, seed);
    Eigen::MatrixXd all, held_force = still;
    ASSERT_EQ(model.gradient_by_parameter(at, parameters, all, nullptr, &history),
              AssemblyStatus::ok);
    Eigen::MatrixXd force = all(Eigen::indexing::all, columns);
    ASSERT_EQ(model.add_gradient_by_history(at, parameters, history, change, force),
              AssemblyStatus::ok);
    ASSERT_EQ(model.carry_history_change(at, parameters, history, still, columns, change),
              AssemblyStatus::ok);
    ASSERT_EQ(model.end_of_step(at, parameters, history, history.state), AssemblyStatus::ok);
    ASSERT_EQ(take_held_step(model, at, parameters, columns, held, held_change, held_force),
              AssemblyStatus::ok);
    ASSERT_GT(force.col(0).norm(), 0.0);
    ASSERT_GT(change.col(1).norm(), 0.0);
    EXPECT_LT((held_force - force).norm(), 1e-12 * force.norm());
    EXPECT_LT((held_change - change).norm(), 1e-12 * change.norm());
    EXPECT_LT((held.state - history.state).norm(), 1e-12 * history.state.norm());
  }
}

TEST(HistoryOfAMesh, StepsOfWhatIsHeldAreThoseOfTheFourFunctions) {
  const HeldSheet sheet(7, testing::rubbing_cloth());
  check_held_steps(sheet.model, sheet.parameters, shaken(sheet.start.x, 1e-3, 9), 4e-4);
}

TEST(HistoryOfAMesh, DerivativesOfAStepOfCloth) {
  const HeldSheet sheet(7, testing::rubbing_cloth());
  EXPECT_EQ(sheet.model.history_count(),
            6 * static_cast<int>(sheet.cloth.mesh.triangles.size()) +
                2 * static_cast<int>(std::count_if(
                        sheet.cloth.hinges.begin(), sheet.cloth.hinges.end(),
                        [](const Hinge& hinge) { return hinge.bend == Direction::weft; })));
  check_step(sheet.model, sheet.parameters, shaken(sheet.start.x, 1e-3, 9), 4e-4);
}

TEST(HistoryOfAMesh, DerivativesOfAStepOfASolid) {
  const SolidMesh mesh = distorted(mixed_box(), 5);
  const auto description = testing::rubbing_solid();
  const MeshModel model = MeshModel::make(description, mesh).value();
  const Eigen::Map<const Eigen::VectorXd> rest(mesh.rest_m.data(), mesh.rest_m.size());
  check_step(model, term_parameters(description), rest, 8e-4);
}

// Without a history, and from a mesh that was never strained: the same bytes.
TEST(HistoryOfAMesh, ANewMeshIsOneWithoutHistory) {
  const HeldSheet sheet(7, testing::rubbing_cloth());
  const Eigen::VectorXd x = shaken(sheet.start.x, 5e-4, 4);
  const History history = sheet.model.never_strained();
  double energy = 0.0, other_energy = 0.0;
  Eigen::VectorXd gradient, other_gradient;
  NodeMatrix matrix = sheet.model.matrix(), other_matrix = sheet.model.matrix();
  ASSERT_EQ(sheet.model.evaluate(x, sheet.parameters, {&energy, &gradient, &matrix}),
            AssemblyStatus::ok);
  ASSERT_EQ(
      sheet.model.evaluate(x, sheet.parameters, {&other_energy, &other_gradient, &other_matrix},
                           nullptr, &history),
      AssemblyStatus::ok);
  EXPECT_GT(energy, 1e-6);
  EXPECT_EQ(energy, other_energy);
  EXPECT_EQ(gradient, other_gradient);
}

// A sheet in homogeneous strain is the material point, frame by frame.
TEST(HistoryOfAMesh, AHomogeneousPathIsThatOfTheMaterialPoint) {
  const auto description = testing::rubbing_cloth();
  const HeldSheet sheet(6, description);
  const auto point = MaterialPoint::make(description).value();
  StrainPath path;
  path.q = {{1.04, 1.0, 0.02},
            {1.06, 1.02, 0.07},
            {1.05, 1.03, 0.04},
            {1.05, 1.01, 0.05},
            {0.99, 1.02, -0.03}};
  path.duration_s.assign(path.q.size(), 0.0);
  path.start.assign(path.q.size(), FrameStart::next);
  path.start[0] = FrameStart::virgin;
  MaterialPoint::Workspace scratch;
  PathResponse response;
  ASSERT_EQ(point.follow(path, sheet.parameters, false, scratch, response), PathStatus::ok);
  History history = sheet.model.never_strained();
  tenter::testing::Comparison stress("stress");
  for (std::size_t k = 0; k < path.q.size(); ++k) {
    const auto at = [&](const Eigen::Vector3d& q) {
      Eigen::VectorXd x(3 * sheet.model.node_count());
      for (int n = 0; n < sheet.model.node_count(); ++n) {
        const Eigen::Vector2d m = sheet.cloth.mesh.material_m.col(n);
        x.segment<3>(3 * static_cast<Eigen::Index>(n)) << q[0] * m[0] + q[2] * m[1], q[1] * m[1],
            0.0;
      }
      return x;
    };
    const Eigen::VectorXd x = at(path.q[k]);
    Eigen::VectorXd gradient;
    ASSERT_EQ(
        sheet.model.evaluate(x, sheet.parameters, {nullptr, &gradient, nullptr}, nullptr, &history),
        AssemblyStatus::ok);
    for (int i = 0; i < 3; ++i) {
      Eigen::Vector3d more = path.q[k];
      more[i] += 1.0;
      stress.add(gradient.dot(at(more) - x) / 0.01, response.stress[k][i]);
    }
    ASSERT_EQ(sheet.model.end_of_step(x, sheet.parameters, history, history.state),
              AssemblyStatus::ok);
  }
  stress.judge(1e-11, 0.1);
}

TEST(HistoryOfAMesh, ALimitHoldsOnTermsWithoutMemory) {
  auto description = testing::rubbing_cloth();
  const Cloth cloth = cloth_of_grid({5, 5, 0.1, 0.1}, Diagonals::alternating).value();
  description.limits = {{"lock", {"weft", "warp", "shear"}, 1.0, "J/m^2"}};
  EXPECT_TRUE(MeshModel::make(description, cloth));
  description.limits[0].terms.push_back("shear_friction");
  const auto refused = MeshModel::make(description, cloth);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("\"shear_friction\" remembers"), std::string::npos)
      << refused.error().message;
}

}  // namespace
}  // namespace tenter::mechanics
