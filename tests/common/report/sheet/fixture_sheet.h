// SPDX-License-Identifier: Apache-2.0
// A result document of a fit to a sheet with every part that a page shows. Made up, seeded.
#pragma once

#include <nlohmann/json.hpp>

namespace tenter::report::fixture {

/// Five captures (one of them held out), two curves, two loops, three meshes of 9 x 9 nodes.
nlohmann::ordered_json sheet_fit();

}  // namespace tenter::report::fixture
