// SPDX-License-Identifier: Apache-2.0
// A capture in memory: one specimen under one protocol, frame by frame. Immutable once made.
//
// Everything is SI. A missing value is NaN and is allowed only in channels that declare it.
// All per-frame vectors have the same length (frame_count). The file layout is in README.md of this
// folder; how frames become observations (stretches, membrane stresses) is estimation's business.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/capture/sheet/sheet.h"

namespace tenter::capture {

/// What a channel measures; its SI unit follows from it (unit_of).
enum class Quantity {
  force,            ///< N
  membrane_stress,  ///< N/m, nominal: force per reference width
  stress,           ///< Pa, nominal: force per reference cross-section
  displacement,     ///< m, change of a length
  length,           ///< m, a length or distance itself
  stretch,          ///< 1, length / rest length
  strain,           ///< 1, engineering strain: stretch - 1
  shear,            ///< 1, amount of simple shear gamma
  position,         ///< m, one coordinate of a tracked point
  other             ///< kept and shown, not used by fits
};

/// One measured quantity over all frames.
struct Channel {
  std::string name;  ///< unique within the capture: letters, digits, '_'
  Quantity quantity = Quantity::other;
  std::string unit;         ///< SI symbol ("N", "m", "1", "Pa", "N/m", ...)
  std::string source_unit;  ///< unit in the file it came from, for show and export
  std::string description;
  std::string point;                    ///< position channels: name of the tracked point
  char coordinate = ' ';                ///< position channels: 'x', 'y' or 'z'
  double sigma = 0.0;                   ///< standard deviation of one reading, SI; 0: not known
  std::vector<double> sigma_per_frame;  ///< empty, or one standard deviation per frame (SI)
  double resolution = 0.0;              ///< smallest step of the instrument, SI; 0: not known
  bool may_be_missing = false;
  std::vector<double> values;  ///< SI, one per frame
};

/// Where one stretch component of the specimen, in test axes, comes from.
///   prescribed  a channel gives it and the model takes it as given (imposed)
///   observed    a channel gives it; the direction is free of stress and the model predicts it
///   free        not measured; the direction is free of stress
///   fixed       held at `fixed_value` (stretch 1, shear 0 unless declared)
struct AxisState {
  enum class Role { prescribed, observed, free, fixed };
  enum class Source { none, channel, points };
  enum class Reference { given, first_frame_of_capture, first_frame_of_run };

  Role role = Role::fixed;
  Source source = Source::none;
  std::string channel =
      {};  ///< Source::channel: stretch, strain, shear, displacement or length channel
  std::string point_a = {};  ///< Source::points: the distance a-b is the length
  std::string point_b = {};
  Reference reference = Reference::given;  ///< rest length for displacement, length and points
  double reference_length_m = 0.0;         ///< Reference::given
  double fixed_value = 1.0;                ///< Role::fixed: stretch (shear for the xy component)
};

/// Homogeneous strain in test axes: F = [[stretch_x, shear_xy], [0, stretch_y]].
struct Kinematics {
  AxisState x;
  AxisState y;
  AxisState xy{.fixed_value = 0.0};  ///< no shear unless said otherwise
};

/// Which channel carries the stress conjugate to which component ("x", "y", "xy").
/// Force and Pa channels become N/m by the specimen's width, thickness or cross-section.
struct StressAssignment {
  std::string component;
  std::string channel;
};

struct Specimen {
  std::string name;      ///< one physical sample
  std::string material;  ///< specimens of one material share it
  std::optional<double> length_m;
  std::optional<double> width_m;    ///< across the x pull unless width_y_m is given
  std::optional<double> width_y_m;  ///< width that the y force acts on
  std::optional<double> thickness_m;
  std::optional<double> cross_section_m2;
  std::optional<double> mass_kg;
  std::optional<double> area_density_kg_m2;
  double axis_angle_rad =
      0.0;  ///< from the material's weft (u) to the test's x axis, anticlockwise
};

enum class Branch { load, unload, hold, other };

struct Phase {
  std::string name;                          ///< e.g. "pull", "strip_x", "hold at 1.5"
  std::string kind;                          ///< "ramp", "cycle", "hold", "step", "other"
  std::optional<double> nominal_rate_per_s;  ///< strain per second, where declared
};

/// One continuous sequence of frames: time increases within it, and what path-dependent laws
/// remember runs through it.
struct Run {
  int number = 1;     ///< as in the source
  std::string group;  ///< runs of one group are repeats of the same path ("" = not a repeat)
};

struct Protocol {
  std::string name;  ///< captures with the same protocol name repeat each other
  std::string description;
  /// What a run starts from: the same specimen as the run before left it, or a specimen never
  /// pulled.
  enum class History { continues, virgin_each_run };
  History history = History::continues;
  std::optional<double> nominal_rate_per_s;  ///< strain rate where no time was recorded
  std::vector<Phase> phases;
};

struct Provenance {
  bool synthetic = false;  ///< made by a generator, not measured; shown everywhere
  std::string source;      ///< where the numbers were published or who measured them
  std::string licence;     ///< "" = not stated
  std::string authors;
  std::string instrument;
  std::string notes;
  std::string imported_from;    ///< file name (no folder)
  std::string imported_sha256;  ///< of that file's bytes
};

struct Capture {
  std::string kind;  ///< "homogeneous_strain" | "tracked_points" | "deforming_sheet"
  std::string title;
  Specimen specimen;
  Protocol protocol;
  Provenance provenance;
  Kinematics kinematics;
  std::vector<StressAssignment> stresses;

  std::vector<Run> runs;
  // per frame, all of the same length
  std::vector<int> frame;  ///< frame number as in the source, increasing within a run
  std::vector<int> run;    ///< index into runs, non-decreasing
  std::vector<int> phase;  ///< index into protocol.phases
  std::vector<Branch> branch;
  std::vector<double> time_s;  ///< empty where no time was recorded
  std::vector<Channel> channels;
  std::optional<Sheet> sheet;  ///< of kind "deforming_sheet", which has no channels, and only there

  std::size_t frame_count() const { return run.size(); }
  const Channel* find(const std::string& name) const {
    for (const Channel& c : channels)
      if (c.name == name) return &c;
    return nullptr;
  }
};

}  // namespace tenter::capture
