// SPDX-License-Identifier: GPL-3.0-or-later
// Twin captures: synthetic pulls of a cloth in which a known effect of a known size hides.
//
// The oracle of the diagnosis. Nothing of server/ is used: the cloth has its own integrator
// (cloth.h), the instruments their own noise (noise_chain.h). The same case gives the same captures
// on every machine, up to the last digits of libm.
//
//   Expected<Twin> twin = make_twin({.effects = {"internal_friction"}, .size = 3.0, .seed = 7});
//   diagnose(twin->captures, preset(twin->baseline_preset));
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "tests/twin/suite.h"

namespace tenter::twin {

/// What to hide, where. No effects (or size 0): a null twin.
struct TwinCase {
  /// "id" or "id:variant" of hidden_effects.h; several are all present
  std::vector<std::string> effects = {};
  double size = 0.0;           ///< of each effect alone, see sizing.h
  std::string suite = "rich";  ///< see suite.h
  std::uint64_t seed = 1;
  /// Captures beside those of the suite, of the same cloth by the same instruments; they change
  /// neither what hides nor the suite's own captures.
  std::vector<PlannedCapture> more = {};
};

/// What was hidden, for whoever marks the answers.
struct Hidden {
  std::string id;
  std::string variant;
  double amplitude = 0.0;
  std::string unit;  ///< of the amplitude
  double achieved_size =
      0.0;  ///< below the size asked for where the largest physical amplitude is not enough
  double share_of_force = 0.0;  ///< of an effect that hides alone: see Ruler::share_of_force
  bool foreign = false;
};

struct Twin {
  std::vector<capture::Capture> captures;
  std::string baseline_preset;  ///< model preset to start the diagnosis from
  std::vector<Hidden> hidden;
  double achieved_size = 0.0;   ///< of all effects together
  double noise_rms_N_m = 0.0;   ///< standard deviation of the x and y stresses
  bool sigma_declared = false;  ///< false: only the repeats tell the noise
};

/// Makes the captures of a case in about 0.1 s. Fails on an unknown effect or suite, and on two
/// effects that need different baselines.
Expected<Twin> make_twin(const TwinCase& twin_case);

}  // namespace tenter::twin
