// SPDX-License-Identifier: GPL-3.0-or-later
// MeshModel on tetrahedra, hexahedra and both.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <limits>

#include "tests/server/mechanics/assembly/model_checks.h"
#include "tests/server/mechanics/assembly/solid_bodies.h"
#include "tests/server/mechanics/point_energy.h"

namespace tenter::mechanics {
namespace {

using testing::random_solid;

/// Every preset, and the measures that no preset has.
std::vector<model::Model> solid_models() {
  std::vector<model::Model> models = presets_of(Body::solid);
  EXPECT_GE(models.size(), 4U);
  models.push_back(testing::model_of({{"solid_green_normal", "linear", {1.1e4}},
                                      {"solid_green_shear", "linear", {0.7e4}},
                                      {"solid_green_xy", "linear", {0.9e4}},
                                      {"solid_invariant_1", "constant_stress", {0.3e4}},
                                      {"solid_invariant_2", "constant_stress", {0.2e4}},
                                      {"solid_volume", "linear", {2.3e4}}}));
  models.back().name = "measures of components and invariants";
  models.push_back(testing::model_of({{"solid_fibre", "exponential_fibre", {1e4, 2.0}},
                                      {"solid_green_fibre", "linear", {0.7e4}},
                                      {"solid_neo_hookean", "constant_stress", {0.9e4}}}));
  models.back().name = "fibres";
  for (model::Term& term : models.back().terms)
    if (term.strain.name.ends_with("fibre")) {
      term.strain.angle_rad = 0.4;
      term.strain.elevation_rad = -0.7;
    }
  return models;
}

template <class Check>
void for_all(Check check) {
  for (const SolidBody& body : solid_bodies()) {
    for (const model::Model& description : solid_models()) {
      SCOPED_TRACE(body.name + ", " + description.name);
      const auto model = MeshModel::make(description, body.mesh);
      ASSERT_TRUE(model) << model.error().message;
      ASSERT_EQ(model->parameter_count(), term_parameters(description).size());
      check(*model, description, body.mesh);
    }
  }
}

Answer answer_at(const MeshModel& model, const Eigen::VectorXd& parameters,
                 const Eigen::VectorXd& x) {
  Answer answer;
  EXPECT_EQ(model.evaluate(x, parameters, {&answer.energy, &answer.gradient, nullptr}),
            AssemblyStatus::ok);
  return answer;
}

TEST(SolidModel, DerivativesByPositionAndParameter) {
  for_all([](const MeshModel& model, const model::Model& description, const SolidMesh& mesh) {
    for (unsigned seed = 4; seed < 6; ++seed)
      check_model(model, term_parameters(description), deformed(mesh, 0.1, seed), 1e-3 * kCell);
  });
}

// At rest, and in a pure dilation, all principal stretches meet; in a uniaxial stretch, two.
TEST(SolidModel, StiffnessWherePrincipalStretchesMeet) {
  const Eigen::Matrix3d states[] = {Eigen::Matrix3d::Identity(), 1.2 * Eigen::Matrix3d::Identity(),
                                    Eigen::Vector3d(1.3, 0.9, 0.9).asDiagonal()};
  for_all([&](const MeshModel& model, const model::Model& description, const SolidMesh& mesh) {
    const Eigen::VectorXd parameters = term_parameters(description);
    for (const Eigen::Matrix3d& f : states) {
      const Eigen::VectorXd x = affine(mesh, f);
      NodeMatrix matrix = model.matrix();
      ASSERT_EQ(model.evaluate(x, parameters, {nullptr, nullptr, &matrix}), AssemblyStatus::ok);
      testing::Comparison comparison("stiffness");
      for (Eigen::Index i = 0; i < x.size(); i += 7) {
        const auto moved = [&](double value) {
          Eigen::VectorXd y = x;
          y[i] = value;
          return Eigen::VectorXd(answer_at(model, parameters, y).gradient);
        };
        const Eigen::VectorXd column = testing::difference(moved, x[i], 1e-3 * kCell);
        Eigen::VectorXd unit = Eigen::VectorXd::Unit(x.size(), i);
        Eigen::VectorXd product = Eigen::VectorXd::Zero(x.size());
        matrix.multiply_add(unit.data(), product.data());
        for (Eigen::Index j = 0; j < x.size(); ++j) comparison.add(product[j], column[j]);
      }
      comparison.judge(1e-6, 1.0);
    }
  });
}

// x = F X + c: the energy is volume x psi(F), the forces' virial is volume x the stress P, and
// nodes inside are in equilibrium whatever the mesh (the patch test).
TEST(SolidModel, AnAffineDeformationIsThatOfAPoint) {
  const double volume = kBoxSize.prod();
  for_all([&](const MeshModel& model, const model::Model& description, const SolidMesh& mesh) {
    testing::Numbers numbers(6);
    testing::Comparison energy("energy"), stress("stress"), inside("force inside");
    double boundary = 0.0;
    for (int sample = 0; sample < 10; ++sample) {
      const Eigen::Matrix3d f = random_solid(numbers);
      const auto point = testing::energy_at<6>(description, testing::z_of(f));
      const Answer at =
          answer_at(model, term_parameters(description), affine(mesh, f, {0.3, -0.2, 0.1}));
      energy.add(at.energy, volume * point.energy);
      Eigen::Matrix3d virial = Eigen::Matrix3d::Zero();
      for (int n = 0; n < mesh.node_count(); ++n) {
        const Eigen::Vector3d force = at.gradient.segment<3>(3 * n);
        virial += force * mesh.rest_m.col(n).transpose();
        if (on_boundary(mesh.rest_m.col(n)))
          boundary = std::max(boundary, force.norm());
        else
          inside.add(force.norm(), 0.0);
      }
      const Eigen::Matrix3d expected = volume * testing::stress_of(f, point);
      for (int i = 0; i < 9; ++i) stress.add(virial.data()[i], expected.data()[i]);
    }
    energy.judge(1e-12, 0.1);
    stress.judge(1e-12, 1.0);
    EXPECT_GT(boundary, 1.0);
    inside.judge(0.0, 0.0, 1e-12 * boundary);
  });
}

// Against the textbook, without measures and laws: mu/2 (I_1 - 3) - mu ln J + lambda/2 (ln J)^2.
TEST(SolidModel, NeoHookeanEnergyIsTheTextbooks) {
  const model::Model description = model::preset("solid_neo_hookean").value();
  const Eigen::VectorXd parameters = term_parameters(description);
  const double mu = 2.0 * parameters[0];
  const double lambda = parameters[1];
  for (const SolidBody& body : solid_bodies()) {
    const auto model = MeshModel::make(description, body.mesh);
    ASSERT_TRUE(model);
    testing::Numbers numbers(7);
    const Eigen::Matrix3d f = random_solid(numbers);
    const double log_j = std::log(f.determinant());
    const double expected = kBoxSize.prod() * (0.5 * mu * (f.squaredNorm() - 3.0) - mu * log_j +
                                               0.5 * lambda * log_j * log_j);
    EXPECT_GT(expected, 0.1);
    EXPECT_NEAR(answer_at(*model, parameters, affine(body.mesh, f)).energy, expected,
                1e-12 * expected);
  }
}

/// Over all unknowns.
Eigen::MatrixXd dense(const NodeMatrix& matrix) {
  const Eigen::Index size = 3 * matrix.node_count();
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(size, i);
    matrix.multiply_add(unit.data(), full.col(i).data());
  }
  return full;
}

// Compressed, a solid's stiffness has negative directions; its positive part has none, also where
// an energy limit adds to it.
TEST(SolidModel, ThePositivePartHasNoNegativeDirection) {
  const Eigen::Matrix3d squeeze = Eigen::Vector3d(0.5, 0.9, 0.8).asDiagonal();
  for (const SolidBody& body : solid_bodies()) {
    for (model::Model description : presets_of(Body::solid)) {
      SCOPED_TRACE(body.name + ", " + description.name);
      description.limits = {limit_of(description, {})};
      const auto model = MeshModel::make(description, body.mesh);
      ASSERT_TRUE(model);
      const EnergyLimitState limits{Eigen::VectorXd::Constant(model->limited_count(), 0.3), 1e-4};
      const auto lowest = [&](double share, const EnergyLimitState* state) {
        NodeMatrix matrix = model->matrix();
        ModelOutput output;
        output.stiffness = &matrix;
        output.positive_share = share;
        EXPECT_EQ(model->evaluate(affine(body.mesh, squeeze), term_parameters(description), output,
                                  state),
                  AssemblyStatus::ok);
        const Eigen::VectorXd eigenvalues =
            Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense(matrix)).eigenvalues();
        return eigenvalues[0] / eigenvalues.tail(1)[0];
      };
      for (const EnergyLimitState* state :
           {static_cast<const EnergyLimitState*>(nullptr), &limits}) {
        EXPECT_LT(lowest(0.0, state), -1e-4);
        EXPECT_GT(lowest(1.0, state), -1e-13);
      }
    }
  }
}

