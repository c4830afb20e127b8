// SPDX-License-Identifier: GPL-3.0-or-later
// MeshModel on cloth: triangles, springs and hinges, each measure on the elements of its domain.
#include "server/mechanics/assembly/history/group_history.h"
#include "server/mechanics/assembly/model_builder.h"

namespace tenter::mechanics {
namespace {

using MembraneGroup = ElementGroup<TriangleElements, 3>;
using SpringGroup = ElementGroup<EdgeElements, 1>;
using HingeGroup = ElementGroup<HingeElements, 1>;

/// Some of the springs or hinges of a cloth, and their numbers among all.
template <class Element>
struct Chosen {
  std::vector<Element> list;
  std::vector<int> number;

  template <class Wanted>
  Chosen(const std::vector<Element>& all, Wanted wanted) {
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (!wanted(all[k])) continue;
      list.push_back(all[k]);
      number.push_back(static_cast<int>(k));
    }
  }
};

bool on_ring2(const std::string& measure) {
  return measure.starts_with("ring2");
}

/// Springs that a measure of the edge domain acts on: ring and direction are in its name.
Chosen<Spring> springs_of(const std::string& measure, const Springs& springs) {
  return {on_ring2(measure) ? springs.ring2 : springs.ring1, [&](const Spring& s) {
            const bool rises = s.angle_rad > 0.0;
            return measure.ends_with("_u")              ? s.direction == Direction::weft
                   : measure.ends_with("_v")            ? s.direction == Direction::warp
                   : s.direction != Direction::diagonal ? false
                   : measure.ends_with("_d1")           ? rises
                   : measure.ends_with("_d2")           ? !rises
                                                        : true;
          }};
}

Chosen<Hinge> hinges_of(const std::string& measure, const std::vector<Hinge>& hinges) {
  const Direction bend = measure.ends_with("_u")   ? Direction::weft
                         : measure.ends_with("_v") ? Direction::warp
                                                   : Direction::diagonal;
  return {hinges, [bend](const Hinge& h) { return h.bend == bend; }};
}

/// The elements of a term's domain and its strain on them.
Expected<MeshModel::Builder::Part> part_of(const model::Term& term, model::Domain domain,
                                           const Support& support, const Cloth& cloth,
                                           MeshModel::Builder& builder) {
  MeshModel::Builder::Part part;
  const auto place = [&](auto& group) {
    part.group = &group;
    part.measure = weighted(group.elements().measure, support,
                            middles(group.elements(), cloth.mesh.material_m));
  };
  const std::string& measure = term.strain.name;
  if (domain == model::Domain::membrane) {
    auto strain = membrane_strain(term.strain);
    if (!strain) return bad_input(name_of(term) + strain.error().message);
    part.strain = *strain;
    place(builder.group("membrane", [&] {
      return std::make_shared<MembraneGroup>(
          triangle_elements(cloth.mesh), ElementKind::triangle,
          numbers(static_cast<int>(cloth.mesh.triangles.size())));
    }));
  } else if (domain == model::Domain::edge) {
    part.strain = spring_strain();
    place(builder.group(measure, [&] {
      const Chosen<Spring> chosen = springs_of(measure, cloth.springs);
      return std::make_shared<SpringGroup>(
          edge_elements(chosen.list),
          on_ring2(measure) ? ElementKind::spring_ring2 : ElementKind::spring_ring1, chosen.number);
    }));
  } else {
    const Chosen<Hinge> chosen = hinges_of(measure, cloth.hinges);
    std::vector<double> rest, height;
    for (const Hinge& h : chosen.list) {
      rest.push_back(h.rest_angle_rad);
      height.push_back(h.height_m);
    }
    part.strain = bending_strain(std::move(rest), height);
    place(builder.group(measure, [&] {
      return std::make_shared<HingeGroup>(hinge_elements(chosen.list), ElementKind::hinge,
                                          chosen.number);
    }));
  }
  return part;
}

}  // namespace

Expected<MeshModel> MeshModel::make(const model::Model& model, const Cloth& cloth) {
  Builder builder(model, cloth.mesh.node_count());
  for (const model::Term& term : model.terms) {
    const auto site = builder.site(term, false);
    if (!site) return tl::unexpected(site.error());
    if (cloth.mesh.period_u_m > 0.0 && term.support.name == "rbf")
      return bad_input(name_of(term) + "a support has a place, which a tube has twice at its seam");
    auto part = part_of(term, site->row->domain, site->support, cloth, builder);
    if (!part) return tl::unexpected(part.error());
    if (auto added = builder.add(term, {std::move(*part)}); !added)
      return tl::unexpected(added.error());
  }
  return builder.finish();
}

}  // namespace tenter::mechanics
