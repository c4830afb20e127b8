// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/knit/field_data.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tests/bench/number_table.h"

namespace tenter::bench {
namespace {

using estimation::SequenceFrame;

constexpr int kNodesU = 33, kNodesV = 11;
constexpr double kRest_m = 0.0393;    // between the clamps, mean of the tracked pulls
constexpr double kSigma_m = 2e-4;     // of a coordinate: what is left of neighbours, and stitches
constexpr std::size_t kNearest = 16;  // points that tell the displacement of a place
constexpr double kInside = 0.02;      // of the height, by which held lines are inside of the field

struct Sample {
  int row = 0, column = 0;
  Eigen::Vector2d rest, shift;  ///< px
};
using Picture = std::vector<Sample>;

Expected<std::map<int, Picture>> read_pictures(const std::string& path) {
  const auto rows = read_numbers(path, {"image", "grid_row", "grid_col", "ux_px", "uy_px"});
  if (!rows) return tl::unexpected(rows.error());
  std::map<int, Picture> pictures;
  for (const std::vector<double>& row : *rows) {
    Sample sample;
    sample.row = static_cast<int>(row[1]);
    sample.column = static_cast<int>(row[2]);
    sample.shift << row[3], row[4];
    sample.rest = kPixels * Eigen::Vector2d(row[2], row[1]) - sample.shift;
    pictures[static_cast<int>(row[0])].push_back(sample);
  }
  return pictures;
}

/// Of the plane through the displacements nearest to a place in the material.
Eigen::Vector2d shift_at(const Picture& picture, const Eigen::Vector2d& place) {
  std::vector<std::pair<double, const Sample*>> nearest;
  for (const Sample& sample : picture)
    nearest.emplace_back((sample.rest - place).squaredNorm(), &sample);
  std::ranges::nth_element(nearest, nearest.begin() + kNearest, {},
                           &decltype(nearest)::value_type::first);
  Eigen::Matrix<double, Eigen::Dynamic, 3> a(kNearest, 3);
  Eigen::Matrix<double, Eigen::Dynamic, 2> b(kNearest, 2);
  for (std::size_t k = 0; k < kNearest; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    a.row(i) << 1.0, (nearest[k].second->rest - place).transpose();
    b.row(i) = nearest[k].second->shift.transpose();
  }
  return a.colPivHouseholderQr().solve(b).row(0).transpose();
}

/// Lowest and highest place in the material that a picture shows of most columns.
std::pair<Eigen::Vector2d, Eigen::Vector2d> extent(const Picture& picture) {
  constexpr double kMost = 0.02;
  Eigen::Vector2d lo, hi;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const Sample& sample : picture) values.push_back(sample.rest[axis]);
    std::ranges::sort(values);
    const auto off = static_cast<std::size_t>(kMost * static_cast<double>(values.size()));
    lo[axis] = values[off];
    hi[axis] = values[values.size() - 1 - off];
  }
  return {lo, hi};
}

}  // namespace

Expected<FieldData> read_field(const std::string& path, int thinning) {
  const auto pictures = read_pictures(path);
  if (!pictures) return tl::unexpected(pictures.error());
  FieldData data;
  Eigen::Vector2d lo = Eigen::Vector2d::Constant(-1e9), hi = -lo;  // what all of them show
  for (const auto& [number, picture] : *pictures) {
    if (picture.size() <= kNearest) return bad_input(path + ": a picture has too few points");
    const auto [from, to] = extent(picture);
    lo = lo.cwiseMax(from);
    hi = hi.cwiseMin(to);
    data.pictures.push_back(number);
    data.heights_px.push_back(to.y() - from.y());
  }
  const double inside = kInside * (hi.y() - lo.y());
  lo.y() += inside;
  hi.y() -= inside;
  const double metres = kRest_m / (hi.y() - lo.y());
  estimation::Sequence& s = data.sequence;
  s.name = "field";
  const Eigen::Vector2d size = metres * (hi - lo);
  const mechanics::Grid grid{kNodesU, kNodesV, size.x(), size.y()};
  auto cloth = cloth_of_grid(grid, mechanics::Diagonals::both);
  if (!cloth) return tl::unexpected(cloth.error());
  s.cloth = *cloth;
  const auto& mesh = s.cloth.mesh;
  s.loads.node_mass_kg = Eigen::VectorXd::Zero(mesh.node_count());
  s.boundaries.resize(1);
  for (int i = 0; i < kNodesU; ++i)
    for (const int j : {0, kNodesV - 1}) s.boundaries[0].held.push_back(grid.node(i, j));
  std::ranges::sort(s.boundaries[0].held);

  const auto in_sheet = [&](const Sample& sample) -> Eigen::Vector2d {
    return metres * (sample.rest - lo);
  };
  std::vector<std::vector<const Sample*>> compared;
  for (const auto& [number, picture] : *pictures) {
    auto& own = compared.emplace_back();
    for (const Sample& sample : picture) {
      const Eigen::Vector2d at = in_sheet(sample);
      const bool is_inside = (at.array() > 0.0).all() && (at.array() < size.array()).all();
      if (is_inside && sample.row / 4 % thinning == 0 && sample.column / 4 % thinning == 0) {
        own.push_back(&sample);
        s.points.push_back({at, kSigma_m});
      }
    }
  }
  Eigen::Index first = 0;
  std::size_t index = 0;
  for (const auto& [number, picture] : *pictures) {
    SequenceFrame frame;
    mechanics::State state{Eigen::VectorXd::Zero(3 * mesh.node_count()), {}};
    for (int n = 0; n < mesh.node_count(); ++n) {
      const Eigen::Vector2d place = mesh.material_m.col(n);
      state.x.segment<2>(3 * static_cast<Eigen::Index>(n)) =
          place + metres * shift_at(picture, place / metres + lo);
    }
    frame.held_m.resize(3, static_cast<Eigen::Index>(s.boundaries[0].held.size()));
    Eigen::Vector2d top = Eigen::Vector2d::Zero(), bottom = top;  // mean shifts of the held lines
    for (std::size_t k = 0; k < s.boundaries[0].held.size(); ++k) {
      const int node = s.boundaries[0].held[k];
      const Eigen::Vector3d at = state.x.segment<3>(3 * static_cast<Eigen::Index>(node));
      frame.held_m.col(static_cast<Eigen::Index>(k)) = at;
      const bool is_top = mesh.material_m(1, node) < 0.5 * size.y();
      (is_top ? top : bottom) += (at.head<2>() - mesh.material_m.col(node)) / kNodesU;
    }
    frame.start = state;
    if (index == 0) s.start = state;
    data.stretches.push_back(1.0 + (bottom.y() - top.y()) / size.y());
    const double unseen = std::numeric_limits<double>::quiet_NaN();
    frame.points_m.setConstant(3, static_cast<Eigen::Index>(s.points.size()), unseen);
    data.even.push_back(frame.points_m);
    for (std::size_t k = 0; k < compared[index].size(); ++k) {
      const Sample& sample = *compared[index][k];
      const Eigen::Index column = first + static_cast<Eigen::Index>(k);
      const Eigen::Vector2d at = in_sheet(sample);
      frame.points_m.col(column).head<2>() = at + metres * sample.shift;
      data.even.back().col(column).head<2>() = at + top + at.y() / size.y() * (bottom - top);
    }
    first += static_cast<Eigen::Index>(compared[index].size());
    frame.block = static_cast<int>(index++);
    s.frames.push_back(std::move(frame));
  }
  return data;
}

}  // namespace tenter::bench
