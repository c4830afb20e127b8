// SPDX-License-Identifier: GPL-3.0-or-later
// What an implicit step of 10 ms costs on hanging cloth (0.5 m, 0.187 kg/m2, two corners held, no
// contact), in milliseconds and in floors: CHOLMOD's factorisation and one solve of the same
// matrix in the same run. CPU time of one thread.
//
//   tenter-bench-step [NODES_A_SIDE ...]          25, 50 and 100: 1152, 4802 and 19602 triangles
//
// The sheet is dropped from the horizontal plane; times are means over 20 steps from 0.3 s on,
// while it swings, and from 2 s on, as it comes to rest.
//
// What friction costs is a ratio: each step with it is timed between two without, in turn, so that
// what else the machine does meets all of them. One of the two is of the sheet without friction in
// its own motion; the other starts where the step with friction does, from the same positions and
// velocities, since the two sheets part and one may be having the harder time.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "server/mechanics/dynamics/step.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/equilibrium/case_file.h"
#include "tests/bench/equilibrium/cholmod_floor.h"

namespace {

using namespace tenter;
using namespace tenter::mechanics;

constexpr double kStep_s = 0.01;
constexpr int kSteps = 20;
constexpr int kRepeats = 3;

[[noreturn]] void give_up(const std::string& why) {
  std::fprintf(stderr, "tenter-bench-step: %s\n", why.c_str());
  std::exit(1);
}

double best_ms(const std::function<void()>& work) {
  double best = 1e300;
  for (int k = 0; k < kRepeats; ++k) {
    const double start = timing::thread_cpu_ms();
    work();
    best = std::min(best, timing::thread_cpu_ms() - start);
  }
  return best;
}

/// That of cotton (Table 5.1) along weft and warp.
void add_friction(model::Model& model) {
  for (const char* strain : {"green_u", "green_v"}) {
    model::Term term;
    term.id = std::string("friction_") + strain;
    term.strain.name = strain;
    term.law.name = "dahl";
    for (const auto& [name, value] : {std::pair{"a", 2.22}, std::pair{"b", 3.16},
                                      std::pair{"c", 0.0}, std::pair{"tau", 0.006}}) {
      model::Parameter p;
      p.name = name;
      p.value = value;
      term.law.parameters.push_back(p);
    }
    model.terms.push_back(term);
  }
}

struct Bench {
  Bench(int nodes, bool has_friction) {
    const std::string name = "hanging_" + std::to_string(nodes) + ".json";
    auto read = bench::read_case(std::filesystem::path(TENTER_BENCH_CASES) / name);
    if (!read) give_up(read.error().message);
    file = std::move(*read);
    if (has_friction) add_friction(file.model);
    file.parameters = term_parameters(file.model);
    auto made = MeshModel::make(file.model, file.cloth);
    if (!made) give_up(made.error().message);
    model = std::make_unique<MeshModel>(std::move(*made));
  }

  TimeStepper stepper() const { return TimeStepper::make(*model, file.boundary).value(); }

  Motion dropped() const {
    State state;
    state.x.resize(file.start.x.size());
    for (Eigen::Index i = 0; i < state.x.size(); i += 3)
      state.x.segment<3>(i) << file.start.x[i], file.start.x[i + 2], file.start.x[i + 1];
    return at_rest(file.boundary, state);
  }

  bench::Case file;
  std::unique_ptr<MeshModel> model;
};

struct Cost {
  double iterations = 0.0, factorisations = 0.0, evaluations = 0.0;
  double worst_N = 0.0;

  void add(const StepResult& step) {
    iterations += step.iterations;
    factorisations += step.factorisations;
    evaluations += step.evaluations;
    worst_N = std::max(worst_N, step.last.net_force_N);
  }
};

/// One step on, which is good.
void take_step(const Bench& bench, TimeStepper& stepper, const StepOptions& options, Motion& motion,
               Cost& cost) {
  const StepInput input{kStep_s, bench.file.loads, {}, {}};
  const auto step = stepper.step(bench.file.parameters, input, motion, options);
  if (!step) give_up(step.error().message);
  if (!step->is_good(options)) give_up(describe(*step, options));
  cost.add(*step);
}

Cost walk(const Bench& bench, TimeStepper& stepper, const StepOptions& options, int steps,
          Motion& motion) {
  Cost cost;
  for (int k = 0; k < steps; ++k) take_step(bench, stepper, options, motion, cost);
  return cost;
}

/// What a step from `motion` makes small, without friction.
struct StepProblem {
  StepProblem(const Bench& bench, const TimeStepper& stepper, const Motion& motion)
      : inertia(inertia_of(bench, motion)),
        potential(*bench.model, bench.file.parameters, bench.file.boundary, stepper.unknowns(),
                  bench.file.loads, contact, nullptr, nullptr, &inertia) {}

