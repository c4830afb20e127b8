// SPDX-License-Identifier: Apache-2.0
#include "common/scene/document.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/scene/examples.h"

namespace tenter::scene {
namespace {

using Json = nlohmann::ordered_json;

/// Every key there is, none at its default.
const char* const kFull = R"({
  "schema": "tenter.scene", "version": 1, "name": "all keys", "description": "words",
  "mesh": {"kind": "grid", "nodes_u": 5, "nodes_v": 4, "length_u_m": 0.4, "length_v_m": 0.3,
           "diagonals": "both"},
  "area_density_kg_m2": 0.2,
  "gravity_m_s2": [0, -9.8, 0],
  "start": {"place": "wound", "radius_m": 0.05, "pitch_m": 0.001, "remembered": true, "noise_m": 1e-4, "seed": 7, "gravity_factor": 0.5},
  "clips": [
    {"id": "top", "nodes": "top"},
    {"id": "bar", "nodes": {"of": "bottom", "without": ["bottom_left", [3]]}, "free": true,
     "mass_kg": 0.01, "centre_of_mass_m": [0, 0, -0.01],
     "cords": [{"id": "a", "at_m": [0.1, 0, 0], "force_N": [1, 2, 3]}]}],
  "obstacles": [{"kind": "plane", "point_m": [0, 0, -1], "normal": [0, 0, 2]},
                {"kind": "cylinder", "point_m": [0, 0, 0], "axis": [0, 1, 0], "radius_m": 0.02},
                {"kind": "sphere", "point_m": [0, 0, 1], "radius_m": 0.03}],
  "weights": [{"id": "w", "nodes": {"box_m": [[0, 0], [0.1, 0.1]]}, "mass_kg": 0.1}],
  "forces": [{"id": "f", "nodes": [0, 1], "force_N": [0, 0, 1]}],
  "pressure": {"nodes": {"beyond": {"point_m": [0.1, 0], "direction": [1, 0]}}, "pressure_Pa": 3},
  "protocol": [
    {"name": "go", "frames": 3, "duration_s": 0.5,
     "obstacles": [{"obstacle": 2, "move_m": [0, 0, -0.1]}],
     "motions": [{"clip": "top", "move_m": [0, 0, 1], "turn_rad": [1, 0, 0], "about_m": [1, 1, 1]},
                 {"clip": "top", "turn_rad": [-1, 0, 0]}],
     "cords": [{"clip": "bar", "cord": "a", "force_N": [0, 0, -1]}],
     "weights": [{"weight": "w", "mass_kg": 0.3}],
     "forces": [{"force": "f", "force_N": [1, 0, 0]}],
     "gravity_factor": 1, "pressure_Pa": 10},
    {"name": "stay", "frames": 2, "duration_s": 1}],
  "solver": {"tolerance_N": 1e-6, "max_iterations": 100, "minimiser": "relaxation",
             "check_minimum": false, "contact_depth_m": 1e-5, "most_halvings": 2},
  "dynamics": {"step_s": 0.02, "scheme": "implicit_euler", "error_m": 1e-5, "damping_s": 0.01,
               "self_contact_m": 0.001, "linearised": false, "start": "equilibrium"},
  "model": "cloth_stvk",
  "experiment": {
    "run": "whole",
    "measures": [{"id": "bend", "kind": "rms_curvature", "words": "bend", "strain": "bend_u",
                  "at": "go"},
                 {"id": "work", "kind": "work", "clip": "top", "from": "start", "at": "stay"}],
    "curves": [{"id": "pull", "kind": "force_travel", "clip": "top", "direction": [0, 0, 2]}],
    "pictures": [{"title": "end", "at": "stay", "eye": [0, -1, 0], "up": [0, 0, 1]}],
    "variants": [{"name": "twice", "pace": 2, "without_laws": ["dahl"],
                  "scene": {"start": {"noise_m": 0}, "pressure": null,
                            "protocol": [{"name": "go", "frames": 4, "duration_s": 3}]}}]}
})";

