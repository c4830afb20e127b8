// SPDX-License-Identifier: GPL-3.0-or-later
// Five parameters to 40 frames of a sheet of 25 x 25 nodes, all seen, in floors.
//
//   tenter-bench-fit-sequences [starts]
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>

#include "common/model/presets.h"
#include "server/estimation/fit.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/bench/equilibrium/cholmod_floor.h"

namespace {

using namespace tenter;
using namespace tenter::estimation;

constexpr int kNodes = 25;
constexpr double kSize_m = 0.1;
constexpr double kPointSigma_m = 7.5e-5;
constexpr double kForceSigma_N = 3e-3;

double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

[[noreturn]] void give_up(const std::string& why) {
  std::fprintf(stderr, "tenter-bench-fit-sequences: %s\n", why.c_str());
  std::exit(1);
}

Eigen::VectorXd true_values() {
  Eigen::VectorXd values(6);
  values << 45.0, 80.0, 9.0, 4e-5, 8e-5, 6e-5;
  return values;
}

/// Diagonal bending is known: five are fitted.
model::Model cloth_model(const Eigen::VectorXd& values) {
  model::Model model = model::preset("cloth_stvk").value();
  const auto parameters = parameters_of(model);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    parameters[i]->value = values[static_cast<Eigen::Index>(i)];
  parameters.back()->fixed = true;
  return model;
}

/// A sheet between two bars, of which the second moves, without measurements.
Sequence between_bars(const std::string& name, bool along_weft, int frames,
                      const Eigen::Vector3d& first_m, const Eigen::Vector3d& last_m) {
  Sequence sequence;
  sequence.name = name;
  const mechanics::Grid grid{kNodes, kNodes, kSize_m, kSize_m};
  sequence.cloth = cloth_of_grid(grid, mechanics::Diagonals::alternating).value();
  const auto& mesh = sequence.cloth.mesh;
  sequence.start.x.resize(3 * mesh.node_count());
  Eigen::VectorXd flat(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    const Eigen::Vector2d at = mesh.material_m.col(n);
    const double s = (along_weft ? at.x() : at.y()) / kSize_m;
    // nearer bars: an arc of the sheet's length, about
    const double shorter = std::max(0.0, -(along_weft ? first_m.x() : first_m.y()) / kSize_m);
    flat.segment<3>(3 * n) << at, 0.0;
    sequence.start.x.segment<3>(3 * n) << Eigen::Vector3d(at.x(), at.y(), 0.0) + s * first_m;
    sequence.start.x[3 * n + 2] =
        -(1e-4 + 0.63 * kSize_m * std::sqrt(shorter)) * std::sin(M_PI * s);
    sequence.points.push_back({at, kPointSigma_m});
  }
  std::vector<int> fixed, moved;
  for (int i = 0; i < kNodes; ++i) {
    fixed.push_back(along_weft ? grid.node(0, i) : grid.node(i, 0));
    moved.push_back(along_weft ? grid.node(kNodes - 1, i) : grid.node(i, kNodes - 1));
  }
  const mechanics::Pose at_rest;
  sequence.boundaries.resize(1);
  sequence.boundaries[0].clips = {clip_on("fixed", fixed, flat, at_rest),
                                  clip_on("moved", moved, flat, at_rest)};
  sequence.start.clips = {at_rest, at_rest};
  const auto masses = mechanics::lumped_masses_kg(mesh, 0.15);
  sequence.loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  for (int c = 0; c < 3; ++c)
    sequence.forces.push_back({1, Eigen::Vector3d::Unit(c), kForceSigma_N});
  for (int f = 0; f < frames; ++f) {
    SequenceFrame frame;
    mechanics::Pose pose;
    pose.position_m = first_m + (last_m - first_m) * (f / (frames - 1.0));
    frame.clips = {at_rest, pose};
    frame.points_m.setZero(3, mesh.node_count());
    frame.forces_N.setZero(3);
    sequence.frames.push_back(frame);
  }
  return sequence;
}

/// 40 frames: stretch along weft and warp, shear, and a sheet that sags between nearer bars.
std::vector<Sequence> all_sequences() {
  std::vector<Sequence> sequences = {
      between_bars("weft", true, 10, {0.0006, 0.0, 0.0}, {0.006, 0.0, 0.0}),
      between_bars("warp", false, 10, {0.0, 0.0006, 0.0}, {0.0, 0.006, 0.0}),
      between_bars("shear", false, 10, {0.0008, 0.0005, 0.0}, {0.008, 0.001, 0.0}),
      between_bars("sag weft", true, 5, {-0.010, 0.0, 0.0}, {-0.014, 0.0, 0.0}),
      between_bars("sag warp", false, 5, {0.0, -0.010, 0.0}, {0.0, -0.014, 0.0})};
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const Eigen::VectorXd truth = true_values();
  for (Sequence& sequence : sequences) {
    auto exact = SequenceEvaluator::make(cloth_model(truth), {sequence});
    if (!exact) give_up(exact.error().message);
    Eigen::VectorXd predicted;
    if (exact->evaluate(truth, predicted, nullptr) != mechanics::PathStatus::ok)
      give_up(exact->failure());
    for (int r = 0; r < exact->row_count(); ++r) {
      const Row& row = exact->rows()[static_cast<std::size_t>(r)];
      SequenceFrame& frame = sequence.frames[static_cast<std::size_t>(row.frame)];
      const int points = 3 * static_cast<int>(sequence.points.size());
      if (row.channel < points)
        frame.points_m(row.channel % 3, row.channel / 3) =
            kPointSigma_m * (predicted[r] + normal(random));
      else
        frame.forces_N[row.channel - points] = kForceSigma_N * (predicted[r] + normal(random));
    }
  }
  return sequences;
}

/// Seconds of one factorisation and one solve by CHOLMOD, the best of its ways.
double floor_s(const Sequence& sequence) {
  const Eigen::VectorXd truth = true_values();
  const auto model = mechanics::MeshModel::make(cloth_model(truth), sequence.cloth).value();
  auto solver = mechanics::EquilibriumSolver::make(model, sequence.boundaries[0]).value();
  mechanics::State state = sequence.start;
  prescribe(sequence, 0, true, state);
  if (!solver.solve(truth, sequence.loads, state)) give_up("the floor has no equilibrium");
  const mechanics::Contact none;
  const mechanics::Potential potential(model, truth, solver.boundary(), solver.unknowns(),
                                       sequence.loads, none);
  mechanics::PotentialValue value;
  if (!potential.evaluate_with_stiffness(state, 0.0, value)) give_up("the floor is not finite");
  double best = std::numeric_limits<double>::infinity();
  using namespace mechanics::bench;
  for (const Ordering ordering : {Ordering::amd, Ordering::metis})
    for (const Relaxation relaxation : {Relaxation::standard, Relaxation::wide}) {
      auto factor = make_cholmod_floor(ordering, relaxation);
      factor->analyze(solver.unknowns().pattern());
      Eigen::VectorXd x = Eigen::VectorXd::Ones(solver.unknowns().count());
      std::vector<double> times;
      for (int k = 0; k < 41; ++k) {
        const double began = processor_seconds();
        if (factor->factorize(value.stiffness.data()) != mechanics::FactorStatus::ok)
          give_up("the floor does not factor the matrix");
        factor->solve(x.data(), x.data(), 1);
        times.push_back(processor_seconds() - began);
        x.setOnes();
      }
      std::nth_element(times.begin(), times.begin() + 20, times.end());
      best = std::min(best, times[20]);
    }
  return best;
}

struct Way {
  const char* name;
  FitMethod method;
  double stepping_tolerance_N;
  bool is_stepping;  ///< or every evaluation exact
};

/// An evaluator that is always exact.
class AlwaysExact final : public ResidualFunction {
 public:
  explicit AlwaysExact(ResidualFunction& inner) : inner_(inner) {}
  int parameter_count() const override { return inner_.parameter_count(); }
  const std::vector<Row>& rows() const override { return inner_.rows(); }
  Eigen::VectorXd weights() const override { return inner_.weights(); }
  mechanics::PathStatus evaluate(const Eigen::VectorXd& p, Eigen::VectorXd& r,
                                 RowMatrix* j) override {
    return inner_.evaluate(p, r, j);
  }

