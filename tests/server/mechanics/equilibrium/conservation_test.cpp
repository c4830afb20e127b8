// SPDX-License-Identifier: GPL-3.0-or-later
// Elastic models are conservative: walked around a closed path of deformations they give back what
// they took (thesis Fig. 4.1 shows what happens else), and no inner force moves or turns a body.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

using tenter::testing::Numbers;

struct Elastic {
  std::string name;
  MeshModel model;
  Eigen::VectorXd parameters;
  Eigen::Matrix3Xd rest_m;
};

/// Every preset on a mesh of its kind, no two parameters alike.
std::vector<Elastic> elastic_models() {
  const Cloth cloth = cloth_of_grid({5, 5, 0.2, 0.2}, Diagonals::alternating).value();
  SolidMesh solid = box_hexahedra(2, 2, 1, {0.2, 0.2, 0.1}).value();
  const SolidMesh tetrahedra = box_tetrahedra(2, 2, 1, {0.2, 0.2, 0.1}).value();
  std::vector<Elastic> list;
  for (const std::string& name : model::preset_names()) {
    model::Model description = model::preset(name).value();
    if (model::remembers_path(description)) continue;
    bool is_solid = false;
    double factor = 1.0;
    for (model::Term& term : description.terms) {
      const model::StrainRow* row = model::find_strain(term.strain.name);
      is_solid = is_solid || row->domain == model::Domain::solid;
      std::tie(term.law.range_lo, term.law.range_hi) = model::spline_range(term.law, row->domain);
      for (model::Parameter& p : term.law.parameters) {
        if (row->domain == model::Domain::hinge) p.value *= 1e3;
        if (term.strain.name.starts_with("ring2")) p.value *= 50.0;
        p.value *= factor;
        factor *= 1.13;
      }
    }
    const Eigen::VectorXd values = values_of(description);
    if (is_solid) {
      list.push_back({name + ", hexahedra", MeshModel::make(description, solid).value(), values,
                      solid.rest_m});
      list.push_back({name + ", tetrahedra", MeshModel::make(description, tetrahedra).value(),
                      values, tetrahedra.rest_m});
      continue;
    }
    Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, cloth.mesh.node_count());
    rest.topRows(2) = cloth.mesh.material_m;
    list.push_back({name, MeshModel::make(description, cloth).value(), values, rest});
  }
  return list;
}

/// A closed path through homogeneous and other deformations: at t = 0 and 1 the same state. Every
/// entry of F and every wave swings with frequencies of its own.
class Loop {
 public:
  Loop(const Eigen::Matrix3Xd& rest_m, unsigned seed) : rest_m_(rest_m) {
    Numbers numbers(seed);
    const auto random = [&](double by) { return numbers.between(-by, by); };
    for (Eigen::Matrix3d& m : stretch_)
      m = Eigen::Matrix3d::NullaryExpr([&](Eigen::Index, Eigen::Index) { return random(0.08); });
    for (Eigen::Matrix3Xd& m : waves_) {
      Eigen::Matrix3d k =
          Eigen::Matrix3d::NullaryExpr([&](Eigen::Index, Eigen::Index) { return random(20.0); });
      m = 0.01 * (k * rest_m_).array().sin().matrix();
    }
  }
  Eigen::VectorXd at(double t) const {
    Eigen::Matrix3d f = Eigen::Matrix3d::Identity();
    Eigen::Matrix3Xd x = Eigen::Matrix3Xd::Zero(3, rest_m_.cols());
    for (int i = 0; i < kParts; ++i) {
      const auto k = static_cast<std::size_t>(i);
      f += stretch_[k] * std::sin(2.0 * M_PI * (i + 1) * t + 0.7 * i);
      x += waves_[k] * std::cos(2.0 * M_PI * (i + 1) * t + 0.3 * i);
    }
    x += f * rest_m_;
    return Eigen::Map<const Eigen::VectorXd>(x.data(), x.size());
  }

 private:
  static constexpr int kParts = 3;
  Eigen::Matrix3Xd rest_m_;
  Eigen::Matrix3d stretch_[kParts];
  Eigen::Matrix3Xd waves_[kParts];
};

struct Work {
  double net_J = 0.0;
  double moved_J = 0.0;  ///< magnitudes of the steps' work
};

