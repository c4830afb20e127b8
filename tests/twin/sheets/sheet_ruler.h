// SPDX-License-Identifier: GPL-3.0-or-later
// How large an effect is on sheets: the rms of what it adds to readings and the baseline's own
// parameters cannot absorb, over the standard deviation of the noise; of forces or of points,
// whichever is more (forces are few among thousands of coordinates). As sizing.h of curves.
//
// What the baseline absorbs is the span of differences of readings by its stiffnesses, projected in
// units of the noise over all captures that are fitted. Cost: a suite of equilibria for each
// stiffness, then one for each truth that moves the sheet.
#pragma once

#include <optional>
#include <vector>

#include "tests/twin/sheets/sheet_effects.h"

namespace tenter::twin {

struct SheetNoise {
  double points_m = 1e-4;
  double forces_N = 3e-3;
};

/// The simulation that a sheet is held against.
enum class SheetBaseline { diagonal, isotropic };

struct SheetSize {
  double size = 0.0;
  double share_of_force = 0.0;  ///< rms over rms, of forces alone
};

class SheetRuler {
 public:
  static Expected<SheetRuler> make(const SheetSuite& suite, const SheetTruth& plain,
                                   SheetBaseline baseline, const SheetNoise& noise,
                                   const Hidden3& hidden);
  const SheetReadings& plain() const { return plain_readings_; }
  /// None where a frame has no rest.
  std::optional<SheetSize> size_of(const SheetTruth& truth) const;

 private:
  SheetRuler(const SheetSuite& suite, const SheetNoise& noise, const Hidden3& hidden)
      : suite_(&suite), noise_(noise), hidden_(&hidden) {}
  /// Whitened readings of what is fitted: points first, then forces.
  Eigen::VectorXd rows_of(const SheetReadings& readings) const;
  std::size_t fitted() const;

  const SheetSuite* suite_;
  SheetNoise noise_;
  const Hidden3* hidden_;
  SheetDone plain_done_;
  SheetReadings plain_readings_;
  Eigen::VectorXd plain_rows_;
  Eigen::MatrixXd span_;  ///< orthonormal columns
  Eigen::Index points_ = 0;
};

}  // namespace tenter::twin
