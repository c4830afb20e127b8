// SPDX-License-Identifier: GPL-3.0-or-later
// What equilibrium costs on the cases of tests/bench/cases, in floors: CHOLMOD's factorisation and
// one solve of the same matrix in the same run, one thread.
//
//   tenter-bench-equilibrium [--benchmark_filter=25] [--benchmark_out=FILE ...]
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/equilibrium/case_file.h"
#include "tests/bench/equilibrium/cholmod_floor.h"
#include "tests/bench/equilibrium/ratio_table.h"

namespace {

using namespace tenter;
using namespace tenter::mechanics;
using bench::Ordering;
using bench::Relaxation;

/// A case, its solver, and its first equilibrium.
class Bench {
 public:
  explicit Bench(const std::string& name) {
    auto read = bench::read_case(std::filesystem::path(TENTER_BENCH_CASES) / (name + ".json"));
    if (!read) give_up(read.error().message);
    file = std::move(*read);
    auto made = MeshModel::make(file.model, file.cloth);
    if (!made) give_up(made.error().message);
    model = std::make_unique<MeshModel>(std::move(*made));
    auto solves = EquilibriumSolver::make(*model, file.boundary);
    if (!solves) give_up(solves.error().message);
    solver = std::make_unique<EquilibriumSolver>(std::move(*solves));
    options.tolerance_N = file.tolerance_N;
  }

  EquilibriumResult solve(State& state, const EquilibriumOptions& how) {
    auto result = solver->solve(file.parameters, file.loads, state, how);
    if (!result) give_up(result.error().message);
    if (!result->is_good(how)) give_up(describe(*result, how));
    return std::move(*result);
  }

  [[noreturn]] static void give_up(const std::string& why) {
    std::fprintf(stderr, "tenter-bench-equilibrium: %s\n", why.c_str());
    std::exit(1);
  }

  bench::Case file;
  std::unique_ptr<MeshModel> model;
  std::unique_ptr<EquilibriumSolver> solver;
  EquilibriumOptions options;
};

void report(benchmark::State& state, int iterations, double net_force_N) {
  state.counters["iterations"] = iterations;
  state.counters["check"] = net_force_N;
}

/// The matrix at the equilibrium of `bench`, factored and solved by CHOLMOD.
void floor_of(benchmark::State& state, Bench& bench, Ordering ordering, Relaxation relaxation) {
  State x = bench.file.start;
  bench.solve(x, bench.options);
  const Contact none;
  const Potential potential(*bench.model, bench.file.parameters, bench.solver->boundary(),
                            bench.solver->unknowns(), bench.file.loads, none);
  PotentialValue value;
  if (!potential.evaluate_with_stiffness(x, 0.0, value)) Bench::give_up("not finite");
  auto factor = bench::make_cholmod_floor(ordering, relaxation);
  factor->analyze(bench.solver->unknowns().pattern());
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(bench.solver->unknowns().count());
  Eigen::VectorXd solution = ones;
  for (auto _ : state) {
    if (factor->factorize(value.stiffness.data()) != FactorStatus::ok)
      Bench::give_up("the floor does not factor the matrix");
    factor->solve(ones.data(), solution.data(), 1);
    benchmark::DoNotOptimize(solution.data());
  }
  state.counters["Mflop"] = factor->cost().flops / 1e6;
  state.counters["MB"] = static_cast<double>(factor->cost().bytes) / 1e6;
}

/// Energy, forces and stiffness at the equilibrium, reduced to the free nodes.
void assembly(benchmark::State& state, Bench& bench, double positive_share) {
  State x = bench.file.start;
  bench.solve(x, bench.options);
  const Contact none;
  const Potential potential(*bench.model, bench.file.parameters, bench.solver->boundary(),
                            bench.solver->unknowns(), bench.file.loads, none);
  PotentialValue value;
  for (auto _ : state)
    if (!potential.evaluate_with_stiffness(x, positive_share, value)) Bench::give_up("not finite");
}

/// From the start of the case.
void cold(benchmark::State& state, Bench& bench) {
  EquilibriumResult result;
  for (auto _ : state) {
    State x = bench.file.start;
    result = bench.solve(x, bench.options);
  }
  report(state, result.iterations, result.last.net_force_N);
}

/// Again with other parameters, from the equilibrium.
void warm(benchmark::State& state, Bench& bench, bool check_minimum) {
  EquilibriumOptions near = bench.options;
  near.start_is_near = true;
  near.check_minimum = check_minimum;
  const Eigen::VectorXd there = bench.file.parameters.cwiseProduct(bench.file.scale);
  EquilibriumResult result;
  for (auto _ : state) {
    state.PauseTiming();
    State x = bench.file.start;
    bench.solve(x, bench.options);
    state.ResumeTiming();
    auto solved = bench.solver->solve(there, bench.file.loads, x, near);
    if (!solved || !solved->is_good(near)) Bench::give_up("the warm start failed");
    result = std::move(*solved);
  }
  report(state, result.iterations, result.last.net_force_N);
}

/// All frames of the path, from its first equilibrium; returns the iterations.
int walk(Bench& bench, State& x) {
  EquilibriumOptions near = bench.options;
  near.start_is_near = true;
  int iterations = 0;
  for (int frame = 0; frame < bench.file.frames; ++frame) {
    x.x.segment<3>(3 * static_cast<Eigen::Index>(bench.file.right_pin)) += bench.file.move_m;
    iterations += bench.solve(x, near).iterations;
  }
  return iterations;
}

void path(benchmark::State& state, Bench& bench) {
  int iterations = 0;
  for (auto _ : state) {
    state.PauseTiming();
    State x = bench.file.start;
    bench.solve(x, bench.options);
    state.ResumeTiming();
    iterations = walk(bench, x);
  }
  state.counters["iterations"] = iterations;
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Two sequences one after the other, and at once in two threads.
void print_two_cores() {
  Bench first("path_25"), second("path_25");
  const auto sequence = [](Bench& bench) {
    for (int k = 0; k < 10; ++k) {
      State x = bench.file.start;
      bench.solve(x, bench.options);
      walk(bench, x);
    }
  };
  sequence(first);
  double best = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double one = seconds_of([&] {
      sequence(first);
      sequence(second);
    });
    const double two = seconds_of([&] {
      std::thread other([&] { sequence(second); });
      sequence(first);
      other.join();
    });
    best = std::max(best, one / two);
  }
  std::printf("two sequences in two threads: %.2f times as fast as one after the other\n", best);
}

/// Cost of a Newton iteration against the number of unknowns, c n^p by least squares in logarithms.
void print_exponent() {
  std::vector<double> size, cost;
  for (const std::string name : {"hanging_25", "hanging_50", "hanging_100"}) {
    Bench bench(name);
    double best = 1e300;
    for (int k = 0; k < 3; ++k) {
      State x = bench.file.start;
      int iterations = 1;
      const double s = seconds_of([&] { iterations = bench.solve(x, bench.options).iterations; });
      best = std::min(best, s / iterations);
    }
    size.push_back(std::log(bench.solver->unknowns().count()));
    cost.push_back(std::log(best));
  }
  double mean_size = 0.0, mean_cost = 0.0, sxy = 0.0, sxx = 0.0;
  for (std::size_t i = 0; i < size.size(); ++i) {
    mean_size += size[i] / static_cast<double>(size.size());
    mean_cost += cost[i] / static_cast<double>(size.size());
  }
  for (std::size_t i = 0; i < size.size(); ++i) {
    sxy += (size[i] - mean_size) * (cost[i] - mean_cost);
    sxx += (size[i] - mean_size) * (size[i] - mean_size);
  }
  std::printf("cost of an iteration from 25 x 25 to 100 x 100: unknowns to the power %.2f\n",
              sxy / sxx);
  struct rusage usage {};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("peak memory of this process, 100 x 100 included: %.0f MB\n",
              static_cast<double>(usage.ru_maxrss) / 1e3);
}

}  // namespace

