// SPDX-License-Identifier: Apache-2.0
// Photographs of strips plus the JSON that describes them, made into a capture of kind
// "strip_profiles".
//
//   Expected<Capture> capture = import_strip_photographs("spirals.json");
//
// The JSON is documented in README.md of this folder; its photographs lie beside it. What cannot be
// understood is refused, naming the file and the key, or the photograph and the pixel. Names and
// SHA-256 of the photographs go into the provenance. Strips of one radius, sense and length are
// repeats of each other.
#pragma once

#include <string>

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

Expected<Capture> import_strip_photographs(const std::string& describe_path);

/// Does this text describe photographs of strips? True for an object of that kind which has a list
/// of photographs.
bool describes_strip_photographs(const std::string& text);

}  // namespace tenter::capture
