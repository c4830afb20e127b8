// SPDX-License-Identifier: GPL-3.0-or-later
// A measured sequence as the estimator sees it (thesis 3.4.1): one specimen between clips, frame
// after frame at rest, with what was seen of it.
//
// Points are places in the material, wherever the mesh has its nodes; what a frame did not see is a
// number that is none (NaN) and makes no row. Forces and torques are what the cords (or whatever
// holds a clip) bear: the clip's weight and the cloth make up the rest.
//
// Values.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
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
  /// The direction is of the clip and turns with it: of shear, only what is parallel to the clip
  /// counts (thesis 3.4.1). Of prescribed clips.
  bool turns_with_clip = false;
  std::string name = {};  ///< what sensor corrections call it: unique in its sequence, or empty
};

/// Torque that the holders of clips bear about an axis, each clip with its factor: with +1 and -1
/// in turn the "aggregated torque" of thesis figure 3.6. Of prescribed clips.
struct TorqueChannel {
  struct Share {
    int clip = 0;
    double factor = 1.0;
  };
  std::vector<Share> clips;
  Eigen::Vector3d about_m = Eigen::Vector3d::Zero();  ///< fixed in space
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();    ///< unit
  double sigma_N_m = 0.0;
};

/// Distance in space of two points of the material.
struct LengthChannel {
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();  ///< (u, v)
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double sigma_m = 0.0;
};

/// Area of the whole sheet in space.
struct AreaChannel {
  double sigma_m2 = 0.0;
};

using ScalarChannel = std::variant<TorqueChannel, LengthChannel, AreaChannel>;

struct SequenceFrame {
  int boundary = 0;                    ///< of the sequence's, from 0
  std::vector<mechanics::Pose> clips;  ///< of prescribed clips; free ones start from here
  Eigen::Matrix3Xd
      held_m;  ///< places of the boundary's held nodes; empty: where the start has them
  /// Where to start from: a measured configuration (thesis 3.4.1). None: the frame before, of the
  /// first one the sequence's start.
  std::optional<mechanics::State> start;
  std::vector<std::vector<Eigen::Vector3d>> cord_force_N;  ///< as in Loads; empty: none
  Eigen::Matrix3Xd points_m;                               ///< one column a PointChannel
  Eigen::VectorXd forces_N;                                ///< one a ForceChannel
  Eigen::VectorXd scalars;                                 ///< one a ScalarChannel: N m, m or m^2
  /// Places in the material (u, v) that were tracked, are no PointChannel, and were not seen here.
  std::vector<Eigen::Vector2d> hidden_m;
  /// PointChannels that were seen here and misread: no coordinate is left of them.
  std::vector<int> misread = {};
  int block = 0;            ///< of this sequence, from 0
  double duration_s = 0.0;  ///< since the frame before, for laws and sensors that know time
};

struct Sequence {
  std::string name;
  mechanics::Cloth cloth;
  /// What is held and clamped. A strip pushed over a table's edge holds other nodes in every frame;
  /// clips are the same in all, but may be free in one and prescribed in another.
  std::vector<mechanics::Boundary> boundaries;
  mechanics::Loads loads;  ///< gravity and masses; cord forces come with the frames
  mechanics::State start;  ///< near the first frame; held nodes stay where it has them
  double weight = 1.0;     ///< of its part of the cost, beside what the fit's weighting gives it
  /// Unit, from the sheet to what sees its points: what they are blurred with lies along it.
  Eigen::Vector3d camera_axis = Eigen::Vector3d::UnitZ();
  double spacing_m = 0.0;  ///< in the material, of all that was tracked; 0: that of the points
  std::vector<PointChannel> points;
  std::vector<ForceChannel> forces;
  std::vector<ScalarChannel> scalars;
  std::vector<SequenceFrame> frames;
};

/// bad_input names the sequence and frame: sizes that do not fit, a sigma that is not positive, a
/// direction not of unit length, a clip or boundary that is none, clips that differ from boundary
/// to boundary, a point outside of the mesh, two forces of one name, a weight that is negative or
/// no number.
Expected<void> check(const Sequence& sequence);

/// Puts what the frame prescribes into `state`: held nodes, poses of prescribed clips, and those of
/// free ones where they are asked to start anew. Nodes of clips follow their poses when solved.
void prescribe(const Sequence& sequence, std::size_t frame, bool with_free_clips,
               mechanics::State& state);

}  // namespace tenter::estimation
