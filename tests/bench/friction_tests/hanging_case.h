// SPDX-License-Identifier: GPL-3.0-or-later
// Hanging weights on one sample of table 5.1, over seeds.
#pragma once

#include "tests/bench/friction_tests/coverage_table.h"

namespace tenter::bench {

CoverageTable hanging_coverage(const twin::FrictionSample& sample, const CoverageOptions& options);

}  // namespace tenter::bench
