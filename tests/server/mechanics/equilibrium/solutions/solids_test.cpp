// SPDX-License-Identifier: GPL-3.0-or-later
// A hollow ball of neo-Hookean rubber under pressure, and a cantilever.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <map>

#include "common/model/presets.h"
#include "server/mechanics/mesh/solid_mesh.h"
#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

/// A cube's surface of cells x cells squares a face, laid on a sphere with equal angles, and
/// `layers` of hexahedra from the inner radius to the outer.
struct Ball {
  SolidMesh mesh;
  std::vector<std::array<int, 3>> inner;  ///< triangles of the inner surface, normals outwards
  std::vector<int> inner_nodes;
};

Ball hollow_ball(int cells, int layers, double inner_m, double outer_m) {
  std::map<std::array<int, 3>, int> number;
  std::vector<Eigen::Vector3d> directions;
  std::vector<std::array<int, 4>> quads;
  const auto node = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = number.emplace(at, static_cast<int>(directions.size()));
    if (is_new) {
      Eigen::Vector3d d;
      for (int i = 0; i < 3; ++i)
        d[i] = std::tan(0.25 * M_PI * (2.0 * at[static_cast<std::size_t>(i)] / cells - 1.0));
      directions.push_back(d.normalized());
    }
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int side : {0, cells}) {
      for (int a = 0; a < cells; ++a) {
        for (int b = 0; b < cells; ++b) {
          const auto corner = [&](int i, int j) {
            std::array<int, 3> at{};
            at[axis] = side;
            at[(axis + 1) % 3] = i;
            at[(axis + 2) % 3] = j;
            return node(at);
          };
          std::array<int, 4> quad = {corner(a, b), corner(a + 1, b), corner(a + 1, b + 1),
                                     corner(a, b + 1)};
          if (side == 0) std::swap(quad[1], quad[3]);
          quads.push_back(quad);
        }
      }
    }
  }
  Ball ball;
  const int sheet = static_cast<int>(directions.size());
  ball.mesh.rest_m.resize(3, static_cast<Eigen::Index>(sheet) * (layers + 1));
  for (int l = 0; l <= layers; ++l)
    for (int n = 0; n < sheet; ++n)
      ball.mesh.rest_m.col(static_cast<Eigen::Index>(l) * sheet + n) =
          (inner_m + (outer_m - inner_m) * l / layers) * directions[static_cast<std::size_t>(n)];
  for (const auto& q : quads) {
    for (int l = 0; l < layers; ++l) {
      std::array<int, 8> hexahedron{};
      for (std::size_t c = 0; c < 4; ++c) {
        hexahedron[c] = l * sheet + q[c];
        hexahedron[c + 4] = (l + 1) * sheet + q[c];
      }
      ball.mesh.hexahedra.push_back(hexahedron);
    }
    ball.inner.push_back({q[0], q[1], q[2]});
    ball.inner.push_back({q[0], q[2], q[3]});
  }
  for (int n = 0; n < sheet; ++n) ball.inner_nodes.push_back(n);
  return ball;
}

