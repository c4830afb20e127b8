// SPDX-License-Identifier: Apache-2.0
// A picture as grey levels, and how it comes from a file.
//
//   Expected<GrayImage> image = read_png("spiral.png");
//
// Colours become grey by their luminance; what is transparent lies on white. Coordinates are
// pixels, x to the right and y down, with whole numbers in the middle of a pixel. Any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace tenter::photograph {

struct GrayImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> level;  ///< row after row; 0 is black

  std::uint8_t at(int x, int y) const {
    return level[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(x)];
  }
  bool holds(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  /// Between pixels, linearly; outside the picture as at its border.
  double level_at(double x, double y) const;
};

/// not_found: no such file; bad_input: not a PNG, a damaged one, or one of more than 100
/// megapixels.
Expected<GrayImage> read_png(const std::string& path);

}  // namespace tenter::photograph