Json full() {
  return Json::parse(kFull);
}

std::string error_of(const std::string& text) {
  const auto scene = parse_scene(text, "FILE");
  if (scene) return "accepted";
  EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
  EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
  return scene.error().message;
}

/// What is said of the full scene with another value at a place.
std::string error_with(const std::string& pointer, const Json& value) {
  Json changed = full();
  changed[Json::json_pointer(pointer)] = value;
  return error_of(changed.dump());
}

TEST(SceneDocument, ReadsEveryKey) {
  const auto scene = parse_scene(kFull, "FILE");
  ASSERT_TRUE(scene) << scene.error().message;
  const auto& grid = std::get<GridMesh>(scene->mesh);
  EXPECT_EQ(grid.nodes_u * 10 + grid.nodes_v, 54);
  EXPECT_EQ(grid.length_u_m, 0.4);
  EXPECT_EQ(grid.diagonals, "both");
  EXPECT_EQ(scene->area_density_kg_m2, 0.2);
  EXPECT_EQ(scene->gravity_m_s2, (Vec3{0, -9.8, 0}));
  EXPECT_EQ(scene->start.place, Start::Place::wound);
  EXPECT_EQ(scene->start.seed, 7U);
  EXPECT_EQ(scene->start.gravity_factor, 0.5);
  ASSERT_EQ(scene->clips.size(), 2U);
  EXPECT_FALSE(scene->clips[0].is_free);
  const Clip& bar = scene->clips[1];
  EXPECT_TRUE(bar.is_free);
  EXPECT_EQ(bar.nodes.kind, Selection::Kind::without);
  EXPECT_EQ(bar.nodes.parts[1].parts[1].indices, std::vector<int>{3});
  EXPECT_EQ(bar.cords[0].force_N, (Vec3{1, 2, 3}));
  EXPECT_EQ(std::get<PlaneObstacle>(scene->obstacles[0]).normal, (Vec3{0, 0, 2}));
  EXPECT_EQ(std::get<CylinderObstacle>(scene->obstacles[1]).radius_m, 0.02);
  EXPECT_EQ(scene->weights[0].nodes.hi, (Vec3{0.1, 0.1, 0}));
  EXPECT_EQ(scene->forces[0].force_N, (Vec3{0, 0, 1}));
  EXPECT_EQ(scene->pressure->nodes.direction, (Vec3{1, 0, 0}));
  const Phase& phase = scene->protocol[0];
  EXPECT_EQ(phase.motions[0].about_m, (Vec3{1, 1, 1}));
  EXPECT_FALSE(phase.motions[1].about_m.has_value());
  EXPECT_EQ(phase.cords[0].force_N, (Vec3{0, 0, -1}));
  EXPECT_EQ(phase.weights[0].mass_kg, 0.3);
  EXPECT_EQ(phase.forces[0].force, "f");
  EXPECT_EQ(phase.gravity_factor, 1.0);
  EXPECT_EQ(phase.pressure_Pa, 10.0);
  EXPECT_EQ(scene->frame_count(), 6);
  EXPECT_EQ(scene->solver.minimiser, "relaxation");
  ASSERT_TRUE(scene->dynamics.has_value());
  EXPECT_EQ(scene->dynamics->step_s, 0.02);
  EXPECT_EQ(scene->dynamics->scheme, "implicit_euler");
  EXPECT_EQ(scene->dynamics->error_m, 1e-5);
  EXPECT_EQ(scene->dynamics->damping_s, 0.01);
  EXPECT_EQ(scene->dynamics->self_contact_m, 0.001);
  EXPECT_TRUE(scene->dynamics->from_rest);
  EXPECT_EQ(scene->protocol[0].duration_s, 0.5);
  EXPECT_EQ(scene->protocol[0].obstacles[0].obstacle, 2);
  EXPECT_EQ(std::get<SphereObstacle>(scene->obstacles[2]).radius_m, 0.03);
  EXPECT_FALSE(scene->solver.check_minimum);
  EXPECT_EQ(scene->solver.most_halvings, 2);
}

