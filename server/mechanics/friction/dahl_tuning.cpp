// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/friction/dahl_tuning.h"

#include <cmath>
#include <string>

#include "server/mechanics/friction/dahl_work.h"

namespace tenter::mechanics {

Expected<TunedFriction> tune_friction(const FrictionWish& wish) {
  struct Row {
    const char* name;
    double value;
    bool is_good;
    const char* wanted;
  };
  const Row rows[] = {{"stiffness", wish.stiffness, wish.stiffness > 0.0, "positive"},
                      {"persistent", wish.persistent, wish.persistent > 0.0, "positive"},
                      {"saturation", wish.saturation, wish.saturation > wish.persistent,
                       "larger than the persistent deformation"},
                      {"growth", wish.growth, wish.growth >= 0.0 && wish.growth < wish.stiffness,
                       "from zero to below the stiffness"},
                      {"saturated", wish.saturated, wish.saturated > 0.0 && wish.saturated < 1.0,
                       "between 0 and 1"}};
  for (const Row& row : rows)
    if (!row.is_good || !std::isfinite(row.value))
      return bad_input(std::string(row.name) + " is " + std::to_string(row.value) +
                       " and must be " + row.wanted);
  TunedFriction tuned;
  tuned.b = wish.growth;
  tuned.tau = (wish.saturation - wish.persistent) / std::log(2.0 / (1.0 - wish.saturated));
  tuned.a = (wish.stiffness - tuned.b) * wish.persistent - tuned.b * tuned.tau;
  if (!(tuned.a > 0.0) || tuned.b > largest_growth(tuned.a, tuned.tau))
    return bad_input("a growth of " + std::to_string(wish.growth) + " leaves a = " +
                     std::to_string(tuned.a) + " with tau = " + std::to_string(tuned.tau) +
                     ": friction near rest would gain work (b tau must not exceed 2 a)");
  return tuned;
}

double persistent_strain(double stiffness, const TunedFriction& friction) {
  if (!(friction.b < stiffness)) return 0.0;
  return (friction.a + friction.b * friction.tau) / (stiffness - friction.b);
}

}  // namespace tenter::mechanics
