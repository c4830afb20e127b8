// SPDX-License-Identifier: Apache-2.0
// What a fit to a sheet leaves at every measured vertex, frame after frame: blocks of residuals.h5
// beside its tables.
//
//   write_residuals(tables, path, blocks);                          // ../residual_file.h
//   Expected<std::vector<VertexResiduals>> some = read_vertex_residuals("residuals.h5", {.capture =
//   "3fa9c1", .first_vertex = 12, .last_vertex = 12});
//
// Layout: /entry/vertices_N is an NXdata group (signal "residual", axes "frame" and "vertex") with
// attributes capture_id and capture_title. Datasets: frame, vertex (numbers of the capture),
// material [vertex][2], sigma [vertex], measured, predicted_start, predicted_fitted
// [frame][vertex][3], residual [frame][vertex] (length of measured minus fitted), all in m. What
// was not measured is NaN. Checked as the tables are when read.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/h5/writer.h"

namespace tenter::report {

/// F frames, V vertices; positions are F x V x 3, the frame slowest.
struct VertexResiduals {
  std::string capture_id;  ///< SHA-256 of the capture
  std::string capture_title;
  std::vector<int> frame;          ///< as in the capture, growing
  std::vector<int> vertex;         ///< as in the capture
  std::vector<double> material_m;  ///< V x 2: (u, v)
  std::vector<double> sigma_m;     ///< V, of one coordinate
  std::vector<double> measured_m;  ///< NaN: not seen (a height that was not measured too)
  std::vector<double> start_m;     ///< of the model that the fit began with
  std::vector<double> fitted_m;

  std::size_t at(std::size_t frame_index, std::size_t vertex_index) const {
    return 3 * (frame_index * vertex.size() + vertex_index);
  }
  /// Length of measured minus fitted over the coordinates that were measured; NaN: none was.
  double residual_m(std::size_t frame_index, std::size_t vertex_index) const;
};

/// What to keep, both ends included; nothing set keeps everything.
struct VertexFilter {
  std::string capture = {};  ///< id, or the beginning of an id of at least 6 digits, or the title
  std::optional<int> first_frame = {}, last_frame = {};
  std::optional<int> first_vertex = {}, last_vertex = {};
};

/// Blocks that nothing of passes the filter are left out. not_found: no such file; bad_input: not a
/// residual file, or a damaged one.
Expected<std::vector<VertexResiduals>> read_vertex_residuals(const std::string& path,
                                                             const VertexFilter& filter = {});
/// In a child process first.
Expected<std::vector<VertexResiduals>> read_vertex_residuals_guarded(
    const std::string& path, const VertexFilter& filter = {});

/// Of write_residuals: adds the blocks to a file that is being made. An inner size that does not
/// fit is ErrorKind::internal.
Expected<void> write_vertex_blocks(h5::H5Writer& file, const std::vector<VertexResiduals>& blocks);

}  // namespace tenter::report
