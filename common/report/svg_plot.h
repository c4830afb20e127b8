// SPDX-License-Identifier: Apache-2.0
// One chart as an inline SVG picture: points and lines over two axes, drawn here so that a page
// needs no script.
//
// Colours and fonts come from the page's style sheet by class; the picture itself says only shapes.
// Points closer together than can be seen are drawn once; nothing is averaged, smoothed or
// reordered.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tenter::report {

struct PlotSeries {
  enum class Mark {
    dots,       ///< filled
    open_dots,  ///< rings
    line,
    crosses
  };
  std::string name;
  std::string css_class;  ///< "measured", "baseline", "extended", "outlier": colour and dash
  Mark mark = Mark::dots;
  std::vector<double> x;  ///< a value that is not finite interrupts a line and drops a dot
  std::vector<double> y;
};

/// Between two curves over x: an interval that changes along the axis. Finite, same lengths.
struct PlotRibbon {
  std::string name;
  std::vector<double> x, lo, hi;
};

struct Plot {
  std::string label;  ///< what a screen reader says
  std::string x_label;
  std::string y_label;
  std::vector<PlotSeries> series;                 ///< drawn in this order
  bool zero_line = false;                         ///< y = 0 always in sight and drawn
  std::optional<std::pair<double, double>> band;  ///< shaded range of y, e.g. one sigma of noise
  std::vector<PlotRibbon> ribbons;                ///< drawn below the series
  std::optional<std::pair<double, double>> seen;  ///< range of x with data; the rest is hatched out
  int width = 560;
  int height = 340;
};

/// "" if no series has a finite point.
std::string render_svg(const Plot& plot);

/// Round numbers (1, 2, 5 x 10^n) covering lo..hi, about `count` of them.
std::vector<double> axis_ticks(double lo, double hi, int count);

}  // namespace tenter::report