TEST(SceneDocument, ComplaintsNameFileKeyAndReason) {
  const struct {
    const char* at;
    Json value;
    const char* says;
  } cases[] = {
      {"/schema", "tenter.model", "FILE: schema: must be 'tenter.scene', not 'tenter.model'"},
      {"/version", 2, "FILE: version: this program reads version 1"},
      {"/name", "", "FILE: name: must be 1 to 200 bytes"},
      {"/extra", 1, "FILE: extra: unknown key; known here are schema,"},
      {"/mesh/kind", "sphere", "FILE: mesh.kind: is 'sphere', must be one of grid, outline, tube,"},
      {"/mesh/nodes_u", 2.5, "FILE: mesh.nodes_u: must be a whole number from 2"},
      {"/mesh/nodes_u", "many", "FILE: mesh.nodes_u: must be a number, not a string"},
      {"/mesh/length_v_m", -1, "FILE: mesh.length_v_m: is -1, must be above 0"},
      {"/mesh/diagonals", "no", "FILE: mesh.diagonals: is 'no', must be one of one, other,"},
      {"/mass_kg", 1, "FILE: mass_kg: a sheet needs either area_density_kg_m2 or mass_kg"},
      {"/area_density_kg_m2", -2, "FILE: area_density_kg_m2: is -2, must not be negative"},
      {"/gravity_m_s2", {1, 2}, "FILE: gravity_m_s2: must hold 3 numbers"},
      {"/start/place", "up", "FILE: start.place: is 'up', must be one of vertical,"},
      {"/start/place", "as_meshed", "FILE: start.place: only a tube or a mesh from a file has a"},
      {"/start/noise_m", -1, "FILE: start.noise_m: must not be negative"},
      {"/start/seed", -1, "FILE: start.seed: must be a whole number from 0"},
      {"/clips/0/id", "a b", "FILE: clips[0].id: must be 1 to 64 letters"},
      {"/clips/0/id", "bar", "FILE: clips[1].id: 'bar' is used twice"},
      {"/clips/0/nodes", "upper", "FILE: clips[0].nodes: is 'upper'; nodes are \"all\", a side"},
      {"/clips/0/nodes", "left_right", "FILE: clips[0].nodes: is 'left_right'; nodes are"},
      {"/clips/0/nodes", "front", "FILE: clips[0].nodes: is 'front'; nodes are"},
      {"/clips/0/nodes", Json::array(), "FILE: clips[0].nodes: names no nodes"},
      {"/clips/0/nodes", {1, 2.5}, "FILE: clips[0].nodes[1]: must be a whole number from 0"},
      {"/clips/0/nodes", true, "FILE: clips[0].nodes: must be a name, a list, or an object"},
      {"/clips/0/mass_kg", -1, "FILE: clips[0].mass_kg: is -1, must not be negative"},
      {"/clips/1/cords/0/at_m", "here", "FILE: clips[1].cords[0].at_m: must be a list"},
      {"/obstacles/0/normal", {0, 0, 0}, "FILE: obstacles[0].normal: has no length"},
      {"/obstacles/1/radius_m", 0, "FILE: obstacles[1].radius_m: is 0, must be above 0"},
      {"/obstacles/1/normal", {0, 0, 1}, "FILE: obstacles[1].normal: unknown key"},
      {"/weights/0/nodes/box_m/0", {0.2, 0}, "FILE: weights[0].nodes.box_m: its low end is above"},
      {"/weights/0/nodes/box_m/0", {0, 0, 0}, "FILE: weights[0].nodes.box_m[0]: must hold 2"},
      {"/forces/0/force_N/1", nullptr, "FILE: forces[0].force_N[1]: must be a number, not null"},
      {"/pressure/nodes/beyond/direction", {0, 0}, "FILE: pressure.nodes.beyond.direction: has no"},
      {"/protocol/0/frames", 0, "FILE: protocol[0].frames: must be a whole number from 1"},
      {"/protocol/1/frames", 100000, "FILE: protocol: has more than 100000 frames"},
      {"/protocol/0/motions/0/clip", "x", "FILE: protocol[0].motions[0].clip: there is no clip"},
      {"/protocol/0/motions/0/clip", "bar",
       "FILE: protocol[0].motions[0].clip: clip 'bar' is free: its cords move it"},
      {"/protocol/0/cords/0/cord", "b", "FILE: protocol[0].cords[0].cord: clip 'bar' has no cord"},
      {"/protocol/0/weights/0/weight", "v", "FILE: protocol[0].weights[0].weight: there is no"},
      {"/protocol/0/forces/0/force", "v", "FILE: protocol[0].forces[0].force: there is no force"},
      {"/solver/minimiser", "luck", "FILE: solver.minimiser: is 'luck', must be one of newton,"},
      {"/solver/tolerance_N", -1, "FILE: solver.tolerance_N: is -1, must not be negative"},
      {"/solver/most_halvings", 21, "FILE: solver.most_halvings: must be a whole number from 0"},
  };
  for (const auto& c : cases) {
    const std::string error = error_with(c.at, c.value);
    EXPECT_TRUE(error.starts_with(c.says)) << c.at << "\n  " << error << "\n  " << c.says;
  }
  Json without = full();
  without.erase("pressure");
  EXPECT_TRUE(error_of(without.dump()).starts_with("FILE: protocol[0].pressure_Pa: the scene has"));
  without = full();
  without.erase("mesh");
  EXPECT_EQ(error_of(without.dump()), "FILE: the key 'mesh' is missing");
  EXPECT_EQ(error_of("[]"), "FILE: a scene document must be a JSON object");
  EXPECT_EQ(error_of("{\n  \"schema\": ,\n}"), "FILE: is not JSON, see line 2, column 13");
  EXPECT_NE(error_of(R"({"schema": "a", "schema": "b"})").find("twice"), std::string::npos);
  EXPECT_NE(error_of(std::string(200000, '[')).find("deep"), std::string::npos);
}

