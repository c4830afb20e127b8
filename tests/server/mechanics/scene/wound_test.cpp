// SPDX-License-Identifier: GPL-3.0-or-later
// Strips that start wound up, and remember it.
#include <gtest/gtest.h>

#include <cmath>

#include "common/model/presets.h"
#include "common/scene/document.h"
#include "server/mechanics/laws/dahl.h"
#include "server/mechanics/scene/run.h"

namespace tenter::mechanics {
namespace {

constexpr double kRadius_m = 0.006;

/// A strip of 60 by 3 mm without weight, wound to 6 mm and held at its outer end.
scene::Scene wound_strip(const std::string& start) {
  auto scene = scene::parse_scene(
      R"({"schema": "tenter.scene", "version": 1, "name": "strip", "mesh": {"kind": "grid",
          "nodes_u": 61, "nodes_v": 4, "length_u_m": 0.06, "length_v_m": 0.003},
          "area_density_kg_m2": 0.2, "gravity_m_s2": [0, 0, 0], "solver": {"tolerance_N": 1e-10},
          "clips": [{"id": "hand", "nodes": {"box_m": [[0, 0], [0.001, 0.003]]}}],
          "start": {"place": "wound", "radius_m": 0.006)" +
          start + "}}",
      "test");
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  return std::move(*scene);
}

TEST(WoundStart, LayersLieOnASpiralOfTheMaterialsLength) {
  for (const double pitch_m : {0.0, 0.0008}) {
    const auto body = make_body(wound_strip(", \"pitch_m\": " + std::to_string(pitch_m)));
    ASSERT_TRUE(body);
    const auto at = [&](int column) {
      return Eigen::Vector3d(body->start_x.segment<3>(3 * static_cast<Eigen::Index>(column)));
    };
    // downwards from the clamp, then around
    EXPECT_NEAR((at(1) - at(0)).normalized().z(), -1.0, 0.02);
    EXPECT_EQ(at(0).norm(), 0.0);
    double largest = 0.0;
    for (int i = 1; i <= 60; ++i) {
      const double chord = (at(i) - at(i - 1)).norm();
      EXPECT_NEAR(chord, 0.001, 2e-6);  // 1 - (h / r)^2 / 24 of the arc
      largest = std::max(largest, at(i).x());
    }
    // radius at the inner end from the circle through its last three nodes
    const Eigen::Vector3d a = at(58), b = at(59), c = at(60);
    const double area = 0.5 * (b - a).cross(c - a).norm();
    EXPECT_NEAR((b - a).norm() * (c - b).norm() * (c - a).norm() / (4.0 * area), kRadius_m,
                0.02 * kRadius_m);
    const double turns = pitch_m > 0.0 ? 1.51 : 1.59;
    EXPECT_NEAR(largest, 2.0 * kRadius_m + pitch_m * (2.0 * turns - 0.5), 0.3e-3);
  }
}

/// Layers that begin in one another cannot be kept apart; those of a spiral can.
TEST(WoundStart, ThatPassesThroughItselfIsRefused) {
  for (const bool has_pitch : {false, true}) {
    auto scene = wound_strip(has_pitch ? R"(, "pitch_m": 0.0008)" : "");
    scene.dynamics.emplace().self_contact_m = 0.0003;
    auto run = SceneRun::make(scene, model::preset("doublecloth").value());
    ASSERT_TRUE(run) << run.error().message;
    const auto end = run->walk({});
    ASSERT_TRUE(end) << end.error().message;
    EXPECT_EQ(end->how == SceneEnd::How::complete, has_pitch) << end->reason;
    EXPECT_EQ(end->reason.find("goes through itself at its start") != std::string::npos, !has_pitch)
        << end->reason;
  }
}

/// Without weight every hinge comes to rest where its stiffness and its friction are in balance.
TEST(WoundStart, WhatIsRememberedStaysBent) {
  const auto model = model::preset("doublecloth").value();
  const auto rest_strains = [&](const std::string& start) {
    auto run = SceneRun::make(wound_strip(start), model);
    EXPECT_TRUE(run);
    std::vector<double> strains;
    const auto end =
        run->walk({[&](const SceneFrame& frame) {
                     for (const TermStrains& s : frame.strains)
                       if (model.terms[static_cast<std::size_t>(s.term)].id == "bend_weft")
                         for (const double eps : s.strain) strains.push_back(std::abs(eps));
                   },
                   {}});
    EXPECT_TRUE(end && end->how == SceneEnd::How::complete) << (end ? end->reason : "");
    std::sort(strains.begin(), strains.end());
    return strains;
  };
  const double friction[] = {12.84e-4, 0.05e-4, 0.0, 7.67};
  const double k1 = 62.19e-7, k2 = 0.07e-7;
  const double wound = 3.0 / kRadius_m;
  const double held = dahl_step(0.0, 0.0, wound, friction).stress;
  double low = 0.0, high = wound;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const double stress =
        (k1 + k2 * middle) * middle + dahl_step(wound, held, middle, friction).stress;
    (stress > 0.0 ? high : low) = middle;
  }
  ASSERT_GT(low, 50.0);
  ASSERT_LT(low, 0.9 * wound);
  const std::vector<double> kept = rest_strains(", \"remembered\": true");
  ASSERT_GT(kept.size(), 100U);
  EXPECT_NEAR(kept[kept.size() / 2], low, 1e-3 * low);
  // never wound: brought from flat to its first rest, flat
  EXPECT_LT(rest_strains("").back(), 1e-3 * low);
}

}  // namespace
}  // namespace tenter::mechanics
