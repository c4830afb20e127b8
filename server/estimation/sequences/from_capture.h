// SPDX-License-Identifier: GPL-3.0-or-later
// A captured sheet (common/capture/sheet/sheet.h) as a sequence that fits can take: a mesh to
// simulate, its clips, table and loads, and what was measured as channels.
//
//   auto captured = sequence_from_capture(capture, {.most_points = 500});
//   if (!captured) return tl::unexpected(captured.error());
//   log(in_words(captured->use));                    // what was compared and what was left out
//   sequences.push_back(std::move(captured->sequence));
//
// Mesh. A grid over the specimen's rectangle of material (inside of an outline that is none, an
// irregular mesh of as many nodes), or the capture's own mesh. A graded grid has as many lines, but
// where the sequence's clips and table want them (material/grid_layout.h). Clips clamp
// the nodes inside their region; where the capture names vertices, the nodes between those. A
// support holds the nodes beyond its edge and the line of nodes before it, frame by frame. Clamped
// and held nodes lie where the poses put them, flat and as at rest.
//
// Forces. The cords of a prescribed clip measure its force in the directions that they span: one
// channel along the first cord, one along what the next one adds at right angles, and so on; or
// along the directions that the options give. They turn with the clip where that fits the cords
// better than staying in space. A channel's standard deviation is that of the cords' sum along it,
// its name that of the cord (of the clip, where the options give its direction; _2, _3 where
// taken). The cords of a free clip are loads, and its pose is only where frames start.
//
// Points. Every vertex that is seen, lies in the simulated mesh and in no clip is compared by its
// place in the material; `most_points` thins them evenly. In a frame where all nodes about a vertex
// are held, its reading tells nothing of the material and is left out. Vertices in the mesh that
// are no channels are in hidden_m of the frames that did not see them.
//
// Frames start from the measured positions (measured_state.h). A branch of a run is a block. Their
// durations are the capture's clock's, over frames that are left out too; zero without a clock.
//
// Pure; cost is linear in vertices x frames, beside one small sparse solve a frame.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::estimation {

struct FromCaptureOptions {
  bool use_own_mesh = false;  ///< else a grid
  int nodes_u = 25;
  /// 0: cells are squares, nearly, as large as nodes_u make those of a square of the same area: a
  /// strip has more along it and fewer across. Slender cells would have no hinge along diagonals.
  int nodes_v = 0;
  /// Lines of the grid through the ends of clips, dense towards their corners inside the cloth and
  /// half way about the table's edges. Not for models of springs, which diagonals of slender cells
  /// make another material (mesh/springs.h).
  bool is_graded = false;
  mechanics::Diagonals diagonals = mechanics::Diagonals::both;  ///< bends alike in all directions
  /// The grid's corners in the material. None: the capture's outline, or else its mesh.
  std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> rectangle_m = {};
  int most_points = 0;                   ///< 0: all
  std::vector<std::size_t> frames = {};  ///< of the capture, rising; empty: all
  int most_frames = 0;                   ///< of these, spread evenly; 0: all
  double unknown_sigma_m = 0.0;          ///< for positions that do not say theirs; 0: an error
  double unknown_sigma_N = 0.0;          ///< the same for tensions
  /// Clips that are named here get these force channels in place of their own.
  struct Force {
    std::string clip;
    Eigen::Vector3d direction;     ///< in space, or of the clip where it turns with that
    bool turns_with_clip = false;  ///< see ForceChannel
  };
  std::vector<Force> forces = {};
  bool start_from_measured = true;
  /// Also the other nodes of the triangles that a support's edge cuts are held, so that the sheet
  /// is clamped at the edge to half an element: the hinges at the last held line bend and stand for
  /// half an element on either side of it. Without, a strip hangs as if it were half an element to
  /// one and a half longer: ten times as far off as the grid alone is (tests/bench/fabrics). False
  /// for what a mesh that held the nodes on the support has made.
  bool clamps_at_edge = true;
};

/// What became of the capture: nothing is left out silently.
struct CaptureUse {
  int vertices = 0;
  int points = 0;      ///< vertices that are compared
  int outside = 0;     ///< of the simulated mesh
  int in_clips = 0;    ///< hidden, or moved by the pose alone
  int never_seen = 0;  ///< in the frames used
  int thinned = 0;     ///< by most_points
  int readings = 0;    ///< coordinates that are compared, over all frames
  int missing = 0;     ///< coordinates of these points that were not seen
  int held = 0;        ///< coordinates of these points where all nodes about them are held
  int missing_forces = 0;
  int frames = 0;
  bool has_graded_grid = false;             ///< its cells are not all alike
  int thinned_frames = 0;                   ///< by most_frames
  std::vector<std::size_t> dropped_frames;  ///< a free clip's cord was not measured
  std::vector<std::size_t> slack_frames;    ///< the capture says that the sheet sags there
  std::vector<int> clip_nodes;              ///< of each clip
};

std::string in_words(const CaptureUse& use);

struct CapturedSequence {
  Sequence sequence;
  CaptureUse use;
  std::vector<int> vertex;         ///< of each PointChannel
  std::vector<std::size_t> frame;  ///< of the capture, for each frame of the sequence
};

/// bad_input names what is wrong: no sheet, no standard deviation, a clip that no node lies in, a
/// weight without a mass, a mesh that is no rectangle and shall be a grid, no frame left.
Expected<CapturedSequence> sequence_from_capture(const capture::Capture& capture,
                                                 const FromCaptureOptions& options = {});

}  // namespace tenter::estimation
