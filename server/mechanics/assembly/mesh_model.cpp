// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/mesh_model.h"

#include <cmath>
#include <map>
#include <string>

#include "common/model/catalogue.h"
#include "server/mechanics/assembly/element_group.h"
#include "server/mechanics/support.h"

namespace tenter::mechanics {
namespace {

using MembraneGroup = ElementGroup<TriangleElements, 3>;
using SpringGroup = ElementGroup<EdgeElements, 1>;
using HingeGroup = ElementGroup<HingeElements, 1>;

/// Springs that a measure of the edge domain acts on: ring and direction are in its name.
std::vector<Spring> springs_of(const std::string& measure, const Springs& springs) {
  const bool ring2 = measure.starts_with("ring2");
  std::vector<Spring> chosen;
  for (const Spring& s : ring2 ? springs.ring2 : springs.ring1) {
    const bool rises = s.angle_rad > 0.0;
    if (measure.ends_with("_u")              ? s.direction == Direction::weft
        : measure.ends_with("_v")            ? s.direction == Direction::warp
        : s.direction != Direction::diagonal ? false
        : measure.ends_with("_d1")           ? rises
        : measure.ends_with("_d2")           ? !rises
                                             : true)
      chosen.push_back(s);
  }
  return chosen;
}

std::vector<Hinge> hinges_of(const std::string& measure, const std::vector<Hinge>& hinges) {
  const Direction bend = measure.ends_with("_u")   ? Direction::weft
                         : measure.ends_with("_v") ? Direction::warp
                                                   : Direction::diagonal;
  std::vector<Hinge> chosen;
  for (const Hinge& h : hinges)
    if (h.bend == bend) chosen.push_back(h);
  return chosen;
}

/// Measure of each element times the weight of the support at its middle.
template <class Elements>
std::vector<double> supported(const Elements& elements, const Support& support,
                              const SurfaceMesh& mesh) {
  std::vector<double> measure = elements.measure;
  if (support.is_everywhere()) return measure;
  for (std::size_t e = 0; e < measure.size(); ++e) {
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const int n : elements.nodes[e])
      middle += mesh.material_m.col(n) / static_cast<double>(elements.nodes[e].size());
    measure[e] *= support.weight(middle.data());
  }
  return measure;
}

}  // namespace

Expected<MeshModel> MeshModel::make(const model::Model& model, const Cloth& cloth) {
  MeshModel result;
  result.node_count_ = cloth.mesh.node_count();
  std::map<std::string, std::shared_ptr<Group>> groups;  // by the elements that they share
  std::vector<std::shared_ptr<Group>> order;
  for (const model::Term& term : model.terms) {
    const std::string name = "term \"" + term.id + "\": ";
    const model::StrainRow* row = model::find_strain(term.strain.name);
    if (!row) return bad_input(name + "no strain measure is called \"" + term.strain.name + "\"");
    if (row->domain == model::Domain::solid)
      return bad_input(name + "\"" + term.strain.name + "\" is a strain of solids, not of cloth");
    const auto support = Support::make(model, term.support);
    if (!support) return bad_input(name + support.error().message);
    if (!support->is_everywhere() && support->dimensions() != 2)
      return bad_input(name + "the samples of its support must have two coordinates on cloth");

    const bool is_membrane = row->domain == model::Domain::membrane;
    auto& group = groups[is_membrane ? "membrane" : term.strain.name];
    GroupTerm entry;
    const auto place = [&]<class Kind>(std::shared_ptr<Kind> fresh) {
      if (!group) {
        group = fresh;
        order.push_back(group);
      }
      entry.measure = supported(static_cast<const Kind&>(*group).elements(), *support, cloth.mesh);
    };
    if (is_membrane) {
      auto strain = membrane_strain(term.strain);
      if (!strain) return bad_input(name + strain.error().message);
      entry.strain = *strain;
      place(std::make_shared<MembraneGroup>(triangle_elements(cloth.mesh)));
    } else if (row->domain == model::Domain::edge) {
      entry.strain = spring_strain();
      place(std::make_shared<SpringGroup>(
          edge_elements(springs_of(term.strain.name, cloth.springs))));
    } else {
      const std::vector<Hinge> hinges = hinges_of(term.strain.name, cloth.hinges);
      std::vector<double> rest, height;
      for (const Hinge& h : hinges) {
        rest.push_back(h.rest_angle_rad);
        height.push_back(h.height_m);
      }
      entry.strain = bending_strain(std::move(rest), height);
      place(std::make_shared<HingeGroup>(hinge_elements(hinges)));
    }
    if (entry.measure.empty())
      return bad_input(name + "this cloth has no element for \"" + term.strain.name + "\"");
    auto law = make_law(term.law, entry.strain->count());
    if (!law) return bad_input(name + law.error().message);
    entry.law = *law;
    entry.first_parameter = result.parameter_count_;
    result.parameter_count_ += entry.law->parameter_count();
    group->terms.push_back(std::move(entry));
  }
  std::vector<std::pair<int, int>> pairs;
  for (const auto& group : order) {
    const auto more = group->pairs();
    pairs.insert(pairs.end(), more.begin(), more.end());
  }
  result.matrix_ = NodeMatrix(result.node_count_, std::move(pairs));
  for (const auto& group : order) {
    group->find_slots(result.matrix_);
    result.groups_.push_back(group);
  }
  return result;
}

AssemblyStatus MeshModel::evaluate(const Eigen::VectorXd& x, const Eigen::VectorXd& parameters,
                                   const ModelOutput& output) const {
  if (output.energy) *output.energy = 0.0;
  if (output.gradient) output.gradient->setZero(3 * node_count_);
  if (output.stiffness) output.stiffness->set_zero();
  for (const auto& group : groups_) group->add(x.data(), parameters.data(), output);
  const bool finite = (!output.energy || std::isfinite(*output.energy)) &&
                      (!output.gradient || output.gradient->allFinite()) &&
                      (!output.stiffness || output.stiffness->is_finite());
  return finite ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

AssemblyStatus MeshModel::gradient_by_parameter(const Eigen::VectorXd& x,
                                                const Eigen::VectorXd& parameters,
                                                Eigen::MatrixXd& result) const {
  result.setZero(3 * node_count_, parameter_count_);
  for (const auto& group : groups_) group->add_by_parameter(x.data(), parameters.data(), result);
  return result.allFinite() ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

}  // namespace tenter::mechanics
