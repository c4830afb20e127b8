// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/material/grid_layout.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/model/presets.h"
#include "server/mechanics/assembly/mesh_model.h"
#include "server/mechanics/law.h"

namespace tenter::estimation {
namespace {

using Corners = std::vector<Eigen::Vector2d>;

Corners box(double lo_u, double hi_u, double lo_v, double hi_v) {
  return {{lo_u, lo_v}, {hi_u, lo_v}, {hi_u, hi_v}, {lo_u, hi_v}};
}

/// Small clips at two corners of a sheet that does not begin at zero.
SpecimenLayout pulled_corners() {
  return {{0.1, 0.2}, {0.2, 0.3}, {box(0.1, 0.11, 0.2, 0.21), box(0.19, 0.2, 0.29, 0.3)}, {}};
}

double spacing_at(const std::vector<double>& lines, double at) {
  const auto next = std::upper_bound(lines.begin(), lines.end(), at);
  return *next - *(next - 1);
}

bool has(const std::vector<double>& lines, double at) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](double line) { return std::abs(line - at) < 1e-12; });
}

TEST(GridLayout, DenseTowardsCornersOfClipsInsideTheCloth) {
  const auto lines = grid_layout(pulled_corners(), {17, 17, 2.2}).value();
  for (const auto& [along, first] : {std::pair{&lines.u_m, 0.1}, std::pair{&lines.v_m, 0.2}}) {
    ASSERT_EQ(along->size(), 17U);
    EXPECT_EQ(along->front(), first);
    EXPECT_TRUE(has(*along, first + 0.01));
    EXPECT_TRUE(has(*along, first + 0.09));
    EXPECT_GT(spacing_at(*along, first + 0.05), 5.0 * spacing_at(*along, first + 0.0101));
  }
}

TEST(GridLayout, BarsAcrossTheWholeSheetNeedNoGrading) {
  const SpecimenLayout bars{
      {0.0, 0.0}, {0.1, 0.1}, {box(0.0, 0.01, 0.0, 0.1), box(0.09, 0.1, 0.0, 0.1)}, {}};
  const auto lines = grid_layout(bars, {11, 11, 2.2}).value();
  const mechanics::GridLines equal = mechanics::lines_of({11, 11, 0.1, 0.1});
  for (std::size_t k = 0; k < 11; ++k) {
    EXPECT_DOUBLE_EQ(lines.u_m[k], equal.u_m[k]);
    EXPECT_DOUBLE_EQ(lines.v_m[k], equal.v_m[k]);
  }
  // where bars end between them lines are moved there
  SpecimenLayout deeper = bars;
  deeper.clips_m[0] = box(0.0, 0.013, 0.0, 0.1);
  EXPECT_TRUE(has(grid_layout(deeper, {11, 11, 2.2})->u_m, 0.013));
}

TEST(GridLayout, EdgesLieHalfWayBetweenLines) {
  for (const bool above : {false, true}) {
    SpecimenLayout strip{{0.0, 0.0}, {0.1, 0.1}, {}, {}};
    for (const double at : {0.062, 0.047, 0.062}) strip.edges.push_back({1, at, above});
    const auto lines = grid_layout(strip, {13, 13, 2.2}).value();
    EXPECT_EQ(lines.u_m, mechanics::lines_of({13, 13, 0.1, 0.1}).u_m);
    ASSERT_EQ(lines.v_m.size(), 13U);
    for (const double at : {0.047, 0.062}) {
      const auto next = std::upper_bound(lines.v_m.begin(), lines.v_m.end(), at);
      EXPECT_NEAR(0.5 * (*next + *(next - 1)), at, 1e-12) << at;
    }
    // nearly all of them where the strip hangs
    const auto free = std::count_if(lines.v_m.begin(), lines.v_m.end(),
                                    [&](double v) { return above ? v < 0.062 : v > 0.047; });
    EXPECT_EQ(free, 11);
  }
}

TEST(GridLayout, MoreEndsThanLinesLeaveSomeOut) {
  SpecimenLayout crowd = pulled_corners();
  for (int k = 1; k < 9; ++k)
    crowd.clips_m.push_back(box(0.12 + 0.005 * k, 0.122 + 0.005 * k, 0.2, 0.21));
  const auto lines = grid_layout(crowd, {9, 9, 2.2});
  ASSERT_TRUE(lines) << lines.error().message;
  EXPECT_EQ(lines->u_m.size(), 9U);
}

/// Patch test: under a homogeneous deformation a graded sheet has the energy of an equal one, and
/// no net force on its inner nodes.
TEST(GridLayout, AHomogeneousStretchIsExactOnIt) {
  const mechanics::GridLines graded = grid_layout(pulled_corners(), {13, 13, 2.2}).value();
  const mechanics::GridLines equal = mechanics::lines_of({13, 13, 0.1, 0.1});
  Eigen::Matrix<double, 3, 2> f;
  f << 1.1, 0.06, -0.03, 0.95, 0.2, 0.1;
  for (const char* preset : {"cloth_stvk", "cloth_soft"}) {
    const auto description = model::preset(preset);
    ASSERT_TRUE(description) << preset;
    double energies[2] = {0.0, 0.0};
    for (const int g : {0, 1}) {
      const mechanics::GridLines& lines = g == 0 ? equal : graded;
      const auto cloth = mechanics::cloth_of_grid(lines, mechanics::Diagonals::both).value();
      const auto model = mechanics::MeshModel::make(*description, cloth).value();
      Eigen::VectorXd x(3 * model.node_count()), gradient;
      for (int n = 0; n < model.node_count(); ++n)
        x.segment<3>(3 * static_cast<Eigen::Index>(n)) = f * cloth.mesh.material_m.col(n);
      ASSERT_EQ(model.evaluate(x, mechanics::term_parameters(*description),
                               {&energies[g], &gradient, nullptr}),
                mechanics::AssemblyStatus::ok);
      double inner = 0.0, rim = 0.0;
      for (int n = 0; n < model.node_count(); ++n) {
        const bool is_inner = n % 13 > 0 && n % 13 < 12 && n / 13 > 0 && n / 13 < 12;
        double& largest = is_inner ? inner : rim;
        largest = std::max(largest, gradient.segment<3>(3 * static_cast<Eigen::Index>(n)).norm());
      }
      EXPECT_GT(rim, 1e-3);
      EXPECT_LT(inner, 1e-10 * rim) << preset << g;
    }
    EXPECT_GT(energies[0], 1e-6);
    EXPECT_NEAR(energies[1] / energies[0], 1.0, 1e-12) << preset;
  }
}

}  // namespace
}  // namespace tenter::estimation