Work around(const Elastic& elastic, const Loop& loop, int steps) {
  Work work;
  Eigen::VectorXd gradient;
  for (int i = 0; i < steps; ++i) {
    const Eigen::VectorXd from = loop.at(static_cast<double>(i) / steps);
    const Eigen::VectorXd to = loop.at(static_cast<double>(i + 1) / steps);
    EXPECT_EQ(elastic.model.evaluate(0.5 * (from + to), elastic.parameters,
                                     {nullptr, &gradient, nullptr}),
              AssemblyStatus::ok);
    work.net_J += gradient.dot(to - from);
    work.moved_J += std::abs(gradient.dot(to - from));
  }
  return work;
}

// The midpoint rule leaves an error of second order in the step, a force without potential would
// leave a part that does not fall.
TEST(Conservation, ClosedLoopsDoNoNetWork) {
  double worst = 0.0;
  for (const Elastic& elastic : elastic_models()) {
    SCOPED_TRACE(elastic.name);
    for (const unsigned seed : {3U, 8U}) {
      const Loop loop(elastic.rest_m, seed);
      double energy = 0.0, again = 0.0;
      ASSERT_EQ(elastic.model.evaluate(loop.at(0.0), elastic.parameters, {&energy}),
                AssemblyStatus::ok);
      ASSERT_EQ(elastic.model.evaluate(loop.at(1.0), elastic.parameters, {&again}),
                AssemblyStatus::ok);
      EXPECT_NEAR(again, energy, 1e-12 * energy);
      const Work coarse = around(elastic, loop, 100);
      const Work fine = around(elastic, loop, 1600);
      EXPECT_GT(fine.moved_J, 0.5 * energy);
      const double part = std::abs(fine.net_J) / fine.moved_J;
      worst = std::max(worst, part);
      EXPECT_LT(part, 1e-5);
      EXPECT_LT(part, 0.02 * std::abs(coarse.net_J) / coarse.moved_J + 1e-12);
    }
  }
  std::printf("closed loops: net work at most %.1e of the work done\n", worst);
}

TEST(Conservation, InnerForcesNeitherMoveNorTurnABody) {
  for (const Elastic& elastic : elastic_models()) {
    SCOPED_TRACE(elastic.name);
    const Loop loop(elastic.rest_m, 5);
    for (const double t : {0.1, 0.45, 0.8}) {
      const Eigen::VectorXd x = loop.at(t);
      Eigen::VectorXd gradient;
      ASSERT_EQ(elastic.model.evaluate(x, elastic.parameters, {nullptr, &gradient, nullptr}),
                AssemblyStatus::ok);
      Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
      double size = 0.0;
      for (Eigen::Index n = 0; n < x.size() / 3; ++n) {
        const Eigen::Vector3d f = gradient.segment<3>(3 * n);
        force += f;
        torque += x.segment<3>(3 * n).cross(f);
        size += f.norm();
      }
      EXPECT_GT(size, 0.1);
      EXPECT_LT(force.norm(), 1e-12 * size);
      EXPECT_LT(torque.norm(), 1e-12 * size * 0.2);
    }
  }
}

// At rest, wherever the body is and however it is turned: no force.
TEST(Conservation, RigidMotionsMakeNoForce) {
  for (const Elastic& elastic : elastic_models()) {
    SCOPED_TRACE(elastic.name);
    const Loop loop(elastic.rest_m, 6);
    Eigen::VectorXd deformed;
    ASSERT_EQ(
        elastic.model.evaluate(loop.at(0.3), elastic.parameters, {nullptr, &deformed, nullptr}),
        AssemblyStatus::ok);
    for (const double angle : {0.0, 1.0, 3.1}) {
      Eigen::Matrix3Xd moved =
          rotation_of(angle * Eigen::Vector3d(0.6, -0.64, 0.48)) * elastic.rest_m;
      moved.colwise() += Eigen::Vector3d(0.3, -0.1, 0.2);
      const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(moved.data(), moved.size());
      Eigen::VectorXd gradient;
      ASSERT_EQ(elastic.model.evaluate(x, elastic.parameters, {nullptr, &gradient, nullptr}),
                AssemblyStatus::ok);
      EXPECT_LT(gradient.norm(), 1e-11 * deformed.norm());
    }
  }
}

}  // namespace
}  // namespace tenter::mechanics::testing
