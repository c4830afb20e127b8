// SPDX-License-Identifier: Apache-2.0
// The middle of a dark strip on a light ground, seen from its edge: from the clamp to the free end.
//
//   1. dark is what lies below a threshold (Otsu's, where none is given); the strip is the dark
//   piece
//      next to the clamp
//   2. how far every pixel of it is from the clamp along the strip (8 neighbours); the farthest is
//      the free end; centroids of pieces of equal distance are a first line
//   3. across that line both edges, where the grey level crosses the threshold between pixels;
//   their
//      middle is the line. Twice.
//
// Lengths in metres by the picture's scale, x to the right and y up, from the clamp on. Points are
// about half a strip's width apart, the last one at the edge of the free end. On a sharp picture
// they are right to a tenth of a pixel.
//
//   const auto line = strip_centre_line(*image, {.metres_per_pixel = 5e-5, .clamp_x = 400,
//                                                .clamp_y = 20});
//
// bad_input that names the pixel: nothing dark at the clamp, a strip thinner than 3 pixels or not
// long, layers that touch each other. Cost: 10 megapixels about a second. Any thread.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/photograph/gray_image.h"

namespace tenter::photograph {

struct StripView {
  double metres_per_pixel = 0.0;
  double clamp_x = 0.0;  ///< pixels: where the strip leaves the clamp
  double clamp_y = 0.0;
  std::optional<int> threshold = {};  ///< grey level; none: from the picture
  /// Only this part of the picture is looked at: left, top, right, bottom (pixels, all included).
  std::optional<std::array<int, 4>> region = {};
};

struct StripCentreLine {
  std::vector<std::array<double, 2>> points_m;
  double length_m = 0.0;  ///< along the points
  double width_m = 0.0;   ///< of the strip as it is seen: how thick the cloth looks
  int threshold = 0;
};

Expected<StripCentreLine> strip_centre_line(const GrayImage& image, const StripView& view);

}  // namespace tenter::photograph
