// SPDX-License-Identifier: GPL-3.0-or-later
// A case of the bench: a square of cloth that hangs by two corners, read from a file of
// tests/bench/cases, so that others can run the same.
#pragma once

#include <filesystem>

#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::mechanics::bench {

struct Case {
  int nodes_a_side = 0;
  Cloth cloth;
  model::Model model;
  Eigen::VectorXd parameters;
  Loads loads;
  Boundary boundary;  ///< both pins are held
  int right_pin = 0;
  State start;
  double tolerance_N = 0.0;
  Eigen::VectorXd scale;  ///< of the parameters after the first equilibrium; empty: none
  int frames = 0;         ///< after the first equilibrium, the right pin moves so often
  Eigen::Vector3d move_m = Eigen::Vector3d::Zero();
};

/// bad_input names the file and the key.
Expected<Case> read_case(const std::filesystem::path& path);

}  // namespace tenter::mechanics::bench
