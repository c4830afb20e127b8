// SPDX-License-Identifier: Apache-2.0
// The tables of a tracked sheet plus the JSON that describes them, made into a capture.
//
//   Expected<Capture> capture = import_sheet("pull.json");
//   Expected<Capture> capture = import_sheet("describe.json", "tracked.csv");
//
// The JSON is documented in README.md of this folder. What cannot be understood is refused, naming
// file, line and column (or the JSON key). Two things are worked out where nothing says them: the
// branches, from the clip that travels most, and the joining of a table that is over the place of a
// clip, linearly. Name and SHA-256 of the table of positions go into the provenance.
#pragma once

#include <string>

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

/// `csv_path` is the table that the description does not name; "" where it names all.
Expected<Capture> import_sheet(const std::string& describe_path, const std::string& csv_path = "");

}  // namespace tenter::capture
