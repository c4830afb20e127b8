// SPDX-License-Identifier: GPL-3.0-or-later
// Where in the material a term acts: its weight on the energy density at a point of the rest shape.
//
//   everywhere   1
//   rbf          w_k(X) = phi_k(X) / sum_l phi_l(X),   phi_l(X) = exp(-|X - X_l|^2 / (2 h^2))
//
// (thesis 4.4: energies, not parameters, are interpolated: a term per sample, each with its own
// parameters, and sum_k w_k = 1 everywhere.) Far from all samples the nearest one wins; the weights
// are never NaN. Cost: one exponential per sample. Immutable; any thread; no allocation in
// weight().
//
//   auto support = Support::make(model, term.support);
//   const double u_v[2] = {0.02, 0.07};
//   energy += support->weight(u_v) * density;
#pragma once

#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"

namespace tenter::mechanics {

class Support {
 public:
  /// bad_input for an unknown name, a field that the model does not have, or a sample it has not.
  static Expected<Support> make(const model::Model& model, const model::Support& description);

  bool is_everywhere() const { return positions_m_.empty(); }
  /// How many coordinates weight() reads: 2 or 3; 0 everywhere.
  int dimensions() const { return dimensions_; }
  /// `position_m`: in the rest shape. May be null where the support is everywhere.
  double weight(const double* position_m) const;

 private:
  int dimensions_ = 0;
  std::size_t sample_ = 0;
  double per_width_ = 0.0;
  std::vector<double> positions_m_;
};

}  // namespace tenter::mechanics
