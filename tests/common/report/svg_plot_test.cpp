// SPDX-License-Identifier: Apache-2.0
#include "common/report/svg_plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/report/svg_file.h"

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

TEST(SvgFile, PlotsStandBesideEachOtherWithTheirKeys) {
  Plot left = with({0.0, 1.0}, {0.0, 1.0}, PlotSeries::Mark::line);
  left.label = "left & best";
  left.series[0].name = "fitted";
  Plot right = left;
  right.label = "right";
  const Plot nothing;
  const std::string svg = svg_file({left, nothing, right}, 2);
  const auto places = [&svg](const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = svg.find(part); at != std::string::npos; at = svg.find(part, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(svg.rfind("<svg xmlns=", 0), 0U);
  EXPECT_EQ(places("<svg"), 3U);
  EXPECT_EQ(places("</svg>"), 3U);
  EXPECT_EQ(places("<svg x=\"0.0\" y=\"24.0\" class=\"plot\""), 1U);
  EXPECT_EQ(places("<svg x=\"560.0\" y=\"24.0\" class=\"plot\""), 1U);
  EXPECT_EQ(places("class=\"title\">left &amp; best<"), 1U);
  EXPECT_EQ(places("class=\"key\">fitted<"), 2U);
  EXPECT_NE(svg.find("width=\"1120\""), std::string::npos);
  EXPECT_EQ(svg_file({nothing}, 1), "");
}

}  // namespace
}  // namespace tenter::report
