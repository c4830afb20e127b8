// SPDX-License-Identifier: GPL-3.0-or-later
// The chain: what does the model get wrong, why, what would be right, how much better is it?
//
//   Diagnosis d = diagnose(request, control);
//
// Pure: captures and model in, findings out. The same request gives the same findings, for any
// number of threads. Method: design/diagnosis.md; steps are the functions of diagnose.cpp.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "common/model/model.h"
#include "server/diagnosis/screen.h"
#include "server/diagnosis/trial.h"
#include "server/estimation/outliers.h"

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
};

struct Request {
  std::vector<std::pair<std::string, capture::Capture>> captures;  ///< SHA-256, content
  model::Model model;
  Options options;
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

struct CaptureScore {
  Score before, after;
  std::optional<Score> held_out_before, held_out_after;
  double noise_floor = 0.0;
};

struct Check {
  std::string level;  ///< "OK", "WARNING", "ERROR"
  std::string what;
  std::string why;
};

struct Diagnosis {
  std::vector<estimation::Curves> curves;  ///< as measured, every frame
  DataPointer data;                        ///< as fitted: thinned, outliers left out
  estimation::Noise noise;
  std::vector<estimation::Outlier> outliers;
  Reference baseline;
  Reference extended;
  Screen first_screen;
  Screen last_screen;  ///< of the extended model
  std::vector<Verdict> verdicts;
  std::vector<PathStep> path;
  std::vector<Check> checklist;
  Score before, after;
  std::optional<Score> held_out_before, held_out_after;
  std::string held_out_kind;
  double noise_floor = 0.0;
  double unexplained_share = 0.0;
  std::vector<CaptureScore> captures;
};

/// The fit alone, with its scores: no effect is tried and no verdict passed. With every parameter
/// fixed it is a simulation. Baseline and extended model are the same.
Expected<Diagnosis> fit_only(const Request& request, const Control& control);

/// bad_input for captures that a material point cannot meet or a model that cannot be fitted;
/// cancelled.
Expected<Diagnosis> diagnose(const Request& request, const Control& control);

}  // namespace tenter::diagnosis
