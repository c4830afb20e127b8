// SPDX-License-Identifier: GPL-3.0-or-later
// The material of a scene: its mesh, where it starts, and the mass of its nodes.
//
//   Expected<SceneBody> body = make_body(scene);
//   auto model = bind(description, *body);
//   auto nodes = select(clip.nodes, *body);
//
// Pure functions; costs are those of mesh/.
#pragma once

#include <Eigen/Core>
#include <variant>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "common/scene/scene.h"
#include "server/mechanics/assembly/cloth.h"
#include "server/mechanics/assembly/mesh_model.h"
#include "server/mechanics/mesh/solid_mesh.h"

namespace tenter::mechanics {

struct SceneBody {
  std::variant<Cloth, SolidMesh> mesh;
  Eigen::Matrix3Xd material_m;   ///< of each node; sheets: (u, v, 0)
  Eigen::VectorXd start_x;       ///< positions before anything is held, 3 numbers a node (m)
  Eigen::VectorXd node_mass_kg;  ///< of the material alone
  int coordinates = 2;           ///< of the material: 2 sheet, 3 body

  int node_count() const { return static_cast<int>(material_m.cols()); }
};

inline Eigen::Vector3d vector3(const scene::Vec3& v) {
  return {v[0], v[1], v[2]};
}

/// bad_input: what the mesh's maker or reader says, begun with "mesh: ".
Expected<SceneBody> make_body(const scene::Scene& scene);

/// bad_input names the term that does not fit the mesh.
Expected<MeshModel> bind(const model::Model& model, const SceneBody& body);

/// Chosen nodes, in rising order. Sides and boxes take in nodes that are off by 1e-9 of the
/// material's extent. bad_input where no node is chosen or an index is out of range.
Expected<std::vector<int>> select(const scene::Selection& selection, const SceneBody& body);

/// The triangles of a sheet (of its first layer), or of the faces of a body that all of `nodes`
/// have, as a surface that a pressure pushes at: normals point the way of the push, which is along
/// the sheet's normals, or into the body.
std::vector<std::array<int, 3>> pressed_surface(const SceneBody& body,
                                                const std::vector<int>& nodes);

}  // namespace tenter::mechanics
