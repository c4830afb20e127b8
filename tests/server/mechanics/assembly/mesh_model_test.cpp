// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/mesh_model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "server/mechanics/material_point.h"
#include "server/mechanics/mesh/outline.h"
#include "tests/server/mechanics/assembly/model_checks.h"

namespace tenter::mechanics {
namespace {

Eigen::VectorXd crumpled(const SurfaceMesh& mesh, double by, unsigned seed) {
  testing::Numbers numbers(seed);
  Eigen::VectorXd x(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    x.segment<3>(3 * n) << mesh.material_m.col(n), 0.0;
    for (int i = 0; i < 3; ++i) x[3 * n + i] += numbers.between(-by, by);
  }
  return x;
}

std::vector<Cloth> cloths() {
  std::vector<Cloth> list;
  list.push_back(cloth_of_grid({6, 5, 0.25, 0.2}, Diagonals::alternating).value());
  list.push_back(cloth_of_grid({5, 5, 0.2, 0.2}, Diagonals::both).value());
  const std::vector<Eigen::Vector2d> outline = {
      {0.0, 0.0}, {0.25, 0.0}, {0.3, 0.2}, {0.1, 0.25}, {0.0, 0.2}};
  list.push_back(cloth_of_mesh(triangulate_outline(outline, 0.05).value()).value());
  return list;
}

TEST(MeshModel, DerivativesByPositionAndParameter) {
  int checked = 0;
  for (const Cloth& cloth : cloths()) {
    for (const model::Model& description : presets_of(Body::cloth)) {
      const auto model = MeshModel::make(description, cloth);
      if (!model) {  // an irregular sheet may have no edge of a family
        EXPECT_NE(model.error().message.find("has no element"), std::string::npos)
            << model.error().message;
        continue;
      }
      SCOPED_TRACE(description.name);
      const Eigen::VectorXd parameters = term_parameters(description);
      ASSERT_EQ(model->parameter_count(), parameters.size());
      check_model(*model, parameters, crumpled(cloth.mesh, 0.006, 3), 1e-5);
      ++checked;
    }
  }
  EXPECT_GT(checked, 30);
}

// A sheet in homogeneous strain: dE/dq = area x the nominal stress of the material point.
TEST(MeshModel, AHomogeneousStretchIsThatOfTheMaterialPoint) {
  const double sides[2] = {0.25, 0.2};
  const Cloth cloth = cloth_of_grid({6, 5, sides[0], sides[1]}, Diagonals::alternating).value();
  int checked = 0;
  for (const model::Model& description : presets_of(Body::cloth)) {
    bool springs_bend = false;  // ring-2 springs feel a stretch, which the point leaves out
    for (const model::Term& t : description.terms)
      springs_bend = springs_bend || t.strain.name.starts_with("ring2");
    if (springs_bend) continue;
    SCOPED_TRACE(description.name);
    const auto model = MeshModel::make(description, cloth);
    const auto point = MaterialPoint::make(description);
    ASSERT_TRUE(model && point);
    const Eigen::VectorXd parameters = term_parameters(description);
    const Eigen::Vector3d q(1.12, 0.94, 0.07);
    const auto energy_at = [&](const Eigen::Vector3d& at) {
      Eigen::VectorXd x(3 * model->node_count());
      for (int n = 0; n < model->node_count(); ++n) {
        const Eigen::Vector2d m = cloth.mesh.material_m.col(n);
        x.segment<3>(3 * n) << at[0] * m[0] + at[2] * m[1], at[1] * m[1], 0.0;
      }
      double energy = 0.0;
      EXPECT_EQ(model->evaluate(x, parameters, {&energy, nullptr, nullptr}), AssemblyStatus::ok);
      return energy;
    };
    StrainPath path;
    path.q = {q};
    path.duration_s = {0.0};
    path.start = {FrameStart::virgin};
    MaterialPoint::Workspace scratch;
    PathResponse response;
    ASSERT_EQ(point->follow(path, parameters, false, scratch, response), PathStatus::ok);
    testing::Comparison stress("stress");
    for (int i = 0; i < 3; ++i) {
      const auto along = [&](double value) {
        Eigen::Vector3d moved = q;
        moved[i] = value;
        return energy_at(moved) / (sides[0] * sides[1]);
      };
      stress.add(response.stress[0][i], testing::difference(along, q[i], 1e-3));
    }
    stress.judge(1e-6);
    ++checked;
  }
  EXPECT_GT(checked, 8);
}

TEST(MeshModel, RigidMotionCostsNothing) {
  const Cloth cloth = cloth_of_grid({6, 5, 0.25, 0.2}, Diagonals::alternating).value();
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  for (const model::Model& description : presets_of(Body::cloth)) {
    SCOPED_TRACE(description.name);
    const auto model = MeshModel::make(description, cloth);
    ASSERT_TRUE(model);
    const Eigen::VectorXd parameters = term_parameters(description);
    const auto evaluate = [&](double crumple) {
      Eigen::VectorXd x = crumpled(cloth.mesh, crumple, 4);
      Answer still, moved;
      EXPECT_EQ(model->evaluate(x, parameters, {&still.energy, &still.gradient, nullptr}),
                AssemblyStatus::ok);
      for (int n = 0; n < model->node_count(); ++n)
        x.segment<3>(3 * n) = (turn * x.segment<3>(3 * n) + Eigen::Vector3d(0.3, -0.2, 0.7)).eval();
      EXPECT_EQ(model->evaluate(x, parameters, {&moved.energy, &moved.gradient, nullptr}),
                AssemblyStatus::ok);
      return std::pair{still, moved};
    };
    const auto [still, moved] = evaluate(0.006);
    EXPECT_GT(still.energy, 0.0);
    EXPECT_NEAR(moved.energy, still.energy, 1e-10 * still.energy);
    const double force = still.gradient.cwiseAbs().maxCoeff();
    for (int n = 0; n < model->node_count(); ++n)
      EXPECT_LT((turn * still.gradient.segment<3>(3 * n) - moved.gradient.segment<3>(3 * n)).norm(),
                1e-9 * force);
    const auto [rest, turned] = evaluate(0.0);
    EXPECT_LT(rest.gradient.cwiseAbs().maxCoeff(), 1e-10 * force);
    EXPECT_LT(turned.gradient.cwiseAbs().maxCoeff(), 1e-10 * force);
  }
}

// Edges of no length and triangles of no height: a finite answer, or one that says so.
TEST(MeshModel, CollapsedElementsAreNeverSilentlyWrong) {
  const Cloth cloth = cloth_of_grid({4, 4, 0.15, 0.15}, Diagonals::one).value();
  int told = 0;
  for (const model::Model& description : presets_of(Body::cloth)) {
    const auto model = MeshModel::make(description, cloth);
    ASSERT_TRUE(model);
    const Eigen::VectorXd parameters = term_parameters(description);
    Eigen::VectorXd x = crumpled(cloth.mesh, 0.0, 1);
    x.segment<3>(0) = x.segment<3>(3);  // two nodes in one place
    NodeMatrix matrix = model->matrix();
    Answer answer;
    const AssemblyStatus status =
        model->evaluate(x, parameters, {&answer.energy, &answer.gradient, &matrix});
    if (status == AssemblyStatus::ok) {
      EXPECT_TRUE(std::isfinite(answer.energy) && answer.gradient.allFinite());
      EXPECT_TRUE(matrix.is_finite());
    } else {
      ++told;
    }
  }
  EXPECT_GT(told, 0) << "a hinge without an edge has no angle";
}

TEST(MeshModel, WhatDoesNotFitIsNamed) {
  const Cloth cloth = cloth_of_grid({4, 4, 0.15, 0.15}, Diagonals::one).value();
  const auto solid = MeshModel::make(model::preset("solid_neo_hookean").value(), cloth);
  ASSERT_FALSE(solid);
  EXPECT_NE(solid.error().message.find("is a strain of solids"), std::string::npos);
  model::Model unknown = model::preset("cloth_stvk").value();
  unknown.terms[1].strain.name = "no_such";
  const auto bad = MeshModel::make(unknown, cloth);
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().message.find("term \"warp\""), std::string::npos);
}

}  // namespace
}  // namespace tenter::mechanics