TEST(SceneDocument, BodiesHaveThreeCoordinatesAndTheirOwnDensity) {
  Json box = {{"schema", "tenter.scene"}, {"version", 1}, {"name", "box"}, {"density_kg_m3", 1000}};
  box["mesh"] = {{"kind", "box"}, {"cells", {2, 2, 2}}, {"size_m", {1, 1, 1}}};
  box["clips"] = Json::array({{{"id", "wall"}, {"nodes", "back_top"}}});
  const auto scene = parse_scene(box.dump(), "FILE");
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(is_solid(scene->mesh));
  EXPECT_EQ(scene->start.place, Start::Place::as_meshed);
  box["start"]["place"] = "vertical";
  EXPECT_TRUE(error_of(box.dump()).starts_with("FILE: start.place: a body starts in its rest"));
  box.erase("start");
  box.erase("density_kg_m3");
  box["area_density_kg_m2"] = 1;
  EXPECT_TRUE(error_of(box.dump()).starts_with("FILE: area_density_kg_m2: is for sheets"));
}

TEST(SceneDocument, ShippedScenesAreSoundAndBearTheirNames) {
  ASSERT_GE(example_texts().size(), 3U);
  for (const ExampleText& text : example_texts()) {
    const auto scene = parse_scene(text.json, text.name);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->name, text.name);
    EXPECT_FALSE(scene->description.empty());
  }
  const auto unknown = example_json("ocean");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().kind, ErrorKind::not_found);
  EXPECT_NE(unknown.error().message.find("hanging_square"), std::string::npos);
}

