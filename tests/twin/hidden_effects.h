// SPDX-License-Identifier: GPL-3.0-or-later
// The effects that a twin can hide: one row each, with what its amplitude turns.
//
// Ids are those of the catalogue of the diagnosis. "id:variant" asks for one form of an effect that
// has several; the bare id takes one by the seed. Foreign effects are deliberately none of the
// catalogue's.
#pragma once

#include <string>
#include <vector>

#include "tests/twin/cloth.h"
#include "tests/twin/machine.h"
#include "tests/twin/random.h"
#include "tests/twin/suite.h"

namespace tenter::twin {

/// Everything that an effect may change.
struct Truth {
  Cloth cloth;
  Faults faults;
};

struct HiddenEffect {
  std::string id;
  std::vector<std::string> variants;  ///< empty, or the forms it can take
  bool foreign = false;               ///< the catalogue of the diagnosis lacks it
  bool needs_time = false;   ///< cannot be told from its neighbours where no time was recorded
  bool needs_loops = false;  ///< shows only where unloading is recorded
  double first_guess = 1.0;  ///< amplitude to start the search for a size from
  double largest = 1e9;      ///< amplitude that stays physical
  std::string unit;          ///< of the amplitude
  /// Switches the effect on. `choices` fixes all else about it (the same at every amplitude).
  void (*apply)(double amplitude, const std::string& variant,
                const std::vector<PlannedCapture>& plans, Random choices, Truth& truth) = nullptr;
  bool needs_specimens = false;  ///< shows only where several specimens do the same
};

const std::vector<HiddenEffect>& hidden_effects();

/// Finds "id" or "id:variant"; nullptr where there is none.
const HiddenEffect* find_hidden_effect(const std::string& name);

/// Variant asked for in "id:variant", or one taken by `choices`; "" where the effect has only one
/// form.
std::string variant_of(const HiddenEffect& effect, const std::string& name, Random choices);

}  // namespace tenter::twin
