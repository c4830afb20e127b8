// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/mechanics/equilibrium/sheets.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::mechanics::testing {

model::Model preset_with(const std::string& name,
                         std::initializer_list<std::pair<std::string, double>> values) {
  model::Model model = model::preset(name).value();
  for (const auto& [id, value] : values) {
    int found = 0;
    for (model::Term& term : model.terms) {
      if (term.id != id) continue;
      term.law.parameters[0].value = value;
      ++found;
    }
    EXPECT_EQ(found, 1) << name << " has no term " << id;
  }
  return model;
}

model::Model linear_model(std::initializer_list<std::pair<std::string, double>> strains) {
  model::Model model;
  model.name = "linear";
  for (const auto& [strain, value] : strains) {
    model::Term term;
    term.id = strain;
    term.strain.name = strain;
    term.law.name = strain == "green_pair" ? "bilinear" : "linear";
    model::Parameter parameter;
    parameter.name = strain == "green_pair" ? "c" : "k";
    parameter.value = value;
    term.law.parameters = {parameter};
    model.terms.push_back(term);
  }
  return model;
}

Eigen::VectorXd values_of(const model::Model& model) {
  std::vector<double> values;
  for (const model::Term& term : model.terms)
    for (const model::Parameter& p : term.law.parameters) values.push_back(p.value);
  return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Sheet::Sheet(Cloth of, const model::Model& description)
    : cloth(std::move(of)),
      model(MeshModel::make(description, cloth).value()),
      parameters(values_of(description)) {}

Body::Body(SolidMesh of, const model::Model& description)
    : mesh(std::move(of)),
      model(MeshModel::make(description, mesh).value()),
      parameters(values_of(description)) {}

Eigen::VectorXd flat(const SurfaceMesh& mesh) {
  return placed(mesh, [](double u, double v) { return Eigen::Vector3d(u, v, 0.0); });
}

Eigen::VectorXd shaken(Eigen::VectorXd x, double by_m, unsigned seed) {
  tenter::testing::Numbers numbers(seed);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += numbers.between(-by_m, by_m);
  return x;
}

Loads weight(const SurfaceMesh& mesh, double area_density_kg_m2) {
  const std::vector<double> mass = lumped_masses_kg(mesh, area_density_kg_m2);
  Loads loads;
  loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(mass.data(), static_cast<Eigen::Index>(mass.size()));
  return loads;
}

EquilibriumResult solved(const MeshModel& model, const Eigen::VectorXd& parameters,
                         const Boundary& boundary, const Loads& loads, State& state,
                         const EquilibriumOptions& options,
                         const std::vector<Obstacle>& obstacles) {
  auto solver = EquilibriumSolver::make(model, boundary, obstacles);
  if (!solver) {
    ADD_FAILURE() << solver.error().message;
    return {};
  }
  auto result = solver->solve(parameters, loads, state, options);
  if (!result) {
    ADD_FAILURE() << result.error().message;
    return {};
  }
  return *result;
}

double order(double coarse_error, double fine_error) {
  return std::log2(coarse_error / fine_error);
}

}  // namespace tenter::mechanics::testing
