// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "common/base/json_node.h"
#include "common/scene/document.h"
#include "common/scene/experiment_read.h"

namespace tenter::scene {

namespace {

using Node = JsonNode;

constexpr int kMostParts = 1'000'000;  // nodes, cells: the mesh's own check is narrower

std::string list_of(std::initializer_list<std::string_view> words) {
  std::string text;
  for (const std::string_view word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

std::string one_of(const Node& node, std::initializer_list<std::string_view> words) {
  std::string word = node.text();
  if (std::find(words.begin(), words.end(), word) == words.end())
    node.refuse("is '" + word + "', must be one of " + list_of(words));
  return word;
}

Mesh read_grid(const Node& node) {
  node.expect_object({"kind", "nodes_u", "nodes_v", "length_u_m", "length_v_m", "diagonals"});
  GridMesh grid;
  grid.nodes_u = node["nodes_u"].whole(2, kMostParts);
  grid.nodes_v = node["nodes_v"].whole(2, kMostParts);
  grid.length_u_m = node["length_u_m"].number();
  grid.length_v_m = node["length_v_m"].number();
  if (node.has("diagonals"))
    grid.diagonals = one_of(node["diagonals"], {"one", "other", "alternating", "both"});
  return grid;
}

Mesh read_tube(const Node& node) {
  node.expect_object({"kind", "nodes_around", "nodes_along", "radius_m", "length_m", "diagonals"});
  TubeMesh tube;
  tube.nodes_around = node["nodes_around"].whole(4, kMostParts);
  tube.nodes_along = node["nodes_along"].whole(2, kMostParts);
  tube.radius_m = node["radius_m"].number();
  tube.length_m = node["length_m"].number();
  if (node.has("diagonals"))
    tube.diagonals = one_of(node["diagonals"], {"one", "other", "alternating", "both"});
  return tube;
}

Mesh read_outline(const Node& node) {
  node.expect_object({"kind", "points_m", "edge_length_m"});
  OutlineMesh outline;
  for (const Node& point : node["points_m"].list()) outline.points_m.push_back(point.numbers<2>());
  outline.edge_length_m = node["edge_length_m"].number();
  return outline;
}

Mesh read_box(const Node& node) {
  node.expect_object({"kind", "cells", "size_m", "elements"});
  BoxMesh box;
  const std::vector<Node> cells = node["cells"].list();
  if (cells.size() != 3) node["cells"].refuse("must hold 3 numbers");
  for (std::size_t i = 0; i < 3; ++i) box.cells[i] = cells[i].whole(1, kMostParts);
  box.size_m = node["size_m"].numbers<3>();
  if (node.has("elements"))
    box.is_tetrahedra = one_of(node["elements"], {"hexahedra", "tetrahedra"}) == "tetrahedra";
  return box;
}

Mesh read_file(const Node& node) {
  node.expect_object(
      {"kind", "path", "sha256", "format", "metres_per_unit", "metres_per_texture_unit"});
  FileMesh file;
  file.path = node.text_or("path", "");
  file.sha256 = node.text_or("sha256", "");
  if (file.path.empty() == file.sha256.empty())
    node.refuse("needs the 'path' of a file, or the 'sha256' of one that the server has");
  file.metres_per_unit = node.number_or("metres_per_unit", 1.0);
  file.metres_per_texture_unit = node.number_or("metres_per_texture_unit", 1.0);
  if (node.has("format")) {
    file.is_msh = one_of(node["format"], {"obj", "ply", "msh"}) == "msh";
    return file;
  }
  if (file.path.empty()) node.refuse("the key 'format' is missing");
  const std::size_t dot = file.path.rfind('.');
  const std::string ending = dot == std::string::npos ? "" : file.path.substr(dot + 1);
  if (ending != "obj" && ending != "ply" && ending != "msh")
    node["path"].refuse("must end in .obj, .ply or .msh, or the mesh needs a 'format'");
  file.is_msh = ending == "msh";
  return file;
}

Mesh read_mesh(const Node& node) {
  const std::string kind = one_of(node["kind"], {"grid", "outline", "tube", "box", "file"});
  if (kind == "grid") return read_grid(node);
  if (kind == "tube") return read_tube(node);
  if (kind == "outline") return read_outline(node);
  if (kind == "box") return read_box(node);
  return read_file(node);
}

/// Two numbers on a sheet, three in a body.
Vec3 read_place(const Node& node, bool solid) {
  if (solid) return node.numbers<3>();
  const Vec2 uv = node.numbers<2>();
  return {uv[0], uv[1], 0.0};
}

std::string read_side(const Node& node, bool solid) {
  std::string word = node.text();
  const std::array<std::string_view, 3> lows = {"left", solid ? "front" : "bottom", "bottom"};
  const std::array<std::string_view, 3> highs = {"right", solid ? "back" : "top", "top"};
  std::size_t from = 0;
  int axes = 0;
  while (from < word.size()) {
    const std::size_t end = std::min(word.find('_', from), word.size());
    const std::string part = word.substr(from, end - from);
    bool known = false;
    for (std::size_t axis = 0; axis < (solid ? 3u : 2u); ++axis)
      if (part == lows[axis] || part == highs[axis]) {
        known = (axes & (1 << axis)) == 0;
        axes |= 1 << axis;
      }
    if (!known)
      node.refuse("is '" + word + "'; nodes are \"all\", a side (left, right, " +
                  std::string(solid ? "front, back, " : "") +
                  "bottom, top) or a corner as bottom_left");
    from = end + 1;
  }
  return word;
}

Selection read_selection(const Node& node, bool solid) {
  Selection selection;
  if (node.is_text()) {
    if (node.text() == "all") return selection;
    selection.kind = Selection::Kind::side;
    selection.side = read_side(node, solid);
    return selection;
  }
  if (node.is_list()) {
    const std::vector<Node> parts = node.list();
    if (parts.empty()) node.refuse("names no nodes");
    if (parts.front().is_number()) {
      selection.kind = Selection::Kind::indices;
      for (const Node& index : parts) selection.indices.push_back(index.whole(0, kMostParts * 4));
      return selection;
    }
    selection.kind = Selection::Kind::any_of;
    for (const Node& part : parts) selection.parts.push_back(read_selection(part, solid));
    return selection;
  }
  if (!node.is_object())
    node.refuse("must be a name, a list, or an object with 'box_m', 'beyond' or 'of'");
  if (node.has("box_m")) {
    node.expect_object({"box_m"});
    selection.kind = Selection::Kind::box;
    const std::vector<Node> ends = node["box_m"].list();
    if (ends.size() != 2) node["box_m"].refuse("must hold two places, low and high");
    selection.lo = read_place(ends[0], solid);
    selection.hi = read_place(ends[1], solid);
  } else if (node.has("beyond")) {
    node.expect_object({"beyond"});
    node["beyond"].expect_object({"point_m", "direction"});
    selection.kind = Selection::Kind::beyond;
    selection.point = read_place(node["beyond"]["point_m"], solid);
    selection.direction = read_place(node["beyond"]["direction"], solid);
  } else {
    node.expect_object({"of", "without"});
    selection.kind = Selection::Kind::without;
    selection.parts = {read_selection(node["of"], solid), read_selection(node["without"], solid)};
  }
  return selection;
}

Clip read_clip(const Node& node, bool solid) {
  node.expect_object({"id", "nodes", "free", "mass_kg", "centre_of_mass_m", "cords"});
  Clip clip;
  clip.id = node["id"].text();
  clip.nodes = read_selection(node["nodes"], solid);
  if (node.has("free")) clip.is_free = node["free"].boolean();
  clip.mass_kg = node.number_or("mass_kg", 0.0);
  if (node.has("centre_of_mass_m")) clip.centre_of_mass_m = node["centre_of_mass_m"].numbers<3>();
  if (node.has("cords"))
    for (const Node& cord : node["cords"].list()) {
      cord.expect_object({"id", "at_m", "force_N"});
      clip.cords.push_back(
          {cord["id"].text(), cord["at_m"].numbers<3>(), cord["force_N"].numbers<3>()});
    }
  return clip;
}

Obstacle read_obstacle(const Node& node) {
  const std::string kind = one_of(node["kind"], {"plane", "cylinder", "sphere"});
  if (kind == "plane") {
    node.expect_object({"kind", "point_m", "normal"});
    return PlaneObstacle{node["point_m"].numbers<3>(), node["normal"].numbers<3>()};
  }
  if (kind == "sphere") {
    node.expect_object({"kind", "point_m", "radius_m"});
    return SphereObstacle{node["point_m"].numbers<3>(), node["radius_m"].number()};
  }
  node.expect_object({"kind", "point_m", "axis", "radius_m"});
  return CylinderObstacle{node["point_m"].numbers<3>(), node["axis"].numbers<3>(),
                          node["radius_m"].number()};
}

Start read_start(const Node& node, bool solid, Start start) {
  node.expect_object(
      {"place", "radius_m", "pitch_m", "remembered", "noise_m", "seed", "gravity_factor"});
  if (node.has("place")) {
    const std::string word =
        one_of(node["place"], {"vertical", "horizontal", "as_meshed", "wound"});
    if (solid && word != "as_meshed")
      node["place"].refuse("a body starts in its rest shape, 'as_meshed'");
    start.place = word == "vertical"     ? Start::Place::vertical
                  : word == "horizontal" ? Start::Place::horizontal
                  : word == "wound"      ? Start::Place::wound
                                         : Start::Place::as_meshed;
  }
  start.radius_m = node.number_or("radius_m", 0.0);
  start.pitch_m = node.number_or("pitch_m", 0.0);
  if (node.has("remembered")) start.is_remembered = node["remembered"].boolean();
  start.noise_m = node.number_or("noise_m", 0.0);
  if (node.has("seed")) start.seed = static_cast<std::uint32_t>(node["seed"].whole(0, 2147483647));
  start.gravity_factor = node.number_or("gravity_factor", 1.0);
  return start;
}

Motion read_motion(const Node& node) {
  node.expect_object({"clip", "move_m", "turn_rad", "about_m"});
  Motion motion;
  motion.clip = node["clip"].text();
  if (node.has("move_m")) motion.move_m = node["move_m"].numbers<3>();
  if (node.has("turn_rad")) motion.turn_rad = node["turn_rad"].numbers<3>();
  if (node.has("about_m")) motion.about_m = node["about_m"].numbers<3>();
  return motion;
}

Phase read_phase(const Node& node) {
  node.expect_object({"name", "frames", "duration_s", "motions", "obstacles", "cords", "weights",
                      "forces", "gravity_factor", "pressure_Pa"});
  Phase phase;
  phase.name = node["name"].text();
  phase.frames = node["frames"].whole(1, kMostFrames);
  if (node.has("motions"))
    for (const Node& motion : node["motions"].list()) phase.motions.push_back(read_motion(motion));
  if (node.has("duration_s")) phase.duration_s = node["duration_s"].number();
  if (node.has("obstacles"))
    for (const Node& obstacle : node["obstacles"].list()) {
      obstacle.expect_object({"obstacle", "move_m"});
      phase.obstacles.push_back(
          {obstacle["obstacle"].whole(0, kMostParts), obstacle["move_m"].numbers<3>()});
    }
  if (node.has("cords"))
    for (const Node& cord : node["cords"].list()) {
      cord.expect_object({"clip", "cord", "force_N"});
      phase.cords.push_back(
          {cord["clip"].text(), cord["cord"].text(), cord["force_N"].numbers<3>()});
    }
  if (node.has("weights"))
    for (const Node& weight : node["weights"].list()) {
      weight.expect_object({"weight", "mass_kg"});
      phase.weights.push_back({weight["weight"].text(), weight["mass_kg"].number()});
    }
  if (node.has("forces"))
    for (const Node& force : node["forces"].list()) {
      force.expect_object({"force", "force_N"});
      phase.forces.push_back({force["force"].text(), force["force_N"].numbers<3>()});
    }
  if (node.has("gravity_factor")) phase.gravity_factor = node["gravity_factor"].number();
  if (node.has("pressure_Pa")) phase.pressure_Pa = node["pressure_Pa"].number();
  return phase;
}

Solver read_solver(const Node& node) {
  node.expect_object({"tolerance_N", "max_iterations", "minimiser", "check_minimum",
                      "contact_depth_m", "most_halvings"});
  Solver solver;
  solver.tolerance_N = node.number_or("tolerance_N", solver.tolerance_N);
  if (node.has("max_iterations"))
    solver.max_iterations = node["max_iterations"].whole(1, 10'000'000);
  if (node.has("minimiser"))
    solver.minimiser = one_of(node["minimiser"], {"newton", "additive_lm", "relaxation"});
  if (node.has("check_minimum")) solver.check_minimum = node["check_minimum"].boolean();
  solver.contact_depth_m = node.number_or("contact_depth_m", solver.contact_depth_m);
  if (node.has("most_halvings")) solver.most_halvings = node["most_halvings"].whole(0, 20);
  return solver;
}

Dynamics read_dynamics(const Node& node) {
  node.expect_object(
      {"step_s", "scheme", "error_m", "damping_s", "self_contact_m", "linearised", "start"});
  Dynamics dynamics;
  dynamics.step_s = node.number_or("step_s", dynamics.step_s);
  if (node.has("scheme")) dynamics.scheme = one_of(node["scheme"], {"bdf2", "implicit_euler"});
  dynamics.error_m = node.number_or("error_m", 0.0);
  dynamics.damping_s = node.number_or("damping_s", 0.0);
  dynamics.self_contact_m = node.number_or("self_contact_m", 0.0);
  if (node.has("linearised")) dynamics.is_linearised = node["linearised"].boolean();
  if (node.has("start"))
    dynamics.from_rest = one_of(node["start"], {"as_placed", "equilibrium"}) == "equilibrium";
  return dynamics;
}

void read_loads(const Node& root, bool solid, Scene& scene) {
  if (root.has("weights"))
    for (const Node& node : root["weights"].list()) {
      node.expect_object({"id", "nodes", "mass_kg"});
      scene.weights.push_back(
          {node["id"].text(), read_selection(node["nodes"], solid), node["mass_kg"].number()});
    }
  if (root.has("forces"))
    for (const Node& node : root["forces"].list()) {
      node.expect_object({"id", "nodes", "force_N"});
      scene.forces.push_back(
          {node["id"].text(), read_selection(node["nodes"], solid), node["force_N"].numbers<3>()});
    }
  if (root.has("pressure")) {
    const Node node = root["pressure"];
    node.expect_object({"nodes", "pressure_Pa"});
    scene.pressure =
        Pressure{node.has("nodes") ? read_selection(node["nodes"], solid) : Selection{},
                 node["pressure_Pa"].number()};
  }
}

Scene read_scene(const Node& root) {
  if (!root.is_object()) root.refuse("a scene document must be a JSON object");
  if (root["schema"].text() != "tenter.scene")
    root["schema"].refuse("must be 'tenter.scene', not '" + root["schema"].text() + "'");
  if (root["version"].number() != 1)
    root["version"].refuse("this program reads version 1 of the scene document");
  root.expect_object(
      {"schema",        "version",   "name",         "description", "mesh",   "area_density_kg_m2",
       "density_kg_m3", "mass_kg",   "gravity_m_s2", "start",       "clips",  "obstacles",
       "weights",       "forces",    "pressure",     "protocol",    "solver", "dynamics",
       "model",         "experiment"});
  Scene scene;
  scene.name = root["name"].text();
  scene.description = root.text_or("description", "");
  scene.mesh = read_mesh(root["mesh"]);
  const bool solid = is_solid(scene.mesh);
  for (const auto& [key, value] :
       {std::pair{"area_density_kg_m2", &scene.area_density_kg_m2},
        std::pair{"density_kg_m3", &scene.density_kg_m3}, std::pair{"mass_kg", &scene.mass_kg}})
    if (root.has(key)) *value = root[key].number();
  if (root.has("gravity_m_s2")) scene.gravity_m_s2 = root["gravity_m_s2"].numbers<3>();
  if (solid || std::holds_alternative<TubeMesh>(scene.mesh))
    scene.start.place = Start::Place::as_meshed;
  if (root.has("start")) scene.start = read_start(root["start"], solid, scene.start);
  if (root.has("clips"))
    for (const Node& clip : root["clips"].list()) scene.clips.push_back(read_clip(clip, solid));
  if (root.has("obstacles"))
    for (const Node& obstacle : root["obstacles"].list())
      scene.obstacles.push_back(read_obstacle(obstacle));
  read_loads(root, solid, scene);
  if (root.has("protocol"))
    for (const Node& phase : root["protocol"].list()) scene.protocol.push_back(read_phase(phase));
  if (root.has("solver")) scene.solver = read_solver(root["solver"]);
  if (root.has("dynamics")) scene.dynamics = read_dynamics(root["dynamics"]);
  scene.model = root.text_or("model", "");
  if (root.has("experiment")) scene.experiment = read_experiment(root["experiment"]);
  return scene;
}

}  // namespace

Expected<Scene> parse_scene(std::string_view json_text, std::string_view source_name) {
  auto scene = read_document(json_text, source_name, kMaxDocumentBytes, read_scene);
  if (!scene) return scene;
  if (auto checked = validate(*scene); !checked)
    return fail(checked.error().kind, std::string(source_name) + ": " + checked.error().message);
  if (scene->experiment && !scene->experiment->variants.empty())
    if (auto runs = add_variants(json_text, source_name, *scene->experiment); !runs)
      return tl::unexpected(runs.error());
  return scene;
}

}  // namespace tenter::scene
