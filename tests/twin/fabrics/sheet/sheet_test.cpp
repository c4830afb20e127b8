// SPDX-License-Identifier: GPL-3.0-or-later
// The smooth sheet: its derivatives, and what it does beside closed forms.
#include "tests/twin/fabrics/sheet/sheet.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tests/twin/fabrics/sheet/sheet_twin.h"
#include "tests/twin/random.h"

namespace tenter::twin {
namespace {

constexpr int kSheetCells = 8;

SplineLine uneven_line() {
  return SplineLine({0.0, 0.012, 0.012, 0.012, 0.03, 0.051, 0.051, 0.08, 0.1});
}

TEST(SplineLine, SumsToOneAndIsLinearWhereItsPlacesAre) {
  const SplineLine line = uneven_line();
  for (double s = 0.0; s <= 0.1; s += 0.0037) {
    const LineValue at = line.at(s);
    double one = 0.0, place = 0.0, slope = 0.0, curve = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double control = line.place(at.first + static_cast<int>(i));
      one += at.value[i];
      place += at.value[i] * control;
      slope += at.slope[i] * control;
      curve += at.curve[i] * control;
    }
    EXPECT_NEAR(one, 1.0, 1e-14) << s;
    EXPECT_NEAR(place, s, 1e-15) << s;
    EXPECT_NEAR(slope, 1.0, 1e-12) << s;
    EXPECT_NEAR(curve, 0.0, 1e-9) << s;
  }
}

TEST(SplineLine, DerivativesAreThoseOfTheValues) {
  const SplineLine line = uneven_line();
  const double h = 1e-6;
  for (double s = 0.0014; s < 0.1; s += 0.0041) {
    const LineValue at = line.at(s), up = line.at(s + h), down = line.at(s - h);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR((up.value[i] - down.value[i]) / (2.0 * h), at.slope[i], 1e-5 * 300.0) << s;
      EXPECT_NEAR((up.slope[i] - down.slope[i]) / (2.0 * h), at.curve[i], 1e-5 * 1e5) << s;
    }
  }
}

TEST(SplineLine, KnowsWhatAGripHolds) {
  const SplineLine line = uneven_line();
  // at a triple knot one function reaches over it from either side
  EXPECT_EQ(line.functions_on(0.0, 0.012), (std::array<int, 2>{0, 3}));
  EXPECT_EQ(line.functions_on(0.012, 0.03)[0], 3);
  EXPECT_EQ(line.functions_on(0.051, 0.1)[1], line.count() - 1);
}

SurfaceVector some_surface(Random& random) {
  SurfaceVector y;
  for (Eigen::Index i = 0; i < 15; ++i) y[i] = (i < 6 ? 0.1 : 30.0) * random.normal();
  y[0] += 1.0;
  y[4] += 1.0;
  return y;
}

TEST(SheetPoint, DerivativesAreThoseOfTheEnergy) {
  Random random(3);
  const Fabric denim = fabric("14");
  for (int trial = 0; trial < 12; ++trial) {
    const SurfaceVector y = some_surface(random);
    PointHistory history;
    for (int m = 0; trial % 2 == 1 && m < kModes; ++m) {
      history.strain[m] = (m < 3 ? 0.02 : 20.0) * random.normal();
      history.friction[m] = (m < 3 ? 10.0 : 1e-3) * random.normal();
    }
    PointEnergy at, up, down;
    evaluate_point(denim, history, y, true, 0.0, at);
    for (Eigen::Index i = 0; i < 15; ++i) {
      const double h = i < 6 ? 1e-6 : 1e-4;
      const double size = at.gradient.segment(i < 6 ? 0 : 6, i < 6 ? 6 : 9).norm();
      SurfaceVector high = y, low = y;
      high[i] += h;
      low[i] -= h;
      evaluate_point(denim, history, high, false, 0.0, up);
      evaluate_point(denim, history, low, false, 0.0, down);
      EXPECT_GT(size, 1e-4);
      EXPECT_NEAR((up.energy - down.energy) / (2.0 * h), at.gradient[i], 1e-6 * size) << i;
      const SurfaceVector column = (up.gradient - down.gradient) / (2.0 * h);
      EXPECT_LT((column - at.hessian.col(i)).norm(), 1e-4 * at.hessian.col(i).norm()) << i;
    }
  }
}

