// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/instrument/reading.h"

namespace tenter::estimation {

void amplify(double gain, int parameter, bool sensitivities, Shown& shown) {
  if (sensitivities) {
    shown.by_p *= gain;
    shown.by_p[parameter] = shown.value;
  }
  shown.value *= gain;
}

void add(double amount, double column, int parameter, bool sensitivities, Shown& shown) {
  shown.value += amount * column;
  if (sensitivities) shown.by_p[parameter] = column;
}

void cut_off(double share, double cap, int first_parameter, bool sensitivities, Shown& shown) {
  const double over = shown.value - cap;
  if (over <= 0.0) return;
  shown.value -= share * over;
  if (!sensitivities) return;
  shown.by_p *= 1.0 - share;
  shown.by_p[first_parameter] = -over;
  shown.by_p[first_parameter + 1] = share;
}

}  // namespace tenter::estimation
