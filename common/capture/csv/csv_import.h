// SPDX-License-Identifier: Apache-2.0
// A CSV of a laboratory's machine plus the JSON that says what its columns are, made into a
// capture.
//
//   Expected<Capture> capture = import_csv("pull.csv", "pull.json");
//
// README.md documents the JSON with worked examples. What cannot be understood is refused, naming
// file, line and column (or the JSON key); nothing is guessed but the branches, where the file has
// no column for them (branch_detection.h). The file's name and SHA-256 go into the provenance.
#pragma once

#include <string>

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

Expected<Capture> import_csv(const std::string& csv_path, const std::string& describe_path);

}  // namespace tenter::capture
