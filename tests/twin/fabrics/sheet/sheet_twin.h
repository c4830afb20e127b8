// SPDX-License-Identifier: GPL-3.0-or-later
// Twins that share nothing with the fit: a protocol done to a smooth sheet (sheet.h) with friction,
// seen at irregular places of the material. Clips lie in the sheet's plane and turn about z.
//
//   const auto places = irregular_places(0.1, 2500, seed);
//   SheetTwin twin = run_protocol(fabric("18"), make_protocol(fabric("18"), "shear"), places);
//   if (!twin.failure.empty()) ...
//   twin.positions_m[frame].col(place)      twin.clip_force_N[frame][clip]
//
// Without friction (without_friction(fabric)) frames do not depend on those before but for the
// choice of a buckled shape. No noise. One thread; a few minutes for the seven protocols at the
// default fineness.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/twin/fabrics/protocols.h"

namespace tenter::twin {

struct SheetTwinOptions {
  double span_m = 4.2e-3;     ///< longest distance of knots; they lie irregularly
  std::uint64_t seed = 1;     ///< of the knots, and of the unevenness that lets a sheet buckle
  double uneven_m = 2e-5;     ///< size of that, at the start only
  double net_force_N = 1e-7;  ///< left at rest
};

struct SheetTwin {
  std::string failure;  ///< empty: all frames found their rest
  int unknowns = 0;
  int iterations = 0;
  std::vector<Eigen::Vector2d> places_m;
  std::vector<Eigen::Matrix3Xd> positions_m;               ///< [frame], a column a place
  std::vector<std::vector<Eigen::Vector3d>> clip_force_N;  ///< [frame][clip], what cords bear
};

/// One place in every cell of a square lattice, anywhere within it: about `count` of them.
std::vector<Eigen::Vector2d> irregular_places(double side_m, int count, std::uint64_t seed);

SheetTwin run_protocol(const Fabric& fabric, const Protocol& protocol,
                       const std::vector<Eigen::Vector2d>& places_m,
                       const SheetTwinOptions& options = {});

}  // namespace tenter::twin
