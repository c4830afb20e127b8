// SPDX-License-Identifier: GPL-3.0-or-later
// From a plan and its readings to a capture as a laboratory would have recorded it: noise, units,
// roles, repeats.
#pragma once

#include <array>
#include <string>

#include "common/capture/capture.h"
#include "tests/twin/machine.h"
#include "tests/twin/random.h"
#include "tests/twin/sizing.h"
#include "tests/twin/suite.h"

namespace tenter::twin {

/// Strips and free pulls carry forces in newton with their widths, the other captures membrane
/// stresses in N/m. `declared`: the channels say their standard deviation; otherwise 0, and only
/// repeats tell it. `step_N_m`: of the displays of the x and y cells, 0 for none.
capture::Capture write_down(const PlannedCapture& plan, const std::string& suite, Readings readings,
                            const NoiseLevels& noise, const std::array<double, 2>& step_N_m,
                            bool declared, Random& random);

}  // namespace tenter::twin