TEST(SheetPoint, ConvexShareIsNeverNegative) {
  Random random(5);
  const Fabric satin = without_friction(fabric("4"));
  bool was_negative = false;
  for (int trial = 0; trial < 20; ++trial) {
    PointEnergy at;
    const SurfaceVector y = some_surface(random);
    const auto lowest_share = [&](double share) {
      evaluate_point(satin, {}, y, true, share, at);
      const Eigen::SelfAdjointEigenSolver<SurfaceMatrix> eigen(at.hessian);
      return eigen.eigenvalues().minCoeff() / eigen.eigenvalues().maxCoeff();
    };
    EXPECT_GT(lowest_share(1.0), -1e-12);
    was_negative = was_negative || lowest_share(0.0) < -1e-6;
  }
  EXPECT_TRUE(was_negative);
}

TEST(Sheet, GradientAndMatrixAreThoseOfTheEnergy) {
  const SplineLine height({0.0, 0.012, 0.012, 0.03, 0.051, 0.08, 0.1});
  const SplineLine plane({0.0, 0.012, 0.012, 0.012, 0.03, 0.051, 0.08, 0.1});
  const Sheet sheet(fabric("18"), {plane, plane, height, height});
  Random random(7);
  Eigen::VectorXd x = sheet.flat();
  for (Eigen::Index k = 0; k < x.size(); ++k) x[k] += 2e-4 * random.normal();
  const int n = sheet.unknown_count();
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  std::vector<int> slots;
  for (const auto& span : sheet.spans())
    for (const int column : span)
      for (const int row : span) slots.push_back(column * n + row);
  Eigen::VectorXd gradient, up, down;
  sheet.evaluate(x, &gradient, &slots, dense.data());
  for (int k = 3; k < n; k += 17) {
    const double h = 1e-8;
    Eigen::VectorXd high = x, low = x;
    high[k] += h;
    low[k] -= h;
    const double slope = (sheet.evaluate(high, &up) - sheet.evaluate(low, &down)) / (2.0 * h);
    EXPECT_NEAR(slope, gradient[k], 1e-5 * gradient.cwiseAbs().maxCoeff()) << k;
    const Eigen::VectorXd column = (up - down) / (2.0 * h);
    EXPECT_GT(column.norm(), 1e-2);
    EXPECT_LT((column - dense.col(k)).norm(), 1e-4 * column.norm()) << k;
  }
}

SheetTwin coarse_twin(const Fabric& fabric, const std::string& name, int frames,
                      const std::vector<Eigen::Vector2d>& places, int spans = kSheetCells) {
  SheetTwinOptions options;
  options.span_m = fabric.side_m / spans;
  return run_protocol(fabric, make_protocol(fabric, name, {.frames = frames, .cells = kSheetCells}),
                      places, options);
}

// Between bars  F = width sigma(E) (1 + e), up to what the sag adds.
TEST(SheetTwin, PulledCanBeReadOffTheCurve) {
  for (const char* id : {"4", "18"}) {
    const Fabric cloth = without_friction(fabric(id));
    const Protocol protocol =
        make_protocol(cloth, "stretch_v", {.frames = 6, .cells = kSheetCells});
    const SheetTwin twin = coarse_twin(cloth, "stretch_v", 6, {{0.05, 0.05}});
    ASSERT_EQ(twin.failure, "");
    const double free_m = cloth.side_m * (kSheetCells - 2) / kSheetCells;
    for (std::size_t f = 0; f < protocol.frames.size(); ++f) {
      const double e = protocol.frames[f].poses[1].position_m.y() / free_m;
      const double want_N =
          cloth.side_m * cloth.curve(Mode::stretch_v).at(e + 0.5 * e * e).stress * (1.0 + e);
      EXPECT_GT(want_N, 0.5);
      EXPECT_NEAR(twin.clip_force_N[f][1].y(), want_N, 1e-3 * want_N) << id << f;
      EXPECT_NEAR(twin.clip_force_N[f][0].y(), -twin.clip_force_N[f][1].y(), 1e-6);
    }
  }
}

