// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/scene/body.h"

#include <cmath>
#include <optional>
#include <utility>

#include "server/mechanics/mesh/grid.h"
#include "server/mechanics/mesh/mesh_text.h"
#include "server/mechanics/mesh/outline.h"
#include "server/mechanics/mesh/solid_text.h"
#include "server/mechanics/mesh/tube.h"

namespace tenter::mechanics {
namespace {

constexpr double kPi = 3.14159265358979323846;

Expected<SceneBody> about_mesh(Expected<SceneBody> body) {
  if (body) return body;
  return fail(body.error().kind, "mesh: " + body.error().message);
}

Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// Where a strip is that winds inwards as `u` grows, to the given radius at `length`, hanging
/// straight down where u = 0. Its radius falls with the angle, rho = rho_0 - q phi, q = pitch / 2
/// pi:
///
///   u = rho_0 phi - q phi^2 / 2,   (x, z)' = rho (sin phi, -cos phi)
Eigen::Vector3d wound_place(const Eigen::Vector3d& material, double length,
                            const scene::Start& start) {
  const double q = start.pitch_m / (2.0 * kPi);
  const auto angle_of = [q](double radius, double way) {
    // of radius phi + q phi^2 / 2 = way, in the form without a difference
    return 2.0 * way / (radius + std::sqrt(radius * radius + 2.0 * q * way));
  };
  const double all = angle_of(start.radius_m, length);
  const double phi = all - angle_of(start.radius_m, length - material.x());
  const double outer = start.radius_m + q * all;
  const double s = std::sin(phi), c = std::cos(phi);
  return {outer * (1.0 - c) - q * (s - phi * c), material.y(),
          -outer * s + q * (phi * s + c - 1.0)};
}

/// `read_m`: where a file had the nodes, or a tube has them; empty for what starts flat.
Expected<SceneBody> sheet(Expected<Cloth> made, const Eigen::Matrix3Xd& read_m,
                          const scene::Scene& scene) {
  if (!made) return tl::unexpected(made.error());
  const SurfaceMesh& mesh = made->mesh;
  SceneBody body;
  body.material_m = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  body.material_m.topRows<2>() = mesh.material_m;
  body.node_mass_kg =
      vector_of(scene.area_density_kg_m2 ? lumped_masses_kg(mesh, *scene.area_density_kg_m2)
                                         : lumped_masses_of_total_kg(mesh, *scene.mass_kg));
  Eigen::Matrix3Xd start_m = body.material_m;
  if (scene.start.place == scene::Start::Place::vertical) start_m.row(1).swap(start_m.row(2));
  if (scene.start.place == scene::Start::Place::as_meshed) start_m = read_m;
  if (scene.start.place == scene::Start::Place::wound)
    for (int node = 0; node < mesh.node_count(); ++node)
      start_m.col(node) =
          wound_place(body.material_m.col(node), mesh.material_m.row(0).maxCoeff(), scene.start);
  body.start_x = start_m.reshaped();
  body.mesh = std::move(*made);
  return body;
}

Expected<SceneBody> solid(Expected<SolidMesh> made, const scene::Scene& scene) {
  if (!made) return tl::unexpected(made.error());
  SceneBody body;
  body.coordinates = 3;
  body.material_m = made->rest_m;
  body.node_mass_kg =
      vector_of(scene.density_kg_m3 ? lumped_masses_kg(*made, *scene.density_kg_m3)
                                    : lumped_masses_of_total_kg(*made, *scene.mass_kg));
  body.start_x = made->rest_m.reshaped();
  body.mesh = std::move(*made);
  return body;
}

Diagonals diagonals_of(const std::string& word) {
  if (word == "one") return Diagonals::one;
  if (word == "other") return Diagonals::other;
  if (word == "both") return Diagonals::both;
  return Diagonals::alternating;
}

Expected<SceneBody> body_of(const scene::GridMesh& grid, const scene::Scene& scene) {
  return sheet(cloth_of_grid({grid.nodes_u, grid.nodes_v, grid.length_u_m, grid.length_v_m},
                             diagonals_of(grid.diagonals)),
               {}, scene);
}

Expected<SceneBody> body_of(const scene::TubeMesh& tube, const scene::Scene& scene) {
  auto mesh = tube_mesh({tube.nodes_around, tube.nodes_along, tube.radius_m, tube.length_m},
                        diagonals_of(tube.diagonals));
  if (!mesh) return tl::unexpected(mesh.error());
  const Eigen::Matrix3Xd round_m = rolled_m(*mesh);
  return sheet(cloth_of_mesh(std::move(*mesh)), round_m, scene);
}

Expected<SceneBody> body_of(const scene::OutlineMesh& outline, const scene::Scene& scene) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(outline.points_m.size());
  for (const scene::Vec2& p : outline.points_m) points.emplace_back(p[0], p[1]);
  auto mesh = triangulate_outline(points, outline.edge_length_m);
  if (!mesh) return tl::unexpected(mesh.error());
  return sheet(cloth_of_mesh(std::move(*mesh)), {}, scene);
}

Expected<SceneBody> body_of(const scene::BoxMesh& box, const scene::Scene& scene) {
  const Eigen::Vector3d size(box.size_m[0], box.size_m[1], box.size_m[2]);
  const auto& n = box.cells;
  return solid(box.is_tetrahedra ? box_tetrahedra(n[0], n[1], n[2], size)
                                 : box_hexahedra(n[0], n[1], n[2], size),
               scene);
}

Expected<SceneBody> body_of(const scene::FileMesh& file, const scene::Scene& scene) {
  if (file.bytes.empty()) return bad_input("the file is empty, or it was only named");
  if (file.is_msh) {
    auto read = read_msh(file.bytes, file.metres_per_unit);
    if (!read) return tl::unexpected(read.error());
    return solid(std::move(read->mesh), scene);
  }
  const auto read = mesh_text::read_surface_text(file.bytes, file.metres_per_unit);
  if (!read) return tl::unexpected(read.error());
  auto mesh = surface_mesh(*read, file.metres_per_texture_unit);
  if (!mesh) return tl::unexpected(mesh.error());
  return sheet(cloth_of_mesh(std::move(*mesh)), read->positions_m, scene);
}

}  // namespace

Expected<SceneBody> make_body(const scene::Scene& scene) {
  return about_mesh(
      std::visit([&scene](const auto& mesh) { return body_of(mesh, scene); }, scene.mesh));
}

Expected<MeshModel> bind(const model::Model& model, const SceneBody& body) {
  return std::visit([&model](const auto& mesh) { return MeshModel::make(model, mesh); }, body.mesh);
}

}  // namespace tenter::mechanics
