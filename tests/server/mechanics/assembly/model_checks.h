// SPDX-License-Identifier: GPL-3.0-or-later
// Models for tests of assembly, and their derivatives against differences.
#pragma once

#include <string>
#include <tuple>
#include <vector>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "server/mechanics/assembly/mesh_model.h"
#include "tests/server/mechanics/elements/element_checks.h"

namespace tenter::mechanics {

enum class Body { cloth, solid };

/// The presets without memory that such a body can have, no two parameters alike; on cloth with
/// values at which every term weighs about the same on a mesh of 5 cm edges.
inline std::vector<model::Model> presets_of(Body body) {
  std::vector<model::Model> models;
  for (const std::string& name : model::preset_names()) {
    model::Model model = model::preset(name).value();
    if (model::remembers_path(model)) continue;
    bool solid = false;
    double factor = 1.0;
    for (model::Term& term : model.terms) {
      const model::StrainRow* row = model::find_strain(term.strain.name);
      solid = solid || row->domain == model::Domain::solid;
      std::tie(term.law.range_lo, term.law.range_hi) = model::spline_range(term.law, row->domain);
      for (model::Parameter& p : term.law.parameters) {
        if (row->domain == model::Domain::hinge) p.value *= 1e3;
        if (term.strain.name.starts_with("ring2")) p.value *= 50.0;
        p.value *= factor;
        factor *= 1.13;
      }
    }
    if (solid == (body == Body::solid)) models.push_back(model);
  }
  return models;
}

/// A limit of 1 J/m^2 or 1 J/m^3 on these terms; none: on all.
inline model::EnergyLimit limit_of(const model::Model& model, std::vector<std::string> terms,
                                   const std::string& id = "lock") {
  const model::StrainRow* row = model::find_strain(model.terms.front().strain.name);
  return {id, std::move(terms), 1.0, std::string(model::energy_density_unit(row->domain))};
}

/// Forces, stiffness and derivatives by parameter at x, against differences with this step.
inline void check_model(const MeshModel& model, const Eigen::VectorXd& parameters,
                        const Eigen::VectorXd& x, double step) {
  NodeMatrix matrix = model.matrix();
  const auto at = [&](const Eigen::VectorXd& y, NodeMatrix* into) {
    Answer answer;
    EXPECT_EQ(model.evaluate(y, parameters, {&answer.energy, &answer.gradient, into}),
              AssemblyStatus::ok);
    return answer;
  };
  check_derivatives(at, matrix, x, step, 1e-6);

  Eigen::MatrixXd by_parameter;
  ASSERT_EQ(model.gradient_by_parameter(x, parameters, by_parameter), AssemblyStatus::ok);
  testing::Comparison comparison("by parameter");
  for (Eigen::Index p = 0; p < parameters.size(); ++p) {
    const auto moved = [&](double value) {
      Eigen::VectorXd changed = parameters;
      changed[p] = value;
      Eigen::VectorXd gradient;
      EXPECT_EQ(model.evaluate(x, changed, {nullptr, &gradient, nullptr}), AssemblyStatus::ok);
      return gradient;
    };
    const Eigen::VectorXd column =
        testing::difference(moved, parameters[p], 1e-3 * std::abs(parameters[p]) + 1e-6);
    for (Eigen::Index i = 0; i < column.size(); ++i) comparison.add(by_parameter(i, p), column[i]);
  }
  comparison.judge(1e-7);
}

}  // namespace tenter::mechanics