TEST(SolidModel, RigidMotionCostsNothing) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.1, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift(0.3, -0.2, 0.7);
  for_all([&](const MeshModel& model, const model::Model& description, const SolidMesh& mesh) {
    const Eigen::VectorXd parameters = term_parameters(description);
    const Eigen::VectorXd x = deformed(mesh, 0.1, 8);
    Eigen::VectorXd moved = x;
    for (int n = 0; n < mesh.node_count(); ++n)
      moved.segment<3>(3 * n) = turn * x.segment<3>(3 * n) + shift;
    const Answer still = answer_at(model, parameters, x);
    const Answer turned = answer_at(model, parameters, moved);
    EXPECT_GT(std::abs(still.energy), 0.1);
    EXPECT_NEAR(turned.energy, still.energy, 1e-11 * std::abs(still.energy));
    const double force = still.gradient.cwiseAbs().maxCoeff();
    EXPECT_GT(force, 1.0);
    Eigen::Vector3d net = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
    for (int n = 0; n < mesh.node_count(); ++n) {
      const Eigen::Vector3d f = still.gradient.segment<3>(3 * n);
      EXPECT_LT((turn * f - turned.gradient.segment<3>(3 * n)).norm(), 1e-10 * force);
      net += f;
      moment += Eigen::Vector3d(x.segment<3>(3 * n)).cross(f);
    }
    EXPECT_LT(net.norm(), 1e-11 * force);
    EXPECT_LT(moment.norm(), 1e-11 * force * kBoxSize.norm());
  });
  // at rest and turned: those of solids that are without stress there
  for (const SolidBody& body : solid_bodies()) {
    for (const model::Model& description : presets_of(Body::solid)) {
      SCOPED_TRACE(body.name + ", " + description.name);
      const auto model = MeshModel::make(description, body.mesh);
      ASSERT_TRUE(model);
      const Eigen::VectorXd parameters = term_parameters(description);
      const double force =
          answer_at(*model, parameters, deformed(body.mesh, 0.1, 8)).gradient.norm();
      EXPECT_LT(answer_at(*model, parameters, affine(body.mesh, turn, shift)).gradient.norm(),
                1e-11 * force);
    }
  }
}

