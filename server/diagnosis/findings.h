// SPDX-License-Identifier: GPL-3.0-or-later
// What a diagnosis says, of curves and of sheets: progress, verdicts, the path of additions, scores
// and the checklist. Values.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "server/diagnosis/effect.h"
#include "server/diagnosis/next/proposal.h"
#include "server/diagnosis/screening/candidate.h"

namespace tenter::diagnosis {

struct Progress {
  std::string stage;
  std::string detail;
  int iteration = 0;
  double cost = 0.0;
  double fraction = 0.0;
};

struct Control {
  std::function<void(const Progress&)> report = [](const Progress&) {};
  std::stop_token stop;
  int threads = 1;
};

struct Options {
  unsigned long long seed = 1;
  int null_twins = 1000;
  int max_effects = 8;
  int max_frames_per_block = 60;
  /// What the reported gain leaves out: "protocols", "repeats", "runs", "blocks", "none"; "auto":
  /// the hardest of them that the rest of the data can foretell.
  std::string leave_out = "auto";
  /// Ids of those that may be tried; none: all of the catalogue.
  std::vector<std::string> effects;
  /// What a proposed capture may ask of the rig.
  RigLimits rig;
};

enum class VerdictKind {
  nothing_found,
  named,
  ambiguous,
  sensor,
  not_excited,
  unexplained,
  numerical
};

struct Verdict {
  VerdictKind kind = VerdictKind::nothing_found;
  std::string effect;  ///< "" where none
  std::string words;
  double size = 0.0;  ///< share of the force (rms over rms)
  double size_lo = 0.0;
  double size_hi = 0.0;
  std::optional<double> p_value;
  std::vector<std::string> alternatives;
  std::optional<NextProtocol> next_protocol;
  std::optional<Design> design;  ///< the same in numbers, where a pull splits the alternatives
  std::vector<std::pair<std::string, double>> evidence;
};

struct PathStep {
  std::string action;  ///< "start", "add", "drop", "reject"
  std::string effect;
  std::string why;
  double chi2 = 0.0;
  double error = 0.0;
  std::optional<double> held_out;
  int parameters = 0;
  double information = 0.0;
  std::optional<double> p_value;
};

/// Relative rms error and R2 over stress rows (all rows where there is no stress).
struct Score {
  double error = 0.0;
  double r2 = 0.0;
};

struct Check {
  std::string level;  ///< "OK", "WARNING", "ERROR"
  std::string what;
  std::string why;
};

/// What a diagnosis says, whatever was captured.
struct Findings {
  Screen first_screen;
  Screen last_screen;  ///< of the extended model
  std::vector<Verdict> verdicts;
  std::vector<PathStep> path;
  std::vector<Check> checklist;
  Score before, after;
  std::optional<Score> held_out_before, held_out_after;
  std::string held_out_kind;  ///< "" where nothing could be left out
  double noise_floor = 0.0;
  double unexplained_share = 0.0;
};

}  // namespace tenter::diagnosis
