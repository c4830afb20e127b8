// SPDX-License-Identifier: GPL-3.0-or-later
// The options of a fit to captures of a deforming sheet, from the job's specification.
//
//   {"resolution": 25, "grid": "graded" | "equal", "points": 2000, "frames": 60, "start":
//   "equation_gap" | "model", "staged": true,
//    "max_control_points": 5, "knots": "even" | "data",
//    "keep_points": false, "channels": "thesis" | "all", "roles":
//    {"<capture>": "stretch_u"}, "held_out": ["<capture>"], "weights": {"<capture>": 2.0},
//    "robust": "none" | "huber" | "cauchy", "profiles": true, "sigma_m": 1e-4, "sigma_N": 0.003,
//    "starts": 20, "seed": 1, "convex": "none" | "every_step" | "afterwards" | "by_construction",
//    "samples": 3, "limits": true, "hold_unseen": "none" | "stand_in" | "start" | 2.6e-5,
//    "without_grid_error": true}
//
// All may be absent. Models of springs are simulated on equal cells in any case. A staged fit needs
// a role for every capture that is fitted; "evaluation" is the role of what is held out. "profiles"
// asks for a word and an interval by profile likelihood for each free parameter, which costs more
// than the fit. "starts" (how many), "convex", "samples" (at most how many) and "limits" are what
// is done after the stages on request (requests/); server/jobs/fit_requests.h says which of them go
// together. "hold_unseen": diagonal bending that the strips of a staged fit do not tell is held at
// what stands in for it (estimation/staged/unseen.h: so a staged fit does unless told otherwise,
// for a twist that nothing holds runs off by decades and spoils what is predicted), at the starting
// model's value, or at this one (N m). "without_grid_error": after the stages all is fitted again
// to what the cloth would show on a grid without error (estimation/staged/refit). sigma_m and
// sigma_N stand in for captures that do not say theirs.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "server/estimation/staged/staged_fit.h"

namespace tenter::jobs {

enum class ConvexWay { none, every_step, afterwards, by_construction };
enum class HoldUnseen { none, stand_in, start, value };

struct SheetFitOptions {
  int resolution = 25;          ///< nodes on a side of the grid, were it a square of the same area
  bool has_graded_grid = true;  ///< see estimation/sequences/material/grid_layout.h
  int points = 0;               ///< vertices of a capture that are compared; 0: all
  int frames = 0;               ///< of a capture, spread evenly; 0: all
  bool first_guess = true;
  bool staged = true;
  int max_control_points = 5;
  bool knots_from_data = false;
  bool keep_points = false;  ///< curves keep the control points of the model
  estimation::Channels channels = estimation::Channels::thesis;
  std::map<std::string, estimation::Role> roles;
  std::set<std::string> held_out;
  std::map<std::string, double> weights;
  estimation::RobustLoss loss;
  bool profiles = false;
  int starts = 0;  ///< random ones; 0: not asked for
  int seed = 1;
  ConvexWay convex = ConvexWay::none;
  int samples = 0;  ///< most that get numbers of their own; 0: not asked for
  bool limits = false;
  HoldUnseen hold_unseen = HoldUnseen::none;
  double held_at = 0.0;  ///< of HoldUnseen::value, N m
  bool without_grid_error = false;
  double sigma_m = 0.0;
  double sigma_N = 0.0;

  estimation::Role role_of(const std::string& capture) const;
  /// Seen by no stage.
  bool is_held_out(const std::string& capture) const;
};

const char* role_name(estimation::Role role);
const char* convex_word(ConvexWay way);

/// bad_input begins with the path of the key: "options.roles.3fa9c1...: ...".
Expected<SheetFitOptions> read_sheet_options(const nlohmann::json& given,
                                             const std::vector<std::string>& captures);

/// What is in force, defaults filled in.
nlohmann::json options_json(const SheetFitOptions& options);

}  // namespace tenter::jobs
