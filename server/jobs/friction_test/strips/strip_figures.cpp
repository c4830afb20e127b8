// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/strips/strip_figures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "server/estimation/friction_tests/strain_point.h"
#include "server/jobs/results/json_number.h"

namespace tenter::jobs {
namespace {

using estimation::ProfileCurve;
using estimation::ProfileSamples;
using estimation::StripTest;
using estimation::TorqueSample;
using nlohmann::json;

constexpr double kMillimetres = 1e3;
constexpr double kMillinewtons = 1e3;

std::string radius_words(double radius_m) {
  if (radius_m <= 0.0) return "never rolled";
  std::string words = std::to_string(kMillimetres * radius_m);
  words.erase(words.find_last_not_of('0') + 1);
  if (words.ends_with('.')) words.pop_back();
  return "from " + words + " mm";
}

json strip_axis(const char* name, const char* unit) {
  return {{"name", name}, {"unit", unit}};
}

struct StripSeries {
  json entry;
  StripSeries(const std::string& name, const char* role, const char* mark)
      : entry{{"name", name},
              {"role", role},
              {"mark", mark},
              {"x", json::array()},
              {"y", json::array()}} {}
  void add(double x, double y) {
    entry["x"].push_back(number(x));
    entry["y"].push_back(number(y));
  }
};

json strip_figure(const char* kind, const std::string& capture, const std::string& title, json x,
                  json y, json series) {
  return {{"kind", kind},      {"capture", capture}, {"title", title},
          {"x", std::move(x)}, {"y", std::move(y)},  {"series", std::move(series)}};
}

/// Contours and curvatures of the smooth curves behind them.
void add_contours(const StripPart& part, json& contours, json& curvatures) {
  for (const StripTest& strip : part.tests.strips) {
    const auto curve = ProfileCurve::fitted(strip.points, {.length_m = strip.length_m});
    if (!curve) continue;
    StripSeries contour(radius_words(strip.radius_m), "measured", "line");
    StripSeries bend(radius_words(strip.radius_m), "measured", "line");
    constexpr int kPlaces = 60;
    for (int i = 0; i <= kPlaces; ++i) {
      const double arc = strip.length_m * i / kPlaces;
      const estimation::ContourPoint at = curve->position(arc);
      contour.add(kMillimetres * at.x_m, kMillimetres * at.y_m);
      bend.add(kMillimetres * arc, curve->curvature(arc));
    }
    contours.push_back(std::move(contour.entry));
    curvatures.push_back(std::move(bend.entry));
  }
}

/// The smallest, a middle and the largest cylinder.
std::vector<double> three_anchors(const StripPart& part) {
  std::set<double> all;
  for (const ProfileSamples& profile : part.found.profiles)
    if (profile.anchor > 0.0) all.insert(profile.anchor);
  std::vector<double> sorted(all.begin(), all.end());
  if (sorted.size() <= 3) return sorted;
  return {sorted.front(), sorted[sorted.size() / 2], sorted.back()};
}

json unload_paths(const StripPart& part, const estimation::StrainPoint& point) {
  json paths = json::array();
  for (const double anchor : three_anchors(part)) {
    StripSeries way("unrolled " + radius_words(3.0 / anchor), "baseline", "line");
    estimation::StrainPoint::Walk walk;
    point.begin(walk);
    const Eigen::VectorXd& parameters = part.found.friction.fit.parameters;
    point.to_strain(anchor, parameters, walk);
    constexpr int kSteps = 120;
    for (int i = 0; i <= kSteps; ++i) {
      const double strain = anchor * (1.0 - static_cast<double>(i) / kSteps);
      double load = 0.0;
      double tangent = 0.0;
      point.look(strain, parameters, false, walk, load, tangent);
      way.add(strain, kMillinewtons * load);
    }
    paths.push_back(std::move(way.entry));
  }
  return paths;
}

}  // namespace

json strip_figures(const StripPart& part, const StripsOfCaptures& strips,
                   const NamedCaptures& captures) {
  const auto place = static_cast<std::size_t>(part.found.profiles.front().number);
  const std::string& id = captures[strips.places[place].capture].first;
  const std::string of = ", " + part.sense + " sense";
  json contours = json::array();
  json curvatures = json::array();
  add_contours(part, contours, curvatures);

  StripSeries at_samples("model at the samples", "baseline", "dots");
  StripSeries read("torque of the weight", "measured", "dots");
  StripSeries missed("torque of the weight - of the model", "baseline", "dots");
  StripSeries compared("torque of the weight, to compare", "measured", "dots");
  StripSeries left("strain read - of the model", "baseline", "dots");
  const auto point = estimation::StrainPoint::make(part.found.friction.model);
  for (const SampleOfStrip& sample : part.samples) {
    const TorqueSample& seen = *sample.read;
    if (std::isfinite(sample.strain)) {
      at_samples.add(kMillimetres * seen.arc_m, sample.strain / 3.0);
      left.add(seen.strain, seen.strain - sample.strain);
    }
    const double torque = kMillinewtons * seen.mean_torque();
    compared.add(seen.strain, torque);
    read.add(seen.strain, torque);
    missed.add(seen.strain, torque - kMillinewtons * sample.torque);
  }
  const bool has_strains = !at_samples.entry["x"].empty();
  if (has_strains) curvatures.push_back(std::move(at_samples.entry));
  json torques = json::array({std::move(read.entry)});
  if (point)
    for (json& path : unload_paths(part, *point)) torques.push_back(std::move(path));

  json figures = json::array();
  figures.push_back(strip_figure("strip_profile", id, "Strips as they were seen" + of,
                                 strip_axis("x", "mm"), strip_axis("y", "mm"),
                                 std::move(contours)));
  figures.push_back(strip_figure("curvature", id, "Curvature along the strips" + of,
                                 strip_axis("along the strip", "mm"),
                                 strip_axis("curvature", "1/m"), std::move(curvatures)));
  figures.push_back(strip_figure("unloading", id, "Torque against strain, unrolled" + of,
                                 strip_axis("strain, 3 curvature", "1/m"),
                                 strip_axis("torque per width", "mN"), std::move(torques)));
  figures.push_back(
      strip_figure("residual_torque", id, "Torque that is missed at the samples" + of,
                   strip_axis("strain, 3 curvature", "1/m"), strip_axis("torque per width", "mN"),
                   json::array({std::move(compared.entry), std::move(missed.entry)})));
  if (has_strains)
    figures.push_back(
        strip_figure("residual_strain", id, "Strain that is missed at the samples" + of,
                     strip_axis("strain, 3 curvature", "1/m"), strip_axis("strain", "1/m"),
                     json::array({std::move(left.entry)})));
  return figures;
}

std::vector<report::ResidualTable> strip_residuals(const StripPart& part,
                                                   const StripsOfCaptures& strips,
                                                   const NamedCaptures& captures) {
  std::map<std::pair<std::size_t, bool>, report::ResidualTable> tables;
  for (const SampleOfStrip& sample : part.samples) {
    const ProfileSamples& profile = *sample.profile;
    const StripPlace& place = strips.places[static_cast<std::size_t>(profile.number)];
    const capture::Capture& capture = captures[place.capture].second;
    for (const bool is_torque : {false, true}) {
      const double predicted = is_torque ? sample.torque : sample.strain;
      if (!std::isfinite(predicted)) continue;
      report::ResidualTable& table = tables[{place.capture, is_torque}];
      table.capture_id = captures[place.capture].first;
      table.capture_title = capture.title;
      table.channel = strips.measure + "_" + part.sense + (is_torque ? "_torque" : "");
      table.unit = is_torque ? "N" : "1/m";
      table.frame.push_back(capture.frame[place.frame]);
      table.run.push_back(capture.runs[static_cast<std::size_t>(capture.run[place.frame])].number);
      table.block.push_back(profile.group);
      table.branch.push_back(profile.anchor > 0.0 ? 1 : 0);
      table.displacement_m.push_back(sample.read->arc_m);
      table.strain_x.push_back(std::nan(""));
      table.strain_y.push_back(std::nan(""));
      table.strain_xy.push_back(std::nan(""));
      table.measured.push_back(is_torque ? sample.read->mean_torque() : sample.read->strain);
      table.predicted_baseline.push_back(predicted);
      table.predicted_extended.push_back(predicted);
      // the torque's own scatter counts by what it moves the strain
      table.sigma.push_back(is_torque ? std::nan("") : sample.read->std_error);
      table.weight.push_back(1.0);
    }
  }
  std::vector<report::ResidualTable> list;
  list.reserve(tables.size());
  for (auto& [place, table] : tables) list.push_back(std::move(table));
  return list;
}

}  // namespace tenter::jobs
