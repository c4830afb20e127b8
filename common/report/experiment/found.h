// SPDX-License-Identifier: Apache-2.0
// What a result document says of an experiment, as figures and tables take it. For the source files
// of this folder only.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/report/experiment/mesh_painter.h"
#include "common/report/json_access.h"
#include "common/report/svg_plot.h"

namespace tenter::report {

struct FoundPicture {
  std::string title;
  View view;
  std::vector<Point3> points;  ///< empty: the run ended before it
};

struct FoundLine {
  std::string words, x_label, y_label;
  std::vector<double> x, y;  ///< in the labels' units
};

struct RunFound {
  std::string name;
  std::string reason;                ///< why it ended early; "": it did not
  std::vector<std::string> numbers;  ///< as heads; an en dash where there is none
  std::vector<FoundLine> lines;
  std::vector<FoundPicture> pictures;
  std::vector<Corners> triangles;
};

struct Found {
  std::string scene, model;
  std::vector<std::string> heads;  ///< words and unit of every measure
  std::vector<RunFound> runs;
};

/// Metres become mm, joules mJ or µJ, shares %; what is odd in a document is left out.
Expected<Found> found_of(const std::string& result_json);
/// Of a document of schema "tenter.simulation". bad_input: without an experiment.
Expected<Found> found_of(const Json& result);

/// The figure (figure.h).
std::string drawn(const Found& found);

}  // namespace tenter::report