AssemblyStatus status_at(const MeshModel& model, const Eigen::VectorXd& parameters,
                         const Eigen::VectorXd& x) {
  NodeMatrix matrix = model.matrix();
  Answer answer;
  const AssemblyStatus status =
      model.evaluate(x, parameters, {&answer.energy, &answer.gradient, &matrix});
  if (status == AssemblyStatus::ok) {
    EXPECT_TRUE(std::isfinite(answer.energy) && answer.gradient.allFinite() && matrix.is_finite());
  }
  // what is asked for does not change what is said
  EXPECT_EQ(model.evaluate(x, parameters, {&answer.energy, nullptr, nullptr}), status);
  Eigen::MatrixXd by_parameter;
  EXPECT_EQ(model.gradient_by_parameter(x, parameters, by_parameter), status);
  return status;
}

TEST(SolidModel, ElementsTurnedInsideOutAreSeen) {
  for_all([](const MeshModel& model, const model::Model& description, const SolidMesh& mesh) {
    const Eigen::VectorXd parameters = term_parameters(description);
    const Eigen::VectorXd rest = affine(mesh, Eigen::Matrix3d::Identity());
    EXPECT_EQ(status_at(model, parameters, rest), AssemblyStatus::ok);
    // the mirrored body has the same C everywhere
    const Eigen::Matrix3d mirror = Eigen::Vector3d(1.0, -1.0, 1.0).asDiagonal();
    EXPECT_EQ(status_at(model, parameters, affine(mesh, mirror)), AssemblyStatus::inverted);
    // one node pushed through its elements, wherever it is
    for (int n = 0; n < mesh.node_count(); ++n) {
      Eigen::VectorXd x = rest;
      const Eigen::Vector3d centre = 0.5 * kBoxSize;
      const Eigen::Vector3d inwards = centre - x.segment<3>(3 * n);
      const Eigen::Vector3d way =
          inwards.norm() > kCell ? Eigen::Vector3d(inwards) : Eigen::Vector3d(kCell, 0.0, 0.0);
      x.segment<3>(3 * n) += 3.0 * kCell * way.normalized();
      EXPECT_EQ(status_at(model, parameters, x), AssemblyStatus::inverted) << "node " << n;
    }
  });
}

