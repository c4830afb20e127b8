// SPDX-License-Identifier: GPL-3.0-or-later
// The three cloth models on the seven deformations of thesis 3.2.2, 25 x 25 nodes on 100 mm, from
// the flat state.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>

#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

constexpr int kSide = 25;
constexpr double kLength = 0.1;
constexpr double kDensity = 0.187;  // kg/m2

struct Deformation {
  const char* name;
  Boundary boundary;
  State state;  ///< flat but for what the clips hold
};

class Machine {
 public:
  explicit Machine(const SurfaceMesh& mesh) : mesh_(mesh), flat_(flat(mesh)) {}

  std::vector<Deformation> all() const {
    std::vector<Deformation> list;
    for (const bool warp : {false, true}) {
      Deformation d{warp ? "stretch warp" : "stretch weft", {}, {flat_, {}}};
      const auto along = [warp](double u, double v) { return warp ? v : u; };
      add(d, "near", [&](double u, double v) { return along(u, v) < kEdge; }, {});
      Pose pulled;
      pulled.position_m[warp ? 1 : 0] = 0.1 * kLength;
      add(
          d, "far", [&](double u, double v) { return along(u, v) > kLength - kEdge; }, pulled);
      list.push_back(d);
    }
    list.push_back(picture_frame());
    for (const bool warp : {false, true}) {
      Deformation d{warp ? "bend warp" : "bend weft", {}, {flat_, {}}};
      d.boundary.held = nodes_where(
          mesh_, [&](double u, double v) { return (warp ? v : u) < 0.4 * kLength + kEdge; });
      list.push_back(d);
    }
    list.push_back(complex_shear());
    list.push_back(corner_pull());
    return list;
  }

 private:
  static constexpr double kEdge = 1e-6;

  template <class Predicate>
  void add(Deformation& d, const char* id, const Predicate& holds, const Pose& pose) const {
    d.boundary.clips.push_back(clip_on(id, nodes_where(mesh_, holds), flat_, Pose{}));
    d.state.clips.push_back(pose);
  }

  /// Four long clips about the sides, without the corners; opposite corners are pulled apart until
  /// the frame is sheared by 15 degrees.
  Deformation picture_frame() const {
    Deformation d{"picture frame", {}, {flat_, {}}};
    const double turn = 7.5 * M_PI / 180.0;
    // u and v axes turned towards each other about the first corner
    const Eigen::Matrix3d of_u = rotation_of({0.0, 0.0, turn});
    const Eigen::Matrix3d of_v = rotation_of({0.0, 0.0, -turn});
    const auto inner = [](double a) { return a > kEdge && a < kLength - kEdge; };
    add(d, "bottom", [&](double u, double v) { return v < kEdge && inner(u); }, {of_u, {0, 0, 0}});
    add(d, "left", [&](double u, double v) { return u < kEdge && inner(v); }, {of_v, {0, 0, 0}});
    const Eigen::Vector3d up(0.0, kLength, 0.0), right(kLength, 0.0, 0.0);
    add(d, "top", [&](double u, double v) { return v > kLength - kEdge && inner(u); },
        {of_u, of_v * up - of_u * up});
    add(d, "right", [&](double u, double v) { return u > kLength - kEdge && inner(v); },
        {of_v, of_u * right - of_v * right});
    return d;
  }

  /// Opposite edges pulled in opposite directions, along themselves.
  Deformation complex_shear() const {
    Deformation d{"complex shear", {}, {flat_, {}}};
    Pose left, right;
    left.position_m = {-0.012, 0.0, 0.0};
    right.position_m = {0.012, 0.0, 0.0};
    add(
        d, "bottom", [](double, double v) { return v < kEdge; }, left);
    add(
        d, "top", [](double, double v) { return v > kLength - kEdge; }, right);
    return d;
  }

