// SPDX-License-Identifier: GPL-3.0-or-later
// The twisted cylinder of the friction paper (Figs. 11 to 13, without contact): cotton of Table 5.1
// around a cylinder, its lower rim turned and turned back. How long may a step be with friction
// from its incremental potential, and with the paper's linearised stress (thesis 5.9)? The paper
// says 15 ms and more.
//
//   tenter-bench-twist
//
// For every way and length of step: the highest kinetic energy on the way and what is left of it at
// the end, how far the end is from that of steps of 1 ms, the persistent shape (mean distance of
// the end from the same without friction), CPU time.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "server/mechanics/dynamics/damping.h"
#include "server/mechanics/dynamics/motion_energy.h"
#include "server/mechanics/dynamics/step.h"

namespace {

using namespace tenter;
using namespace tenter::mechanics;

constexpr double kRadius_m = 0.04, kHeight_m = 0.15, kPi = 3.14159265358979323846;
constexpr int kAround = 40, kUp = 26;
constexpr double kTurn_rad = 1.0;
constexpr double kTwist_s = 0.25, kEnd_s = 0.9;  // there, back, and waiting
constexpr double kDensity_kg_m2 = 0.143;
constexpr double kDahl[] = {2.22, 3.16, 0.0, 0.006};

model::Term term(const std::string& id, const std::string& strain, const std::string& law,
                 const std::vector<std::pair<std::string, double>>& parameters) {
  model::Term result;
  result.id = id;
  result.strain.name = strain;
  result.law.name = law;
  for (const auto& [name, value] : parameters) {
    model::Parameter p;
    p.name = name;
    p.value = value;
    result.law.parameters.push_back(p);
  }
  return result;
}

/// Stretch of Table 5.1 both ways; shear and bending of a light weave.
model::Model cotton(const std::string& friction) {
  model::Model model;
  model.name = "cotton";
  model.terms = {term("weft", "soft_u", "linear", {{"k", 135.6}}),
                 term("warp", "soft_v", "linear", {{"k", 135.6}}),
                 term("shear", "green_uv", "linear", {{"k", 20.0}}),
                 term("bend_weft", "bend_u", "linear", {{"k", 2e-5}}),
                 term("bend_warp", "bend_v", "linear", {{"k", 2e-5}}),
                 term("bend_bias", "bend_d", "linear", {{"k", 2e-5}})};
  model = with_damping(model, 0.01).value();
  if (friction.empty()) return model;
  const std::vector<std::pair<std::string, double>> p = {
      {"a", kDahl[0]}, {"b", kDahl[1]}, {"c", kDahl[2]}, {"tau", kDahl[3]}};
  model.terms.push_back(term("friction_weft", "soft_u", friction, p));
  model.terms.push_back(term("friction_warp", "soft_v", friction, p));
  return model;
}

struct Outcome {
  bool is_done = false;
  double highest_J = 0.0, last_J = 0.0;
  double iterations = 0.0;
  double cpu_s = 0.0;
  Eigen::VectorXd x;
};

double angle_at(double t) {
  return kTurn_rad * std::clamp(t < kTwist_s ? t / kTwist_s : 2.0 - t / kTwist_s, 0.0, 1.0);
}

Outcome twist(const model::Model& description, double step_s, bool is_linearised) {
  const Grid grid{kAround, kUp, 2.0 * kPi * kRadius_m * 0.97, kHeight_m};
  const Cloth cloth = cloth_of_grid(grid, Diagonals::alternating).value();
  const MeshModel model = MeshModel::make(description, cloth).value();
  const Eigen::VectorXd parameters = term_parameters(description);
  Boundary boundary;
  State state;
  state.x.resize(3 * static_cast<Eigen::Index>(grid.node_count()));
  for (int n = 0; n < grid.node_count(); ++n) {
    const double phi = cloth.mesh.material_m(0, n) / kRadius_m;
    state.x.segment<3>(3 * static_cast<Eigen::Index>(n)) << kRadius_m * std::cos(phi),
        kRadius_m * std::sin(phi), cloth.mesh.material_m(1, n);
  }
  std::vector<int> low, high;
  for (int i = 0; i < kAround; ++i) {
    low.push_back(grid.node(i, 0));
    high.push_back(grid.node(i, kUp - 1));
  }
  boundary.clips = {clip_on("low", low, state.x, {}), clip_on("high", high, state.x, {})};
  state.clips = {Pose{}, Pose{}};
  const auto masses = lumped_masses_kg(cloth.mesh, kDensity_kg_m2);
  StepInput input;
  input.duration_s = step_s;
  input.loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  StepOptions options;
  options.scheme = TimeScheme::implicit_euler;
  options.is_linearised = is_linearised;
  auto stepper = TimeStepper::make(model, boundary).value();
  Motion motion = at_rest(boundary, state);
  Outcome outcome;
  const std::clock_t start = std::clock();
  const int steps = static_cast<int>(std::lround(kEnd_s / step_s));
  for (int k = 1; k <= steps; ++k) {
    Pose turned;
    turned.rotation = rotation_of({0.0, 0.0, angle_at(k * step_s)});
    input.clips = {turned, Pose{}};
    const auto step = stepper.step(parameters, input, motion, options);
    if (!step || !step->is_good(options)) return outcome;
    outcome.iterations += step->iterations;
    outcome.last_J = momenta(boundary, input.loads.node_mass_kg, motion).kinetic_J;
    outcome.highest_J = std::max(outcome.highest_J, outcome.last_J);
  }
  outcome.is_done = true;
  outcome.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  outcome.iterations /= steps;
  outcome.x = motion.at.x;
  return outcome;
}

double mean_distance_mm(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  double sum = 0.0;
  for (Eigen::Index n = 0; n < a.size(); n += 3) sum += (a - b).segment<3>(n).norm();
  return 3e3 * sum / static_cast<double>(a.size());
}

}  // namespace

