// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/skin/skin_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "tests/bench/number_table.h"

namespace tenter::bench {
namespace {

using estimation::Sequence;
using estimation::SequenceFrame;
using mechanics::Grid;
using mechanics::Pose;

constexpr double kCell_m = 4e-3;
constexpr int kCellsU = 26, kCellsV = 14;  // 104 mm x 56 mm
constexpr int kPadCells = 2, kGapCells = 8;

using Table = std::vector<std::vector<double>>;

/// |force| where the pad has moved by `displacement_m`, linear between readings.
double force_at(const Table& forces, double displacement_m) {
  for (std::size_t i = 1; i < forces.size(); ++i) {
    const double a = -1e-3 * forces[i - 1][0];
    const double b = -1e-3 * forces[i][0];
    if (b < displacement_m || b == a) continue;
    const double share = (displacement_m - a) / (b - a);
    return -(forces[i - 1][1] + share * (forces[i][1] - forces[i - 1][1]));
  }
  return -forces.back()[1];
}

std::vector<int> pad_nodes(const Grid& grid, int first_cell) {
  std::vector<int> nodes;
  for (int j = (kCellsV - kPadCells) / 2; j <= (kCellsV + kPadCells) / 2; ++j)
    for (int i = first_cell; i <= first_cell + kPadCells; ++i) nodes.push_back(grid.node(i, j));
  return nodes;
}

}  // namespace

Expected<SkinData> read_skin(const std::string& folder, bool edge_is_held, int thinning) {
  const auto dic = read_numbers(folder + "/healthy_dic.csv",
                                {"frame", "point", "x0_mm", "y0_mm", "ux_mm", "uy_mm"});
  if (!dic) return tl::unexpected(dic.error());
  const auto pads = read_numbers(
      folder + "/healthy_pads.csv",
      {"frame", "moving_pad_x_mm", "moving_pad_y_mm", "fixed_pad_x_mm", "fixed_pad_y_mm"});
  if (!pads) return tl::unexpected(pads.error());
  const auto forces = read_numbers(folder + "/healthy_force_filtered.csv",
                                   {"pad_displacement_x_mm", "pad_force_x_N"});
  if (!forces) return tl::unexpected(forces.error());

  SkinData data;
  Sequence& s = data.sequence;
  s.name = "skin";
  const Grid grid{kCellsU + 1, kCellsV + 1, kCellsU * kCell_m, kCellsV * kCell_m};
  auto cloth = cloth_of_grid(grid, mechanics::Diagonals::alternating);
  if (!cloth) return tl::unexpected(cloth.error());
  s.cloth = *cloth;
  const auto& mesh = s.cloth.mesh;
  s.start.x.setZero(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n)
    s.start.x.segment<2>(3 * static_cast<Eigen::Index>(n)) = mesh.material_m.col(n);

  const int left_pad = (kCellsU - kGapCells) / 2 - kPadCells;
  const Pose at_rest;
  s.boundaries.resize(1);
  s.boundaries[0].clips = {
      clip_on("moving", pad_nodes(grid, left_pad), s.start.x, at_rest),
      clip_on("fixed", pad_nodes(grid, left_pad + kPadCells + kGapCells), s.start.x, at_rest)};
  if (edge_is_held)
    for (int j = 0; j <= kCellsV; ++j)
      for (int i = 0; i <= kCellsU; ++i)
        if (i == 0 || j == 0 || i == kCellsU || j == kCellsV)
          s.boundaries[0].held.push_back(grid.node(i, j));
  s.start.clips = {at_rest, at_rest};
  s.loads.node_mass_kg = Eigen::VectorXd::Zero(mesh.node_count());
  data.gap_m = kGapCells * kCell_m;
  data.between_m = {(left_pad + kPadCells) * kCell_m, 0.5 * kCellsV * kCell_m};

  // the middle between both pads' marks is the middle of the patch
  const std::vector<double>& first = pads->front();
  const Eigen::Vector2d middle(0.5e-3 * (first[1] + first[3]), 0.5e-3 * (first[2] + first[4]));
  const Eigen::Vector2d shift = 0.5 * Eigen::Vector2d(grid.length_u_m, grid.length_v_m) - middle;
  std::map<int, std::vector<const std::vector<double>*>> by_frame;
  for (const std::vector<double>& row : *dic)
    if (static_cast<int>(row[1]) % thinning == 0)
      by_frame[static_cast<int>(row[0])].push_back(&row);
  for (const auto* row : by_frame.begin()->second)
    s.points.push_back(
        {Eigen::Vector2d(1e-3 * (*row)[2], 1e-3 * (*row)[3]) + shift, kPointSigma_m});
  s.forces = {{0, -Eigen::Vector3d::UnitX(), kForceSigma_N, false}};
  for (const auto& [number, rows] : by_frame) {
    if (rows.size() != s.points.size()) return bad_input("a frame of the film misses points");
    SequenceFrame frame;
    const std::vector<double>& pad = (*pads)[static_cast<std::size_t>(number)];
    Pose pose;
    pose.position_m << 1e-3 * (pad[1] - first[1]), 1e-3 * (pad[2] - first[2]), 0.0;
    frame.clips = {pose, at_rest};
    frame.points_m.resize(3, static_cast<Eigen::Index>(rows.size()));
    for (std::size_t k = 0; k < rows.size(); ++k)
      frame.points_m.col(static_cast<Eigen::Index>(k))
          << s.points[k].material_m.x() + 1e-3 * (*rows[k])[4],
          s.points[k].material_m.y() + 1e-3 * (*rows[k])[5],
          std::numeric_limits<double>::quiet_NaN();
    frame.forces_N.setConstant(1, force_at(*forces, pose.position_m.norm()));
    frame.block = static_cast<int>(s.frames.size());
    s.frames.push_back(std::move(frame));
  }
  return data;
}

}  // namespace tenter::bench
