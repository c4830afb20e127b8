// SPDX-License-Identifier: GPL-3.0-or-later
// Is it friction that makes these loops, or does the load depend on how fast the strain changes?
//
// Two witnesses, both of which have to speak against friction:
//   1. the catalogue's viscosity (server/diagnosis): the best of its screen, refitted beside
//   stiffness
//      and friction, is decisively better than these alone, on rows that count as independent
//   2. a fact that needs no model: in a long hold the load falls by more than a tenth of the run's
//      largest, or at three times the rate a loop of one amplitude loses another work by more than
//      15 %. Friction changes in neither.
// Only captures that split the two (rates a factor of three apart, or a hold;
// Excitation::splits_rate) can answer.
//
// Cost: two to four fits and a screen. Pure; same bytes for any number of threads.
#pragma once

#include <optional>
#include <string>

#include "server/diagnosis/diagnose.h"

namespace tenter::jobs {

enum class RateAnswer {
  not_asked,  ///< the captures cannot tell: one rate and no hold, or no times
  friction,   ///< nothing decisive speaks against friction
  viscosity   ///< both witnesses do
};

struct RateQuestion {
  RateAnswer answer = RateAnswer::not_asked;
  double friction_share = 0.0;   ///< of what the elastic term misses, that friction explains
  double viscosity_share = 0.0;  ///< the same of viscosity
  double evidence = 0.0;         ///< information of friction - of viscosity; decisive above 10
  std::optional<double>
      fallen;           ///< share of the load that is lost in the long hold that loses most
  double hold_s = 0.0;  ///< how long that is
  std::optional<double> loss_ratio;  ///< work lost in a loop, fast over slow, at one amplitude
  double rate_ratio = 1.0;           ///< of those two
  std::string words;                 ///< one or two sentences
};

/// `captures` of one strain (loops_of) and the model that was fitted to them (fit_loops).
/// bad_input, cancelled.
Expected<RateQuestion> ask_for_rate(
    const std::vector<std::pair<std::string, capture::Capture>>& captures,
    const model::Model& fitted, const diagnosis::Control& control);

}  // namespace tenter::jobs
