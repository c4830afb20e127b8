// SPDX-License-Identifier: Apache-2.0
// residuals.h5 beside a result: one row per frame and channel, one table per capture and channel.
//
//   Expected<void> done = write_residuals(tables, "residuals.h5");
//   Expected<std::vector<ResidualTable>> some = read_residuals("residuals.h5", {.channel =
//   "force"});
//
// Layout: /entry/table_N is an NXdata group (signal "measured", axes "strain_x", or
// "displacement_m" where there is one) with attributes capture_id, capture_title and channel; its
// datasets have the names of the members below. A fit to a sheet adds blocks of vertices
// (sheet/vertex_residuals.h); its channels are clip forces, whose strains are not known. The bytes
// depend on the tables only. Reading checks as capture files do (common/h5/reader.h); _guarded runs
// it in a child process first.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/h5/reader.h"
#include "common/report/sheet/vertex_residuals.h"

namespace tenter::report {

/// All vectors have the same length; `time_s` and `displacement_m` may be empty. Stresses and
/// forces are in `unit`.
struct ResidualTable {
  std::string capture_id;  ///< SHA-256 of the capture
  std::string capture_title;
  std::string channel;      ///< stress channel
  std::string unit;         ///< of measured, predicted and sigma ("N/m")
  std::vector<int> frame;   ///< as in the capture
  std::vector<int> run;     ///< run number as in the capture
  std::vector<int> block;   ///< number of the block, from 0, in the order of the capture
  std::vector<int> branch;  ///< 0 load, 1 unload, 2 hold, 3 other
  std::vector<double> time_s;
  std::vector<double> displacement_m;  ///< of the clip since the first frame, signed; may be empty
  std::vector<double> strain_x;        ///< stretch_x - 1, as the evaluation took it
  std::vector<double> strain_y;        ///< NaN where neither measured nor solved for
  std::vector<double> strain_xy;       ///< amount of shear
  std::vector<double> measured;        ///< NaN where missing
  std::vector<double> predicted_baseline;
  std::vector<double> predicted_extended;  ///< the baseline's again where nothing was added
  std::vector<double> sigma;               ///< standard deviation of one reading
  std::vector<double>
      weight;  ///< 0..1 of the robust loss at the end; 0 for a row that was left out

  std::size_t size() const { return frame.size(); }
};

/// What to keep; nothing set keeps everything.
struct ResidualFilter {
  std::string capture = {};  ///< id, or the beginning of an id of at least 6 digits, or the title
  std::string channel = {};
  std::optional<int> block = {};
  std::optional<int> first_frame = {};  ///< inclusive
  std::optional<int> last_frame = {};   ///< inclusive
};

/// "load", "unload", "hold" or "other" of a branch number.
std::string branch_word(int branch);

Expected<void> write_residuals(const std::vector<ResidualTable>& tables, const std::string& path,
                               const std::vector<VertexResiduals>& vertices = {});

/// Is it a residual file, of a version that this program reads?
Expected<void> check_residual_file(const h5::H5Reader& file);

/// Whether `name` (of a filter; "": any) means the capture.
bool names_capture(const std::string& name, const std::string& id, const std::string& title);

/// Tables that no row of passes the filter are left out.
Expected<std::vector<ResidualTable>> read_residuals(const std::string& path,
                                                    const ResidualFilter& filter = {});
Expected<std::vector<ResidualTable>> read_residuals_guarded(const std::string& path,
                                                            const ResidualFilter& filter = {});

}  // namespace tenter::report
