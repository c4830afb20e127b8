// SPDX-License-Identifier: GPL-3.0-or-later
// One factorisation and one solve on the matrix of a cloth, by every way we have, beside CHOLMOD's.
//
//   tenter-bench-floor [--benchmark_filter=25] [--benchmark_out=FILE --benchmark_out_format=json]
#include <benchmark/benchmark.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "tests/bench/equilibrium/cholmod_floor.h"
#include "tests/bench/equilibrium/ratio_table.h"
#include "tests/server/mechanics/sparse/matrices.h"

namespace {

using namespace tenter::mechanics;
using bench::Ordering;
using bench::Relaxation;

struct Way {
  std::string name;
  std::function<std::unique_ptr<SparseFactor>()> make;
};

std::vector<Way> ways() {
  const auto floor = [](Ordering ordering, Relaxation relaxation) {
    return [=] { return bench::make_cholmod_floor(ordering, relaxation); };
  };
  const auto ours = [](InstructionSet set) { return [=] { return make_supernodal_factor(set); }; };
  return {{"floor: AMD", floor(Ordering::amd, Relaxation::standard)},
          {"floor: AMD, wide", floor(Ordering::amd, Relaxation::wide)},
          {"floor: METIS", floor(Ordering::metis, Relaxation::standard)},
          {"floor: METIS, wide", floor(Ordering::metis, Relaxation::wide)},
          {"CHOLMOD behind our interface", make_cholmod_factor},
          {"ours", ours(InstructionSet::best)},
          {"ours, AVX2", ours(InstructionSet::avx2)},
          {"ours, portable", ours(InstructionSet::portable)}};
}

struct Case {
  test::TestMatrix matrix;
  std::vector<double> right_side;
};

/// Checked before its time counts: the residual of this way's own answer.
bool prepare(benchmark::State& state, SparseFactor& factor, const Case& input, int count,
             std::vector<double>& solution) {
  factor.analyze(input.matrix.pattern);
  solution.resize(input.right_side.size());
  if (factor.factorize(input.matrix.values.data()) != FactorStatus::ok) {
    state.SkipWithError("not factored");
    return false;
  }
  factor.solve(input.right_side.data(), solution.data(), count);
  double worst = 0.0;
  for (int k = 0; k < count; ++k) {
    const std::size_t offset = static_cast<std::size_t>(k) * input.matrix.pattern.size;
    worst = std::max(worst, test::residual(input.matrix, solution.data() + offset,
                                           input.right_side.data() + offset));
  }
  state.counters["check"] = worst;
  state.counters["MB"] = static_cast<double>(factor.cost().bytes) / 1e6;
  if (!(worst < 1e-11)) state.SkipWithError("wrong answer");
  return worst < 1e-11;
}

void factor_and_solve(benchmark::State& state, const Way& way, const Case& input) {
  const std::unique_ptr<SparseFactor> factor = way.make();
  std::vector<double> solution;
  if (!prepare(state, *factor, input, 1, solution)) return;
  state.counters["Mflop"] = factor->cost().flops / 1e6;
  for (auto _ : state) {
    if (factor->factorize(input.matrix.values.data()) != FactorStatus::ok)
      state.SkipWithError("not factored");
    factor->solve(input.right_side.data(), solution.data(), 1);
    benchmark::DoNotOptimize(solution.data());
  }
}

void solve_only(benchmark::State& state, const Way& way, const Case& input, int count) {
  const std::unique_ptr<SparseFactor> factor = way.make();
  std::vector<double> solution;
  if (!prepare(state, *factor, input, count, solution)) return;
  state.counters["Mflop"] = 4e-6 * factor->cost().factor_entries * count;
  for (auto _ : state) {
    factor->solve(input.right_side.data(), solution.data(), count);
    benchmark::DoNotOptimize(solution.data());
  }
}

void analysis(benchmark::State& state, const Way& way, const Case& input) {
  const std::unique_ptr<SparseFactor> factor = way.make();
  std::vector<double> solution;
  if (!prepare(state, *factor, input, 1, solution)) return;
  for (auto _ : state) {
    const std::unique_ptr<SparseFactor> fresh = way.make();
    fresh->analyze(input.matrix.pattern);
  }
}

}  // namespace

int main(int argc, char** argv) {
  // ways take turns, so that what else the machine does falls on all of them
  char interleaved[] = "--benchmark_enable_random_interleaving=true";
  std::vector<char*> arguments = {argv[0], interleaved};
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  constexpr int kManyRightSides = 16;
  std::mt19937 random(25);
  std::vector<Case> inputs;
  for (const int nodes : {25, 50, 100}) {
    test::TestMatrix matrix = test::cloth_matrix(nodes, random);
    std::vector<double> b = test::random_vector(kManyRightSides * matrix.pattern.size, random);
    inputs.push_back({std::move(matrix), std::move(b)});
  }
  const std::vector<std::string> sizes = {"25 x 25", "50 x 50", "100 x 100"};
  const auto add = [](const std::string& name, auto function) {
    benchmark::RegisterBenchmark(name.c_str(), function)
        ->Unit(benchmark::kMillisecond)
        ->MeasureProcessCPUTime()
        ->MinTime(0.1)
        ->Repetitions(5);
  };
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const Case& input = inputs[i];
    for (const Way& way : ways()) {
      add(sizes[i] + " factor+solve/" + way.name,
          [way, &input](benchmark::State& state) { factor_and_solve(state, way, input); });
      if (way.name.starts_with("ours, ")) continue;
      add(sizes[i] + " solve 1/" + way.name,
          [way, &input](benchmark::State& state) { solve_only(state, way, input, 1); });
      add(sizes[i] + " solve 16/" + way.name, [way, &input](benchmark::State& state) {
        solve_only(state, way, input, kManyRightSides);
      });
      add(sizes[i] + " analyze/" + way.name,
          [way, &input](benchmark::State& state) { analysis(state, way, input); });
    }
  }
  bench::RatioTable table;
  benchmark::RunSpecifiedBenchmarks(&table);
  benchmark::Shutdown();
  return 0;
}
