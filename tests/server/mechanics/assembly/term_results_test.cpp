// SPDX-License-Identifier: GPL-3.0-or-later
// Energies and strains per term.
#include <gtest/gtest.h>

#include <numeric>

#include "server/mechanics/mesh/outline.h"
#include "server/mechanics/solid_strain.h"
#include "tests/server/mechanics/assembly/model_checks.h"
#include "tests/server/mechanics/assembly/solid_bodies.h"

namespace tenter::mechanics {
namespace {

Cloth cloth() {
  return cloth_of_grid({6, 5, 0.25, 0.2}, Diagonals::alternating).value();
}

/// u (1.12, 0.05, 0) + v (0.07, 0.94, 0), lifted into a ridge along v of this height over u.
Eigen::VectorXd stretched(const Cloth& on, double ridge) {
  Eigen::VectorXd x(3 * on.mesh.node_count());
  for (int n = 0; n < on.mesh.node_count(); ++n) {
    const Eigen::Vector2d m = on.mesh.material_m.col(n);
    x.segment<3>(3 * n) << 1.12 * m[0] + 0.07 * m[1], 0.05 * m[0] + 0.94 * m[1],
        ridge * std::sin(12.0 * m[0]);
  }
  return x;
}

void expect_energies(const MeshModel& model, const model::Model& description,
                     const Eigen::VectorXd& x) {
  const Eigen::VectorXd parameters = term_parameters(description);
  double energy = 0.0;
  Eigen::VectorXd energies;
  ASSERT_EQ(model.evaluate(x, parameters, {&energy, nullptr, nullptr}), AssemblyStatus::ok);
  ASSERT_EQ(model.term_energies(x, parameters, energies), AssemblyStatus::ok);
  ASSERT_EQ(energies.size(), static_cast<Eigen::Index>(description.terms.size()));
  EXPECT_EQ(model.term_count(), energies.size());
  const double scale = energies.cwiseAbs().sum();
  EXPECT_GT(scale, 1e-3);
  EXPECT_NEAR(energies.sum(), energy, 1e-14 * scale);
  // the energy of a term is that of the model in which the others have no stiffness
  Eigen::Index first = 0;
  for (Eigen::Index t = 0; t < energies.size(); ++t) {
    const auto& law = description.terms[static_cast<std::size_t>(t)].law;
    const auto count = static_cast<Eigen::Index>(law.parameters.size());
    Eigen::VectorXd alone = Eigen::VectorXd::Zero(parameters.size());
    for (Eigen::Index p = 0; p < parameters.size(); ++p)
      if (p >= first && p < first + count) alone[p] = parameters[p];
    ASSERT_EQ(model.evaluate(x, alone, {&energy, nullptr, nullptr}), AssemblyStatus::ok);
    EXPECT_NEAR(energies[t], energy, 1e-13 * scale) << description.terms[t].id;
    first += count;
  }
}

TEST(TermEnergies, SumToTheEnergy) {
  const Cloth sheet = cloth();
  for (const model::Model& description : presets_of(Body::cloth)) {
    SCOPED_TRACE(description.name);
    const auto model = MeshModel::make(description, sheet);
    ASSERT_TRUE(model) << model.error().message;
    expect_energies(*model, description, stretched(sheet, 0.02));
  }
  for (const SolidBody& body : solid_bodies()) {
    for (const model::Model& description : presets_of(Body::solid)) {
      SCOPED_TRACE(body.name + ", " + description.name);
      const auto model = MeshModel::make(description, body.mesh);
      ASSERT_TRUE(model) << model.error().message;
      expect_energies(*model, description, deformed(body.mesh, 0.1, 2));
    }
  }
}

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// Every preset of cloth under a homogeneous stretch: membranes have the strain of the material
// point, springs the stretch of their direction, hinges none.
TEST(TermStrains, OfAHomogeneousStretchAreThoseOfThePoint) {
  const Cloth sheet = cloth();
  const Eigen::VectorXd x = stretched(sheet, 0.0);
  Eigen::Matrix2d f;
  f << 1.12, 0.07, 0.05, 0.94;
  const Eigen::Matrix2d c = f.transpose() * f;
  int membranes = 0, springs = 0, hinges = 0;
  for (const model::Model& description : presets_of(Body::cloth)) {
    SCOPED_TRACE(description.name);
    const auto model = MeshModel::make(description, sheet);
    ASSERT_TRUE(model);
    std::vector<TermStrains> strains;
    ASSERT_EQ(model->term_strains(x, strains), AssemblyStatus::ok);
    ASSERT_EQ(strains.size(), description.terms.size());
    for (std::size_t t = 0; t < strains.size(); ++t) {
      const TermStrains& entry = strains[t];
      ASSERT_EQ(entry.term, static_cast<int>(t));
      ASSERT_EQ(entry.element.size(), entry.measure.size());
      ASSERT_EQ(entry.strain.size(),
                entry.element.size() * static_cast<std::size_t>(entry.strains));
      ASSERT_FALSE(entry.element.empty());
      for (std::size_t k = 0; k < entry.element.size(); ++k) {
        const auto number = static_cast<std::size_t>(entry.element[k]);
        const double* strain = entry.strain.data() + k * static_cast<std::size_t>(entry.strains);
        if (entry.kind == ElementKind::triangle) {
          StrainValue expected;
          const auto measure = StrainMeasure::make(description.terms[t].strain);
          ASSERT_TRUE(measure);
          measure->evaluate({c(0, 0), c(1, 1), c(0, 1)}, expected);
          ASSERT_EQ(entry.strains, measure->count());
          for (int i = 0; i < entry.strains; ++i) EXPECT_NEAR(strain[i], expected.value[i], 1e-13);
          ++membranes;
        } else if (entry.kind == ElementKind::hinge) {
          EXPECT_EQ(entry.measure[k], sheet.hinges[number].area_m2);
          EXPECT_NEAR(strain[0], 0.0, 1e-10);
          ++hinges;
        } else {
          const bool ring2 = entry.kind == ElementKind::spring_ring2;
          const Spring& s = (ring2 ? sheet.springs.ring2 : sheet.springs.ring1)[number];
          const Eigen::Vector2d along(std::cos(s.angle_rad), std::sin(s.angle_rad));
          EXPECT_NEAR(strain[0], (f * along).norm() - 1.0, 1e-13);
          EXPECT_EQ(entry.measure[k], s.area_m2);
          ++springs;
        }
      }
      if (entry.kind == ElementKind::triangle) {
        EXPECT_NEAR(sum(entry.measure), 0.25 * 0.2, 1e-15);
      }
    }
  }
  EXPECT_GT(membranes, 100);
  EXPECT_GT(springs, 100);
  EXPECT_GT(hinges, 100);
}

// A sheet rolled onto a cylinder: hinges that bend it have three times its curvature (hinges.h).
TEST(TermStrains, OfARolledSheetAreItsCurvatures) {
  const double radius = 0.1;
  const Cloth sheet = cloth_of_grid({21, 5, 0.2, 0.04}, Diagonals::one).value();
  Eigen::VectorXd x(3 * sheet.mesh.node_count());
  for (int n = 0; n < sheet.mesh.node_count(); ++n) {
    const Eigen::Vector2d m = sheet.mesh.material_m.col(n);
    x.segment<3>(3 * n) << radius * std::sin(m[0] / radius), m[1], radius * std::cos(m[0] / radius);
  }
  const model::Model description = model::preset("cloth_stvk").value();
  const auto model = MeshModel::make(description, sheet);
  ASSERT_TRUE(model);
  std::vector<TermStrains> strains;
  ASSERT_EQ(model->term_strains(x, strains), AssemblyStatus::ok);
  int checked = 0;
  for (const TermStrains& entry : strains) {
    const auto& term = description.terms[static_cast<std::size_t>(entry.term)];
    if (term.strain.name != "bend_u") continue;
    for (const double curvature : entry.strain) {
      EXPECT_NEAR(std::abs(curvature), 3.0 / radius, 1e-3 / radius);
      ++checked;
    }
  }
  EXPECT_GT(checked, 50);
}

TEST(TermStrains, OfSolidsAreThoseOfThePoint) {
  testing::Numbers numbers(3);
  const Eigen::Matrix3d f = testing::random_solid(numbers);
  std::vector<TermStrains> strains;  // reused from body to body
  for (const SolidBody& body : solid_bodies()) {
    for (const model::Model& description : presets_of(Body::solid)) {
      SCOPED_TRACE(body.name + ", " + description.name);
      const auto model = MeshModel::make(description, body.mesh);
      ASSERT_TRUE(model);
      ASSERT_EQ(model->term_strains(affine(body.mesh, f), strains), AssemblyStatus::ok);
      const bool mixed = !body.mesh.tetrahedra.empty() && !body.mesh.hexahedra.empty();
      ASSERT_EQ(strains.size(), description.terms.size() * (mixed ? 2 : 1));
      std::vector<double> volume(description.terms.size(), 0.0);
      for (const TermStrains& entry : strains) {
        const auto t = static_cast<std::size_t>(entry.term);
        const auto measure = SolidStrain::make(description.terms[t].strain);
        ASSERT_TRUE(measure);
        SolidStrainValue expected;
        measure->evaluate(testing::z_of(f), expected);
        ASSERT_EQ(entry.strains, measure->count());
        for (std::size_t k = 0; k < entry.strain.size(); ++k)
          EXPECT_NEAR(entry.strain[k], expected.value[k % static_cast<std::size_t>(entry.strains)],
                      1e-12);
        const bool points = entry.kind == ElementKind::hexahedron_point;
        ASSERT_EQ(entry.element.size(),
                  points ? 8 * body.mesh.hexahedra.size() : body.mesh.tetrahedra.size());
        for (std::size_t k = 0; k < entry.element.size(); ++k)
          EXPECT_EQ(entry.element[k], static_cast<int>(points ? k / 8 : k));
        volume[t] += sum(entry.measure);
      }
      for (const double v : volume) EXPECT_NEAR(v, kBoxSize.prod(), 1e-15);
    }
  }
}

TEST(TermStrains, BadStatesAreSaid) {
  const SolidBody body = solid_bodies().front();
  const model::Model description = model::preset("solid_ogden").value();
  const auto model = MeshModel::make(description, body.mesh);
  ASSERT_TRUE(model);
  const Eigen::Matrix3d mirror = Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal();
  std::vector<TermStrains> strains;
  Eigen::VectorXd energies;
  EXPECT_EQ(model->term_strains(affine(body.mesh, mirror), strains), AssemblyStatus::inverted);
  EXPECT_EQ(model->term_energies(affine(body.mesh, mirror), term_parameters(description), energies),
            AssemblyStatus::inverted);
  const Cloth sheet = cloth();
  const model::Model flat = model::preset("cloth_stvk").value();
  const auto on_cloth = MeshModel::make(flat, sheet);
  ASSERT_TRUE(on_cloth);
  Eigen::VectorXd x = stretched(sheet, 0.0);
  x[4] = std::nan("");
  EXPECT_EQ(on_cloth->term_strains(x, strains), AssemblyStatus::not_finite);
  EXPECT_EQ(on_cloth->term_energies(x, term_parameters(flat), energies),
            AssemblyStatus::not_finite);
}

}  // namespace
}  // namespace tenter::mechanics
