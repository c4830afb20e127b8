// SPDX-License-Identifier: GPL-3.0-or-later
// How large an effect is: the rms of what it adds to the readings and the baseline's own parameters
// cannot absorb, over the standard deviation of the noise.
//
// Readings are stacked, each divided by its channel's noise, over all captures of the suite. What
// the baseline can absorb is the span of the finite differences of the elastic readings by the
// baseline's parameters.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/twin/hidden_effects.h"
#include "tests/twin/machine.h"
#include "tests/twin/suite.h"

namespace tenter::twin {

/// Standard deviations of the channels.
struct NoiseLevels {
  double stress_N_m = 0.2;
  double shear_stress_N_m = 0.06;
  double observed_stretch = 2e-4;
};

/// The simulation that the twin is held against. Names are those of the shipped model presets.
enum class Baseline { stvk_orthotropic, stvk_isotropic, stvk_diagonal };
std::string preset_name(Baseline baseline);

/// The baseline in whose light these effects are misfits; orthotropic StVK for most.
Baseline baseline_for(const std::vector<std::string>& effect_ids);

/// All readings of the suite, stacked and divided by their noise; `sigma_N_m`, where wanted, gets
/// what each was divided by, zero for a stretch.
std::vector<double> whitened_readings(const std::vector<PlannedCapture>& plans, const Truth& truth,
                                      const NoiseLevels& noise,
                                      std::vector<double>* sigma_N_m = nullptr);

/// Measures sizes of truths against one effect-free truth.
class Ruler {
 public:
  Ruler(const std::vector<PlannedCapture>& plans, const Truth& plain, Baseline baseline,
        const NoiseLevels& noise);

  /// rms of whitened_readings(truth) - whitened_readings(plain), projected off the baseline's span.
  double size_of(const Truth& truth) const;

  /// What the best baseline leaves of the stresses, rms over the rms of all stresses that are read:
  /// the share of the force that the effect accounts for. The best baseline is sought among all of
  /// its parameters, not only in the tangent at the plain cloth.
  double share_of_force(const Truth& truth) const;

 private:
  /// What is added to the readings, without what the baseline absorbs.
  std::vector<double> unabsorbed(const std::vector<double>& readings) const;

  /// Readings' central differences by the baseline's parameters, each over twice the step.
  std::vector<std::vector<double>> columns_at(const Truth& cloth) const;

  const std::vector<PlannedCapture>& plans_;
  NoiseLevels noise_;
  Truth plain_cloth_;
  std::vector<Elastic> directions_;
  std::vector<double> plain_;
  std::vector<std::vector<double>> span_;  ///< orthonormal
};

/// An amplitude and the size that it gives.
struct Sized {
  double amplitude = 0.0, size = 0.0;
};
/// The amplitude at which an effect has the wanted size, within `tolerance` of it: fixed-point
/// steps in the logarithm with the secant's slope (the size is nearly a power of the amplitude). At
/// most `largest`.
Sized find_amplitude(double first_guess, double largest, double wanted,
                     const std::function<double(double)>& size_of, double tolerance = 0.002);

}  // namespace tenter::twin
