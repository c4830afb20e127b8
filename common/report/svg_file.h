// SPDX-License-Identifier: Apache-2.0
// Plots in a file of their own, without a page around them: the same charts (svg_plot.h) with the
// colours that pages bring along.
//
//   std::string svg = svg_file({left, middle, right}, 3);   // beside each other, labels above
//
// Lines of the classes r0, r1, ... r7 have eight colours; measured, baseline and extended those of
// pages. The names of a plot's series are its key. "" where no plot has a point.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/report/svg_plot.h"

namespace tenter::report {

inline constexpr std::size_t kLineColours = 8;

/// Rules for charts, without the element around them.
std::string plot_style();

/// The class of line number `index`.
std::string line_class(std::size_t index);

/// A chart with its upper left corner at a place of another picture; "" where it has no point.
std::string placed_plot(const Plot& plot, double x, double y);

std::string svg_file(const std::vector<Plot>& plots, std::size_t across);

}  // namespace tenter::report
