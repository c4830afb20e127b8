// SPDX-License-Identifier: GPL-3.0-or-later
// Captures and data sets made for tests: a strip pulled along x through planned strains, its force
// read by a model.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/model/model.h"
#include "server/estimation/prediction.h"

namespace tenter::testing {

/// Triangular loops: `runs` runs, each from zero to `peak` and back, `frames` frames up and as many
/// down.
struct LoopPlan {
  int runs = 3;
  int frames = 25;
  double peak = 0.06;
  double rate_per_s = 0.002;
  bool has_time = true;
  bool transverse_free =
      false;  ///< y is observed and free of stress, else prescribed at 0.3 times x
  std::string group = "loops";
};

/// Strains prescribed, stresses zero until filled; two stress channels (one with a free transverse
/// direction).
capture::Capture loop_capture(const LoopPlan& plan);

/// Data set of these captures with a standard deviation for every stress (stretches get a
/// thousandth of it).
std::shared_ptr<estimation::DataSet> data_of(const std::vector<capture::Capture>& captures,
                                             double sigma);

/// Replaces what was measured by what the model shows, plus noise of `sigma` (stretches: a
/// thousandth) from a seed.
void measure_with(const model::Model& model, double sigma, unsigned seed,
                  estimation::DataSet& data);

/// Preset with these values in its first parameters.
model::Model preset_with(const std::string& name, const std::vector<double>& values);

/// Adds a correction of the catalogue with a value in its first parameter.
void add_correction(model::Model& model, const std::string& type, const std::string& component,
                    double value);

}  // namespace tenter::testing
