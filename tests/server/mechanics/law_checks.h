// SPDX-License-Identifier: GPL-3.0-or-later
// What every law must hold, checked along a random path: one call for each law in the tests.
//
//   stress     derivative of the (step's) energy by strain          tangent    of the stress by
//   strain, symmetric by_p, by_s derivatives of stress and end state by parameters, starting state
//   and strain rest       no stress, no end state other than zero, at rest purity     the same
//   input gives the same output, and nothing is read that was not given
#pragma once

#include <string>
#include <vector>

#include "server/mechanics/law.h"

namespace tenter::testing {

struct LawCase {
  std::string words;
  model::Law law;
  int strains = 1;
  double lo = -0.05;  ///< strains of the path
  double hi = 0.10;
  double step_s = 0.5;             ///< mean duration of a step; 0: no time
  double finest = 5e-6;            ///< step of the differences by strain
  std::vector<double> kinks = {};  ///< strains, of the path or remembered, where the law bends
  bool stressed_at_rest = false;   ///< energies through control points may have a stress there
  bool has_tangent = true;
  unsigned seed = 1;
};

/// A law of the catalogue with these values in its parameters.
model::Law law_with(const std::string& name, const std::vector<double>& values, double lo = 0.0,
                    double hi = 0.0);

void check_law(const LawCase& law_case);

/// Follows a law from rest through strains (one strain measure), each step of `step_s`; stresses at
/// the ends.
std::vector<double> follow_law(const mechanics::Law& law, const std::vector<double>& parameters,
                               const std::vector<double>& strains, double step_s);

std::vector<double> values_of(const model::Law& law);

}  // namespace tenter::testing
