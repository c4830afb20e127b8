// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-discretisation [fabric] [cells] [frames] [finest] [beta] [sequence...]: what a grid
// alone costs. The generator's own curves are put on grids of 1, 2, 3 ... `finest` times `cells`,
// without noise or friction, and compared with the smooth sheet: no fit reaches below that at its
// true curves. The rig stays the same: `cells` sets how deep clips grip. Seen at nodes and seen
// anywhere differ by what flat triangles cut off a curved sheet.
//
// Per grid: root mean square distance in units of the noise (0.075 mm, 3 mN a cord), and of what
// the three finest grids say, the observed order and where h = 0 is (Richardson, 1911):
//
//   p: |e_1 - e_2| / |e_2 - e_3| = (h_1^p - h_2^p) / (h_2^p - h_3^p)
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/bench/fabrics/frame_errors.h"
#include "tests/twin/fabrics/sequences/cross_twin.h"
#include "tests/twin/fabrics/sequences/fabric_model.h"

namespace {

using namespace tenter;
using twin::FrameError;
using Frames = std::vector<FrameError>;

/// Along the clips: of shear, what is fitted to (thesis 3.4.1).
enum class Kind { position, force, force_along_clips };

/// A grid's rows of the frames that rest on all grids.
Eigen::VectorXd rows_of(const std::vector<Frames>& grids, std::size_t grid, Kind kind) {
  std::vector<double> rows;
  for (std::size_t f = 0; f < grids[grid].size(); ++f) {
    if (!std::all_of(grids.begin(), grids.end(), [&](const Frames& g) { return g[f].rests; }))
      continue;
    const FrameError& frame = grids[grid][f];
    const Eigen::VectorXd& of = kind == Kind::position ? frame.positions : frame.forces;
    const bool is_along = kind == Kind::force_along_clips;  // every second one
    for (Eigen::Index k = is_along ? 1 : 0; k < of.size(); k += is_along ? 2 : 1)
      rows.push_back(of[k]);
  }
  return Eigen::Map<const Eigen::VectorXd>(rows.data(), static_cast<Eigen::Index>(rows.size()));
}

double rms(const Eigen::VectorXd& rows) {
  return rows.size() > 0 ? std::sqrt(rows.squaredNorm() / static_cast<double>(rows.size())) : 0.0;
}

/// The order by bisection; 0 where differences do not shrink as a power would have them.
double observed_order(const Eigen::VectorXd& e1, const Eigen::VectorXd& e2,
                      const Eigen::VectorXd& e3, double n1, double n2, double n3) {
  const double ratio = (e1 - e2).norm() / (e2 - e3).norm();
  const auto model = [&](double p) {
    return (std::pow(n1, -p) - std::pow(n2, -p)) / (std::pow(n2, -p) - std::pow(n3, -p));
  };
  double lo = 0.05, hi = 8.0;
  if (!(ratio > model(lo)) || !(ratio < model(hi))) return 0.0;
  for (int k = 0; k < 60; ++k) (model(0.5 * (lo + hi)) < ratio ? lo : hi) = 0.5 * (lo + hi);
  return 0.5 * (lo + hi);
}

void print_limit(const char* what, const std::vector<Frames>& grids,
                 const std::vector<int>& factors, Kind kind) {
  if (grids.size() < 3) return;
  const std::size_t k = grids.size() - 1;
  const auto e = [&](std::size_t back) { return rows_of(grids, k - back, kind); };
  const auto n = [&](std::size_t back) { return static_cast<double>(factors[k - back]); };
  if (e(0).size() == 0) return;
  const double p = observed_order(e(2), e(1), e(0), n(2), n(1), n(0));
  std::printf("    %-9s", what);
  if (p == 0.0) {
    std::printf(" no order: the grids' differences do not shrink yet\n");
    return;
  }
  const double grows = std::pow(n(0) / n(1), p) - 1.0;
  const Eigen::VectorXd limit = e(0) + (e(0) - e(1)) / grows;
  std::printf(" order %4.1f, at h = 0 %7.2f noise\n", p, rms(limit));
}

std::vector<Eigen::Vector2d> nodes_of(double side_m, int cells) {
  std::vector<Eigen::Vector2d> places;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) places.emplace_back(side_m * i / cells, side_m * j / cells);
  return places;
}

