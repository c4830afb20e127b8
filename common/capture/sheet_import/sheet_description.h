// SPDX-License-Identifier: Apache-2.0
// What the JSON says that describes the tables of a deforming sheet: which file and column holds
// what, in which unit. README.md of this folder documents the keys. Nothing of the tables is read
// here.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "common/capture/csv/csv_table.h"
#include "common/capture/csv/description.h"
#include "common/capture/units.h"

namespace tenter::capture {

/// Some columns of a CSV, by what they are for.
struct TableSpec {
  std::string key;   ///< of the JSON, for messages
  std::string file;  ///< see TableFolder; "": the CSV that the import was called with
  CsvOptions csv;
  bool decimal_comma = false;
  std::vector<std::pair<std::string, std::vector<std::string>>> where;
  std::map<std::string, std::string> columns;  ///< use ("frame", "x", ...) to header cell
  UnitConversion to_si;
  bool may_be_missing = false;
  bool ignore_other_frames = false;

  bool has(const std::string& use) const { return columns.count(use) != 0; }
};

struct MeshSpec {
  std::string file;  ///< OBJ or PLY; "": tables
  double metres_per_unit = 1.0;
  double metres_per_texture_unit = 1.0;
  int first_vertex = 0;  ///< number of the first vertex in the table of positions
  std::optional<TableSpec> vertices;
  std::optional<TableSpec> triangles;
};

/// A tracked point with columns of its own in the table of positions.
struct PointSpec {
  std::string name;
  std::optional<Vec2> material_m;
  std::map<std::string, std::string> columns;
};

struct PoseSpec {
  RigidPose constant;  ///< stands where the table has no column
  std::optional<TableSpec> table;
};

struct ClipSpec {
  ClipTrack track;                    ///< all but poses and vertices
  std::vector<std::string> vertices;  ///< by name
  bool grip_from_first_frame = false;
  PoseSpec pose;
};

struct CordSpec {
  CordTrack track;  ///< all but what is over frames
  TableSpec tension;
  Vec3 direction = {0.0, 0.0, 0.0};  ///< where the table has no columns for it
  /// The table is not over frames but over the place of a clip along a coordinate.
  struct Over {
    std::string clip;
    std::size_t coordinate = 0;
    UnitConversion to_m;
  };
  std::optional<Over> over;
};

struct SupportSpec {
  SupportTrack track;
  std::optional<TableSpec> edge;  ///< else a constant one
  double edge_m = 0.0;
  PoseSpec pose;
};

/// What two clips that pull the sheet taut say of its rest.
struct RestSpec {
  std::array<std::string, 2> clips;
  double slack_below_m = 0.0;  ///< 0: no frame is slack
  double read_at_m = 0.0;      ///< distance at which places in the material are read; 0: not there
  std::vector<int> runs;       ///< whose mean they are; empty: all
};

struct SheetDescription {
  Description frames;             ///< with everything that is not the sheet in its head
  std::string frames_file;        ///< as TableSpec::file
  bool are_frames_given = false;  ///< else the table of positions names them
  std::optional<MeshSpec> mesh;
  TableSpec positions;
  std::vector<PointSpec> points;
  bool material_from_first_frame = false;
  bool material_from_rest = false;  ///< read where `rest` says
  bool is_material_seen() const { return material_from_first_frame || material_from_rest; }
  std::optional<RestSpec> rest;
  Sheet head;  ///< name, sigma, gravity
  std::vector<ClipSpec> clips;
  std::vector<CordSpec> cords;
  std::vector<SupportSpec> supports;
};

/// Errors name the document and the path of the bad key.
Expected<SheetDescription> parse_sheet_description(const std::string& text,
                                                   const std::string& name);

/// Does this text describe a sheet? True for an object whose kind is "deforming_sheet".
bool describes_sheet(const std::string& text);

}  // namespace tenter::capture