int main(int argc, char** argv) {
  char interleaved[] = "--benchmark_enable_random_interleaving=true";
  std::vector<char*> arguments = {argv[0], interleaved};
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  print_exponent();
  print_two_cores();

  std::map<std::string, Bench> cases;
  for (const std::string name : {"hanging_25", "closer_25", "horizontal_25", "warm_25", "path_25",
                                 "hanging_50", "closer_50", "hanging_100", "closer_100"})
    cases.emplace(std::piecewise_construct, std::forward_as_tuple(name),
                  std::forward_as_tuple(name));
  const auto add = [](const std::string& name, auto function) {
    benchmark::RegisterBenchmark(name.c_str(), function)
        ->Unit(benchmark::kMillisecond)
        ->MeasureProcessCPUTime()
        ->MinTime(0.1)
        ->Repetitions(5);
  };
  for (const std::string nodes : {"25", "50", "100"}) {
    const std::string size = nodes + " x " + nodes;
    Bench& hanging = cases.at("hanging_" + nodes);
    Bench& closer = cases.at("closer_" + nodes);
    for (const auto& [ordering, ordering_name] :
         {std::pair{Ordering::amd, "AMD"}, std::pair{Ordering::metis, "METIS"}})
      for (const auto& [relaxation, relaxation_name] :
           {std::pair{Relaxation::standard, ""}, std::pair{Relaxation::wide, ", wide"}})
        add(size + "/floor: " + ordering_name + relaxation_name,
            [&hanging, ordering = ordering, relaxation = relaxation](benchmark::State& state) {
              floor_of(state, hanging, ordering, relaxation);
            });
    add(size + "/assembly", [&hanging](benchmark::State& state) { assembly(state, hanging, 0.0); });
    add(size + "/assembly, positive part",
        [&hanging](benchmark::State& state) { assembly(state, hanging, 1.0); });
    add(size + "/hanging", [&hanging](benchmark::State& state) { cold(state, hanging); });
    add(size + "/pins 10 % closer", [&closer](benchmark::State& state) { cold(state, closer); });
    if (nodes != "25") continue;
    add(size + "/from the horizontal plane",
        [&cases](benchmark::State& state) { cold(state, cases.at("horizontal_25")); });
    add(size + "/parameters + 1 %",
        [&cases](benchmark::State& state) { warm(state, cases.at("warm_25"), true); });
    add(size + "/parameters + 1 %, no check",
        [&cases](benchmark::State& state) { warm(state, cases.at("warm_25"), false); });
    add(size + "/path of 40 frames",
        [&cases](benchmark::State& state) { path(state, cases.at("path_25")); });
  }
  bench::RatioTable table;
  benchmark::RunSpecifiedBenchmarks(&table);
  benchmark::Shutdown();
  return 0;
}