TEST(SolidModel, CollapsedElementsAndBadPositionsAreNeverSilentlyWrong) {
  for_all([](const MeshModel& model, const model::Model& description, const SolidMesh& mesh) {
    const Eigen::VectorXd parameters = term_parameters(description);
    for (const double left : {0.0, 1e-12}) {
      const Eigen::Matrix3d flat = Eigen::Vector3d(1.1, 0.9, left).asDiagonal();
      EXPECT_EQ(status_at(model, parameters, affine(mesh, flat)), AssemblyStatus::inverted);
    }
    EXPECT_EQ(status_at(model, parameters, affine(mesh, Eigen::Matrix3d::Zero())),
              AssemblyStatus::inverted);
    // nearly flat, yet the right way round: an answer in numbers
    const Eigen::Matrix3d thin = Eigen::Vector3d(1.1, 0.9, 1e-4).asDiagonal();
    EXPECT_EQ(status_at(model, parameters, affine(mesh, thin)), AssemblyStatus::ok);
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(), 1e200}) {
      Eigen::VectorXd x = affine(mesh, Eigen::Matrix3d::Identity());
      x[3 * (mesh.node_count() / 2)] = bad;
      EXPECT_NE(status_at(model, parameters, x), AssemblyStatus::ok) << bad;
    }
  });
}

/// A model with each term given to two samples; those of the second are `factor` times as stiff.
model::Model over_two_samples(const model::Model& plain, double factor) {
  model::Model model = plain;
  model.fields = {{"body", 3, {0.0, 0.0, 0.0, 0.15, 0.1, 0.08}, 0.06}};
  model.terms.clear();
  for (const model::Term& term : plain.terms) {
    for (int sample = 1; sample <= 2; ++sample) {
      model.terms.push_back(term);
      model.terms.back().id += "_" + std::to_string(sample);
      model.terms.back().support = {"rbf", "body", sample};
      if (sample == 2)
        for (model::Parameter& p : model.terms.back().law.parameters)
          if (p.unit != "1") p.value *= factor;
    }
  }
  return model;
}

