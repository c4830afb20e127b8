// SPDX-License-Identifier: GPL-3.0-or-later
// Is it friction that makes these loops, or does the load depend on how fast the strain changes?
//
// The effects of the catalogue (server/diagnosis) are asked: beside the same elastic term, the best
// internal friction and the best viscosity of its screen are refitted, and their information is
// compared on rows that count as independent. Only captures that split the two (rates a factor of
// three apart, or a hold; Excitation::splits_rate) can answer. With them go two facts that need no
// model: how far the load falls in a hold, and how the work lost in a loop changes with the rate at
// one amplitude. Friction changes in neither.
//
// Cost: three fits and a screen. Pure; same bytes for any number of threads.
#pragma once

#include <optional>
#include <string>

#include "server/diagnosis/diagnose.h"

namespace tenter::jobs {

enum class RateAnswer {
  not_asked,  ///< the captures cannot tell: one rate and no hold, or no times
  friction,   ///< friction explains them at least as well
  viscosity,  ///< viscosity explains them decisively better: no friction
};

struct RateQuestion {
  RateAnswer answer = RateAnswer::not_asked;
  double friction_share = 0.0;       ///< of what the elastic term misses, that friction explains
  double viscosity_share = 0.0;      ///< the same of viscosity
  double evidence = 0.0;             ///< information of friction - of viscosity; decisive above 10
  std::optional<double> fallen;      ///< share of the load that is lost in the hold that loses most
  double hold_s = 0.0;               ///< how long that is
  std::optional<double> loss_ratio;  ///< work lost in a loop, fast over slow, at one amplitude
  double rate_ratio = 1.0;           ///< of those two
  std::string words;                 ///< one or two sentences
};

/// `captures` of one strain (loops_of); `measure` of it. bad_input, cancelled.
Expected<RateQuestion> ask_for_rate(
    const std::vector<std::pair<std::string, capture::Capture>>& captures,
    const std::string& measure, const diagnosis::Control& control);

}  // namespace tenter::jobs
