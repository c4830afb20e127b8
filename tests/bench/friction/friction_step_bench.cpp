// SPDX-License-Identifier: GPL-3.0-or-later
// What internal friction adds to an implicit step: hanging cloth of 0.5 m and 0.187 kg/m2, two
// corners pinned, no contact, steps of 10 ms after a drop from the horizontal, with and without
// friction on both stretches, shear and all bending.
//
//   tenter-bench-friction-step [NODES_A_SIDE ...]         25 and 50: 1152 and 4802 triangles
//
// CPU time of one thread, mean over the steps from 0.3 s on; each sheet swings on its own. Prints
// ratios within one run.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "server/mechanics/dynamics/step.h"
#include "tests/bench/cpu_time.h"

namespace {

using namespace tenter;
using namespace tenter::mechanics;

constexpr double kStep_s = 0.01;
constexpr int kWarm = 30;
constexpr int kSteps = 20;
constexpr int kRepeats = 3;

model::Term friction(const std::string& strain, double a, double b, double tau) {
  model::Term term;
  term.id = strain + "_friction";
  term.strain.name = strain;
  term.law.name = "dahl";
  term.law.parameters = model::default_parameters(*model::find_law("dahl"), 1);
  const double values[] = {a, b, 0.0, tau};
  for (std::size_t k = 0; k < 4; ++k) term.law.parameters[k].value = values[k];
  return term;
}

/// The warp of cotton (table 5.1) for the membrane, of doublecloth's order for bending.
model::Model cloth(bool rubs) {
  model::Model model = model::preset("cloth_stvk").value();
  const double stiffness[] = {135.6, 135.6, 20.0, 3e-5, 3e-5, 3e-5};
  for (std::size_t t = 0; t < model.terms.size(); ++t)
    model.terms[t].law.parameters[0].value = stiffness[t];
  if (!rubs) return model;
  for (const char* strain : {"green_u", "green_v"})
    model.terms.push_back(friction(strain, 2.22, 3.16, 0.006));
  model.terms.push_back(friction("green_uv", 0.4, 2.0, 0.01));
  for (const char* strain : {"bend_u", "bend_v", "bend_d"})
    model.terms.push_back(friction(strain, 4e-4, 1e-6, 10.0));
  return model;
}

struct Times {
  double linearised_ms = 0.0, converged_ms = 0.0, evaluation_ms = 0.0;
  double factorisations = 0.0, evaluations = 0.0;
};

Times times_of(int nodes, bool rubs) {
  const Cloth sheet = cloth_of_grid({nodes, nodes, 0.5, 0.5}, Diagonals::alternating).value();
  const model::Model description = cloth(rubs);
  const MeshModel model = MeshModel::make(description, sheet).value();
  const Eigen::VectorXd parameters = term_parameters(description);
  Boundary boundary;
  boundary.held = {nodes * (nodes - 1), nodes * nodes - 1};
  State state;
  state.x.setZero(3 * model.node_count());
  for (int n = 0; n < model.node_count(); ++n)
    state.x.segment<2>(3 * static_cast<Eigen::Index>(n)) = sheet.mesh.material_m.col(n);
  StepInput input;
  input.duration_s = kStep_s;
  const std::vector<double> masses = lumped_masses_kg(sheet.mesh, 0.187);
  input.loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  input.loads.gravity_m_s2 = {0.0, 0.0, -9.81};
  auto stepper = TimeStepper::make(model, boundary).value();
  StepOptions options;
  options.scheme = TimeScheme::implicit_euler;
  Motion motion = at_rest(boundary, state);
  const auto go = [&](Motion& from, const StepOptions& how) {
    const auto step = stepper.step(parameters, input, from, how);
    if (!step || !step->is_solved(how)) {
      std::fprintf(stderr, "a step failed: %s\n",
                   step ? describe(*step, how).c_str() : step.error().message.c_str());
      std::exit(1);
    }
    return *step;
  };
  for (int k = 0; k < kWarm; ++k) go(motion, options);
  Times best{1e300, 1e300, 1e300, 0.0, 0.0};
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    Times now;
    Motion from = motion;
    NodeMatrix matrix = model.matrix();
    Eigen::VectorXd gradient;
    double energy = 0.0;
    for (int k = 0; k < kSteps; ++k) {
      StepOptions linearised = options;
      linearised.is_linearised = true;
      Motion copy = from;
      double start = timing::thread_cpu_ms();
      const auto step = stepper.step(parameters, input, copy, linearised);
      now.linearised_ms += (timing::thread_cpu_ms() - start) / kSteps;
      if (!step) std::exit(1);
      const History history{from.history.size() > 0 ? from.history : model.never_strained().state,
                            kStep_s};
      start = timing::thread_cpu_ms();
      if (model.evaluate(from.at.x, parameters, {&energy, &gradient, &matrix}, nullptr, &history) !=
          AssemblyStatus::ok)
        std::exit(1);
      now.evaluation_ms += (timing::thread_cpu_ms() - start) / kSteps;
      start = timing::thread_cpu_ms();
      const StepResult done = go(from, options);
      now.converged_ms += (timing::thread_cpu_ms() - start) / kSteps;
      now.factorisations += static_cast<double>(done.factorisations) / kSteps;
      now.evaluations += static_cast<double>(done.evaluations) / kSteps;
    }
    best.linearised_ms = std::min(best.linearised_ms, now.linearised_ms);
    best.converged_ms = std::min(best.converged_ms, now.converged_ms);
    best.evaluation_ms = std::min(best.evaluation_ms, now.evaluation_ms);
    best.factorisations = now.factorisations;
    best.evaluations = now.evaluations;
  }
  return best;
}

}  // namespace

int main(int count, char** arguments) {
  std::vector<int> sizes;
  for (int i = 1; i < count; ++i) sizes.push_back(std::atoi(arguments[i]));
  if (sizes.empty()) sizes = {25, 50};
  std::printf("%9s %9s %13s %13s %13s %15s %12s\n", "triangles", "friction", "evaluation",
              "linearised", "converged", "factorisations", "evaluations");
  for (const int nodes : sizes) {
    const Times without = times_of(nodes, false), with = times_of(nodes, true);
    const int triangles = 2 * (nodes - 1) * (nodes - 1);
    for (const auto& [words, t] : {std::pair{"without", &without}, std::pair{"with", &with}})
      std::printf("%9d %9s %10.3f ms %10.3f ms %10.3f ms %15.2f %12.2f\n", triangles, words,
                  t->evaluation_ms, t->linearised_ms, t->converged_ms, t->factorisations,
                  t->evaluations);
    std::printf(
        "%9d %9s %10.2f    %10.2f    %10.2f    %15.2f %12.2f\n", triangles, "ratio",
        with.evaluation_ms / without.evaluation_ms, with.linearised_ms / without.linearised_ms,
        with.converged_ms / without.converged_ms, with.factorisations / without.factorisations,
        with.evaluations / without.evaluations);
  }
  return 0;
}
