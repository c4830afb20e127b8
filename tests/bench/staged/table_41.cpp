// SPDX-License-Identifier: GPL-3.0-or-later
// Table 4.1 of the thesis for the twins of its two fabrics (A: #12, B: #14): the energy grows by an
// addend a step; training errors as in the thesis, and those of the held-out sequences.
//
//   tenter-bench-table-41 --help
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>

#include "server/estimation/staged/tables/progressive.h"
#include "tests/bench/staged/twin_rig.h"

int main(int argc, char** argv) {
  using namespace tenter;
  using Clock = std::chrono::steady_clock;
  bench::RigSettings rig;
  rig.frames = 20;
  estimation::StageOptions options;
  options.threads = 2;
  std::vector<std::string> fabrics = {"12", "14"};
  bool is_verbose = false;
  CLI::App app("Table 4.1 of the thesis for the twins of its two fabrics.");
  bench::add_rig_options(app, rig);
  app.add_option("--threads", options.threads)->capture_default_str();
  app.add_option("--fabrics", fabrics, "4, 12, 14, 18.")->delimiter(',')->capture_default_str();
  app.add_flag("--verbose", is_verbose, "Say what each stage is doing.");
  CLI11_PARSE(app, argc, argv);
  if (is_verbose)
    options.on_progress = [](const estimation::StageProgress& p) {
      std::fprintf(stderr, "%-12s iteration %2d  cost %.6g\n", p.stage.c_str(), p.iteration,
                   p.cost);
      return true;
    };
  for (const std::string& fabric : fabrics) {
    const auto training = bench::fitting_sequences(fabric, rig);
    const auto held_out = bench::evaluation_sequences(fabric, rig);
    const auto start = Clock::now();
    const auto rows = estimation::progressive_fit(training, held_out, options);
    if (!rows) {
      std::fprintf(stderr, "#%s: %s\n", fabric.c_str(), rows.error().message.c_str());
      continue;
    }
    std::printf("#%s        training: mm        N   held out: mm        N   cost  iterations\n",
                fabric.c_str());
    for (const auto& row : *rows) {
      std::printf("%-12s %12.4f %8.4f %14.4f %8.4f  %.4g  %d", row.name.c_str(),
                  row.training.position_mm, row.training.force_N, row.held_out.position_mm,
                  row.held_out.force_N, row.cost, row.iterations);
      if (row.message != "converged") std::printf("  %s", row.message.c_str());
      if (row.dropped > 0) std::printf("  %d frames dropped", row.dropped);
      if (row.training.restless + row.held_out.restless > 0)
        std::printf("  %d and %d frames without a rest", row.training.restless,
                    row.held_out.restless);
      std::printf("\n");
    }
    std::printf("%.1f s with %d threads, peak memory %.0f MB\n\n",
                std::chrono::duration<double>(Clock::now() - start).count(), options.threads,
                bench::peak_memory_MB());
    std::fflush(stdout);
  }
  return 0;
}
