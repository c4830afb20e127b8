// SPDX-License-Identifier: Apache-2.0
// A result document for tests of the reports, made by formula: no measurement and no fit stands
// behind its numbers.
#pragma once

#include <nlohmann/json.hpp>

namespace tenter::report::fixture {

/// A diagnosis of three captures (the last one marked synthetic) with every key of the contract.
nlohmann::ordered_json result();

}  // namespace tenter::report::fixture
