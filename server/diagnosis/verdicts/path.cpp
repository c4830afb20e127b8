// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/path.h"

#include <algorithm>

namespace tenter::diagnosis {

PathStep path_step(const std::string& action, const std::string& effect, const std::string& why,
                   const Reference& at, double error) {
  PathStep step;
  step.action = action;
  step.effect = effect;
  step.why = why;
  step.chi2 = at.fit.chi2;
  step.error = error;
  step.parameters = free_count(at.model);
  step.information = information(at.fit.chi2, step.parameters, 0, at.fit.effective_rows);
  return step;
}

std::string made_needless(const Reference& reduced, const Reference& whole) {
  const double rows = std::max(whole.fit.effective_rows, reduced.fit.effective_rows);
  const int added = std::max(1, free_count(whole.model) - free_count(reduced.model));
  const double p =
      f_test(reduced.fit.chi2, whole.fit.chi2, added, determined_count(whole.fit), rows);
  return p >= 1e-3 ? "what was added later made it needless (p = " + std::to_string(p) + ")" : "";
}

std::string stands_in(double share, double left, bool is_exact) {
  // more is asked of a name where more stays unexplained; what came in late, when little was
  // missed, explains much of little
  constexpr double kMost = 0.5;
  double least_share = left > 0.25 ? 0.65 : left > 0.1 ? 0.5 : 0.35;
  if (is_exact && left > 0.1) least_share = 0.9;
  return left > kMost || share < least_share
             ? "it explains little of what is missed, and much stays unexplained: a stand-in"
             : "";
}

bool is_a_series(int effects, double first_share) {
  constexpr int kMany = 3;
  constexpr double kLittle = 0.4;  // three equal causes: a third, and some of what others share
  return effects >= kMany && first_share < kLittle;
}

}  // namespace tenter::diagnosis
