// SPDX-License-Identifier: Apache-2.0
#include "tests/common/report/sheet/fixture_sheet.h"

#include <cmath>
#include <random>
#include <string>

#include "common/model/document.h"
#include "common/model/presets.h"
#include "common/report/json_access.h"

namespace tenter::report::fixture {

namespace {

constexpr const char* kRoles[] = {"stretch_u", "stretch_v", "shear", "bend_u", "evaluation"};

std::string sheet_id(int index) {
  return std::string(63, 'b') + static_cast<char>('0' + index);
}

Json errors(double sigma, double before, double after) {
  return {{"rows", 40},
          {"sigma", sigma},
          {"rms_before", before},
          {"rms_after", after},
          {"before_sigmas", before / sigma},
          {"after_sigmas", after / sigma}};
}

Json capture(int index) {
  const bool bends = index == 3;
  const bool held_out = index == 4;
  Json dropped = Json::array();
  if (index == 2) dropped.push_back({{"frame", 17}, {"reason", "no stable equilibrium was found"}});
  return {{"id", sheet_id(index)},
          {"title", std::string("FIXTURE wool, ") + kRoles[index]},
          {"synthetic", index == 1},
          {"specimen", "swatch 18"},
          {"material", "wool blend"},
          {"licence", "CC-BY-4.0"},
          {"role", kRoles[index]},
          {"held_out", held_out},
          {"weight", 1.0},
          {"frames", 40 - index},
          {"dropped", dropped},
          {"points", 625},
          {"rows", 75040},
          {"notes", Json::array({"31 of 656 vertices lie under clips and were not compared"})},
          {"force", bends ? Json(nullptr) : errors(0.003, 0.041, held_out ? 0.0062 : 0.0033)},
          {"position", errors(7.5e-5, 4.1e-4, held_out ? 1.2e-4 : 8.1e-5)}};
}

Json curve(const char* term, double stiffness, bool with_band) {
  Json strain = Json::array(), start = Json::array(), stress = Json::array();
  Json lo = Json::array(), hi = Json::array();
  for (int i = 0; i <= 40; ++i) {
    const double e = 0.005 * i;
    const double s = stiffness * e * (1.0 + 8.0 * e);
    strain.push_back(e);
    start.push_back(1.4 * stiffness * e);
    stress.push_back(s);
    lo.push_back(with_band ? Json(s * (0.97 - e)) : Json(nullptr));
    hi.push_back(with_band ? Json(s * (1.03 + e)) : Json(nullptr));
  }
  return {{"term", term},
          {"law", "spline_stiffness"},
          {"x", {{"name", "strain"}, {"unit", "1"}}},
          {"y", {{"name", "stress"}, {"unit", "N/m"}}},
          {"strain", strain},
          {"start", start},
          {"stress", stress},
          {"lo", lo},
          {"hi", hi},
          {"reached", {0.0, 0.13}},
          {"control_points", 3}};
}

Json loop(int index) {
  Json figure = {{"kind", "loop"},
                 {"capture", sheet_id(index)},
                 {"title", "Force of clip left"},
                 {"x", {{"name", "displacement"}, {"unit", "m"}}},
                 {"y", {{"name", "force"}, {"unit", "N"}}},
                 {"series", Json::array()}};
  for (const char* role : {"measured", "baseline", "extended"}) {
    Json x = Json::array(), y = Json::array();
    for (int i = 0; i <= 30; ++i) {
      x.push_back(0.0004 * i);
      y.push_back(0.05 * i * (1.0 + 0.02 * i) * (role[0] == 'b' ? 1.3 : 1.0));
    }
    figure["series"].push_back(
        {{"name", role}, {"role", role}, {"block", 0}, {"branch", "load"}, {"x", x}, {"y", y}});
  }
  return figure;
}

/// A square that sags, seen from the side as much as from above.
Json mesh(int index, const char* why) {
  constexpr int kNodes = 9;
  std::mt19937 random(static_cast<unsigned>(7 + index));
  std::normal_distribution<double> noise(0.0, 4e-5);
  Json position = Json::array(), residual = Json::array(), triangles = Json::array();
  Json arrows = Json::array();
  for (int j = 0; j < kNodes; ++j)
    for (int i = 0; i < kNodes; ++i) {
      const double x = 0.0125 * i;
      const double y = 0.0125 * j;
      const Json at = {x, y, -4.0 * x * (0.1 - x)};
      position.push_back(at);
      const double dz = 1.5e-3 * std::sin(31.4 * x) * (1.0 + index) + noise(random);
      residual.push_back(i == 0 ? Json(nullptr) : Json(std::abs(dz)));
      if (i % 2 == 1) arrows.push_back({{"at_m", at}, {"residual_m", {0.3 * dz, dz, 0.0}}});
    }
  for (int j = 0; j + 1 < kNodes; ++j)
    for (int i = 0; i + 1 < kNodes; ++i) {
      const int a = j * kNodes + i;
      triangles.push_back({a, a + 1, a + kNodes + 1});
      triangles.push_back({a, a + kNodes + 1, a + kNodes});
    }
  return {{"capture", sheet_id(index)}, {"title", std::string("FIXTURE wool, ") + kRoles[index]},
          {"frame", 12 + index},        {"why", why},
          {"triangles", triangles},     {"position_m", position},
          {"residual_m", residual},     {"sigma_m", 7.5e-5},
          {"arrows", arrows},           {"rms_m", 9.4e-5}};
}

Json stage(const char* name, const char* term, double before, double after, bool done) {
  return {{"name", name},
          {"terms", Json::array({term})},
          {"done", done},
          {"message", done ? "" : "FIXTURE no sequence"},
          {"guessed", done},
          {"guess_message", ""},
          {"control_points", 3},
          {"cost_at_start", 2.0 * before},
          {"cost_before", before},
          {"cost_after", after},
          {"rows", 4000},
          {"iterations", 7},
          {"at_bound", done ? Json::array() : Json::array({std::string(term) + ".k"})},
          {"zero_gradient", Json::array()},
          {"flat", Json::array()},
          {"dropped", Json::array()}};
}

}  // namespace

Json sheet_fit() {
  const Json model = Json::parse(model::write_model(model::preset("cloth_stvk").value()));
  Json root = {{"schema", "tenter.sheet_fit"},
               {"version", 1},
               {"kind", "fit"},
               {"options", {{"resolution", 25}, {"staged", true}}},
               {"starting_model", model},
               {"model", model}};
  root["captures"] = Json::array();
  for (int i = 0; i < 5; ++i) root["captures"].push_back(capture(i));
  root["fitted"] = {{"force", errors(0.003, 0.041, 0.0033)},
                    {"position", errors(7.5e-5, 4.1e-4, 8.1e-5)}};
  root["held_out"] = {{"force", errors(0.003, 0.041, 0.0062)},
                      {"position", errors(7.5e-5, 4.1e-4, 1.2e-4)}};
  root["stages"] = Json::array({stage("stretch_u", "weft", 81000.0, 5300.0, true),
                                stage("shear", "shear", 91000.0, 4100.0, false)});
  root["parameters"] = Json::array(
      {{{"name", "weft.k"},
        {"value", 81.2},
        {"unit", "N/m"},
        {"std_error", 0.4},
        {"interval", {80.4, 82.0}},
        {"profile", {{"word", "one_sided"}, {"lo", 0.125}, {"hi", nullptr}, {"fits", 9}}},
        {"state", "free"}},
       {{"name", "shear.k"},
        {"value", 0.0},
        {"unit", "N/m"},
        {"std_error", nullptr},
        {"interval", nullptr},
        {"held", true},
        {"state", "at_bound"}}});
  root["correlations"] = Json::array({{{"a", "weft.k"}, {"b", "shear.k"}, {"value", -0.94}}});
  root["curves"] = Json::array({curve("weft", 81.0, true), curve("warp", 120.0, false)});
  root["figures"] = Json::array({loop(0), loop(1)});
  root["meshes"] = Json::array({mesh(0, "largest displacement"), mesh(0, "worst residual"),
                                mesh(4, "largest displacement")});
  root["grid_error"] = {
      {"rounds", 2}, {"settled", false}, {"change_sigmas", 0.4}, {"share_as_sigma", 0.15}};
  root["grid_error"]["captures"] =
      Json::array({{{"id", sheet_id(2)},
                    {"title", "FIXTURE wool, shear"},
                    {"order", 1.7},
                    {"force", {{"rms", 0.012}, {"largest", 0.03}, {"sigmas", 4.0}, {"rows", 320}}},
                    {"position", nullptr},
                    {"frames_without", 2}}});
  root["starts"] = {{"count", 3},         {"seed", 5},         {"widest", 10.0},
                    {"share", 0.01},      {"frames", 8},       {"cost_of_fit", 4100.0},
                    {"is_better", false}, {"in_best_basin", 2}};
  root["starts"]["outcomes"] =
      Json::array({{{"start", 0}, {"cost", 4100.0}, {"iterations", 2}, {"message", "converged"}},
                   {{"start", 2}, {"cost", 4120.0}, {"iterations", 9}, {"message", "converged"}},
                   {{"start", 3}, {"cost", 9100.0}, {"iterations", 9}, {"message", "converged"}},
                   {{"start", 1}, {"cost", nullptr}, {"iterations", 0}, {"message", "no rest"}}});
  root["convexity"] = {{"way", "every_step"},
                       {"was_convex", false},
                       {"is_convex", true},
                       {"least", {{"term", "weft"}, {"strain", {0.02, 0.0}}, {"eigenvalue", -3.5}}},
                       {"cost_before", 4100.0},
                       {"cost_after", 4300.0},
                       {"projections", 6},
                       {"iterations", 5},
                       {"message", "converged, every step projected"}};
  root["samples"] = {{"positions_m", {{0.025, 0.025}, {0.075, 0.025}}},
                     {"width_m", 0.025},
                     {"released", {2}},
                     {"training_before", 4100.0},
                     {"training", 3900.0},
                     {"held_out_before", 800.0},
                     {"held_out", 640.0},
                     {"message", ""}};
  root["samples"]["steps"] = Json::array({{{"sample", 2},
                                           {"kept", true},
                                           {"training", 3900.0},
                                           {"held_out_before", 800.0},
                                           {"held_out", 640.0},
                                           {"sigmas", 5.5},
                                           {"rows_left_out", 36}}});
  root["limit"] = {{"id", "lock"},
                   {"unit", "J/m^2"},
                   {"given", 2.0},
                   {"is_reached", true},
                   {"energy_max", 1.25},
                   {"std_error", 0.03},
                   {"at_least", nullptr},
                   {"active_frames", 4},
                   {"cost", 4100.0},
                   {"cost_without", 5200.0},
                   {"message", "the limit \"lock\" is reached"}};
  root["checklist"] =
      Json::array({{{"level", "WARNING"}, {"what", "Frames dropped"}, {"why", "1 of 194"}},
                   {{"level", "OK"}, {"what", "Converged"}, {"why", "every stage"}}});
  root["fit"] = {{"cost", 4100.0}, {"iterations", 14}, {"status", "converged"}, {"message", ""}};
  return root;
}

}  // namespace tenter::report::fixture
