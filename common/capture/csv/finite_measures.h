// SPDX-License-Identifier: Apache-2.0
// Private: columns in measures of finite strain become what captures hold.
//
//   E = (stretch^2 - 1) / 2    Green strain, held as stretch - 1
//   P = F S                    S: second Piola-Kirchhoff stress, held as nominal stress P;
//                              F = [[x, xy], [0, y]]
#pragma once

#include <optional>
#include <string>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "common/capture/csv/description.h"

namespace tenter::capture {

/// stretch - 1; nothing where no stretch has such a strain.
std::optional<double> engineering_strain(double green_strain);

/// In place, for the channels whose columns say so. Where the description does not tell the
/// stretches that P needs, bad_input names `json_name` and the column.
Expected<void> make_stresses_nominal(const Description& description, const std::string& json_name,
                                     Capture& capture);

}  // namespace tenter::capture
