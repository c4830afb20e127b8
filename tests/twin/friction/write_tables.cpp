// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-twin-friction FOLDER [seed]: tables of two tests of internal friction on samples of thesis
// tables 5.1 and 5.2, labelled synthetic, with the descriptions that import them:
//
//   weights.csv, .json   polyester, warp: 0 to 6 N in steps of 1 N, three times
//   strips.csv, .json    doublecloth, warp: spirals of six cylinders and a cantilever
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/twin/friction/hanging_cloth.h"
#include "tests/twin/friction/hanging_strip.h"

namespace {

using namespace tenter::twin;

constexpr const char* kWeights = R"({
  "schema": "tenter.describe", "version": 1, "kind": "homogeneous_strain",
  "title": "Hanging weights, polyester, warp",
  "columns": {
    "run": {"is": "run"},
    "weight_N": {"channel": "weight", "quantity": "force", "unit": "N"},
    "length_mm": {"channel": "length", "quantity": "length", "unit": "mm", "sigma": 0.1}
  },
  "specimen": {"name": "square", "material": "polyester", "width": {"value": 100, "unit": "mm"},
               "axis_angle": {"value": 90, "unit": "degree"}},
  "protocol": {"name": "hanging weights", "history": "continues",
               "phases": [{"name": "weights", "kind": "cycle"}]},
  "provenance": {"source": "tenter-twin-friction", "synthetic": true},
  "kinematics": {"x": {"role": "prescribed", "channel": "length",
                       "reference_length": {"value": 100, "unit": "mm"}},
                 "y": {"role": "free"}},
  "stresses": {"x": "weight"}
}
)";

constexpr const char* kStrips = R"({
  "schema": "tenter.describe", "version": 1, "kind": "strip_profiles",
  "title": "Spirals and a cantilever, doublecloth, warp",
  "columns": {
    "strip": {"is": "run"},
    "x_mm": {"channel": "x", "quantity": "position", "unit": "mm", "point": "strip",
             "coordinate": "x", "sigma": 0.05},
    "y_mm": {"channel": "y", "quantity": "position", "unit": "mm", "point": "strip",
             "coordinate": "y", "sigma": 0.05},
    "radius_mm": {"channel": "radius", "quantity": "length", "unit": "mm"},
    "length_mm": {"channel": "length", "quantity": "length", "unit": "mm"}
  },
  "specimen": {"name": "strips", "material": "doublecloth", "width": {"value": 25, "unit": "mm"},
               "area_density": {"value": 255, "unit": "g/m2"},
               "axis_angle": {"value": 90, "unit": "degree"}},
  "protocol": {"name": "spirals", "history": "virgin_each_run"},
  "provenance": {"source": "tenter-twin-friction", "synthetic": true}
}
)";

bool write_weights(const std::string& folder, std::uint64_t seed) {
  HangingPlan plan;
  plan.seed = seed;
  std::ofstream csv(folder + "/weights.csv");
  csv.precision(12);
  csv << "run,weight_N,length_mm\n";
  for (const HangingReading& reading : hang(stretch_samples().back(), plan))
    csv << reading.run + 1 << ',' << reading.weight_N + plan.dead_weight_N << ','
        << 1e3 * reading.length_m << '\n';
  std::ofstream json(folder + "/weights.json");
  json << kWeights;
  return csv.good() && json.good();
}

bool write_strips(const std::string& folder, std::uint64_t seed) {
  constexpr double kNoise = 5e-5;
  std::ofstream csv(folder + "/strips.csv");
  csv.precision(12);
  csv << "strip,x_mm,y_mm,radius_mm,length_mm\n";
  int number = 0;
  for (const double radius_mm : {0.0, 5.0, 10.0, 16.0, 23.0, 31.5, 50.0}) {
    StripPlan plan;
    plan.radius_m = 1e-3 * radius_mm;
    plan.hinges = 120;
    if (radius_mm == 0.0) {
      plan.clamp_angle_rad = kCantileverAngle;
      plan.length_m = 0.06;
    }
    const RestingStrip strip = resting_strip(bending_samples()[1], plan);
    ++number;
    for (const StripPoint& p :
         photographed(strip, kNoise, 1000 * seed + static_cast<std::uint64_t>(number)))
      csv << number << ',' << 1e3 * p.x_m << ',' << 1e3 * p.y_m << ',' << radius_mm << ','
          << 1e3 * plan.length_m << '\n';
  }
  std::ofstream json(folder + "/strips.json");
  json << kStrips;
  return csv.good() && json.good();
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2 || count > 3) {
    std::fprintf(stderr, "usage: tenter-twin-friction FOLDER [seed]\n");
    return 2;
  }
  const std::string folder = arguments[1];
  const std::uint64_t seed = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1;
  if (write_weights(folder, seed) && write_strips(folder, seed)) return 0;
  std::fprintf(stderr, "%s: cannot be written\n", folder.c_str());
  return 6;
}
