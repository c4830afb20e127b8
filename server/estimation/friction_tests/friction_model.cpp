// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/friction_model.h"

#include <string>

#include "common/model/catalogue.h"

namespace tenter::estimation {
namespace {

model::Term term_of(std::string_view id, std::string_view measure, std::string_view law) {
  const model::StrainRow* row = model::find_strain(measure);
  model::Term term;
  term.id = id;
  term.strain.name = measure;
  term.law.name = law;
  term.law.parameters = model::default_parameters(*model::find_law(law), 0, row->domain);
  return term;
}

}  // namespace

model::Model friction_model(std::string_view strain_measure) {
  model::Model model;
  model.name = "friction_" + std::string(strain_measure);
  model.description = "linear stiffness and internal friction on one strain";
  model.terms.push_back(term_of("elastic", strain_measure, "linear_stiffness"));
  model.terms.push_back(term_of("friction", strain_measure, "dahl"));
  return model;
}

model::Model with_values(model::Model model, const FrictionValues& values) {
  model.terms[0].law.parameters[0].value = values.k1;
  model.terms[0].law.parameters[1].value = values.k2;
  auto& friction = model.terms[1].law.parameters;
  friction[0].value = values.a;
  friction[1].value = values.b;
  friction[2].value = 0.0;
  friction[3].value = values.tau;
  return model;
}

FrictionValues values_of(const Eigen::VectorXd& p) {
  return {p[kK1], p[kK2], p[kA], p[kB], p[kTau]};
}

Eigen::VectorXd flat(const FrictionValues& v) {
  Eigen::VectorXd p(static_cast<Eigen::Index>(kFrictionParameters));
  p << v.k1, v.k2, v.a, v.b, 0.0, v.tau;
  return p;
}

double gains_below(const FrictionValues& v) {
  const double missing = v.b * v.tau - 2.0 * v.a;
  if (missing <= 0.0) return 0.0;
  return missing / (2.0 * v.b);  // b is not zero: its product with tau is above 2 a
}

}  // namespace tenter::estimation
