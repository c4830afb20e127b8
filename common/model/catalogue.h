// SPDX-License-Identifier: Apache-2.0
// What a model may be made of: strain measures, laws, supports and sensor corrections, as tables of
// rows.
//
// This is the list of names, sizes, units and bounds; what a name computes is its own file in
// server/mechanics (sensors: server/estimation). A new law is one row here, its file there and its
// test.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/model/model.h"

namespace tenter::model {

/// On which elements of a mesh a measure lives, and with it the units of a term's parameters.
enum class Domain {
  membrane,  ///< triangles: energy per area (N/m), strain without unit
  edge,      ///< springs: the same
  hinge,     ///< pairs of triangles: energy per area (N/m), strain a curvature (1/m)
  solid      ///< tetrahedra, hexahedra: energy per volume (N/m^2), strain without unit
};

/// Units, bounds and defaults are those of a membrane; see in_domain() for the others.
struct ParameterRow {
  std::string_view name;
  std::string_view unit;
  std::optional<double> lower;  ///< hard bounds: a document may tighten them, never widen them
  std::optional<double> upper;
  double value = 0.0;  ///< where a document gives none
  bool fixed = false;  ///< not fitted unless a document says otherwise
  int per_strain = 0;  ///< n: the parameter is energy / strain^n (unit N/m, N s/m) or strain^-n
};

/// Warp is v, weft is u; w_u and w_v are the columns of F in material axes.
struct StrainRow {
  std::string_view name;
  int strains = 1;         ///< k: how many scalars it gives
  bool has_angle = false;  ///< takes angle_rad, from weft towards warp; solids also elevation_rad
  std::string_view words;
  Domain domain = Domain::membrane;
  bool at_point = true;  ///< edges, hinges: answers a homogeneous strain of a material point
};

struct LawRow {
  std::string_view name;
  int strains = 1;      ///< how many scalar strains it takes; 0: any number
  bool spline = false;  ///< parameters[0] stands for one control point; they are named k1, k2, ...
  int min_points = 0;   ///< spline laws: fewest control points
  bool path_dependent = false;           ///< has a memory: must be stepped along the path
  bool rate_dependent = false;           ///< needs time
  std::vector<ParameterRow> parameters;  ///< never empty
  std::string_view words;
  bool grid = false;  ///< spline laws of two strains: as many control points as a square number
};

/// What a correction's channels are of: curves of a homogeneous strain show N/m, clips of a sheet
/// N.
enum class Seen { curves, sheets };

/// A correction turns the true value of a channel into what it shows; of sheets, it may also say
/// what the rig did to the specimen. A name that both know has a row for each.
struct CorrectionRow {
  std::string_view name;
  std::vector<ParameterRow> parameters;
  std::string_view words;
  Seen seen = Seen::curves;
};

const std::vector<StrainRow>& strain_catalogue();
const std::vector<LawRow>& law_catalogue();
const std::vector<CorrectionRow>& correction_catalogue();

/// nullptr where there is no such row.
const StrainRow* find_strain(std::string_view name);
const LawRow* find_law(std::string_view name);
const CorrectionRow* find_correction(std::string_view name, Seen seen = Seen::curves);

/// Whether a correction has the parameters of a row, in their units. One of offset, gain, ... may
/// fit the rows of both curves and sheets, where no unit tells them apart.
bool fits(const SensorCorrection& correction, const CorrectionRow& row);

constexpr int kMaxControlPoints = 64;

/// "membrane", "edge", "hinge" or "solid".
std::string_view words_of(Domain domain);
/// "curves" or "sheets".
std::string_view words_of(Seen seen);

/// Of energy per area or volume, as energy limits give it: "J/m^2", in solids "J/m^3".
std::string_view energy_density_unit(Domain domain);

/// A row with the unit of its domain, and bounds and default scaled to what is usual there: a
/// solid's moduli are 10^3 times a membrane's, a curvature is 10^3 (1/m) times a strain, and the
/// energy of bending a tenth of that of stretching: 100 N/m becomes 1e5 N/m^2 and 1e-5 N m.
ParameterRow in_domain(const ParameterRow& row, Domain domain);

/// The parameters of a law at their defaults, in the catalogue's order; `control_points` counts for
/// splines only.
std::vector<Parameter> default_parameters(const LawRow& law, int control_points = 0,
                                          Domain domain = Domain::membrane);
std::vector<Parameter> default_parameters(const CorrectionRow& correction);

/// Strains of the first and the last control point of a spline law. Equal bounds in the document
/// mean "not chosen yet": a fit puts the range that its data reach, and until then 0 to 0.5 holds
/// (-300 to 300 1/m for hinges, which bend both ways: a radius of 1 cm at three times its
/// curvature).
std::pair<double, double> spline_range(const Law& law, Domain domain = Domain::membrane);

/// hermite_stiffness, bspline_stiffness or convex_spline: their knots may be uneven.
bool may_have_knots(const Law& law);

/// Pieces that a stiffness spline with so many control points has: one fewer than points; of
/// B-splines, cubic from four points on, as many less as their degree.
int spline_pieces(const Law& law, int points);

/// The ends of the pieces of a stiffness spline, from the range's lower end to its upper one: the
/// document's knots, or even ones.
std::vector<double> spline_knots(const Law& law, Domain domain = Domain::membrane);

/// Whether a term's law has a memory: frames are then steps of one path, and none may be left out.
bool remembers_path(const Model& model);

}  // namespace tenter::model
