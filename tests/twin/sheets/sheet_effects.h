// SPDX-License-Identifier: GPL-3.0-or-later
// The effects that a sheet of the examination can hide: what hidden_effects.h is to curves.
#pragma once

#include <string>
#include <vector>

#include "tests/twin/random.h"
#include "tests/twin/sheets/sheet_faults.h"

namespace tenter::twin {

struct SheetTruth {
  Fabric fabric;
  SheetFaults faults;
  bool is_fabric_plain = true;  ///< no effect is one of the material
};

struct SheetEffect {
  std::string id;
  std::vector<std::string> variants;  ///< empty, or the forms it can take
  bool foreign = false;               ///< the catalogue of the diagnosis lacks it
  bool needs_time = false;   ///< cannot be told from its neighbours where no time was recorded
  bool is_material = false;  ///< it changes the fabric
  bool needs_shear = false;  ///< shows only where stretch and shear come together
  double first_guess = 1.0;  ///< amplitude to start the search for a size from
  double largest = 1e9;      ///< amplitude that stays physical
  std::string unit;          ///< of the amplitude
  /// Switches the effect on. `plain`: what was read without. `choices` fixes all else about it.
  void (*apply)(double amplitude, const std::string& variant, const SheetSuite& suite,
                const SheetReadings& plain, Random choices, SheetTruth& truth) = nullptr;
};

const std::vector<SheetEffect>& sheet_effects();
const SheetEffect* find_sheet_effect(const std::string& id);  ///< nullptr where there is none

/// Whether such a suite shows it; viscosity without time too, in a group with friction.
bool can_show(const SheetTraits& traits, const SheetEffect& effect);

}  // namespace tenter::twin
