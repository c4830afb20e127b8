// SPDX-License-Identifier: Apache-2.0
#include "tests/common/report/fixture_result.h"

#include <cmath>
#include <random>
#include <string>

#include "common/model/document.h"
#include "common/model/presets.h"
#include "common/report/json_access.h"

namespace tenter::report::fixture {

namespace {

std::string capture_id(int index) {
  return std::string(63, 'a') + static_cast<char>('0' + index);
}

const char* capture_title(int index) {
  static constexpr const char* titles[] = {"FIXTURE knit, wale pull, five repeats",
                                           "FIXTURE warp knit, equibiaxial strip",
                                           "FIXTURE twin with friction"};
  return titles[index];
}

/// One pull and release: a stiffening curve, with half a loop's width added on loading.
struct Loop {
  double top = 0.0;
  double stiffness = 0.0;
  double width = 0.0;

  double elastic(double e) const { return stiffness * (e + 2.2 * e * e); }
  double stress(double e, bool loading) const {
    const double friction = width * (0.3 + 2.0 * e);
    return elastic(e) + (loading ? friction * (1.0 - std::exp(-e / 0.03))
                                 : friction * (2.0 * std::exp(-(top - e) / 0.03) - 1.0));
  }
};

Json axis(const char* name, const char* unit) {
  return {{"name", name}, {"unit", unit}};
}

Json series(const std::string& name, const char* role, const std::string& block) {
  return {
      {"name", name}, {"role", role}, {"block", block}, {"x", Json::array()}, {"y", Json::array()}};
}

void add_figures(Json& figures, int capture, int repeats, const Loop& loop) {
  std::mt19937 random(static_cast<unsigned>(40 + capture));
  std::normal_distribution<double> noise(0.0, 0.006 * loop.stress(loop.top, true));
  const char* stretch = "strain along the pull";
  Json force = {{"kind", "loop"},
                {"capture", capture_id(capture)},
                {"title", "Membrane stress along the pull"},
                {"x", axis(stretch, "1")},
                {"y", axis("stress", "N/m")},
                {"series", Json::array()}};
  Json by_strain = {{"kind", "residual_strain"},
                    {"capture", capture_id(capture)},
                    {"title", "Residual against strain"},
                    {"x", axis(stretch, "1")},
                    {"y", axis("stress", "N/m")},
                    {"band", {-noise.stddev(), noise.stddev()}},
                    {"series", Json::array()}};
  Json by_time = by_strain;
  by_time["kind"] = "residual_time";
  by_time["title"] = "Residual against time";
  by_time["x"] = axis("time", "s");
  Json across = force;
  across["kind"] = "transverse";
  across["title"] = "Stretch across the pull";
  across["y"] = axis("stretch across", "1");

  double time = 0.0;
  Json outliers = series("misread force", "outlier", "run 2, loading");
  for (int run = 1; run <= repeats; ++run)
    for (const bool loading : {true, false}) {
      const std::string block =
          "run " + std::to_string(run) + (loading ? ", loading" : ", unloading");
      Json measured = series("measured", "measured", block);
      measured["branch"] = loading ? "load" : "unload";
      Json baseline = series("baseline", "baseline", block);
      Json extended = series("extended", "extended", block);
      Json wide = series("measured", "measured", block);
      Json left_before = series("left by the baseline", "baseline", block);
      Json left_after = series("left by the extended model", "extended", block);
      Json late_before = left_before;
      Json late_after = left_after;
      for (int i = 0; i <= 60; ++i) {
        const double e = loop.top * (loading ? i : 60 - i) / 60.0;
        const double first = run == 1 ? 1.07 : 1.0;
        const double value = first * loop.stress(e, loading) + noise(random);
        const double line = 1.02 * loop.stiffness * (1.0 + 1.1 * loop.top) * e;
        const double fit = loop.stress(e, loading);
        time += 0.5;
        measured["x"].push_back(e);
        measured["y"].push_back(value);
        if (run == 1 || run == repeats) {
          baseline["x"].push_back(e);
          baseline["y"].push_back(line);
          extended["x"].push_back(e);
          extended["y"].push_back(fit);
        }
        wide["x"].push_back(e);
        wide["y"].push_back(1.0 - 0.35 * e + 0.15 * e * e + noise(random) / 4000.0);
        left_before["x"].push_back(e);
        left_before["y"].push_back(value - line);
        left_after["x"].push_back(e);
        left_after["y"].push_back(value - fit);
        late_before["x"].push_back(time);
        late_before["y"].push_back(value - line);
        late_after["x"].push_back(time);
        late_after["y"].push_back(value - fit);
        if (run == 2 && loading && (i == 22 || i == 41)) {
          outliers["x"].push_back(e);
          outliers["y"].push_back(value * 1.45);
        }
      }
      force["series"].push_back(measured);
      if (run == 1 || run == repeats) {
        force["series"].push_back(baseline);
        force["series"].push_back(extended);
      }
      across["series"].push_back(wide);
      by_strain["series"].push_back(left_before);
      by_strain["series"].push_back(left_after);
      by_time["series"].push_back(late_before);
      by_time["series"].push_back(late_after);
    }
  force["series"].push_back(outliers);
  for (const Json& figure : {force, across, by_strain, by_time}) figures.push_back(figure);
}

Json capture(int index, bool synthetic) {
  return {{"id", capture_id(index)},
          {"title", capture_title(index)},
          {"synthetic", synthetic},
          {"specimen", "F" + std::to_string(index + 1)},
          {"material", "fixture cloth"},
          {"licence", index == 1 ? "" : "MIT"},
          {"source", "made by formula for a test"},
          {"frames", 610 - 120 * index},
          {"blocks", 10 - 2 * index},
          {"noise_floor", 0.011 + 0.002 * index},
          {"noise_source", index == 2 ? "stated sigma" : "repeats"},
          {"error_before", 0.182 - 0.03 * index},
          {"error_after", 0.021 + 0.003 * index},
          {"held_out_before", 0.201 - 0.03 * index},
          {"held_out_after", 0.027 + 0.003 * index},
          {"channels",
           {{{"name", "force"}, {"unit", "N"}, {"sigma", 0.08}, {"sigma_source", "repeats"}}}}};
}

Json verdicts() {
  Json list = Json::array();
  list.push_back(
      {{"verdict", "NAMED"},
       {"effect", "nonlinear_stiffness"},
       {"words",
        "The fabric stiffens with strain, the same on loading and unloading. A stiffness that "
        "grows from 41 N/m at rest to 160 N/m at the largest strain takes most of the misfit."},
       {"size", 0.118},
       {"interval", {0.109, 0.127}},
       {"p_value", 0.00002},
       {"alternatives", Json::array()},
       {"next_protocol", nullptr},
       {"evidence",
        {{"f_statistic", 81.2},
         {"held_out_gain", 0.41},
         {"bootstrap_share", 1.0},
         {"blocks", 24}}}});
  list.push_back(
      {{"verdict", "AMBIGUOUS"},
       {"effect", "internal_friction"},
       {"words",
        "Loading and unloading differ by a loop whose width grows with strain. Friction inside the "
        "yarns explains it; so does viscosity, because every capture was pulled at one rate and "
        "never held."},
       {"size", 0.062},
       {"interval", {0.055, 0.068}},
       {"p_value", 0.0004},
       {"alternatives", {"viscosity"}},
       {"next_protocol",
        {{"name", "two_rates_and_a_hold"},
         {"words", "Pull the same specimen ten times faster, and hold at the top for a minute."},
         {"phases",
          {{{"kind", "ramp"}, {"words", "pull to 0.3 at 0.01 per second and back"}},
           {{"kind", "ramp"}, {"words", "pull to 0.3 at 0.1 per second and back"}},
           {{"kind", "hold"}, {"words", "pull to 0.3 and hold for 60 s"}}}}}},
       {"evidence", {{"canonical_correlation", 0.991}}}});
  list.push_back({{"verdict", "SENSOR"},
                  {"effect", "outliers"},
                  {"words",
                   "Two readings of run 2 stand apart from all repeats and do not come again; a "
                   "robust loss keeps them out."},
                  {"size", 0.009},
                  {"interval", {0.006, 0.012}},
                  {"p_value", 0.013},
                  {"alternatives", Json::array()},
                  {"next_protocol", nullptr},
                  {"evidence", {{"readings", 2}}}});
  list.push_back(
      {{"verdict", "UNEXPLAINED"},
       {"effect", nullptr},
       {"words",
        "A small part of the misfit above the noise is taken by no effect of the catalogue."},
       {"size", 0.008},
       {"interval", nullptr},
       {"p_value", nullptr},
       {"alternatives", Json::array()},
       {"next_protocol", nullptr},
       {"evidence", Json::object()}});
  for (const char* effect : {"plastic_set", "force_camera_delay"})
    list.push_back({{"verdict", "NOT_EXCITED"},
                    {"effect", effect},
                    {"words", "No capture returns to zero after a new maximum."},
                    {"size", nullptr},
                    {"interval", nullptr},
                    {"p_value", nullptr},
                    {"alternatives", Json::array()},
                    {"next_protocol",
                     {{"name", "nested_loops"},
                      {"words", "Loops of growing height, each back to zero."},
                      {"phases", {{{"kind", "cycle"}, {"words", "to 0.1 and back"}}}}}},
                    {"evidence", Json::object()}});
  return list;
}

Json path_step(const char* action, const char* effect, double error, double held_out,
               int parameters, double bic, double p, const char* why) {
  return {{"action", action},    {"effect", effect[0] == '\0' ? Json(nullptr) : Json(effect)},
          {"error", error},      {"held_out", held_out},
          {"chi2", error * 1e5}, {"parameters", parameters},
          {"bic", bic},          {"p_value", p < 0 ? Json(nullptr) : Json(p)},
          {"why", why}};
}

}  // namespace

Json result() {
  Json root = {{"schema", "tenter.result"},   {"version", 1},
               {"kind", "diagnose"},          {"verdicts", verdicts()},
               {"noise_floor", 0.012},        {"error_before", 0.171},
               {"error_after", 0.023},        {"held_out_before", 0.194},
               {"held_out_after", 0.029},     {"r2_before", 0.9023},
               {"r2_after", 0.9983},          {"held_out_r2_before", 0.8821},
               {"held_out_r2_after", 0.9961}, {"unexplained_share", 0.034},
               {"held_out_kind", "repeats"}};
  model::Model baseline = model::preset("stvk_orthotropic").value();
  root["baseline_model"] = Json::parse(model::write_model(baseline));
  model::Term friction = baseline.terms[0];
  friction.id = "friction_45";
  friction.effect = "internal_friction";
  friction.strain = {"fibre", 0.7853981633974483};
  friction.law.name = "dahl";
  friction.law.parameters = {{"a", 3.1, "N/m", 0.0, {}, false, 0.2, 2.7, 3.5},
                             {"b", 12.0, "N/m", 0.0, {}, false, 1.0, 10.0, 14.0},
                             {"c", 0.0, "N/m", 0.0, {}, true, {}, {}, {}},
                             {"tau", 0.03, "1", 1e-6, {}, false, 0.004, 0.022, 0.038}};
  baseline.name = "stvk_orthotropic_extended";
  baseline.terms.push_back(friction);
  root["model"] = Json::parse(model::write_model(baseline));

  root["captures"] = Json::array({capture(0, false), capture(1, false), capture(2, true)});
  root["screen"] =
      Json::array({{{"effect", "nonlinear_stiffness"},
                    {"gain", 8120.0},
                    {"df", 4},
                    {"ratio", 14.2},
                    {"status", "screened"},
                    {"grid", Json::object()}},
                   {{"effect", "internal_friction"},
                    {"gain", 2310.0},
                    {"df", 2},
                    {"ratio", 6.1},
                    {"status", "screened"},
                    {"grid", {{"tau", 0.03}}}},
                   {{"effect", "viscosity"},
                    {"gain", 2290.0},
                    {"df", 1},
                    {"ratio", 6.0},
                    {"status", "screened"},
                    {"grid", Json::object()}},
                   {{"effect", "load_cell_drift"},
                    {"gain", 9.0},
                    {"df", 1},
                    {"ratio", 0.4},
                    {"status", "screened"},
                    {"grid", Json::object()}},
                   {{"effect", "plastic_set"},
                    {"gain", nullptr},
                    {"df", 2},
                    {"ratio", nullptr},
                    {"status", "not excited: no capture returns to zero after a new maximum"},
                    {"grid", Json::object()}}});
  root["path"] =
      Json::array({path_step("start", "", 0.171, 0.194, 4, 9120, -1, "the baseline as fitted"),
                   path_step("add", "nonlinear_stiffness", 0.064, 0.071, 13, 2310, 0.00002,
                             "largest expected gain; every gate passed"),
                   path_step("add", "internal_friction", 0.023, 0.029, 19, 480, 0.0004,
                             "left-out pulls better by 59 %"),
                   path_step("reject", "load_cell_drift", 0.023, 0.030, 20, 486, 0.31,
                             "p above 0.001, left-out pulls no better")});
  root["parameters"] = Json::array();
  for (const model::Term& term : baseline.terms)
    for (const model::Parameter& p : term.law.parameters)
      root["parameters"].push_back(
          {{"name", term.id + "." + p.name},
           {"value", p.value},
           {"unit", p.unit},
           {"std_error", p.fixed ? Json(nullptr) : Json(0.03 * p.value)},
           {"interval", p.fixed ? Json(nullptr) : Json({0.94 * p.value, 1.06 * p.value})},
           {"state", p.fixed ? "fixed" : "free"}});
  root["checklist"] = Json::array(
      {{{"level", "OK"}, {"what", "Noise from repeats"}, {"why", "24 blocks in 3 captures"}},
       {{"level", "WARNING"},
        {"what", "One rate only"},
        {"why", "friction and viscosity cannot be told apart"}},
       {{"level", "OK"}, {"what", "Converged"}, {"why", "gradient below 1e-8"}}});
  root["figures"] = Json::array();
  add_figures(root["figures"], 0, 5, {0.32, 60.0, 6.0});
  add_figures(root["figures"], 1, 2, {0.22, 110.0, 14.0});
  add_figures(root["figures"], 2, 1, {0.30, 80.0, 10.0});
  root["fit"] = {{"cost", 511.3}, {"iterations", 23}, {"status", "converged"}, {"message", ""}};
  return root;
}

}  // namespace tenter::report::fixture
