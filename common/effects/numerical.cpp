// SPDX-License-Identifier: Apache-2.0
#include "common/effects/effects.h"

namespace tenter::effects {

std::vector<Row> numerical_rows() {
  return {
      {"mesh_resolution",
       Kind::numerical,
       "a discretisation that is too coarse: steps of the path, or elements, that are too large",
       "changes where the path is stepped more finely",
       "nothing is added: one refined solve is compared before any material is blamed",
       {"internal_friction", "viscosity"},
       {"denser_frames",
        "Record the same path with frames at half the distance.",
        {{"repeat", "the same path, twice as many frames"}}}},
      {"solver_tolerance",
       Kind::numerical,
       "a fit that stopped before its optimum",
       "chi2 falls when the same search goes on with a tighter tolerance",
       "nothing is added: the search is taken on from its end with tighter tolerances",
       {"wrong_basin"},
       {"tighter_fit", "Needs no capture: fit again with a tighter tolerance.", {}}},
      {"wrong_basin",
       Kind::numerical,
       "a fit in the wrong basin: another start leads to a better optimum",
       "two-valued between starts, and between repeats",
       "nothing is added: the search is repeated from other starts",
       {"solver_tolerance", "nonlinear_stiffness"},
       {"other_starts", "Needs no capture: fit from other starts and keep the best.", {}}},
  };
}

}  // namespace tenter::effects
