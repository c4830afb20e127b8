// SPDX-License-Identifier: Apache-2.0
// Options of `tenter fit` and `tenter diagnose` that only captures of a deforming sheet have.
//
//   auto draft = std::make_shared<SheetFitDraft>();
//   add_sheet_fit_options(*command, *draft);
//   ...
//   Expected<void> done = complete_options(*draft, run.captures, ids, options);   // ids: SHA-256
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace CLI {
class App;
}

namespace tenter::cli {

struct SheetFitDraft {
  std::vector<std::string> roles;     ///< "CAPTURE=ROLE"
  std::vector<std::string> held_out;  ///< captures as they were named
  std::vector<std::string> weights;   ///< "CAPTURE=NUMBER"
  int resolution = -1;
  std::string grid;
  int points = -1;
  int frames = -1;
  int max_control_points = -1;
  std::string knots;
  bool keep_points = false;
  std::string start;
  std::string channels;
  std::string robust;
  bool at_once = false;
  bool profiles = false;
  int starts = -1;
  std::string convex;
  int samples = -1;
  bool limits = false;
  std::string hold_unseen;
  bool without_grid_error = false;
};

void add_sheet_fit_options(CLI::App& command, SheetFitDraft& draft);
/// Those that a diagnosis has too: what is held out, and how captures are read.
void add_sheet_reading_options(CLI::App& command, SheetFitDraft& draft);

/// Puts what was given into the job's options. `names` are the captures as the user named them,
/// `ids` their SHA-256, in the same order; bad_input names the option that names none of them.
Expected<void> complete_options(const SheetFitDraft& draft, const std::vector<std::string>& names,
                                const std::vector<std::string>& ids, nlohmann::json& options);

}  // namespace tenter::cli
