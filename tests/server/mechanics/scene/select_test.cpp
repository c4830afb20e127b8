// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/scene/document.h"
#include "server/mechanics/scene/body.h"

namespace tenter::mechanics {
namespace {

scene::Scene scene_of(const std::string& mesh, const std::string& nodes) {
  const bool solid = mesh.find("box") != std::string::npos;
  auto scene = scene::parse_scene(
      R"({"schema": "tenter.scene", "version": 1, "name": "s", "mass_kg": 0.3, "mesh": )" + mesh +
          (solid ? "" : R"(, "start": {"place": "vertical"})") +
          R"(, "clips": [{"id": "c", "nodes": )" + nodes + "}]}",
      "test");
  EXPECT_TRUE(scene) << scene.error().message;
  return scene.value_or(scene::Scene());
}

const char* const kGrid =
    R"({"kind": "grid", "nodes_u": 4, "nodes_v": 3, "length_u_m": 0.3, "length_v_m": 0.2})";
const char* const kBox = R"({"kind": "box", "cells": [2, 1, 1], "size_m": [0.2, 0.1, 0.1]})";

std::vector<int> chosen(const std::string& mesh, const std::string& nodes) {
  const scene::Scene scene = scene_of(mesh, nodes);
  const auto body = make_body(scene);
  EXPECT_TRUE(body);
  const auto found = select(scene.clips[0].nodes, *body);
  EXPECT_TRUE(found) << nodes;
  return found.value_or(std::vector<int>());
}

TEST(Select, NodesOfASheetByWhereTheyAre) {
  using Nodes = std::vector<int>;
  EXPECT_EQ(chosen(kGrid, R"("all")").size(), 12U);
  EXPECT_EQ(chosen(kGrid, R"("left")"), (Nodes{0, 4, 8}));
  EXPECT_EQ(chosen(kGrid, R"("right")"), (Nodes{3, 7, 11}));
  EXPECT_EQ(chosen(kGrid, R"("bottom")"), (Nodes{0, 1, 2, 3}));
  EXPECT_EQ(chosen(kGrid, R"("top_right")"), (Nodes{11}));
  EXPECT_EQ(chosen(kGrid, R"({"box_m": [[0.1, 0], [0.2, 0.1]]})"), (Nodes{1, 2, 5, 6}));
  EXPECT_EQ(chosen(kGrid, R"({"beyond": {"point_m": [0.2, 0], "direction": [5, 0]}})"),
            (Nodes{2, 3, 6, 7, 10, 11}));
  EXPECT_EQ(chosen(kGrid, "[7, 2, 2]"), (Nodes{2, 7}));
  EXPECT_EQ(chosen(kGrid, R"(["top_left", [5]])"), (Nodes{5, 8}));
  EXPECT_EQ(chosen(kGrid, R"({"of": "bottom", "without": ["left", "right"]})"), (Nodes{1, 2}));
}

TEST(Select, NodesOfABodyHaveAThirdSide) {
  using Nodes = std::vector<int>;
  EXPECT_EQ(chosen(kBox, R"("left")"), (Nodes{0, 3, 6, 9}));
  EXPECT_EQ(chosen(kBox, R"("front")"), (Nodes{0, 1, 2, 6, 7, 8}));
  EXPECT_EQ(chosen(kBox, R"("bottom")"), (Nodes{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(chosen(kBox, R"("right_back_top")"), (Nodes{11}));
}

TEST(Select, SaysWhichChoiceIsEmptyOrOutOfRange) {
  const auto complaint = [](const std::string& nodes) {
    const scene::Scene scene = scene_of(kGrid, nodes);
    const auto found = select(scene.clips[0].nodes, make_body(scene).value());
    return found ? "found" : found.error().message;
  };
  EXPECT_EQ(complaint("[12]"), "node 12 is chosen, but the mesh has nodes 0 to 11");
  EXPECT_EQ(complaint(R"(["left", [99]])"), "node 99 is chosen, but the mesh has nodes 0 to 11");
  EXPECT_EQ(complaint(R"({"box_m": [[1, 1], [2, 2]]})"), "no node of the mesh is chosen");
}

TEST(SceneBody, StandsWhereItStartsAndWeighsWhatItShould) {
  const auto sheet = make_body(scene_of(kGrid, R"("left")"));
  ASSERT_TRUE(sheet);
  EXPECT_NEAR(sheet->node_mass_kg.sum(), 0.3, 1e-15);
  EXPECT_EQ(Eigen::Vector3d(sheet->start_x.segment<3>(33)), Eigen::Vector3d(0.3, 0, 0.2));
  const auto box = make_body(scene_of(kBox, R"("left")"));
  ASSERT_TRUE(box);
  EXPECT_NEAR(box->node_mass_kg.sum(), 0.3, 1e-15);
  EXPECT_EQ(Eigen::Vector3d(box->start_x.segment<3>(33)), Eigen::Vector3d(0.2, 0.1, 0.1));
}

/// Closed, and the volume inside is that of the body, negative since normals point in.
TEST(PressedSurface, OfABodyClosesWithNormalsIntoIt) {
  for (const char* elements : {"hexahedra", "tetrahedra"}) {
    std::string mesh = kBox;
    mesh.insert(mesh.size() - 1, std::string(R"(, "elements": ")") + elements + "\"");
    const auto body = make_body(scene_of(mesh, R"("all")"));
    ASSERT_TRUE(body);
    std::vector<int> all(static_cast<std::size_t>(body->node_count()));
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
    Eigen::Vector3d area = Eigen::Vector3d::Zero();
    double volume = 0.0;
    for (const auto& t : pressed_surface(*body, all)) {
      const Eigen::Vector3d a = body->material_m.col(t[0]), b = body->material_m.col(t[1]),
                            c = body->material_m.col(t[2]);
      area += 0.5 * (b - a).cross(c - a);
      volume += a.dot(b.cross(c)) / 6.0;
    }
    EXPECT_NEAR(volume, -0.002, 1e-15) << elements;
    EXPECT_NEAR(area.norm(), 0.0, 1e-15) << elements;
  }
}

}  // namespace
}  // namespace tenter::mechanics
