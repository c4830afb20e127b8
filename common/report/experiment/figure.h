// SPDX-License-Identifier: Apache-2.0
// The figure of an experiment (a scene's `experiment`, common/experiment) as one SVG file: for
// every run its pictures, all of one title to the same scale, the table of its numbers, and one
// plot for each curve with a line for every run.
//
//   Expected<std::string> svg = experiment_svg(result_json);
//
// Made from the job's document alone (schema "tenter.simulation"); needs no style sheet, font or
// network. The same document gives the same bytes; all text is escaped. bad_input: another
// document, or one whose scene has no experiment.
#pragma once

#include <string>

#include "common/base/error.h"

namespace tenter::report {

Expected<std::string> experiment_svg(const std::string& result_json);

/// The table of the numbers as text for a terminal, one line a run; the same errors.
Expected<std::string> experiment_text(const std::string& result_json);

}  // namespace tenter::report