  static Inertia inertia_of(const Bench& bench, const Motion& motion) {
    StepStart start;
    start_step(TimeScheme::implicit_euler, bench.file.boundary, motion, kStep_s, start);
    Inertia inertia;
    inertia.set(bench.file.boundary, bench.file.loads.node_mass_kg, start);
    return inertia;
  }

  Contact contact;
  Inertia inertia;
  Potential potential;
};

double floor_ms(const Bench& bench, const TimeStepper& stepper, const Motion& motion) {
  const StepProblem problem(bench, stepper, motion);
  const Potential& potential = problem.potential;
  PotentialValue value;
  if (!potential.evaluate_with_stiffness(motion.at, 1.0, value)) give_up("not finite");
  double best = 1e300;
  Eigen::VectorXd solution = value.by_unknown;
  for (const auto ordering : {bench::Ordering::amd, bench::Ordering::metis}) {
    for (const auto relaxation : {bench::Relaxation::standard, bench::Relaxation::wide}) {
      const auto factor = bench::make_cholmod_floor(ordering, relaxation);
      factor->analyze(stepper.unknowns().pattern());
      best = std::min(best, best_ms([&] {
                        if (factor->factorize(value.stiffness.data()) != FactorStatus::ok)
                          give_up("the floor does not factor the matrix");
                        factor->solve(value.by_unknown.data(), solution.data(), 1);
                      }));
    }
  }
  return best;
}

void print_parts(const Bench& bench, const TimeStepper& stepper, const Motion& motion,
                 double floor) {
  const StepProblem problem(bench, stepper, motion);
  const Potential& potential = problem.potential;
  PotentialValue value;
  const auto print = [&](const char* what, const std::function<void()>& work) {
    work();
    const double ms = best_ms(work);
    std::printf("  %-38s %9.3f ms %6.2f floors\n", what, ms, ms / floor);
  };
  const auto check = [](bool good) {
    if (!good) give_up("not finite");
  };
  print("energy", [&] { check(potential.energy_J(motion.at) < 1e300); });
  print("energy and forces", [&] { check(potential.evaluate(motion.at, value)); });
  print("energy, forces and stiffness",
        [&] { check(potential.evaluate_with_stiffness(motion.at, 0.0, value)); });
  const auto factor = make_factor();
  factor->analyze(stepper.unknowns().pattern());
  check(potential.evaluate_with_stiffness(motion.at, 1.0, value));
  print("factorisation",
        [&] { check(factor->factorize(value.stiffness.data()) == FactorStatus::ok); });
  Eigen::VectorXd solution = value.by_unknown;
  print("solve", [&] { factor->solve(value.by_unknown.data(), solution.data(), 1); });
  print("product", [&] {
    multiply(stepper.unknowns().pattern(), value.stiffness.data(), value.by_unknown.data(),
             solution.data());
  });
}

struct Way {
  const char* name;
  StepOptions options;
};

std::vector<Way> ways() {
  StepOptions euler;
  euler.scheme = TimeScheme::implicit_euler;
  StepOptions linearised = euler;
  linearised.is_linearised = true;
  return {{"linearised", linearised},
          {"converged to 1e-5 N, implicit Euler", euler},
          {"converged to 1e-5 N, BDF2", StepOptions()}};
}

/// The motion at this instant, in steps of implicit Euler.
Motion motion_at(const Bench& bench, TimeStepper& stepper, double until_s) {
  Motion motion = bench.dropped();
  StepOptions euler;
  euler.scheme = TimeScheme::implicit_euler;
  walk(bench, stepper, euler, static_cast<int>(until_s / kStep_s + 0.5), motion);
  return motion;
}

void print_cost(const char* name, double ms, double floor, const Cost& cost) {
  std::printf(
      "  %-38s %9.3f ms %6.2f floors  %.1f iterations %.1f factorisations %.1f evaluations, "
      "%.1e N\n",
      name, ms, ms / floor, cost.iterations / kSteps, cost.factorisations / kSteps,
      cost.evaluations / kSteps, cost.worst_N);
  std::fflush(stdout);
}

void print_ways(const Bench& bench, const char* when, double until_s) {
  TimeStepper stepper = bench.stepper();
  const Motion start = motion_at(bench, stepper, until_s);
  const double floor = floor_ms(bench, stepper, start);
  std::printf(" %s; the floor is %.3f ms\n", when, floor);
  print_parts(bench, stepper, start, floor);
  for (const Way& way : ways()) {
    Cost cost;
    const double ms = best_ms([&] {
                        Motion motion = start;
                        cost = walk(bench, stepper, way.options, kSteps, motion);
                      }) /
                      kSteps;
    print_cost(way.name, ms, floor, cost);
  }
}

/// One of several walks that are timed in turn.
struct Walk {
  explicit Walk(const Bench& of) : bench(of), stepper(of.stepper()) {}