TEST(SceneExperiment, RunsAreTheSceneAndItsVariants) {
  const auto runs = runs_of(kFull, "FILE");
  ASSERT_TRUE(runs) << runs.error().message;
  ASSERT_EQ(runs->size(), 2U);
  EXPECT_EQ((*runs)[0].name, "whole");
  EXPECT_EQ((*runs)[0].scene.frame_count(), 6);
  EXPECT_TRUE((*runs)[0].without_laws.empty());
  EXPECT_TRUE((*runs)[0].scene.pressure.has_value());
  const auto& twice = (*runs)[1];
  EXPECT_EQ(twice.name, "twice");
  EXPECT_EQ(twice.without_laws, std::vector<std::string>{"dahl"});
  EXPECT_FALSE(twice.scene.pressure.has_value());
  EXPECT_FALSE(twice.scene.experiment.has_value());
  EXPECT_EQ(twice.scene.start.noise_m, 0.0);
  EXPECT_EQ(twice.scene.start.radius_m, 0.05);  // what the patch does not name stays
  ASSERT_EQ(twice.scene.protocol.size(), 1U);
  EXPECT_EQ(*twice.scene.protocol[0].duration_s, 1.5);
  Json plain = full();
  plain.erase("experiment");
  const auto one = runs_of(plain.dump(), "FILE");
  ASSERT_TRUE(one && one->size() == 1);
  EXPECT_EQ((*one)[0].name, "");
}

TEST(SceneExperiment, SaysWhatIsWrong) {
  const std::string at = "/experiment/";
  EXPECT_NE(error_with(at + "measures/0/kind", "mood").find("measures[0].kind: is 'mood', must be"),
            std::string::npos);
  EXPECT_NE(error_with(at + "measures/0/clip", "top").find("is no key of the kind"),
            std::string::npos);
  EXPECT_NE(error_with(at + "measures/1/clip", "hand").find("there is no clip 'hand'"),
            std::string::npos);
  EXPECT_NE(error_with(at + "measures/1/at", "later").find("there is no phase 'later'"),
            std::string::npos);
  EXPECT_NE(error_with(at + "measures/1/id", "bend").find("is used twice"), std::string::npos);
  EXPECT_NE(error_with(at + "pictures/0/eye", {0, 0, 1}).find("must not point at who looks"),
            std::string::npos);
  EXPECT_NE(error_with(at + "curves/0/direction", {0, 0, 0}).find("a length"), std::string::npos);
  EXPECT_NE(error_with(at + "variants/0/name", "whole").find("is used twice"), std::string::npos);
  EXPECT_NE(error_with(at + "variants/0/pace", 0).find("must be above 0"), std::string::npos);
  EXPECT_NE(error_with(at + "variants/0/scene/start/noise_m", -1)
                .find("experiment.variants[0].scene: start.noise_m: must not"),
            std::string::npos);
  EXPECT_NE(error_with(at + "variants/0/scene/experiment", Json::object()).find("of its own"),
            std::string::npos);
}

