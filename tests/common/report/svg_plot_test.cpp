// SPDX-License-Identifier: Apache-2.0
#include "common/report/svg_plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tenter::report {
namespace {

Plot with(std::vector<double> x, std::vector<double> y, PlotSeries::Mark mark) {
  Plot plot;
  plot.series.push_back({"s", "measured", mark, std::move(x), std::move(y)});
  return plot;
}

std::size_t count(const std::string& text, char c) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), c));
}

TEST(AxisTicks, AreRoundAndInside) {
  const std::vector<double> ticks = axis_ticks(0.013, 0.31, 6);
  ASSERT_GE(ticks.size(), 4u);
  EXPECT_NEAR(ticks[0], 0.05, 1e-12);
  EXPECT_NEAR(ticks[1], 0.10, 1e-12);
  EXPECT_LE(ticks.back(), 0.31);
  EXPECT_TRUE(axis_ticks(1.0, 1.0, 5).empty());
  EXPECT_TRUE(axis_ticks(0.0, std::numeric_limits<double>::infinity(), 5).empty());
  EXPECT_LE(axis_ticks(1e17, 1e17 + 64.0, 6).size(), 51u);
}

TEST(SvgPlot, NothingToDrawIsNoPicture) {
  const double nan = std::nan("");
  EXPECT_EQ(render_svg(with({}, {}, PlotSeries::Mark::line)), "");
  EXPECT_EQ(render_svg(with({nan, 1.0}, {1.0, nan}, PlotSeries::Mark::dots)), "");
  EXPECT_EQ(render_svg(with({-1.7e308, 1.7e308}, {0.0, 1.0}, PlotSeries::Mark::dots)), "");
}

TEST(SvgPlot, OneDotPerVisiblePlaceHoweverManyReadings) {
  std::vector<double> x, y;
  for (int i = 0; i < 10000; ++i) {
    x.push_back(i % 3);
    y.push_back(i % 3);
  }
  const std::string svg = render_svg(with(x, y, PlotSeries::Mark::dots));
  EXPECT_EQ(count(svg.substr(svg.find("class=\"dot\"")), 'M'), 3u);
}

TEST(SvgPlot, ALineKeepsItsEndsAndBreaksAtMissingValues) {
  const std::string svg = render_svg(
      with({0.0, 1.0, std::nan(""), 2.0, 3.0}, {0.0, 1.0, 1.0, 2.0, 0.0}, PlotSeries::Mark::line));
  const std::string d = svg.substr(svg.find("class=\"line\""));
  EXPECT_EQ(count(d.substr(0, d.find("/>")), 'M'), 2u);
  EXPECT_EQ(count(d.substr(0, d.find("/>")), 'L'), 2u);
}

TEST(SvgPlot, ListsOfUnequalLengthUseTheShorter) {
  EXPECT_NE(render_svg(with({0.0, 1.0, 2.0}, {0.0, 1.0}, PlotSeries::Mark::dots)), "");
  EXPECT_NE(render_svg(with({5.0}, {5.0}, PlotSeries::Mark::open_dots)), "");
}

}  // namespace
}  // namespace tenter::report