/// How deep a heavy elastica hangs: B theta'' = -w (L - s) cos theta, flat at 0, free at L.
double elastica_drop_m(double stiffness_N_m, double weight_N_m2, double length_m) {
  constexpr int kSteps = 1000;
  const double h = length_m / kSteps;
  const auto shoot = [&](double curvature, double& drop_m) {
    double theta = 0.0, kappa = curvature;
    drop_m = 0.0;
    const auto bend = [&](double s, double t) {
      return -weight_N_m2 / stiffness_N_m * (length_m - s) * std::cos(t);
    };
    for (int k = 0; k < kSteps; ++k) {
      const double s = k * h;
      const double k1 = kappa, m1 = bend(s, theta);
      const double k2 = kappa + 0.5 * h * m1, m2 = bend(s + 0.5 * h, theta + 0.5 * h * k1);
      const double k3 = kappa + 0.5 * h * m2, m3 = bend(s + 0.5 * h, theta + 0.5 * h * k2);
      const double k4 = kappa + h * m3, m4 = bend(s + h, theta + h * k3);
      const double next = theta + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      drop_m += h / 6.0 * (std::sin(theta) + 4.0 * std::sin(theta + 0.5 * h * k2) + std::sin(next));
      theta = next;
      kappa += h / 6.0 * (m1 + 2.0 * m2 + 2.0 * m3 + m4);
    }
    return kappa;  // at the free end
  };
  double low = 0.0, high = weight_N_m2 * length_m * length_m / stiffness_N_m, drop_m = 0.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (shoot(middle, drop_m) < 0.0 ? low : high) = middle;
  }
  return drop_m;
}

// Without coupling a strip bends as a beam, whatever its width; finer knots come nearer.
TEST(SheetTwin, HangsAsAHeavyElastica) {
  Fabric cloth = without_friction(fabric("14"));
  constexpr double kStiffness_N_m = 1.2e-4;
  cloth.curves[static_cast<std::size_t>(Mode::bend_u)] = {0.0, 0.0, {kStiffness_N_m}};
  const Protocol protocol = make_protocol(cloth, "bend_u", {.frames = 3, .cells = kSheetCells});
  const std::vector<Eigen::Vector2d> tip = {{0.1, 0.013}, {0.1, 0.071}};
  const auto worst_error = [&](int spans) {
    const SheetTwin twin = coarse_twin(cloth, "bend_u", 3, tip, spans);
    EXPECT_EQ(twin.failure, "");
    double worst = 0.0;
    for (std::size_t f = 0; f < twin.positions_m.size(); ++f) {
      const double length_m = cloth.side_m - protocol.frames[f].table->hi_u;
      const double want_m =
          elastica_drop_m(kStiffness_N_m, cloth.mass_kg * kGravity_m_s2 / 0.01, length_m);
      EXPECT_GT(want_m, 1e-3);
      for (Eigen::Index k = 0; k < 2; ++k)
        worst = std::max(worst, std::abs(-twin.positions_m[f](2, k) / want_m - 1.0));
    }
    return worst;
  };
  const double coarse = worst_error(kSheetCells), fine = worst_error(2 * kSheetCells);
  EXPECT_LT(coarse, 0.02);
  EXPECT_LT(fine, 0.003);
}

// Thesis 3.5: loading over unloading, at the same elongation half way along a branch.
TEST(SheetTwin, LoadsStifferThanItUnloads) {
  const Fabric wool = fabric("18");
  const Protocol protocol = make_protocol(wool, "stretch_v", {.frames = 42, .cells = kSheetCells});
  const SheetTwin twin = coarse_twin(wool, "stretch_v", 42, {{0.05, 0.05}});
  ASSERT_EQ(twin.failure, "");
  const auto force_half_way = [&](int branch) {
    double nearest = 1.0, force_N = 0.0;
    const double half_m =
        0.5 * wool.limits.stretch_v * wool.side_m * (kSheetCells - 2) / kSheetCells;
    for (std::size_t f = 0; f < protocol.frames.size(); ++f) {
      const double off = std::abs(protocol.frames[f].poses[1].position_m.y() / half_m - 1.0);
      if (protocol.frames[f].block != branch || off > nearest) continue;
      nearest = off;
      force_N = twin.clip_force_N[f][1].y();
    }
    EXPECT_LT(nearest, 0.07);
    return force_N;
  };
  EXPECT_NEAR(force_half_way(0) / force_half_way(1), 1.6, 0.05);
  // the loop is retraced
  EXPECT_NEAR(force_half_way(4), force_half_way(2), 1e-3 * force_half_way(2));
  EXPECT_NEAR(force_half_way(5), force_half_way(3), 1e-3 * force_half_way(3));
}

}  // namespace
}  // namespace tenter::twin