  /// The k-th step from `motion`; its time is the best one of all repeats.
  void step(int k, const StepOptions& options, Motion& motion) {
    const double start = timing::thread_cpu_ms();
    take_step(bench, stepper, options, motion, cost);
    const double ms = timing::thread_cpu_ms() - start;
    double& least = best[static_cast<std::size_t>(k)];
    least = least == 0.0 ? ms : std::min(least, ms);
  }

  double mean_ms() const { return std::accumulate(best.begin(), best.end(), 0.0) / kSteps; }
  /// Of a step in which nothing buckles: those in which it does cost several times as much.
  double median_ms() const {
    std::array<double, kSteps> sorted = best;
    std::nth_element(sorted.begin(), sorted.begin() + kSteps / 2, sorted.end());
    return sorted[kSteps / 2];
  }

  const Bench& bench;
  TimeStepper stepper;
  Cost cost;  ///< of the last repeat
  std::array<double, kSteps> best{};
};

void print_friction(const Bench& elastic, const Bench& friction) {
  TimeStepper elastic_stepper = elastic.stepper(), stepper = friction.stepper();
  const Motion elastic_start = motion_at(elastic, elastic_stepper, 0.3);
  const Motion start = motion_at(friction, stepper, 0.3);
  const double floor = floor_ms(friction, stepper, start);
  std::printf(" with friction, swinging, from 0.3 s; the floor is %.3f ms\n", floor);
  print_parts(friction, stepper, start, floor);
  for (const Way& way : ways()) {
    Walk with(friction), own(elastic), same(elastic);
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      with.cost = own.cost = same.cost = Cost();
      Motion motion = start, elastic_motion = elastic_start;
      for (int k = 0; k < kSteps; ++k) {
        Motion beside = motion;
        beside.history.resize(0);
        beside.last_history.resize(0);
        own.step(k, way.options, elastic_motion);
        with.step(k, way.options, motion);
        same.step(k, way.options, beside);
      }
    }
    print_cost(way.name, with.mean_ms(), floor, with.cost);
    print_cost("  without, in its own motion", own.mean_ms(), floor, own.cost);
    print_cost("  without, from the same states", same.mean_ms(), floor, same.cost);
    std::printf(
        "  friction costs %.2f times the steps without in their own motion (medians: %.2f), "
        "%.2f times those from the same states (%.2f)\n",
        with.mean_ms() / own.mean_ms(), with.median_ms() / own.median_ms(),
        with.mean_ms() / same.mean_ms(), with.median_ms() / same.median_ms());
    std::fflush(stdout);
  }
}

void run(int nodes) {
  const Bench elastic(nodes, false);
  const Bench friction(nodes, true);
  std::printf("\n%d x %d nodes, %zu triangles\n", nodes, nodes,
              elastic.file.cloth.mesh.triangles.size());
  print_ways(elastic, "swinging, from 0.3 s", 0.3);
  print_ways(elastic, "from 2 s", 2.0);
  print_friction(elastic, friction);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes;
  for (int k = 1; k < argc; ++k) sizes.push_back(std::atoi(argv[k]));
  if (sizes.empty()) sizes = {25, 50, 100};
  for (const int nodes : sizes) run(nodes);
  return 0;
}
