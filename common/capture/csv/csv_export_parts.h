// SPDX-License-Identifier: Apache-2.0
// Private: parts of an export that those of other kinds of capture have too.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/capture/capture.h"

namespace tenter::capture {

/// Run, group, frame, phase, branch, time and channels: one row a frame.
std::string table_of(const Capture& capture);
/// What describes the columns of that table.
nlohmann::ordered_json describe_columns(const Capture& capture);
nlohmann::ordered_json describe_specimen(const Specimen& specimen);
nlohmann::ordered_json describe_protocol(const Protocol& protocol);
nlohmann::ordered_json describe_provenance(const Provenance& provenance);

}  // namespace tenter::capture
