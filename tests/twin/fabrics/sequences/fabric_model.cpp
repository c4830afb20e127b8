// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sequences/fabric_model.h"

#include "common/model/catalogue.h"
#include "common/model/presets.h"

namespace tenter::twin {

double strain_scale(Mode mode) {
  return mode < Mode::bend_u ? 1.0 : 3.0;
}

model::Model fabric_model(const Fabric& fabric) {
  model::Model model = model::preset("cloth_stvk").value();
  model.name = "fabric " + fabric.id;
  model.description = fabric.name;
  for (std::size_t m = 0; m < fabric.curves.size(); ++m) {
    const StiffnessCurve& curve = fabric.curves[m];
    const double scale = strain_scale(static_cast<Mode>(m));
    const auto points = static_cast<int>(curve.k.size());
    model::Law& law = model.terms[m].law;
    law.name = points > 1 ? "hermite_stiffness" : "linear";
    law.range_lo = points > 1 ? scale * curve.lo : 0.0;
    law.range_hi = points > 1 ? scale * curve.hi : 0.0;
    law.parameters = model::default_parameters(
        *model::find_law(law.name), points, m < 3 ? model::Domain::membrane : model::Domain::hinge);
    for (std::size_t i = 0; i < curve.k.size(); ++i) law.parameters[i].value = curve.k[i] / scale;
  }
  const auto at_rest = [&](Mode mode) { return fabric.curve(mode).stiffness(0.0); };
  model.terms[5].law.parameters.front().value =
      (at_rest(Mode::bend_twist) - 0.25 * (at_rest(Mode::bend_u) + at_rest(Mode::bend_v))) / 3.0;
  return model;
}

}  // namespace tenter::twin