  /// One pair of opposite corners pulled apart, the other let in.
  Deformation corner_pull() const {
    Deformation d{"corner pull", {}, {flat_, {}}};
    const double clip = 2.0 * kLength / (kSide - 1) + kEdge;
    const auto corner = [&](const char* id, bool right, bool top, double out) {
      Pose pose;
      pose.position_m = {right ? out : -out, top ? out : -out, 0.0};
      add(
          d, id,
          [&](double u, double v) {
            return (right ? u > kLength - clip : u < clip) && (top ? v > kLength - clip : v < clip);
          },
          pose);
    };
    corner("a", false, false, 0.005);
    corner("b", true, true, 0.005);
    corner("c", true, false, -0.003);
    corner("d", false, true, -0.003);
    return d;
  }

  const SurfaceMesh& mesh_;
  Eigen::VectorXd flat_;
};

std::vector<model::Model> models() {
  return {preset_with("cloth_springs", {{"weft", 300.0},
                                        {"warp", 400.0},
                                        {"diagonal_1", 60.0},
                                        {"diagonal_2", 60.0},
                                        {"bend_weft", 20.0},
                                        {"bend_warp", 30.0},
                                        {"bend_diagonal", 10.0}}),
          preset_with("cloth_soft", {{"weft", 300.0},
                                     {"warp", 400.0},
                                     {"shear", 60.0},
                                     {"bend_weft", 2e-6},
                                     {"bend_warp", 4e-6},
                                     {"bend_diagonal", 3e-6}}),
          preset_with("cloth_stvk", {{"weft", 300.0},
                                     {"warp", 400.0},
                                     {"shear", 60.0},
                                     {"bend_weft", 2e-6},
                                     {"bend_warp", 4e-6},
                                     {"bend_diagonal", 3e-6}})};
}

TEST(Deformations, TheThreeModelsComeToRestFromTheFlatState) {
  std::printf("%-16s %-14s %6s %6s %7s %7s %12s %s\n", "model", "deformation", "steps", "factor",
              "evals", "saddles", "net force N", "highest - lowest node, mm");
  for (const model::Model& description : models()) {
    const Sheet sheet(
        cloth_of_grid({kSide, kSide, kLength, kLength}, Diagonals::alternating).value(),
        description);
    const Loads loads = weight(sheet.cloth.mesh, kDensity);
    for (Deformation& deformation : Machine(sheet.cloth.mesh).all()) {
      SCOPED_TRACE(description.name + ", " + deformation.name);
      EquilibriumOptions options;
      State& state = deformation.state;
      const EquilibriumResult result = solved(sheet, deformation.boundary, loads, state, options);
      EXPECT_TRUE(result.is_good(options)) << describe(result, options);
      EXPECT_LE(result.last.net_force_N, 1e-5);
      EXPECT_LT(result.iterations, 1000);
      const Eigen::Map<const Eigen::Matrix3Xd> nodes(state.x.data(), 3, sheet.nodes());
      const double relief_m = nodes.row(2).maxCoeff() - nodes.row(2).minCoeff();
      std::printf("%-16s %-14s %6d %6d %7d %7d %12.1e %.2f\n", description.name.c_str(),
                  deformation.name, result.iterations, result.factorisations, result.evaluations,
                  result.saddles_left, result.last.net_force_N, 1e3 * relief_m);
      // what holds the cloth bears its weight, and pulls at nothing else
      Eigen::Vector3d held = Eigen::Vector3d::Zero();
      for (const int n : deformation.boundary.held) held += result.by_node.segment<3>(3 * n);
      for (const Clip& clip : deformation.boundary.clips)
        held -= reaction(clip, state.x, result.by_node, {0, 0, 0}).force_N;
      const double weight_N = kDensity * kLength * kLength * 9.81;
      EXPECT_NEAR(held.z(), weight_N, 0.02 * weight_N);
      EXPECT_LT(std::hypot(held.x(), held.y()), 0.02 * weight_N);
    }
  }
}

}  // namespace
}  // namespace tenter::mechanics::testing