void print_sequence(const twin::Fabric& cloth, const std::string& name, int cells, int frames,
                    int finest, double beta) {
  // the table's edge is half way between two lines of `cells`: only of odd multiples as well
  const bool is_bend = name.starts_with("bend");
  std::vector<int> factors, nodes;
  for (int factor = 1; factor <= finest; factor += is_bend ? 2 : 1) {
    factors.push_back(factor);
    nodes.push_back(factor * cells + 1);
  }
  const model::Model truth = twin::fabric_model(cloth);
  struct Variant {
    const char* words;
    bool at_nodes, beyond_edge;
    double grading;
  };
  std::vector<Variant> variants = {{"seen anywhere", false, true, 0.0},
                                   {"seen at the coarsest grid's nodes", true, true, 0.0}};
  if (is_bend)
    variants.push_back({"nodes on the table held, none beyond its edge", false, false, 0.0});
  if (beta > 0.0) variants = {{"graded, seen anywhere", false, true, beta}};
  for (const auto& [words, at_nodes, beyond_edge, grading] : variants) {
    twin::CrossOptions options;
    options.places = 900;
    options.grid.holds_line_beyond_edge = beyond_edge;
    options.grid.grading = grading;
    if (at_nodes) options.grid.points_m = nodes_of(cloth.side_m, cells);
    const auto made = twin::cross_twins(
        cloth, twin::make_protocol(cloth, name, {.frames = frames, .cells = cells}), options,
        nodes);
    if (!made) {
      std::printf("%s: %s\n", name.c_str(), made.error().message.c_str());
      return;
    }
    std::printf("%s, %s\n", name.c_str(), words);
    std::vector<Frames> grids;
    for (std::size_t g = 0; g < nodes.size(); ++g) {
      grids.push_back(twin::frame_errors((*made)[g].sequence, truth));
      const twin::MeanErrors errors = mean_errors(grids.back());
      std::printf("    %3d x %-3d position %8.2f", nodes[g], nodes[g], errors.position);
      if (!(*made)[g].sequence.forces.empty()) std::printf("   force %8.2f", errors.force);
      if (errors.meaningless > 0)
        std::printf("   in %d of %d frames distances of points say nothing; in the others %.2f",
                    errors.meaningless, frames, errors.position_where_meaningful);
      if (errors.lost > 0) std::printf("   %d frames without rest", errors.lost);
      std::printf("\n");
      std::fflush(stdout);
    }
    print_limit("position", grids, factors, Kind::position);
    print_limit("force", grids, factors, Kind::force);
    if (name == "shear") {
      std::printf("    along clips");
      for (std::size_t g = 0; g < grids.size(); ++g)
        std::printf(" %.2f", rms(rows_of(grids, g, Kind::force_along_clips)));
      std::printf("\n");
      print_limit("along", grids, factors, Kind::force_along_clips);
    }
    std::fflush(stdout);
  }
}

}  // namespace

int main(int count, char** arguments) {
  const std::string id = count > 1 ? arguments[1] : "18";
  const int cells = count > 2 ? std::atoi(arguments[2]) : 12;
  const int frames = count > 3 ? std::atoi(arguments[3]) : 6;
  const int finest = count > 4 ? std::atoi(arguments[4]) : 3;
  const twin::Fabric cloth = twin::without_friction(twin::fabric(id));
  std::printf("#%s %s: true curves on grids, beside the smooth sheet, in units of the noise\n",
              id.c_str(), cloth.name.c_str());
  const double beta = count > 5 ? std::atof(arguments[5]) : 0.0;
  std::vector<std::string> names(arguments + std::min(count, 6), arguments + count);
  if (names.empty()) names = twin::protocol_names();
  for (const std::string& name : names) print_sequence(cloth, name, cells, frames, finest, beta);
  return 0;
}
