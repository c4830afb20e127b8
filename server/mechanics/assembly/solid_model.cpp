// SPDX-License-Identifier: GPL-3.0-or-later
// MeshModel on solids: every term on the tetrahedra and on the quadrature points of the hexahedra.
#include "server/mechanics/assembly/history/group_history.h"
#include "server/mechanics/assembly/model_builder.h"

namespace tenter::mechanics {
namespace {

using TetrahedronGroup = ElementGroup<TetrahedronElements, 6>;
using HexahedronGroup = ElementGroup<HexahedronPoints, 6>;

}  // namespace

Expected<MeshModel> MeshModel::make(const model::Model& model, const SolidMesh& mesh) {
  if (auto good = check(mesh); !good) return tl::unexpected(good.error());
  Builder builder(model, mesh.node_count());
  for (const model::Term& term : model.terms) {
    const auto site = builder.site(term, true);
    if (!site) return tl::unexpected(site.error());
    const auto strain = solid_strain(term.strain);
    if (!strain) return bad_input(name_of(term) + strain.error().message);
    auto& tetrahedra = builder.group("tetrahedra", [&] {
      return std::make_shared<TetrahedronGroup>(tetrahedron_elements(mesh),
                                                ElementKind::tetrahedron,
                                                numbers(static_cast<int>(mesh.tetrahedra.size())));
    });
    auto& points = builder.group("hexahedra", [&] {
      return std::make_shared<HexahedronGroup>(
          hexahedron_points(mesh), ElementKind::hexahedron_point,
          numbers(8 * static_cast<int>(mesh.hexahedra.size()), 8));
    });
    // a support is weighed where the energy is: at the quadrature point (thesis 4.2.6)
    const auto added = builder.add(
        term,
        {{&tetrahedra, *strain,
          weighted(tetrahedra.elements().measure, site->support,
                   middles(tetrahedra.elements(), mesh.rest_m))},
         {&points, *strain,
          weighted(points.elements().measure, site->support, hexahedron_point_places_m(mesh))}});
    if (!added) return tl::unexpected(added.error());
  }
  return builder.finish();
}

}  // namespace tenter::mechanics
