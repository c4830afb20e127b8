// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <set>

#include "common/base/sha256.h"
#include "common/scene/document.h"
#include "common/scene/experiment_read.h"

namespace tenter::scene {

namespace {

std::string words_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

std::string at(const std::string& list, std::size_t index) {
  return list + "[" + std::to_string(index) + "]";
}

/// The first thing that is wrong; later ones are not of interest.
class Check {
 public:
  void that(bool good, const std::string& path, const std::string& reason) {
    if (!good && trouble_.empty()) trouble_ = path + ": " + reason;
  }
  void finite(double value, const std::string& path) {
    that(std::isfinite(value), path, "must be a finite number");
  }
  void finite(const Vec3& value, const std::string& path) {
    for (const double v : value) finite(v, path);
  }
  void positive(double value, const std::string& path) {
    that(std::isfinite(value) && value > 0.0, path, "is " + words_of(value) + ", must be above 0");
  }
  void not_negative(double value, const std::string& path) {
    that(std::isfinite(value) && value >= 0.0, path,
         "is " + words_of(value) + ", must not be negative");
  }
  void direction(const Vec3& value, const std::string& path) {
    finite(value, path);
    that(std::hypot(value[0], value[1], value[2]) > 0.0, path, "has no length");
  }
  /// Names for people and for HDF5 paths.
  void identifier(const std::string& text, const std::string& path) {
    bool good = !text.empty() && text.size() <= 64;
    for (const char c : text)
      good = good && ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      c == '_' || c == '-');
    that(good, path, "must be 1 to 64 letters, digits, '_' or '-'");
  }
  void one_line(const std::string& text, const std::string& path) {
    bool good = !text.empty() && text.size() <= 200;
    for (const char c : text) good = good && static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
    that(good, path, "must be 1 to 200 bytes of text without line feeds");
  }
  Expected<void> result() const {
    if (trouble_.empty()) return {};
    return bad_input(trouble_);
  }

