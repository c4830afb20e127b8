// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/figures/spiral_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/model/presets.h"
#include "server/estimation/friction_tests/strain_point.h"
#include "server/mechanics/scene/run.h"
#include "tests/twin/friction/hanging_strip.h"

namespace tenter::bench {
namespace {

using nlohmann::json;

/// The run with the wound strip let go to the next equilibrium, and nothing else.
Expected<std::vector<scene::Run>> resting_runs(const std::string& text) {
  json document = json::parse(text);
  document.erase("dynamics");
  document["protocol"] = json::array();
  json& experiment = document["experiment"];
  for (const char* list : {"measures", "curves", "pictures"}) experiment.erase(list);
  return scene::runs_of(document.dump(), "at rest");
}

/// Along the strip: place, curvature and the torque of what hangs below, per width (N).
struct Profile {
  std::vector<double> arc_m, curvature, torque_N;
};

/// Curvature counts as the strip was wound.
Profile profile_of(const mechanics::SceneRun& run, const mechanics::SceneFrame& frame) {
  const mechanics::SceneBody& body = run.body();
  const double width = body.material_m.row(1).maxCoeff();
  struct Row {
    double mass = 0.0, moment = 0.0, z = 0.0;
    int nodes = 0;
    double x() const { return moment / mass; }
  };
  std::map<long long, Row> rows;  // by nanometres along the strip
  for (int n = 0; n < body.node_count(); ++n) {
    Row& row = rows[std::llround(1e9 * body.material_m(0, n))];
    row.mass += body.node_mass_kg[n];
    row.moment += body.node_mass_kg[n] * frame.state.x[3 * n];
    row.z += frame.state.x[3 * n + 2];
    ++row.nodes;
  }
  std::vector<double> arc, x, z, mass;
  for (const auto& [place, row] : rows) {
    arc.push_back(1e-9 * static_cast<double>(place));
    x.push_back(row.x());
    z.push_back(row.z / row.nodes);
    mass.push_back(row.mass / width);
  }
  Profile profile;
  const double gravity = std::abs(run.scene().gravity_m_s2[2]);
  for (std::size_t i = 1; i + 1 < arc.size(); ++i) {
    double torque = 0.0;
    for (std::size_t j = i + 1; j < arc.size(); ++j) torque -= gravity * mass[j] * (x[j] - x[i]);
    const double before = std::atan2(z[i] - z[i - 1], x[i] - x[i - 1]);
    const double after = std::atan2(z[i + 1] - z[i], x[i + 1] - x[i]);
    const double turn = std::remainder(after - before, 2.0 * 3.14159265358979323846);
    profile.arc_m.push_back(arc[i]);
    profile.curvature.push_back(2.0 * turn / (arc[i + 1] - arc[i - 1]));
    profile.torque_N.push_back(torque);
  }
  return profile;
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// What the hinges say: of the first term with bend_u, a third of its strain.
double hinge_rms(const model::Model& model, const mechanics::SceneFrame& frame) {
  for (const mechanics::TermStrains& strains : frame.strains) {
    if (model.terms[static_cast<std::size_t>(strains.term)].strain.name != "bend_u") continue;
    double sum = 0.0, all = 0.0;
    for (std::size_t e = 0; e < strains.measure.size(); ++e) {
      sum += strains.measure[e] * strains.strain[e] * strains.strain[e] / 9.0;
      all += strains.measure[e];
    }
    return std::sqrt(sum / all);
  }
  return NAN;
}

/// Curvatures that the strain point has under the profile's torques.
std::vector<double> balanced(const model::Model& model, double radius_m, const Profile& profile) {
  model::Model strain = model;
  std::erase_if(strain.terms, [](const model::Term& term) { return term.strain.name != "bend_u"; });
  const auto point = estimation::StrainPoint::make(strain);
  if (!point) return {};
  const Eigen::VectorXd parameters = mechanics::term_parameters(strain);
  std::vector<double> curvature;
  for (const double torque : profile.torque_N) {
    estimation::StrainPoint::Walk walk;
    point->begin(walk);
    point->to_strain(3.0 / radius_m, parameters, walk);
    if (point->to_load(torque, parameters, walk) != mechanics::PathStatus::ok) return {};
    curvature.push_back(walk.strain / 3.0);
  }
  return curvature;
}

/// rms curvature of the chain's hinges beyond the clamp.
/// "58.7"; "no rest" where the chain found none.
std::string chain_rms(const std::string& material, bool has_friction, double radius_m,
                      double clamp_m) {
  for (twin::FrictionSample sample : twin::bending_samples()) {
    if (sample.name != material) continue;
    if (!has_friction) sample.a = sample.b = 0.0;
    twin::StripPlan plan{.radius_m = radius_m, .length_m = 0.1 - clamp_m, .hinges = 400};
    plan.gravity_m_s2 = 9.81;
    plan.clamp_angle_rad += clamp_m / radius_m;  // the clamp holds the wound strip's first part
    const twin::RestingStrip strip = twin::resting_strip(sample, plan);
    if (!strip.is_at_rest) return "no rest";
    std::vector<double> curvature;
    for (const double eps : strip.strain) curvature.push_back(eps / 3.0);
    char number[24];
    std::snprintf(number, sizeof number, "%.4g", rms(curvature));
    return number;
  }
  return "no strip";
}

}  // namespace

bool check_spirals(const scene::Scene& scene, const std::string& scene_text) {
  const auto model = model::preset(scene.model);
  const auto runs = resting_runs(scene_text);
  if (!model || !runs) return false;
  std::printf("%s, unrolled with care, rms curvature (1/m)\n%-26s%10s%10s%10s%10s%14s\n",
              scene.model.c_str(), "", "shape", "hinges", "balance", "chain", "balance off");
  for (const scene::Run& run : *runs) {
    if (run.scene.start.pitch_m > 0.0) continue;  // not of one radius
    model::Model used = *model;
    std::erase_if(used.terms, [&run](const model::Term& term) {
      return std::find(run.without_laws.begin(), run.without_laws.end(), term.law.name) !=
             run.without_laws.end();
    });
    auto walk = mechanics::SceneRun::make(run.scene, used);
    if (!walk) {
      std::printf("%s: %s\n", run.name.c_str(), walk.error().message.c_str());
      return false;
    }
    Profile profile;
    double hinges = NAN;
    const auto end = walk->walk({.on_frame =
                                     [&](const mechanics::SceneFrame& frame) {
                                       profile = profile_of(*walk, frame);
                                       hinges = hinge_rms(used, frame);
                                     },
                                 .go_on = {}});
    if (!end || profile.arc_m.empty()) {
      std::printf("%s: %s\n", run.name.c_str(), end ? end->reason.c_str() : "failed");
      return false;
    }
    // what the clamp holds stays wound
    constexpr double kClamp_m = 0.001;
    while (!profile.arc_m.empty() && profile.arc_m.front() < kClamp_m - 1e-6)
      for (auto* list : {&profile.arc_m, &profile.curvature, &profile.torque_N})
        list->erase(list->begin());
    const double radius_m = run.scene.start.radius_m;
    const std::vector<double> balance = balanced(used, radius_m, profile);
    if (balance.empty()) return false;
    std::vector<double> off;
    for (std::size_t i = 0; i < balance.size(); ++i)
      off.push_back(balance[i] - profile.curvature[i]);
    std::printf("%-26s%10.4g%10.4g%10.4g%10s%12.3g %%\n", run.name.c_str(), rms(profile.curvature),
                hinges, rms(balance),
                chain_rms(scene.model, run.without_laws.empty(), radius_m, kClamp_m).c_str(),
                100.0 * rms(off) / rms(profile.curvature));
  }
  std::printf("\n");
  return true;
}

}  // namespace tenter::bench
