// SPDX-License-Identifier: GPL-3.0-or-later
// A measured sequence as the estimator sees it (thesis 3.4.1): one specimen between clips, frame
// after frame at rest, with what was seen of it.
//
// Points are places in the material, wherever the mesh has its nodes; what a frame did not see is a
// number that is none (NaN) and makes no row. Forces are what the cords pull a clip with, along a
// given direction: the clip's weight and the cloth bear the rest.
//
// Values.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/mechanics/assembly/cloth.h"
#include "server/mechanics/conditions/boundary.h"
#include "server/mechanics/conditions/loads.h"

namespace tenter::estimation {

struct PointChannel {
  Eigen::Vector2d material_m = Eigen::Vector2d::Zero();  ///< (u, v)
  double sigma_m = 0.0;
};

struct ForceChannel {
  int clip = 0;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit
  double sigma_N = 0.0;
};

struct SequenceFrame {
  std::vector<mechanics::Pose> clips;  ///< of prescribed clips; free ones start from here
  std::vector<std::vector<Eigen::Vector3d>> cord_force_N;  ///< as in Loads; empty: none
  Eigen::Matrix3Xd points_m;                               ///< one column a PointChannel
  Eigen::VectorXd forces_N;                                ///< one a ForceChannel
  int block = 0;                                           ///< of this sequence, from 0
};

struct Sequence {
  std::string name;
  mechanics::Cloth cloth;
  mechanics::Boundary boundary;
  mechanics::Loads loads;  ///< gravity and masses; cord forces come with the frames
  mechanics::State start;  ///< near the first frame; held nodes stay where it has them
  std::vector<PointChannel> points;
  std::vector<ForceChannel> forces;
  std::vector<SequenceFrame> frames;
};

/// bad_input names the sequence and frame: sizes that do not fit, a sigma that is not positive, a
/// direction not of unit length, a clip that is none, a point outside of the mesh.
Expected<void> check(const Sequence& sequence);

}  // namespace tenter::estimation
