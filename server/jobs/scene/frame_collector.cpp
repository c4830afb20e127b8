// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/scene/frame_collector.h"

#include <cstdio>
#include <string>
#include <utility>

#include "common/model/document.h"

namespace tenter::jobs {
namespace {

using frames::Elements;
using mechanics::ElementKind;

const char* name_of(ElementKind kind) {
  switch (kind) {
    case ElementKind::triangle:
      return "triangle";
    case ElementKind::spring_ring1:
      return "spring_ring1";
    case ElementKind::spring_ring2:
      return "spring_ring2";
    case ElementKind::hinge:
      return "hinge";
    case ElementKind::tetrahedron:
      return "tetrahedron";
    case ElementKind::hexahedron_point:
      return "hexahedron";
  }
  return "";
}

template <std::size_t N>
Elements elements_of(const char* kind, const std::vector<std::array<int, N>>& list) {
  Elements elements{kind, static_cast<int>(N), {}};
  for (const auto& element : list)
    elements.nodes.insert(elements.nodes.end(), element.begin(), element.end());
  return elements;
}

Elements elements_of(const char* kind, const std::vector<mechanics::Spring>& list) {
  Elements elements{kind, 2, {}};
  for (const mechanics::Spring& spring : list) {
    elements.nodes.push_back(spring.a);
    elements.nodes.push_back(spring.b);
  }
  return elements;
}

Elements elements_of(const char* kind, const std::vector<mechanics::Hinge>& list) {
  Elements elements{kind, 4, {}};
  for (const mechanics::Hinge& hinge : list)
    elements.nodes.insert(elements.nodes.end(), hinge.nodes.begin(), hinge.nodes.end());
  return elements;
}

template <class Vector>
void append(std::vector<double>& list, const Vector& values) {
  list.insert(list.end(), values.data(), values.data() + values.size());
}

}  // namespace

FrameCollector::FrameCollector(const mechanics::SceneRun& run, const model::Model& model)
    : model_(model), frames_asked_(run.scene().frame_count()) {
  const mechanics::SceneBody& body = run.body();
  set_.title = run.scene().name + " with " + model.name;
  set_.model_json = model::write_model(model);
  set_.nodes = body.node_count();
  set_.coordinates = body.coordinates;
  for (int node = 0; node < set_.nodes; ++node)
    for (int c = 0; c < set_.coordinates; ++c) set_.material_m.push_back(body.material_m(c, node));

  const auto add_elements = [this](ElementKind kind, Elements elements) {
    element_count_[kind] = elements.count();
    set_.elements.push_back(std::move(elements));
  };
  if (const auto* cloth = std::get_if<mechanics::Cloth>(&body.mesh)) {
    add_elements(ElementKind::triangle, elements_of("triangle", cloth->mesh.triangles));
    add_elements(ElementKind::hinge, elements_of("hinge", cloth->hinges));
    add_elements(ElementKind::spring_ring1, elements_of("spring_ring1", cloth->springs.ring1));
    add_elements(ElementKind::spring_ring2, elements_of("spring_ring2", cloth->springs.ring2));
  } else {
    const auto& solid = std::get<mechanics::SolidMesh>(body.mesh);
    add_elements(ElementKind::tetrahedron, elements_of("tetrahedron", solid.tetrahedra));
    add_elements(ElementKind::hexahedron_point, elements_of("hexahedron", solid.hexahedra));
  }
  for (const scene::Phase& phase : run.scene().protocol) set_.phases.push_back(phase.name);
  for (const scene::Clip& clip : run.scene().clips) {
    set_.clips.push_back(clip.id);
    for (const scene::Cord& cord : clip.cords) set_.cords.push_back(clip.id + "." + cord.id);
  }
  for (const model::Term& term : model.terms) set_.terms.push_back(term.id);
}

void FrameCollector::begin_strains(const std::vector<mechanics::TermStrains>& strains) {
  for (const mechanics::TermStrains& from : strains) {
    const model::Term& term = model_.terms[static_cast<std::size_t>(from.term)];
    frames::StrainSeries series{term.id, term.strain.name, name_of(from.kind), "1", {}, {}};
    series.values.resize(static_cast<std::size_t>(from.strains));
    if (from.kind == ElementKind::hinge) series.unit = "1/m";
    series.share.assign(static_cast<std::size_t>(element_count_.at(from.kind)), 0.0);
    for (std::size_t e = 0; e < from.element.size(); ++e)
      series.share[static_cast<std::size_t>(from.element[e])] += from.measure[e];
    set_.strains.push_back(std::move(series));
  }
}

/// An element's strain is the mean of its entries, weighed by what they stand for.
void FrameCollector::add_strains(const std::vector<mechanics::TermStrains>& strains) {
  for (std::size_t i = 0; i < strains.size(); ++i) {
    const mechanics::TermStrains& from = strains[i];
    frames::StrainSeries& series = set_.strains[i];
    const auto count = static_cast<std::size_t>(from.strains);
    const std::size_t begin = series.values.front().size();
    for (std::vector<double>& values : series.values) values.resize(begin + series.share.size());
    for (std::size_t e = 0; e < from.element.size(); ++e) {
      const auto element = static_cast<std::size_t>(from.element[e]);
      if (series.share[element] <= 0.0) continue;
      const double part = from.measure[e] / series.share[element];
      for (std::size_t k = 0; k < count; ++k)
        series.values[k][begin + element] += part * from.strain[e * count + k];
    }
  }
}

Expected<void> FrameCollector::add(const mechanics::SceneFrame& frame) {
  if (set_.frame_count() == 0) {
    begin_strains(frame.strains);
    double numbers = (frame.instant ? 6.0 : 3.0) * set_.nodes;
    for (const frames::StrainSeries& s : set_.strains)
      numbers += static_cast<double>(s.share.size()) * s.strains();
    if (const double bytes = 8.0 * numbers * frames_asked_; bytes > kMostFrameBytes) {
      char words[160];
      std::snprintf(words, sizeof words,
                    "scene: %d frames of this mesh and model would be %.1f GB, more than the "
                    "allowed %.1f GB",
                    frames_asked_, 1e-9 * bytes, 1e-9 * kMostFrameBytes);
      return bad_input(words);
    }
  }
  set_.phase.push_back(frame.phase);
  set_.phase_share.push_back(frame.share);
  set_.steps.push_back(frame.steps);
  set_.iterations.push_back(frame.iterations);
  set_.factorisations.push_back(frame.factorisations);
  set_.stability.push_back(frame.stability == mechanics::Stability::minimum   ? 0
                           : frame.stability == mechanics::Stability::neutral ? 1
                                                                              : 2);
  set_.net_force_N.push_back(frame.net_force_N);
  set_.contact_violation_m.push_back(frame.contact_violation_m);
  set_.limit_violation.push_back(frame.limit_violation);
  set_.gravity_factor.push_back(frame.levels.gravity_factor);
  set_.pressure_Pa.push_back(frame.levels.pressure_Pa);
  set_.potential_J.push_back(frame.energy_J);
  append(set_.position_m, frame.state.x);
  if (frame.instant) {
    set_.time_s.push_back(frame.instant->time_s);
    set_.kinetic_J.push_back(frame.instant->kinetic_J);
    set_.step_error_m.push_back(frame.instant->error_m);
    append(set_.velocity_m_s, frame.instant->velocity_m_s);
  }
  for (std::size_t c = 0; c < frame.reactions.size(); ++c) {
    const mechanics::Pose& pose = frame.state.clips[c];
    append(set_.clip_position_m, pose.position_m);
    append(set_.clip_rotation, Eigen::Matrix3d(pose.rotation.transpose()));  // row by row
    append(set_.force_N, frame.reactions[c].force_N);
    append(set_.torque_N_m, frame.reactions[c].torque_N_m);
    for (const Eigen::Vector3d& force : frame.levels.cord_force_N[c])
      append(set_.cord_force_N, force);
  }
  append(set_.term_energy_J, frame.term_energies_J);
  add_strains(frame.strains);
  return {};
}

}  // namespace tenter::jobs
