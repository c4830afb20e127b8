// SPDX-License-Identifier: GPL-3.0-or-later
// The twin fabrics in the rig, as staged fits take them; and how much memory a program took.
#pragma once

#include <string>
#include <vector>

#include "server/estimation/staged/roles.h"
#include "tests/bench/cpu_time.h"
#include "tests/twin/fabrics/fabric.h"

namespace CLI {
class App;
}

namespace tenter::bench {

struct RigSettings {
  int nodes = 25;
  int frames = 40;
  double cord_loop_N = 0.0;  ///< 0.1: as the thesis measured
  unsigned seed = 1;
};

/// The five sequences for fits, or the two for evaluation. Exits with a sentence where a twin has
/// no rest, and where there are too few nodes (7 a side) or no frame.
std::vector<estimation::RoleSequence> fitting_sequences(const std::string& fabric,
                                                        const RigSettings& settings);
std::vector<estimation::RoleSequence> evaluation_sequences(const std::string& fabric,
                                                           const RigSettings& settings);

double peak_memory_MB();
double cpu_seconds();  ///< of the process

/// --nodes, --frames, --cord: with what stands in `settings` as their defaults.
void add_rig_options(CLI::App& app, RigSettings& settings);

}  // namespace tenter::bench
