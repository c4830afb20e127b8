// SPDX-License-Identifier: Apache-2.0
#include "tests/common/report/experiment/fixture_simulation.h"

#include "common/report/json_access.h"

namespace tenter::report::fixture {

namespace {

Json run(const char* name, double bend, double size) {
  Json entry = {{"name", name}, {"completed", true}, {"reason", nullptr}};
  entry["measures"] = {{"bend", bend}, {"lost", 2e-6}, {"gone", nullptr}};
  const Json x = {{"name", "along"}, {"unit", "m"}, {"values", {0.0, 0.05, 0.1}}};
  const Json y = {{"name", "curvature"}, {"unit", "1/m"}, {"values", {1.0, bend, 3.0}}};
  entry["curves"] = Json::array({{{"id", "profile"}, {"words", "curvature"}, {"x", x}, {"y", y}}});
  Json picture = {{"title", "at rest"}, {"eye", {0, -1, 0}}, {"up", {0, 0, 1}}};
  picture["position_m"] = Json::array({{0, 0, 0}, {size, 0, 0}, {0, 0, size}});
  entry["pictures"] = Json::array({picture});
  entry["triangles"] = Json::array({{0, 1, 2}});
  return entry;
}

Json frame(double force_N) {
  return {{"frame", 0},
          {"steps", 2},
          {"iterations", 7},
          {"net_force_N", 3e-6},
          {"energies_J", {{"weft", 0.0125}, {"bend", 1.5e-5}}},
          {"reactions",
           {{"top",
             {{"position_m", {0, 0, 0}},
              {"force_N", {0, 0, force_N}},
              {"torque_N_m", {0, 0.025, 0}}}}}}};
}

}  // namespace

Json simulation() {
  const auto measure = [](const char* id, const char* words, const char* unit) {
    return Json{{"id", id}, {"words", words}, {"unit", unit}};
  };
  Json result = {{"schema", "tenter.simulation"}, {"version", 1}, {"kind", "simulate"}};
  result["scene"] = "a & b";
  result["words"] = "A strip is rolled up <tightly> and let go.";
  result["model"] = "felt";
  result["parameters"] =
      Json::array({{{"name", "bend_v.k1"}, {"value", 145.3e-7}, {"unit", "N m"}},
                   {{"name", "friction_v.tau"}, {"value", 29.9}, {"unit", "1/m"}}});
  result["completed"] = true;
  result["reason"] = nullptr;
  result["frames_asked"] = 2;
  result["nodes"] = 625;
  result["elements"] = {{"triangle", 1152}};
  result["frames"] = Json::array({frame(1.0), frame(4.75)});
  result["experiment"]["measures"] =
      Json::array({measure("bend", "rms curvature", "1/m"), measure("lost", "work", "J"),
                   measure("gone", "gone", "1")});
  result["experiment"]["runs"] =
      Json::array({run("with <friction>", 123.4, 0.1), run("without", 5.0, 0.05)});
  return result;
}

}  // namespace tenter::report::fixture