 private:
  ResidualFunction& inner_;
};

}  // namespace

int main(int argc, char** argv) {
  const int starts = argc > 1 ? std::atoi(argv[1]) : 3;
  const std::vector<Sequence> sequences = all_sequences();
  const double floor = floor_s(sequences[2]);
  std::printf("floor: %.3f ms\n", 1e3 * floor);
  std::printf("%-26s %5s %7s %6s %6s %7s %8s %7s %7s %7s %6s %9s %7s\n", "way", "start", "floors",
              "outer", "inner", "factors", "energies", "equil.", "sens.", "rest", "share",
              "chi2/row", "worst");
  const double as_exact = SequenceOptions().stepping_tolerance_N;
  const Way ways[] = {{"trust region", FitMethod::trust_region, as_exact, true},
                      {"trust region, to 1e-6 N", FitMethod::trust_region, 1e-6, true},
                      {"trust region, exact", FitMethod::trust_region, as_exact, false},
                      {"Gauss-Newton, 1 %", FitMethod::gauss_newton, as_exact, true}};
  for (const Way& way : ways) {
    std::mt19937 random(7);
    for (int start = 0; start < starts; ++start) {
      Eigen::VectorXd values = true_values();
      for (int p = 0; p < 5; ++p) {
        const double off = std::uniform_real_distribution<double>(0.3, 0.5)(random);
        values[p] *= random() % 2 ? 1.0 + off : 1.0 - off;
      }
      const model::Model model = cloth_model(values);
      SequenceOptions options;
      options.clock = processor_seconds;
      options.stepping_tolerance_N = way.stepping_tolerance_N;
      auto evaluator = SequenceEvaluator::make(model, sequences, options);
      if (!evaluator) give_up(evaluator.error().message);
      AlwaysExact exact(*evaluator);
      FitOptions how;
      how.method = way.method;
      const double began = processor_seconds();
      const FitResult result =
          way.is_stepping ? fit(*evaluator, model, how) : fit(exact, model, how);
      const double seconds = processor_seconds() - began;
      if (!result.usable) give_up(result.message + evaluator->failure());
      const SequenceCost& cost = evaluator->cost();
      double worst = 0.0;
      for (int p = 0; p < 5; ++p)
        worst = std::max(worst,
                         std::abs(result.parameters[p] - true_values()[p]) / result.std_error[p]);
      // per frame: all sensitivities beside one equilibrium
      const double share =
          (cost.sensitivity_s / cost.sensitivities) / (cost.equilibrium_s / cost.equilibria);
      std::printf("%-26s %5d %7.0f %6d %6d %7d %8d %7.0f %7.0f %7.0f %5.0f%% %9.4f %7.3f %s\n",
                  way.name, start + 1, seconds / floor, result.iterations, cost.iterations,
                  cost.factorisations, cost.evaluations, cost.equilibrium_s / floor,
                  cost.sensitivity_s / floor,
                  (seconds - cost.equilibrium_s - cost.sensitivity_s) / floor, 100.0 * share,
                  result.residuals.squaredNorm() / evaluator->row_count(), worst,
                  result.converged ? "" : result.message.c_str());
    }
  }
  return 0;
}
