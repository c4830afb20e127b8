// SPDX-License-Identifier: GPL-3.0-or-later
// The staged fit of one twin fabric (thesis 3.4.2): time, what each stage did, memory.
//
//   tenter-bench-staged [--fabric=18] [--nodes=25] [--frames=40] [--threads=2] [--coupled=1]
//                       [--early=20] [--model=cloth_springs_spline] [--law=hermite_stiffness]
//                       [--points=5] [--verbose=1]
#include <chrono>
#include <cstdio>

#include "common/model/presets.h"
#include "server/estimation/staged/splines/spline_refinement.h"
#include "server/estimation/staged/staged_fit.h"
#include "tests/bench/staged/twin_rig.h"

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv) {
  using namespace tenter;
  const auto number = [&](const char* name, const char* otherwise) {
    return std::stoi(bench::argument(argc, argv, name, otherwise));
  };
  const std::string fabric = bench::argument(argc, argv, "fabric", "18");
  bench::RigSettings rig;
  rig.nodes = number("nodes", "25");
  rig.frames = number("frames", "40");
  auto before = Clock::now();
  const auto measured = bench::fitting_sequences(fabric, rig);
  std::printf("#%s, %d x %d nodes, %d frames a sequence: measured in %.1f s\n", fabric.c_str(),
              rig.nodes, rig.nodes, rig.frames, seconds_since(before));

  estimation::StagedOptions options;
  options.stage.threads = number("threads", "2");
  options.coupled = number("coupled", "1") != 0;
  options.stage.most_points = number("points", "5");
  options.early_frames = number("early", "20");
  const std::string form = bench::argument(argc, argv, "model", "cloth_stvk_spline");
  before = Clock::now();
  const double cpu_before = bench::cpu_seconds();
  const bool is_verbose = number("verbose", "0") != 0;
  if (is_verbose)
    options.stage.on_progress = [&](const estimation::StageProgress& p) {
      std::printf("  %6.2f s  %-14s %d points  iteration %2d  cost %.6g\n", seconds_since(before),
                  p.stage.c_str(), p.control_points, p.iteration, p.cost);
      std::fflush(stdout);
      return true;
    };
  model::Model start = model::preset(form).value();
  if (const std::string law = bench::argument(argc, argv, "law", ""); !law.empty())
    for (model::Term& term : start.terms)
      if (estimation::is_spline(term.law)) term.law.name = law;
  const auto fit = estimation::staged_fit(std::move(start), measured, options);
  if (!fit) {
    std::fprintf(stderr, "%s\n", fit.error().message.c_str());
    return 1;
  }
  const double seconds = seconds_since(before);
  const double cpu_seconds = bench::cpu_seconds() - cpu_before;
  std::printf(
      "stage            rows   cost/rows: start     guess       fit   points  iterations  "
      "dropped  not free\n");
  for (const estimation::StageRecord& s : fit->stages) {
    const double rows = s.rows > 0 ? s.rows : 1.0;
    int points = 0;
    for (const auto& r : s.refinements)
      if (r.kept) points = r.control_points;
    std::printf("%-14s %6d  %16.4g %9.4g %9.4g  %7d  %10d  %7zu  %8zu  %s %s\n", s.name.c_str(),
                s.rows, s.cost_at_start / rows, s.cost_before / rows, s.cost_after / rows, points,
                s.iterations, s.dropped.size(), s.not_free.size(), s.message.c_str(),
                s.guess_message.c_str());
  }
  for (const model::Term& term : fit->model.terms) {
    std::printf("%-14s [%.4g, %.4g]", term.id.c_str(), term.law.range_lo, term.law.range_hi);
    for (const model::Parameter& p : term.law.parameters) std::printf("  %.4g", p.value);
    std::printf("\n");
  }
  std::printf("staged fit: %.1f s with %d threads (%.1f CPU seconds), peak memory %.0f MB\n",
              seconds, options.stage.threads, cpu_seconds, bench::peak_memory_MB());
  return 0;
}
