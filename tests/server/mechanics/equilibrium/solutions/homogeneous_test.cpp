// SPDX-License-Identifier: GPL-3.0-or-later
// Homogeneous states: with every node of the rim where an affine map takes it, the inside follows,
// and the reactions carry the stress of the textbook. Linear triangles have that to rounding on any
// mesh.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "server/mechanics/mesh/edges.h"
#include "server/mechanics/mesh/outline.h"
#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

using Map = Eigen::Matrix<double, 3, 2>;

/// Nodes of edges that one triangle has.
std::vector<int> rim(const SurfaceMesh& mesh) {
  std::vector<bool> is_on_rim(static_cast<std::size_t>(mesh.node_count()), false);
  for (const Edge& edge : edges(mesh)) {
    if (edge.interior()) continue;
    is_on_rim[static_cast<std::size_t>(edge.low)] = true;
    is_on_rim[static_cast<std::size_t>(edge.high)] = true;
  }
  std::vector<int> nodes;
  for (int n = 0; n < mesh.node_count(); ++n)
    if (is_on_rim[static_cast<std::size_t>(n)]) nodes.push_back(n);
  return nodes;
}

double area_m2(const SurfaceMesh& mesh) {
  double sum = 0.0;
  for (const double area : triangle_areas_m2(mesh)) sum += area;
  return sum;
}

std::vector<Cloth> meshes() {
  std::vector<Cloth> list;
  for (const Diagonals d : {Diagonals::one, Diagonals::alternating, Diagonals::both})
    list.push_back(cloth_of_grid({7, 6, 0.12, 0.09}, d).value());
  const std::vector<Eigen::Vector2d> outline = {
      {0.0, 0.0}, {0.11, 0.01}, {0.13, 0.08}, {0.06, 0.11}, {0.0, 0.07}};
  list.push_back(cloth_of_mesh(triangulate_outline(outline, 0.013).value()).value());
  return list;
}

/// A stiffness of each strain; all of them isotropic or not.
struct Membrane {
  double weft = 130.0, warp = 90.0, pair = 25.0, shear = 35.0;

  model::Model model() const {
    return linear_model(
        {{"green_u", weft}, {"green_v", warp}, {"green_pair", pair}, {"green_uv", shear}});
  }
  /// First Piola-Kirchhoff stress F S, N/m.
  Map stress(const Map& f) const {
    const Eigen::Matrix2d c = f.transpose() * f;
    const double eu = 0.5 * (c(0, 0) - 1.0), ev = 0.5 * (c(1, 1) - 1.0);
    Eigen::Matrix2d s;
    s << weft * eu + pair * ev, shear * c(0, 1), shear * c(0, 1), warp * ev + pair * eu;
    return f * s;
  }
};

struct Deformation {
  const char* name;
  Map f;
};

std::vector<Deformation> deformations() {
  std::vector<Deformation> list(4);
  const Eigen::Matrix3d turn = rotation_of({0.4, -0.7, 0.2});
  list[0] = {"uniaxial", Map::Zero()};
  list[0].f << 1.2, 0.0, 0.0, 1.0, 0.0, 0.0;
  list[1] = {"biaxial", Map::Zero()};
  list[1].f << 1.15, 0.0, 0.0, 1.3, 0.0, 0.0;
  list[2] = {"simple shear", Map::Zero()};
  list[2].f << 1.1, 0.25, 0.0, 1.1, 0.0, 0.0;
  list[3] = {"all, turned", Map::Zero()};
  list[3].f << 1.2, 0.1, -0.05, 1.1, 0.0, 0.0;
  list[3].f = (turn * list[3].f).eval();
  return list;
}

