// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/friction_tests/bending_figures.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

#include "common/report/svg_file.h"
#include "server/estimation/friction_tests/strain_point.h"

namespace tenter::bench {
namespace {

using report::Plot;
using report::PlotSeries;

bool write(const std::string& path, const Plot& plot) {
  const std::string svg = report::svg_file({plot}, 1);
  std::ofstream file(path);
  file << svg;
  return !svg.empty() && file.good();
}

PlotSeries series(const char* css, PlotSeries::Mark mark) {
  PlotSeries s;
  s.css_class = css;
  s.mark = mark;
  return s;
}

/// Contours one after the other, a gap between them; and the curvature of their smooth curves.
void add_contours(const estimation::BendingTests& tests, Plot& profiles, Plot& curvatures) {
  PlotSeries contour = series("measured", PlotSeries::Mark::line);
  PlotSeries bend = series("measured", PlotSeries::Mark::line);
  for (const estimation::StripTest& strip : tests.strips) {
    const auto curve = estimation::ProfileCurve::fitted(strip.points, {.length_m = strip.length_m});
    if (!curve) continue;
    constexpr int kPlaces = 100;
    for (int i = 0; i <= kPlaces; ++i) {
      const double arc = strip.length_m * i / kPlaces;
      const estimation::ContourPoint at = curve->position(arc);
      contour.x.push_back(1e3 * at.x_m);
      contour.y.push_back(1e3 * at.y_m);
      bend.x.push_back(1e3 * arc);
      bend.y.push_back(curve->curvature(arc));
    }
    for (PlotSeries* s : {&contour, &bend}) {
      s->x.push_back(NAN);
      s->y.push_back(NAN);
    }
  }
  profiles.series.push_back(std::move(contour));
  curvatures.series.push_back(std::move(bend));
}

/// The model's way back from three cylinders.
void add_unload_paths(const estimation::BendingEstimate& found, Plot& plot) {
  const auto point = estimation::StrainPoint::make(found.friction.model);
  if (!point) return;
  PlotSeries way = series("extended", PlotSeries::Mark::line);
  way.name = "model, unrolled from 4, 7.5 and 23 mm";
  for (const double radius_m : {0.004, 0.0075, 0.023}) {
    estimation::StrainPoint::Walk walk;
    point->begin(walk);
    point->to_strain(3.0 / radius_m, found.friction.fit.parameters, walk);
    constexpr int kSteps = 200;
    for (int i = 0; i <= kSteps; ++i) {
      const double strain = 3.0 / radius_m * (1.0 - static_cast<double>(i) / kSteps);
      double load = 0.0;
      double tangent = 0.0;
      point->look(strain, found.friction.fit.parameters, false, walk, load, tangent);
      way.x.push_back(strain);
      way.y.push_back(1e3 * load);
    }
    way.x.push_back(NAN);
    way.y.push_back(NAN);
  }
  plot.series.push_back(std::move(way));
}

}  // namespace

bool write_bending_figures(const std::string& folder, const std::string& name,
                           const estimation::BendingTests& tests,
                           const estimation::BendingEstimate& found) {
  Plot profiles{"profiles", "x (mm)", "y (mm)", {}, false, {}, {}, {}};
  Plot curvatures{"curvature", "along the strip (mm)", "curvature (1/m)", {}, true, {}, {}, {}};
  add_contours(tests, profiles, curvatures);

  Plot torques{"torque", "strain, 3 curvature (1/m)", "torque (mN)", {}, true, {}, {}, {}};
  Plot residuals{
      "residuals", "strain, 3 curvature (1/m)", "strain, model - read (1/m)", {}, true, {}, {}, {}};
  PlotSeries read = series("measured", PlotSeries::Mark::dots);
  read.name = "torque of the weight";
  PlotSeries missed = series("measured", PlotSeries::Mark::dots);
  std::size_t row = 0;
  for (const estimation::ProfileSamples& profile : found.profiles)
    for (const estimation::TorqueSample& sample : profile.samples) {
      missed.x.push_back(sample.strain);
      missed.y.push_back(found.predicted[row++] - sample.strain);
      if (profile.anchor == 0.0) continue;
      read.x.push_back(sample.strain);
      read.y.push_back(1e3 * sample.mean_torque());
    }
  torques.series.push_back(std::move(read));
  add_unload_paths(found, torques);
  residuals.series.push_back(std::move(missed));
  const std::string base = folder + "/" + name;
  return write(base + "_profiles.svg", profiles) && write(base + "_curvatures.svg", curvatures) &&
         write(base + "_torques.svg", torques) && write(base + "_residuals.svg", residuals);
}

}  // namespace tenter::bench
