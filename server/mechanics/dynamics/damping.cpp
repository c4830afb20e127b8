// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/dynamics/damping.h"

#include <cmath>
#include <utility>
#include <vector>

#include "common/model/catalogue.h"
#include "server/mechanics/law.h"

namespace tenter::mechanics {

Expected<model::Model> with_damping(model::Model model, double time_s) {
  if (!(time_s >= 0.0) || !std::isfinite(time_s))
    return bad_input("the time of the damping must be zero or more seconds");
  std::vector<model::Term> damping;
  for (const model::Term& term : model.terms) {
    const auto* row = model::find_strain(term.strain.name);
    if (!row) return bad_input("no strain is called \"" + term.strain.name + "\"");
    if (row->strains != 1) continue;
    auto law = make_law(term.law, 1);
    if (!law) return tl::unexpected(law.error());
    if ((*law)->state_count() > 0) continue;
    std::vector<double> parameters;
    for (const model::Parameter& p : term.law.parameters) parameters.push_back(p.value);
    const double unit_strain = 1.0;
    LawOutput out;
    (*law)->clear(out);
    (*law)->evaluate({&unit_strain, parameters.data(), nullptr, 0.0, false}, out);
    const double stiffness = out.tangent[0][0];
    if (!(stiffness > 0.0)) continue;
    model::Term resists = term;
    resists.id += "_damping";
    resists.law = model::Law();
    resists.law.name = "kelvin_voigt";
    model::Parameter eta;
    eta.name = "eta";
    eta.value = time_s * stiffness;
    eta.unit = "N s/m";
    resists.law.parameters = {eta};
    damping.push_back(std::move(resists));
  }
  model.terms.insert(model.terms.end(), damping.begin(), damping.end());
  return model;
}

}  // namespace tenter::mechanics
