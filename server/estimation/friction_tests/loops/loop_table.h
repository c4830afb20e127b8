// SPDX-License-Identifier: GPL-3.0-or-later
// Readings of loops of one strain: the strain that a machine imposed and the load that it measured,
// in the order in which they were taken.
//
//   load = force per rest width (N/m) = sigma d eps / d lambda,   d eps / d lambda = sqrt(1 + 2
//   eps)
//
// A run may begin anew, from a specimen without a history, or go on where the one before ended.
// Branches are the pieces that go one way; a reading's anchor is where its branch began.
//
//   Expected<LoopTable> checked = check(table);
//
// SI units; pure; any thread.
#pragma once

#include <vector>

#include "common/base/error.h"
#include "server/estimation/friction_tests/anchored_errors.h"

namespace tenter::estimation {

struct LoopReading {
  double strain = 0.0;  ///< Green's
  double load = 0.0;    ///< N/m
  int branch = 0;       ///< readings of one branch follow each other
};

struct LoopTable {
  std::vector<LoopReading> readings;
  /// Readings before which the specimen is one without a history; rising. The first one always is.
  std::vector<int> beginnings;
  double load_noise = 0.0;  ///< N/m, of one load; 0: taken from the fit's own residuals
};

/// bad_input that names the reading: finite numbers, strains above -1/2, at least twelve readings,
/// branches that go up and such that go down.
Expected<LoopTable> check(LoopTable table);

/// The papers' errors of all readings that have an anchor: those of the branches after the first of
/// each beginning.
std::vector<AnchoredReading> anchored_readings(const LoopTable& table);

/// Work that is lost on the way of all readings, over the work of loading: the integral of the load
/// over the stretch, all of it over what its rising parts have. 0 where nothing is loaded.
double lost_share(const LoopTable& table);

}  // namespace tenter::estimation