TEST(SolidModel, SamplesOfAFieldShareTheMaterial) {
  for (const SolidBody& body : solid_bodies()) {
    for (const model::Model& plain : presets_of(Body::solid)) {
      SCOPED_TRACE(body.name + ", " + plain.name);
      const Eigen::VectorXd x = deformed(body.mesh, 0.1, 9);
      const auto one = MeshModel::make(plain, body.mesh);
      ASSERT_TRUE(one);
      const Answer expected = answer_at(*one, term_parameters(plain), x);
      const model::Model equal = over_two_samples(plain, 1.0);
      const auto split = MeshModel::make(equal, body.mesh);
      ASSERT_TRUE(split) << split.error().message;
      const Answer at = answer_at(*split, term_parameters(equal), x);
      EXPECT_NEAR(at.energy, expected.energy, 1e-12 * std::abs(expected.energy));
      EXPECT_LT((at.gradient - expected.gradient).norm(), 1e-11 * expected.gradient.norm());

      const model::Model uneven = over_two_samples(plain, 2.0);
      const double energy = answer_at(*split, term_parameters(uneven), x).energy;
      EXPECT_GT(energy, 1.1 * expected.energy);
      EXPECT_LT(energy, 1.9 * expected.energy);
      check_model(*split, term_parameters(uneven), x, 1e-3 * kCell);
    }
  }
}

// In hexahedra the weight is that of the quadrature point: a constant density w(X) psi integrates
// to what a fine mesh gives, which the middles of the elements would not.
TEST(SolidModel, SupportsAreWeighedAtQuadraturePoints) {
  const Eigen::Vector3d size(0.2, 0.2, 0.2);
  const model::Model plain = model::preset("solid_stvk").value();
  const auto energy_on = [&](int cells) {
    const SolidMesh mesh = box_hexahedra(cells, cells, cells, size).value();
    model::Model first = over_two_samples(plain, 1.0);
    std::erase_if(first.terms, [](const model::Term& t) { return t.support.sample == 2; });
    first.fields[0].positions_m = {0.0, 0.1, 0.1, 0.1, 0.1, 0.1};
    first.fields[0].width_m = 0.05;
    const auto model = MeshModel::make(first, mesh);
    EXPECT_TRUE(model);
    return answer_at(*model, term_parameters(first),
                     affine(mesh, 1.1 * Eigen::Matrix3d::Identity()))
        .energy;
  };
  const double fine = energy_on(12);
  EXPECT_GT(fine, 0.1);
  EXPECT_NEAR(energy_on(2), fine, 5e-3 * fine);
}

TEST(SolidModel, WhatDoesNotFitIsNamed) {
  const SolidMesh mesh = box_tetrahedra(1, 1, 1, kBoxSize).value();
  const auto error_of = [&](const model::Model& model, const SolidMesh& on) {
    const auto made = MeshModel::make(model, on);
    EXPECT_FALSE(made);
    return made ? std::string() : made.error().message;
  };
  EXPECT_EQ(error_of(model::preset("stvk_orthotropic").value(), mesh),
            "term \"weft\": \"green_u\" is a strain of cloth, not of solids");
  model::Model model = over_two_samples(model::preset("solid_stvk").value(), 1.0);
  model.fields[0].dimensions = 2;
  EXPECT_EQ(error_of(model, mesh),
            "term \"trace_1\": the samples of its support must have three coordinates in a solid");
  model = model::preset("solid_stvk").value();
  model.terms[1].strain.name = "no_such";
  EXPECT_EQ(error_of(model, mesh), "term \"square\": no strain measure is called \"no_such\"");
  model = model::preset("solid_stvk").value();
  model.terms[0].law.name = "bilinear";
  EXPECT_NE(error_of(model, mesh).find("term \"trace\": "), std::string::npos);
  SolidMesh broken = mesh;
  std::swap(broken.tetrahedra[2][0], broken.tetrahedra[2][1]);
  EXPECT_NE(error_of(model::preset("solid_stvk").value(), broken).find("tetrahedron 2"),
            std::string::npos);
}

}  // namespace
}  // namespace tenter::mechanics