 private:
  std::string trouble_;
};

void check_mesh(const Mesh& mesh, Check& check) {
  if (const auto* grid = std::get_if<GridMesh>(&mesh)) {
    check.positive(grid->length_u_m, "mesh.length_u_m");
    check.positive(grid->length_v_m, "mesh.length_v_m");
  } else if (const auto* tube = std::get_if<TubeMesh>(&mesh)) {
    check.positive(tube->radius_m, "mesh.radius_m");
    check.positive(tube->length_m, "mesh.length_m");
  } else if (const auto* outline = std::get_if<OutlineMesh>(&mesh)) {
    check.that(outline->points_m.size() >= 3, "mesh.points_m", "an outline needs three points");
    for (std::size_t i = 0; i < outline->points_m.size(); ++i)
      for (const double v : outline->points_m[i]) check.finite(v, at("mesh.points_m", i));
    check.positive(outline->edge_length_m, "mesh.edge_length_m");
  } else if (const auto* box = std::get_if<BoxMesh>(&mesh)) {
    for (const double v : box->size_m) check.positive(v, "mesh.size_m");
  } else if (const auto* file = std::get_if<FileMesh>(&mesh)) {
    check.positive(file->metres_per_unit, "mesh.metres_per_unit");
    check.positive(file->metres_per_texture_unit, "mesh.metres_per_texture_unit");
    check.that(file->sha256.empty() || is_sha256(file->sha256), "mesh.sha256",
               "must be a SHA-256 in 64 lower-case hex digits");
  }
}

void check_selection(const Selection& selection, const std::string& path, Check& check) {
  check.finite(selection.lo, path + ".box_m");
  check.finite(selection.hi, path + ".box_m");
  for (std::size_t i = 0; i < 3; ++i)
    check.that(selection.lo[i] <= selection.hi[i], path + ".box_m",
               "its low end is above its high");
  if (selection.kind == Selection::Kind::beyond) {
    check.finite(selection.point, path + ".beyond.point_m");
    check.direction(selection.direction, path + ".beyond.direction");
  }
  const bool listed = selection.kind == Selection::Kind::any_of;
  for (std::size_t i = 0; i < selection.parts.size(); ++i)
    check_selection(selection.parts[i], listed ? at(path, i) : path + (i == 0 ? ".of" : ".without"),
                    check);
}

void check_mass(const Scene& scene, Check& check) {
  const bool solid = is_solid(scene.mesh);
  const int given = static_cast<int>(scene.area_density_kg_m2.has_value()) +
                    static_cast<int>(scene.density_kg_m3.has_value()) +
                    static_cast<int>(scene.mass_kg.has_value());
  check.that(given == 1, "mass_kg",
             solid ? "a body needs either density_kg_m3 or mass_kg"
                   : "a sheet needs either area_density_kg_m2 or mass_kg");
  if (scene.area_density_kg_m2) {
    check.that(!solid, "area_density_kg_m2", "is for sheets; a body has density_kg_m3");
    check.not_negative(*scene.area_density_kg_m2, "area_density_kg_m2");
  }
  if (scene.density_kg_m3) {
    check.that(solid, "density_kg_m3", "is for bodies; a sheet has area_density_kg_m2");
    check.not_negative(*scene.density_kg_m3, "density_kg_m3");
  }
  if (scene.mass_kg) check.not_negative(*scene.mass_kg, "mass_kg");
  check.finite(scene.gravity_m_s2, "gravity_m_s2");
}

void check_clip(const Clip& clip, const std::string& path, Check& check) {
  check.identifier(clip.id, path + ".id");
  check_selection(clip.nodes, path + ".nodes", check);
  check.not_negative(clip.mass_kg, path + ".mass_kg");
  check.finite(clip.centre_of_mass_m, path + ".centre_of_mass_m");
  std::set<std::string> ids;
  for (std::size_t i = 0; i < clip.cords.size(); ++i) {
    const std::string cord = at(path + ".cords", i);
    check.identifier(clip.cords[i].id, cord + ".id");
    check.that(ids.insert(clip.cords[i].id).second, cord + ".id", "is used twice");
    check.finite(clip.cords[i].at_m, cord + ".at_m");
    check.finite(clip.cords[i].force_N, cord + ".force_N");
  }
}

void check_start(const Scene& scene, Check& check) {
  const Start& start = scene.start;
  check.that(std::isfinite(start.noise_m) && start.noise_m >= 0.0, "start.noise_m",
             "must not be negative");
  check.finite(start.gravity_factor, "start.gravity_factor");
  const bool is_tube = std::holds_alternative<TubeMesh>(scene.mesh);
  check.that(start.place != Start::Place::as_meshed || is_solid(scene.mesh) || is_tube ||
                 std::holds_alternative<FileMesh>(scene.mesh),
             "start.place", "only a tube or a mesh from a file has a place of its own");
  check.that(start.place == Start::Place::as_meshed || !is_tube, "start.place",
             "a tube starts round, 'as_meshed'");
  const bool is_wound = start.place == Start::Place::wound;
  if (is_wound) check.positive(start.radius_m, "start.radius_m");
  check.that(is_wound || start.radius_m == 0.0, "start.radius_m", "is for what is 'wound'");
  check.not_negative(start.pitch_m, "start.pitch_m");
  check.that(is_wound || start.pitch_m == 0.0, "start.pitch_m", "is for what is 'wound'");
}

void check_boundary(const Scene& scene, Check& check) {
  std::set<std::string> ids;
  for (std::size_t i = 0; i < scene.clips.size(); ++i) {
    check_clip(scene.clips[i], at("clips", i), check);
    check.that(ids.insert(scene.clips[i].id).second, at("clips", i) + ".id",
               "'" + scene.clips[i].id + "' is used twice");
  }
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const std::string path = at("obstacles", i);
    if (const auto* plane = std::get_if<PlaneObstacle>(&scene.obstacles[i])) {
      check.finite(plane->point_m, path + ".point_m");
      check.direction(plane->normal, path + ".normal");
    } else if (const auto* cylinder = std::get_if<CylinderObstacle>(&scene.obstacles[i])) {
      check.finite(cylinder->point_m, path + ".point_m");
      check.direction(cylinder->axis, path + ".axis");
      check.positive(cylinder->radius_m, path + ".radius_m");
    } else if (const auto* sphere = std::get_if<SphereObstacle>(&scene.obstacles[i])) {
      check.finite(sphere->point_m, path + ".point_m");
      check.positive(sphere->radius_m, path + ".radius_m");
    }
  }
}

