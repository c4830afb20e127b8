// SPDX-License-Identifier: Apache-2.0
// A scene: a piece of material, what holds it and pulls at it, and what is done to it frame by
// frame. With a model it is everything that `tenter simulate` needs.
//
// The document (JSON, schema "tenter.scene", version 1) and the meaning of every key are described
// in README.md; document.h reads it. Data only: what it means in numbers is
// server/mechanics/scene. SI units; lengths of vectors in m, forces in N, turns in rad.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/scene/experiment.h"

namespace tenter::scene {

using Vec2 = std::array<double, 2>;
using Vec3 = std::array<double, 3>;

/// A regular sheet, (0, 0) to (length_u, length_v); u is weft, v is warp.
struct GridMesh {
  int nodes_u = 0, nodes_v = 0;
  double length_u_m = 0.0, length_v_m = 0.0;
  std::string diagonals = "alternating";  ///< one, other, alternating or both
};

/// A regular sheet that is sewn to itself, u around and v along: a sleeve about the z axis.
struct TubeMesh {
  int nodes_around = 0, nodes_along = 0;
  double radius_m = 0.0, length_m = 0.0;
  std::string diagonals = "alternating";  ///< as a grid's
};

/// An irregular sheet inside an outline.
struct OutlineMesh {
  std::vector<Vec2> points_m;
  double edge_length_m = 0.0;
};

/// A regular body, (0, 0, 0) to size.
struct BoxMesh {
  std::array<int, 3> cells = {};
  Vec3 size_m = {};
  bool is_tetrahedra = false;  ///< else hexahedra
};

/// A mesh of another program: OBJ and PLY are sheets, MSH is a body.
struct FileMesh {
  std::string path;    ///< beside the scene: what a user names
  std::string sha256;  ///< of the file: what a job names
  std::string bytes;   ///< the file itself, for who makes the mesh; not in the document
  double metres_per_unit = 1.0;
  double metres_per_texture_unit = 1.0;
  bool is_msh = false;
};

using Mesh = std::variant<GridMesh, OutlineMesh, BoxMesh, FileMesh, TubeMesh>;

/// Bodies have three material coordinates, sheets two.
bool is_solid(const Mesh& mesh);

/// Nodes, chosen in the material's coordinates.
struct Selection {
  enum class Kind {
    everything,
    side,     ///< left, right, bottom, top (bodies: also front, back), or a corner as bottom_left
    box,      ///< lo to hi, both included
    beyond,   ///< where (place - point) . direction >= 0: the cloth on a table, up to its edge
    indices,  ///< by number
    any_of,   ///< parts[0] or parts[1] or ...
    without   ///< parts[0], but none of parts[1]
  };
  Kind kind = Kind::everything;
  std::string side;
  Vec3 lo = {}, hi = {};
  Vec3 point = {}, direction = {};
  std::vector<int> indices;
  std::vector<Selection> parts;
};

/// A cord pulls with a force that does not turn with the clip.
struct Cord {
  std::string id;
  Vec3 at_m = {};  ///< from the middle of the clip's nodes, as the clip lies at the start
  Vec3 force_N = {};
};

/// A rigid body that nodes are clamped in: it goes where the protocol puts it, or, free, where
/// cords, weight and material pull it.
struct Clip {
  std::string id;
  Selection nodes;
  bool is_free = false;
  double mass_kg = 0.0;
  Vec3 centre_of_mass_m = {};  ///< from the middle of its nodes, as the clip lies at the start
  std::vector<Cord> cords;
};

struct PlaneObstacle {
  Vec3 point_m = {};
  Vec3 normal = {0.0, 0.0, 1.0};  ///< material stays on the side that it points to
};
struct CylinderObstacle {
  Vec3 point_m = {};
  Vec3 axis = {1.0, 0.0, 0.0};
  double radius_m = 0.0;
};
struct SphereObstacle {
  Vec3 point_m = {};  ///< its middle
  double radius_m = 0.0;
};
using Obstacle = std::variant<PlaneObstacle, CylinderObstacle, SphereObstacle>;

/// A mass that hangs at nodes, in equal parts.
struct Weight {
  std::string id;
  Selection nodes;
  double mass_kg = 0.0;
};

/// A force on nodes, in equal parts.
struct Force {
  std::string id;
  Selection nodes;
  Vec3 force_N = {};
};

/// On a sheet held along its rim, or on the surface of a body from outside its material.
struct Pressure {
  Selection nodes;
  double pressure_Pa = 0.0;
};

struct Start {
  enum class Place {
    vertical,    ///< (u, 0, v)
    horizontal,  ///< (u, v, 0)
    as_meshed,   ///< as the file has it; a tube: round; bodies: the rest shape
    wound        ///< u goes around an axis along y, from where it hangs down inwards; v is y
  };
  Place place = Place::horizontal;
  double radius_m = 0.0;  ///< of what is wound, at its inner end
  double pitch_m = 0.0;   ///< between its layers
  /// The material was brought here from its rest shape in one way, and remembers it.
  bool is_remembered = false;
  double noise_m = 0.0;  ///< every node that is free is off its place by up to this
  std::uint32_t seed = 1;
  double gravity_factor = 1.0;
};

/// What a clip does in a phase, as a share of it: move, and turn about a point.
struct Motion {
  std::string clip;
  Vec3 move_m = {};
  Vec3 turn_rad = {};           ///< about its own direction, by its length
  std::optional<Vec3> about_m;  ///< none: the middle of the clip's nodes, wherever it is by then
};

struct CordForce {
  std::string clip, cord;
  Vec3 force_N = {};
};
struct WeightMass {
  std::string weight;
  double mass_kg = 0.0;
};
struct ForceValue {
  std::string force;
  Vec3 force_N = {};
};

/// What an obstacle does in a phase, as a share of it.
struct ObstacleMotion {
  int obstacle = 0;  ///< its place among the scene's
  Vec3 move_m = {};
};

/// Some frames over which everything changes linearly: clips by their motions (applied in order),
/// the rest towards the values given.
struct Phase {
  std::string name;
  int frames = 0;
  std::optional<double> duration_s;  ///< with dynamics: always; without: never
  std::vector<Motion> motions;
  std::vector<ObstacleMotion> obstacles;  ///< with dynamics only
  std::vector<CordForce> cords;
  std::vector<WeightMass> weights;
  std::vector<ForceValue> forces;
  std::optional<double> gravity_factor;
  std::optional<double> pressure_Pa;
};

struct Solver {
  double tolerance_N = 1e-5;
  int max_iterations = 2000;
  std::string minimiser = "newton";  ///< newton, additive_lm or relaxation
  bool check_minimum = true;
  double contact_depth_m = 1e-6;
  int most_halvings = 5;  ///< of a frame's step, where it fails
};

/// Frames are instants of a motion, not states of rest.
struct Dynamics {
  double step_s = 0.01;         ///< the longest step
  std::string scheme = "bdf2";  ///< bdf2 or implicit_euler
  double error_m = 0.0;         ///< of one step, which it follows; 0: steps are as long as they may
  double damping_s = 0.0;       ///< Baraff and Witkin's: this time its stiffness, for every strain
  double self_contact_m = 0.0;  ///< thickness at which a sheet keeps off itself; 0: it may pass
  bool is_linearised = false;   ///< one linear system a step, for comparison
  bool from_rest = false;       ///< frame 0 is the equilibrium; else the start as it is placed
};

struct Scene {
  std::string name;
  std::string description;
  Mesh mesh;
  std::optional<double> area_density_kg_m2;  ///< one of the three
  std::optional<double> density_kg_m3;
  std::optional<double> mass_kg;
  Vec3 gravity_m_s2 = {0.0, 0.0, -9.81};
  Start start;
  std::vector<Clip> clips;
  std::vector<Obstacle> obstacles;
  std::vector<Weight> weights;
  std::vector<Force> forces;
  std::optional<Pressure> pressure;
  std::vector<Phase> protocol;
  Solver solver;
  std::optional<Dynamics> dynamics;
  std::string model;  ///< preset that it is meant for; "": the usual one
  std::optional<Experiment> experiment;

  /// The start and every frame of the protocol.
  int frame_count() const;
};

}  // namespace tenter::scene