int main() {
  const Outcome elastic = twist(cotton(""), 0.001, false);
  const Outcome fine = twist(cotton("dahl"), 0.001, false);
  if (!elastic.is_done || !fine.is_done) {
    std::fprintf(stderr, "tenter-bench-twist: steps of 1 ms fail\n");
    return 1;
  }
  std::printf(
      "steps of 1 ms: highest kinetic energy %.3g mJ, %.3g mJ without friction; persistent "
      "shape %.3f mm; %.1f s, %.1f s without friction (%.2f times)\n",
      1e3 * fine.highest_J, 1e3 * elastic.highest_J, mean_distance_mm(fine.x, elastic.x),
      fine.cpu_s, elastic.cpu_s, fine.cpu_s / elastic.cpu_s);
  struct Way {
    const char* name;
    const char* law;
    bool is_linearised;
  };
  constexpr Way kWays[] = {{"potential, converged", "dahl", false},
                           {"potential, one system a step", "dahl", true},
                           {"5.9, converged", "dahl_linearised", false},
                           {"5.9, one system a step", "dahl_linearised", true}};
  for (const Way& way : kWays) {
    double largest_ms = 0.0;
    bool are_all_stable = true;
    for (const double step_ms : {2.5, 5.0, 10.0, 12.5, 15.0, 22.5, 30.0, 45.0, 60.0, 90.0}) {
      const Outcome out = twist(cotton(way.law), 1e-3 * step_ms, way.is_linearised);
      const bool is_stable =
          out.is_done && out.highest_J < 3.0 * fine.highest_J && out.last_J < 0.1 * fine.highest_J;
      are_all_stable = are_all_stable && is_stable;
      if (are_all_stable) largest_ms = step_ms;
      if (!out.is_done) {
        std::printf("  %-30s %5.1f ms  fails\n", way.name, step_ms);
        continue;
      }
      std::printf(
          "  %-30s %5.1f ms  %-8s highest %8.3g mJ, at the end %8.2g mJ; off the fine end "
          "%7.3f mm; %4.1f iterations, %.2f s\n",
          way.name, step_ms, is_stable ? "stable" : "unstable", 1e3 * out.highest_J,
          1e3 * out.last_J, mean_distance_mm(out.x, fine.x), out.iterations, out.cpu_s);
    }
    std::printf("%s: stable up to steps of %.1f ms\n", way.name, largest_ms);
  }
  return 0;
}