void check_loads(const Scene& scene, Check& check) {
  std::set<std::string> ids;
  for (std::size_t i = 0; i < scene.weights.size(); ++i) {
    const std::string path = at("weights", i);
    check.identifier(scene.weights[i].id, path + ".id");
    check.that(ids.insert(scene.weights[i].id).second, path + ".id", "is used twice");
    check_selection(scene.weights[i].nodes, path + ".nodes", check);
    check.not_negative(scene.weights[i].mass_kg, path + ".mass_kg");
  }
  ids.clear();
  for (std::size_t i = 0; i < scene.forces.size(); ++i) {
    const std::string path = at("forces", i);
    check.identifier(scene.forces[i].id, path + ".id");
    check.that(ids.insert(scene.forces[i].id).second, path + ".id", "is used twice");
    check_selection(scene.forces[i].nodes, path + ".nodes", check);
    check.finite(scene.forces[i].force_N, path + ".force_N");
  }
  if (scene.pressure) {
    check_selection(scene.pressure->nodes, "pressure.nodes", check);
    check.finite(scene.pressure->pressure_Pa, "pressure.pressure_Pa");
  }
}

const Clip* find_clip(const Scene& scene, const std::string& id) {
  for (const Clip& clip : scene.clips)
    if (clip.id == id) return &clip;
  return nullptr;
}

template <class List>
bool has_id(const List& list, const std::string& id) {
  for (const auto& entry : list)
    if (entry.id == id) return true;
  return false;
}

void check_phase(const Phase& phase, const Scene& scene, const std::string& path, Check& check) {
  check.one_line(phase.name, path + ".name");
  if (scene.dynamics)
    check.that(phase.duration_s.has_value(), path, "a motion needs the phase's 'duration_s'");
  else
    check.that(!phase.duration_s.has_value(), path + ".duration_s",
               "equilibria take no time: it is for a scene with 'dynamics'");
  if (phase.duration_s) check.positive(*phase.duration_s, path + ".duration_s");
  for (std::size_t i = 0; i < phase.obstacles.size(); ++i) {
    const std::string here = at(path + ".obstacles", i);
    check.that(scene.dynamics.has_value(), here, "obstacles move in a scene with 'dynamics' only");
    check.that(phase.obstacles[i].obstacle < static_cast<int>(scene.obstacles.size()),
               here + ".obstacle", "the scene has no obstacle of this number");
    check.finite(phase.obstacles[i].move_m, here + ".move_m");
  }
  for (std::size_t i = 0; i < phase.motions.size(); ++i) {
    const Motion& motion = phase.motions[i];
    const std::string here = at(path + ".motions", i);
    const Clip* clip = find_clip(scene, motion.clip);
    check.that(clip != nullptr, here + ".clip", "there is no clip '" + motion.clip + "'");
    check.that(clip == nullptr || !clip->is_free, here + ".clip",
               "clip '" + motion.clip + "' is free: its cords move it, not the protocol");
    check.finite(motion.move_m, here + ".move_m");
    check.finite(motion.turn_rad, here + ".turn_rad");
    if (motion.about_m) check.finite(*motion.about_m, here + ".about_m");
  }
  for (std::size_t i = 0; i < phase.cords.size(); ++i) {
    const std::string here = at(path + ".cords", i);
    const Clip* clip = find_clip(scene, phase.cords[i].clip);
    check.that(clip != nullptr, here + ".clip", "there is no clip '" + phase.cords[i].clip + "'");
    check.that(clip == nullptr || has_id(clip->cords, phase.cords[i].cord), here + ".cord",
               "clip '" + phase.cords[i].clip + "' has no cord '" + phase.cords[i].cord + "'");
    check.finite(phase.cords[i].force_N, here + ".force_N");
  }
  for (std::size_t i = 0; i < phase.weights.size(); ++i) {
    const std::string here = at(path + ".weights", i);
    check.that(has_id(scene.weights, phase.weights[i].weight), here + ".weight",
               "there is no weight '" + phase.weights[i].weight + "'");
    check.not_negative(phase.weights[i].mass_kg, here + ".mass_kg");
  }
  for (std::size_t i = 0; i < phase.forces.size(); ++i) {
    const std::string here = at(path + ".forces", i);
    check.that(has_id(scene.forces, phase.forces[i].force), here + ".force",
               "there is no force '" + phase.forces[i].force + "'");
    check.finite(phase.forces[i].force_N, here + ".force_N");
  }
  if (phase.gravity_factor) check.finite(*phase.gravity_factor, path + ".gravity_factor");
  if (phase.pressure_Pa) {
    check.that(scene.pressure.has_value(), path + ".pressure_Pa",
               "the scene has no 'pressure' that could change");
    check.finite(*phase.pressure_Pa, path + ".pressure_Pa");
  }
}

