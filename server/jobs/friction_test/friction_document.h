// SPDX-License-Identifier: GPL-3.0-or-later
// What all tests of internal friction leave in result.json: the key friction_test.
//
//   friction_test: {protocol, parts: [{direction: weft | warp, sense: positive | negative | null,
//     noise, noise_unit, gains_below, snapped, chi2_per_row,
//     numbers: [{name, unit, told, value | null, interval [lo | null, hi | null], words}],
//     stages: [{k1, k2, a, b, tau, rms_load}], and what only its protocol has}]}
//
// A part is one strain of the cloth that was fitted on its own: a direction, of strips also a sense
// of curvature. A number that the data do not tell is null there and among the parameters.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "server/diagnosis/diagnose.h"
#include "server/estimation/friction_tests/friction_estimate.h"

namespace tenter::jobs {

/// "weft" of green_u and bend_u, "warp" of green_v and bend_v.
std::string direction_of(const std::string& measure);

nlohmann::json part_json(const estimation::FrictionEstimate& found, const std::string& measure,
                         const std::string& noise_unit);

/// What is not told, and steps that may gain work, each as a warning; `name` of the part goes
/// before,
/// "" where there is one only.
std::vector<diagnosis::Check> checks_of(const estimation::FrictionEstimate& found,
                                        const std::string& name);

/// The values of what is not told leave the list of the model's parameters.
void withhold(const estimation::FrictionEstimate& found, nlohmann::json& parameters);

}  // namespace tenter::jobs
