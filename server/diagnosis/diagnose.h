// SPDX-License-Identifier: GPL-3.0-or-later
// The chain: what does the model get wrong, why, what would be right, how much better is it?
//
//   Diagnosis d = diagnose(request, control);
//
// Pure: captures and model in, findings out. The same request gives the same findings, for any
// number of threads. Method: design/diagnosis.md; steps are the functions of diagnose.cpp.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "common/model/model.h"
#include "server/diagnosis/findings.h"
#include "server/diagnosis/screen.h"
#include "server/diagnosis/trials/trial.h"
#include "server/estimation/outliers.h"

namespace tenter::diagnosis {

struct Request {
  std::vector<std::pair<std::string, capture::Capture>> captures;  ///< SHA-256, content
  model::Model model;
  Options options;
};

struct CaptureScore {
  Score before, after;
  std::optional<Score> held_out_before, held_out_after;
  double noise_floor = 0.0;
};

struct Diagnosis : Findings {
  std::vector<estimation::Curves> curves;  ///< as measured, every frame
  DataPointer data;                        ///< as fitted: thinned, outliers left out
  estimation::Noise noise;
  std::vector<estimation::Outlier> outliers;
  Reference baseline;
  Reference extended;
  /// Of the last round of additions: what passes every gate but the one on left-out data, where
  /// there are none; best first.
  std::vector<Trial> unproven;
  /// Of the same round: what passes every gate but that the form of what was found may miss as
  /// much.
  std::vector<Trial> within_form;
  std::vector<CaptureScore> captures;
};

/// The fit alone, with its scores: no effect is tried and no verdict passed. With every parameter
/// fixed it is a simulation. Baseline and extended model are the same.
Expected<Diagnosis> fit_only(const Request& request, const Control& control);

/// bad_input for captures that a material point cannot meet or a model that cannot be fitted;
/// cancelled.
Expected<Diagnosis> diagnose(const Request& request, const Control& control);

}  // namespace tenter::diagnosis