void check_solver(const Solver& solver, Check& check) {
  check.not_negative(solver.tolerance_N, "solver.tolerance_N");
  check.positive(solver.contact_depth_m, "solver.contact_depth_m");
}

void check_dynamics(const Scene& scene, Check& check) {
  const Dynamics& dynamics = *scene.dynamics;
  check.not_negative(dynamics.self_contact_m, "dynamics.self_contact_m");
  check.that(dynamics.self_contact_m == 0.0 || !is_solid(scene.mesh), "dynamics.self_contact_m",
             "is for sheets");
  check.that(dynamics.self_contact_m == 0.0 || !dynamics.is_linearised, "dynamics.linearised",
             "linearised steps cannot keep a sheet from passing through itself");
  check.positive(dynamics.step_s, "dynamics.step_s");
  check.not_negative(dynamics.error_m, "dynamics.error_m");
  check.not_negative(dynamics.damping_s, "dynamics.damping_s");
}

}  // namespace

bool is_solid(const Mesh& mesh) {
  if (std::holds_alternative<BoxMesh>(mesh)) return true;
  const auto* file = std::get_if<FileMesh>(&mesh);
  return file != nullptr && file->is_msh;
}

int Scene::frame_count() const {
  int count = 1;
  for (const Phase& phase : protocol) count += phase.frames;
  return count;
}

Expected<void> validate(const Scene& scene) {
  Check check;
  check.one_line(scene.name, "name");
  check_mesh(scene.mesh, check);
  check_mass(scene, check);
  check_start(scene, check);
  check_boundary(scene, check);
  check_loads(scene, check);
  long long frames = 1;
  for (std::size_t i = 0; i < scene.protocol.size(); ++i) {
    check_phase(scene.protocol[i], scene, at("protocol", i), check);
    frames += scene.protocol[i].frames;
  }
  check.that(frames <= kMostFrames, "protocol",
             "has more than " + std::to_string(kMostFrames) + " frames");
  check_solver(scene.solver, check);
  if (scene.dynamics) check_dynamics(scene, check);
  if (!scene.model.empty()) check.one_line(scene.model, "model");
  if (auto sound = check.result(); !sound || !scene.experiment) return sound;
  return check_experiment(scene);
}

}  // namespace tenter::scene