/// All keys of the document are properties of the schema, and the other way round.
TEST(SceneDocument, TheSchemaFileKnowsTheSameKeys) {
  std::ifstream file(TENTER_SCENE_SCHEMA);
  const Json schema = Json::parse(file);
  const auto same = [](const Json& document, const Json& properties, const std::string& where) {
    for (const auto& [key, value] : document.items())
      EXPECT_TRUE(properties.contains(key)) << where << "." << key;
  };
  const Json scene = full();
  same(scene, schema["properties"], "scene");
  for (const auto& [key, value] : schema["properties"].items())
    EXPECT_TRUE(scene.contains(key) || key == "density_kg_m3" || key == "mass_kg") << key;
  for (const char* part : {"start", "pressure", "solver", "dynamics"}) {
    const Json& properties = schema["properties"][part]["properties"];
    same(scene[part], properties, part);
    EXPECT_EQ(scene[part].size(), properties.size()) << part;
  }
  const Json& experiment = schema["properties"]["experiment"]["properties"];
  same(scene["experiment"], experiment, "experiment");
  EXPECT_EQ(scene["experiment"].size(), experiment.size());
  for (const char* list : {"pictures", "variants"})
    same(scene["experiment"][list][0], experiment[list]["items"]["properties"], list);
  for (const char* list : {"measures", "curves"})
    same(scene["experiment"][list][0], schema["$defs"]["measure"]["properties"], list);
  same(scene["mesh"], schema["$defs"]["grid"]["properties"], "grid");
  same(scene["clips"][1], schema["$defs"]["clip"]["properties"], "clip");
  EXPECT_EQ(scene["clips"][1].size(), schema["$defs"]["clip"]["properties"].size());
  same(scene["protocol"][0], schema["$defs"]["phase"]["properties"], "phase");
  EXPECT_EQ(scene["protocol"][0].size(), schema["$defs"]["phase"]["properties"].size());
}

TEST(MeshFormat, IsKnownByHowAFileBegins) {
  EXPECT_EQ(mesh_format("# made by hand\n\nv 0 0 0\n"), "obj");
  EXPECT_EQ(mesh_format("mtllib a.mtl\r\nv 0 0 0\r\n"), "obj");
  EXPECT_EQ(mesh_format("ply\nformat ascii 1.0\n"), "ply");
  EXPECT_EQ(mesh_format("$MeshFormat\n4.1 0 8\n"), "msh");
  for (const char* other :
       {"", "# only words\n", "v,force\n1,2\n", "time force\n", "vertex 1\n", "\x89HDF\r\n", "f"})
    EXPECT_EQ(mesh_format(other), "") << other;
}

class SceneFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "tenter-scene-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string put(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return (folder_ / name).string();
  }
  static std::string with_mesh(const std::string& path) {
    Json scene = {{"schema", "tenter.scene"}, {"version", 1}, {"name", "read"}, {"mass_kg", 0.1}};
    scene["mesh"] = {{"kind", "file"}, {"path", path}, {"metres_per_unit", 0.001}};
    return scene.dump();
  }
  std::filesystem::path folder_;
};

TEST_F(SceneFiles, NameTheirMeshBySha256WhenTheyAreSent) {
  const std::string mesh_file = put("cloth.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto file = read_scene_file(put("a.scene.json", with_mesh("cloth.obj")));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->mesh_file, mesh_file);
  const std::string sha256(64, 'a');
  const auto scene = parse_scene(with_stored_mesh(file->text, sha256), "sent");
  ASSERT_TRUE(scene) << scene.error().message;
  const auto& mesh = std::get<FileMesh>(scene->mesh);
  EXPECT_EQ(mesh.sha256, sha256);
  EXPECT_TRUE(mesh.path.empty());
  EXPECT_FALSE(mesh.is_msh);
  EXPECT_EQ(mesh.metres_per_unit, 0.001);
}

TEST_F(SceneFiles, SayWhatIsWrongWithTheirMesh) {
  const auto complaint = [this](const std::string& path) {
    const auto file = read_scene_file(put("a.scene.json", with_mesh(path)));
    return file ? "accepted" : file.error().message;
  };
  EXPECT_NE(complaint("cloth.stl").find("mesh.path: must end in .obj, .ply or .msh"),
            std::string::npos);
  EXPECT_NE(complaint("nowhere.obj").find("nowhere.obj"), std::string::npos);
  put("table.obj", "time,force\n1,2\n");
  EXPECT_NE(complaint("table.obj").find("does not begin like a file of OBJ or PLY"),
            std::string::npos);
  put("binary.ply", "ply\nformat binary_little_endian 1.0\n");
  EXPECT_EQ(complaint("binary.ply"), "accepted");
}

}  // namespace
}  // namespace tenter::scene
