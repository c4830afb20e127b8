// SPDX-License-Identifier: GPL-3.0-or-later
// A reading on its way through an instrument, and its derivatives by all parameters of a model.
//
//   amplify   v <- gain v                            add   v <- v + amount column
//   cut_off   v <- v - share max(0, v - cap)         1: a flat top
//
//   amplify(p[i], i, wants_derivatives, shown);
//
// Each step owns its parameters: no step before it has set their derivatives. by_p is touched only
// where derivatives are wanted. Pure; nothing allocates; O(parameters).
#pragma once

#include <Eigen/Core>

namespace tenter::estimation {

/// One reading as predicted, and its derivatives by all parameters: terms first, then corrections.
struct Shown {
  double value = 0.0;
  Eigen::RowVectorXd by_p;
};

void amplify(double gain, int parameter, bool sensitivities, Shown& shown);
/// `column`: what one unit of the parameter adds.
void add(double amount, double column, int parameter, bool sensitivities, Shown& shown);
/// `first_parameter` is that of the share, the next one that of the cap.
void cut_off(double share, double cap, int first_parameter, bool sensitivities, Shown& shown);

}  // namespace tenter::estimation