TEST(Homogeneous, AffineOnAnyMeshWithTheStressOfTheTextbook) {
  const Membrane membrane;
  for (const Cloth& cloth : meshes()) {
    const Sheet sheet(cloth, membrane.model());
    SCOPED_TRACE(sheet.nodes());
    Boundary boundary;
    boundary.held = rim(sheet.cloth.mesh);
    ASSERT_LT(static_cast<int>(boundary.held.size()), sheet.nodes() - 10);
    for (const Deformation& deformation : deformations()) {
      SCOPED_TRACE(deformation.name);
      const Eigen::VectorXd affine = placed(sheet.cloth.mesh, [&](double u, double v) {
        return Eigen::Vector3d(deformation.f * Eigen::Vector2d(u, v));
      });
      State state{shaken(affine, 1e-3, 7), {}};
      for (const int n : boundary.held) state.x.segment<3>(3 * n) = affine.segment<3>(3 * n);
      EquilibriumOptions options;
      options.tolerance_N = 1e-12;
      const EquilibriumResult result = solved(sheet, boundary, Loads{}, state, options);
      ASSERT_TRUE(result.is_good(options)) << describe(result, options);
      EXPECT_LT((state.x - affine).lpNorm<Eigen::Infinity>(), 1e-12);

      // the affine state itself: no net force inside
      Eigen::VectorXd gradient;
      ASSERT_EQ(sheet.model.evaluate(affine, sheet.parameters, {nullptr, &gradient, nullptr}),
                AssemblyStatus::ok);
      double inside_N = 0.0, rim_N = 0.0;
      std::vector<bool> is_held(static_cast<std::size_t>(sheet.nodes()), false);
      for (const int n : boundary.held) is_held[static_cast<std::size_t>(n)] = true;
      for (int n = 0; n < sheet.nodes(); ++n)
        (is_held[static_cast<std::size_t>(n)] ? rim_N : inside_N) +=
            gradient.segment<3>(3 * n).norm();
      EXPECT_GT(rim_N, 1.0);
      EXPECT_LT(inside_N, 1e-12 * rim_N);

      // area x stress = sum of reaction x material place
      Map stress = Map::Zero();
      for (const int n : boundary.held)
        stress += result.by_node.segment<3>(3 * n) * sheet.cloth.mesh.material_m.col(n).transpose();
      stress /= area_m2(sheet.cloth.mesh);
      const Map expected = membrane.stress(deformation.f);
      EXPECT_LT((stress - expected).norm(), 1e-11 * expected.norm());
    }
  }
}

// The three cloth models, each against its own formula, on the mesh that its springs are made for.
TEST(Homogeneous, StretchOfTheThreeClothModels) {
  const double k = 120.0, stretch = 1.18;
  const double green = 0.5 * (stretch * stretch - 1.0);
  struct Row {
    const char* preset;
    double stress_N_m;  ///< along the weft, nominal
  };
  const double diagonal = std::sqrt(0.5 * (stretch * stretch + 1.0));
  const Row rows[] = {{"cloth_stvk", k * green * stretch},
                      {"cloth_soft", k * (stretch - 1.0)},
                      // two families at 45 degrees, each with the whole sheet
                      {"cloth_springs", k * (stretch - 1.0) +
                                            2.0 * k * (diagonal - 1.0) * 0.5 * stretch / diagonal}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.preset);
    model::Model description = model::Model{};
    description = preset_with(row.preset, {{"weft", k}, {"warp", k}});
    for (model::Term& term : description.terms)
      term.law.parameters[0].value = term.id.starts_with("bend") ? 0.0 : k;
    const Sheet sheet(cloth_of_grid({9, 9, 0.1, 0.1}, Diagonals::both).value(), description);
    Boundary boundary;
    boundary.held = rim(sheet.cloth.mesh);
    const Eigen::VectorXd affine = placed(
        sheet.cloth.mesh, [&](double u, double v) { return Eigen::Vector3d(stretch * u, v, 0.0); });
    State state{shaken(affine, 5e-4, 2), {}};
    for (const int n : boundary.held) state.x.segment<3>(3 * n) = affine.segment<3>(3 * n);
    EquilibriumOptions options;
    options.tolerance_N = 1e-11;
    const EquilibriumResult result = solved(sheet, boundary, Loads{}, state, options);
    ASSERT_TRUE(result.is_good(options)) << describe(result, options);
    EXPECT_LT((state.x - affine).lpNorm<Eigen::Infinity>(), 1e-11);
    Map stress = Map::Zero();
    for (const int n : boundary.held)
      stress += result.by_node.segment<3>(3 * n) * sheet.cloth.mesh.material_m.col(n).transpose();
    EXPECT_NEAR(stress(0, 0) / 0.01, row.stress_N_m, 1e-10 * row.stress_N_m);
  }
}

}  // namespace
}  // namespace tenter::mechanics::testing
