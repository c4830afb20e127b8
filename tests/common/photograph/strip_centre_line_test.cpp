// SPDX-License-Identifier: Apache-2.0
#include "common/photograph/strip_centre_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace tenter::photograph {
namespace {

using Point = std::array<double, 2>;

constexpr double kScale = 1e-4;  // m a pixel
constexpr int kSide = 640;
constexpr Point kClamp = {400.0, 60.0};

/// Places along a strip from its clamp, in pixels of the picture; direction from its curvature.
std::vector<Point> curve(double length_px, const std::function<double(double)>& curvature) {
  std::vector<Point> points = {kClamp};
  double angle = M_PI / 2.0;  // down
  constexpr double kStep = 0.05;
  for (double s = 0.0; s < length_px; s += kStep) {
    angle += kStep * curvature(s + 0.5 * kStep);
    points.push_back(
        {points.back()[0] + kStep * std::cos(angle), points.back()[1] + kStep * std::sin(angle)});
  }
  return points;
}

double distance_to(const std::vector<Point>& points, const Point& at) {
  double least = 1e300;
  for (const Point& p : points) least = std::min(least, std::hypot(p[0] - at[0], p[1] - at[1]));
  return least;
}

/// Drawn with square ends, soft edges of a pixel, uneven light and a little grain.
GrayImage drawn(const std::vector<Point>& points, double width_px) {
  GrayImage image{kSide, kSide, std::vector<std::uint8_t>(kSide * kSide)};
  std::vector<double> away(image.level.size(), 1e9);
  std::vector<std::size_t> nearest(image.level.size(), 0);
  const int reach = static_cast<int>(width_px) + 2;
  for (std::size_t k = 0; k < points.size(); ++k)
    for (int y = static_cast<int>(points[k][1]) - reach;
         y <= static_cast<int>(points[k][1]) + reach; ++y)
      for (int x = static_cast<int>(points[k][0]) - reach;
           x <= static_cast<int>(points[k][0]) + reach; ++x) {
        if (!image.holds(x, y)) continue;
        const auto i = static_cast<std::size_t>(y * kSide + x);
        const double distance = std::hypot(x - points[k][0], y - points[k][1]);
        if (distance >= away[i]) continue;
        away[i] = distance;
        nearest[i] = k;
      }
  for (std::size_t i = 0; i < away.size(); ++i) {
    if (away[i] > 1e8 || (nearest[i] > 0 && nearest[i] + 1 < points.size())) continue;
    // beyond an end: how far along, and how far across
    const Point& end = points[nearest[i]];
    const Point& inner = nearest[i] == 0 ? points[1] : points[points.size() - 2];
    const double size = std::hypot(end[0] - inner[0], end[1] - inner[1]);
    const Point off = {static_cast<double>(i % kSide) - end[0],
                       static_cast<double>(i / kSide) - end[1]};
    const double along = (off[0] * (end[0] - inner[0]) + off[1] * (end[1] - inner[1])) / size;
    const double across = std::sqrt(std::max(0.0, away[i] * away[i] - along * along));
    away[i] = std::max(across, 0.5 * width_px + along);
  }
  unsigned grain = 7;
  for (std::size_t i = 0; i < away.size(); ++i) {
    grain = grain * 1664525u + 1013904223u;
    const double share = std::clamp(0.5 * width_px + 0.5 - away[i], 0.0, 1.0);
    const double light = 215.0 + 20.0 * static_cast<double>(i % kSide) / kSide;
    image.level[i] = static_cast<std::uint8_t>(share * 40.0 + (1.0 - share) * light +
                                               6.0 * ((grain >> 16) % 1000) / 1000.0);
  }
  return image;
}

TEST(StripCentreLine, FollowsAKnownSpiral) {
  // from a radius of 60 pixels to one of 150: 6 to 15 mm
  const double length = 620.0;
  const auto truth = curve(length, [&](double s) { return 1.0 / (150.0 - 90.0 * s / length); });
  const auto line = strip_centre_line(drawn(truth, 7.0), {kScale, kClamp[0], kClamp[1]});
  ASSERT_TRUE(line) << line.error().message;
  ASSERT_GT(line->points_m.size(), 100U);
  const auto off_mm = [&](const Point& p, const std::vector<Point>& places) {
    const Point pixel = {kClamp[0] + p[0] / kScale, kClamp[1] - p[1] / kScale};
    return 1e3 * kScale * distance_to(places, pixel);
  };
  // a tenth of a pixel along the strip, and three at its ends, which are carried on to
  double largest_mm = 0.0;
  for (std::size_t i = 1; i + 1 < line->points_m.size(); ++i)
    largest_mm = std::max(largest_mm, off_mm(line->points_m[i], truth));
  EXPECT_LT(largest_mm, 0.01);
  EXPECT_LT(off_mm(line->points_m.front(), {truth.front()}), 0.03);
  EXPECT_LT(off_mm(line->points_m.back(), {truth.back()}), 0.03);
  EXPECT_NEAR(1e3 * line->length_m, 1e3 * kScale * length, 0.1);
  EXPECT_NEAR(1e3 * line->width_m, 1e3 * 7.0 * kScale, 0.05);
}

TEST(StripCentreLine, SaysWhatItCannotUse) {
  const auto straight = curve(400.0, [](double) { return 0.0; });
  const GrayImage image = drawn(straight, 7.0);
  const auto words = [](const Expected<StripCentreLine>& refused) {
    return refused ? std::string("taken") : refused.error().message;
  };
  EXPECT_EQ(words(strip_centre_line(image, {kScale, kClamp[0], kClamp[1]})), "taken");
  EXPECT_NE(words(strip_centre_line(image, {kScale, 100.0, 60.0})).find("within 20 pixels"),
            std::string::npos);
  EXPECT_NE(words(strip_centre_line(image, {0.0, 100.0, 60.0})).find("scale"), std::string::npos);
  EXPECT_NE(words(strip_centre_line(image, {kScale, -3.0, 60.0})).find("clamp is outside"),
            std::string::npos);
  EXPECT_NE(words(strip_centre_line(drawn(straight, 1.5), {kScale, kClamp[0], kClamp[1]}))
                .find("thinner"),
            std::string::npos);
  StripView half{kScale, kClamp[0], kClamp[1]};
  half.region = {300, 0, 500, 90};
  EXPECT_NE(words(strip_centre_line(image, half)).find("no strip"), std::string::npos);
  // a coil whose second turn lies on the first
  const auto coil = curve(900.0, [](double) { return 1.0 / 60.0; });
  EXPECT_NE(words(strip_centre_line(drawn(coil, 9.0), {kScale, kClamp[0], kClamp[1]})), "taken");
}

TEST(GrayImage, RefusesWhatIsNoPicture) {
  const auto missing = read_png("/nowhere/strip.png");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::not_found);
}

}  // namespace
}  // namespace tenter::photograph