/// Radius that the inner wall comes to, from P_r' = 2 (P_t - P_r) / R of the nominal stresses
/// P_i = 2 c (l_i - 1/l_i) + k ln J / l_i, with P_r (A) = -p (r/A)^2 and P_r (B) = 0: shooting for
/// r(A).
double inner_radius(double c, double k, double pressure_Pa, double a, double b) {
  constexpr int kSteps = 2000;
  const auto radial = [&](double lr, double lt) {
    return 2.0 * c * (lr - 1.0 / lr) + k * std::log(lr * lt * lt) / lr;
  };
  const auto tangential = [&](double lr, double lt) {
    return 2.0 * c * (lt - 1.0 / lt) + k * std::log(lr * lt * lt) / lt;
  };
  // l_r from P_r, which rises with it
  const auto stretch = [&](double stress, double lt) {
    double low = 1e-3, high = 20.0;
    for (int i = 0; i < 80; ++i) {
      const double middle = 0.5 * (low + high);
      (radial(middle, lt) < stress ? low : high) = middle;
    }
    return 0.5 * (low + high);
  };
  const auto outer_stress = [&](double start) {
    double r = start, stress = -pressure_Pa * (r / a) * (r / a);
    const double h = (b - a) / kSteps;
    const auto slopes = [&](double at, double radius, double p) {
      const double lt = radius / at, lr = stretch(p, lt);
      return Eigen::Vector2d(lr, 2.0 * (tangential(lr, lt) - p) / at);
    };
    for (int i = 0; i < kSteps; ++i) {  // midpoint rule
      const double at = a + i * h;
      const Eigen::Vector2d first = slopes(at, r, stress);
      const Eigen::Vector2d middle =
          slopes(at + 0.5 * h, r + 0.5 * h * first[0], stress + 0.5 * h * first[1]);
      r += h * middle[0];
      stress += h * middle[1];
    }
    return stress;
  };
  double low = a, high = 1.6 * a;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (outer_stress(middle) < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Eigen::VectorXd rest(const SolidMesh& mesh) {
  return Eigen::Map<const Eigen::VectorXd>(mesh.rest_m.data(), mesh.rest_m.size());
}

// Trilinear elements: second order. The ball floats, so its state is neutral.
TEST(Solids, AHollowBallUnderPressure) {
  const double c = 5e3, k = 3e4, inner = 0.02, outer = 0.03, pressure = 3500.0;
  model::Model rubber = model::preset("solid_neo_hookean").value();
  rubber.terms[0].law.parameters[0].value = c;
  rubber.terms[1].law.parameters[0].value = k;
  const double exact = inner_radius(c, k, pressure, inner, outer);
  ASSERT_GT(exact, 1.1 * inner);
  ASSERT_LT(exact, 1.5 * inner);
  std::vector<double> errors;
  for (const int cells : {2, 4, 8}) {
    const Ball ball = hollow_ball(cells, cells / 2, inner, outer);
    ASSERT_TRUE(check(ball.mesh)) << check(ball.mesh).error().message;
    const Body body(ball.mesh, rubber);
    Boundary boundary;
    boundary.pressed = ball.inner;
    Loads loads;
    loads.pressure_Pa = pressure;
    State state{rest(ball.mesh), {}};
    EquilibriumOptions options;
    options.tolerance_N = 1e-8;
    const EquilibriumResult result =
        solved(body.model, body.parameters, boundary, loads, state, options);
    ASSERT_TRUE(result.is_good(options)) << describe(result, options);
    EXPECT_EQ(result.stability, Stability::neutral);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const int n : ball.inner_nodes) middle += state.x.segment<3>(3 * n);
    middle /= static_cast<double>(ball.inner_nodes.size());
    double radius = 0.0;
    for (const int n : ball.inner_nodes) radius += (state.x.segment<3>(3 * n) - middle).norm();
    radius /= static_cast<double>(ball.inner_nodes.size());
    errors.push_back(std::abs(radius - exact) / (exact - inner));
    std::printf("hollow ball, %d x %d a face: radius %.6f of %.6f, %d iterations\n", cells, cells,
                radius, exact, result.iterations);
  }
  for (std::size_t i = 1; i < errors.size(); ++i) {
    const double observed = order(errors[i - 1], errors[i]);
    std::printf("hollow ball: error of the expansion %.2e, order %.2f\n", errors[i], observed);
    EXPECT_NEAR(observed, 2.0, 0.35);
  }
  EXPECT_LT(errors.back(), 0.03);
}

// Without lateral contraction (lambda = 0) the beam theories need no correction at the clamp:
// deflection F L^3 / (3 E I) + F L / (5/6 G A). Trilinear elements are too stiff in bending by a
// part that falls with the square of the cell.
TEST(Solids, ACantileverBendsAsTimoshenkoSays) {
  const double young = 1e6, length = 0.2, height = 0.02, width = 0.01, force = 2e-3;
  model::Model material = model::preset("solid_stvk").value();
  material.terms[0].law.parameters[0].value = 0.0;          // lambda
  material.terms[1].law.parameters[0].value = 0.5 * young;  // mu = E / 2
  const double inertia = width * std::pow(height, 3) / 12.0;
  const double exact = force * std::pow(length, 3) / (3.0 * young * inertia) +
                       force * length / (5.0 / 6.0 * 0.5 * young * width * height);
  ASSERT_LT(exact, 0.01 * length) << "small enough for the linear theory";
  ASSERT_GT(exact, 1e-3 * length);
  std::vector<double> errors;
  for (const int cells : {2, 4, 8}) {
    const SolidMesh mesh = box_hexahedra(10 * cells, 1, cells, {length, width, height}).value();
    const Body body(mesh, material);
    Boundary boundary;
    Loads loads;
    loads.node_force_N.setZero(3 * mesh.node_count());
    for (int n = 0; n < mesh.node_count(); ++n) {
      const Eigen::Vector3d at = mesh.rest_m.col(n);
      if (at.x() == 0.0) boundary.held.push_back(n);
      if (at.x() < length - 1e-9) continue;
      const bool is_end = at.z() == 0.0 || at.z() > height - 1e-9;
      loads.node_force_N[3 * n + 2] = -0.5 * force * (is_end ? 0.5 : 1.0) / cells;
    }
    State state{rest(mesh), {}};
    EquilibriumOptions options;
    options.tolerance_N = 1e-10;
    const EquilibriumResult result =
        solved(body.model, body.parameters, boundary, loads, state, options);
    ASSERT_TRUE(result.is_good(options)) << describe(result, options);
    EXPECT_EQ(result.stability, Stability::minimum);
    double drop = 0.0, reaction_N = 0.0, moment_N_m = 0.0;
    int count = 0;
    for (int n = 0; n < mesh.node_count(); ++n) {
      if (mesh.rest_m(0, n) < length - 1e-9) continue;
      drop += mesh.rest_m(2, n) - state.x[3 * n + 2];
      ++count;
    }
    drop /= count;
    for (const int n : boundary.held) {
      reaction_N += result.by_node[3 * n + 2];
      moment_N_m +=
          state.x[3 * n + 2] * result.by_node[3 * n] - state.x[3 * n] * result.by_node[3 * n + 2];
    }
    EXPECT_NEAR(reaction_N, force, 1e-9);
    EXPECT_NEAR(std::abs(moment_N_m), force * length, 2e-4 * force * length);
    errors.push_back(std::abs(drop - exact) / exact);
  }
  for (std::size_t i = 1; i < errors.size(); ++i) {
    const double observed = order(errors[i - 1], errors[i]);
    std::printf("cantilever, %d cells over its height: error %.2e, order %.2f\n", 2 << i, errors[i],
                observed);
    EXPECT_NEAR(observed, 2.0, 0.25);
  }
  EXPECT_LT(errors.back(), 0.02);
}

}  // namespace
}  // namespace tenter::mechanics::testing
