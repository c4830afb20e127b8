// SPDX-License-Identifier: Apache-2.0
// A model document between its JSON text and memory: read, write, check.
//
//   Expected<Model> model = parse_model(text, "fabric.json");
//   // error: "fabric.json: terms[2].law.parameters.k.min: must be a number, not a string"
//
// The form is in README.md and tenter.model.schema.json. Unknown and repeated keys are errors. A
// parameter may be a plain number, and what a document leaves out (unit, bounds, whole parameters)
// is the catalogue's default.
#pragma once

#include <string>
#include <string_view>

#include "common/base/error.h"
#include "common/model/model.h"

namespace tenter::model {

inline constexpr std::size_t kMaxDocumentBytes = 4u << 20;

/// Parses and validates. `source_name` is what messages call the text.
Expected<Model> parse_model(std::string_view json_text, std::string_view source_name);

/// The whole model with all its bounds, keys in a fixed order; equal models give equal text, and a
/// number read back is the same number to the last bit. The model must be valid.
std::string write_model(const Model& model);

/// Names known, sizes matching, ids unique, values within bounds and finite; messages begin with
/// the path of the key.
Expected<void> validate(const Model& model);

}  // namespace tenter::model
