// SPDX-License-Identifier: GPL-3.0-or-later
// The full field of a garter knit pulled along its wales (`knit-uniaxial-tracked`, Singal et al.
// 2024, MIT), in four pictures, as one sequence without forces.
//
// The field is given over the deformed picture, so that each picture has points of its own: a point
// at x with displacement d lies at x - d in the material. Neither millimetres nor the pixels of a
// step of the grid are given. With kPixels a step, and no other whole number, the height at rest is
// the same by all four pictures; the clamps' distance at rest is that of the tracked pulls of the
// same fabric. Lines of nodes at the top and the bottom of the field are held where the pictures
// have them; the sides are free, for the field is as wide as the specimen.
//
//   auto data = read_field("dic_field_acrylic_garter_y.csv", 6);
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::bench {

inline constexpr double kPixels = 8.0;

struct FieldData {
  estimation::Sequence sequence;       ///< one frame a picture, points of others are not seen
  std::vector<int> pictures;           ///< their numbers
  std::vector<double> heights_px;      ///< of the field at rest, by each picture
  std::vector<double> stretches;       ///< of the height
  std::vector<Eigen::Matrix3Xd> even;  ///< where an even stretch has the points of each frame
};

/// Every `thinning`-th row and column is compared. Errors as read_numbers().
Expected<FieldData> read_field(const std::string& path, int thinning);

}  // namespace tenter::bench
