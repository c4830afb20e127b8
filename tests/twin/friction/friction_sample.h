// SPDX-License-Identifier: GPL-3.0-or-later
// The six samples of thesis tables 5.1 and 5.2, and how one strain of theirs answers: Dahl's law
// 5.2 by small Runge-Kutta steps, which shares nothing with the closed form of the server.
//
//   FrictionState state;
//   state = moved(sample, state, 0.1);                 // strain 0 -> 0.1
//   double load = stress(sample, state);               // N/m; bending: N
#pragma once

#include <string>
#include <vector>

namespace tenter::twin {

/// SI: N/m and 1 for stretch (table 5.1), N m, N and 1/m for bending (5.2).
struct FrictionSample {
  std::string name;
  double density_kg_m2 = 0.0;
  double k1 = 0.0, k2 = 0.0;
  double a = 0.0, b = 0.0;
  double tau = 0.0;
};

const std::vector<FrictionSample>& stretch_samples();  ///< cotton, spandex, polyester
const std::vector<FrictionSample>& bending_samples();  ///< felt, doublecloth, paper

struct FrictionState {
  double strain = 0.0;
  double friction = 0.0;  ///< its stress
};

/// Elastic stress and friction.
double stress(const FrictionSample& sample, const FrictionState& state);

/// After one step of strain; exact to the fourth order of step / tau.
FrictionState stepped(const FrictionSample& sample, FrictionState state, double step);

/// Moved to a strain in steps of a hundredth of tau.
FrictionState moved(const FrictionSample& sample, FrictionState state, double strain);

}  // namespace tenter::twin
