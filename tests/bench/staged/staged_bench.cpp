// SPDX-License-Identifier: GPL-3.0-or-later
// The staged fit of one twin fabric (thesis 3.4.2): time, what each stage did, memory.
//
//   tenter-bench-staged --fabric 14 --points 6; --help says more
#include <CLI/CLI.hpp>
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
  bench::RigSettings rig;
  estimation::StagedOptions options;
  options.stage.threads = 2;
  options.early_frames = 20;
  std::string fabric = "18", form = "cloth_stvk_spline", law, knots = "even";
  bool is_verbose = false;
  CLI::App app("The staged fit of one twin fabric: time, what each stage did, memory.");
  bench::add_rig_options(app, rig);
  app.add_option("--fabric", fabric, "4, 12, 14 or 18.")->capture_default_str();
  app.add_option("--threads", options.stage.threads)
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--coupled,!--no-coupled", options.coupled, "With the coupled repeat, or without.");
  app.add_option("--early", options.early_frames, "Frames of early stages.")->capture_default_str();
  app.add_option("--model", form, "A preset.")->capture_default_str();
  app.add_option("--law", law, "Of its curves: hermite_stiffness, bspline_stiffness, ...");
  app.add_option("--points", options.stage.most_points, "Control points at most.")
      ->capture_default_str();
  app.add_option("--knots", knots, "At even strains, or where the data ask for them.")
      ->check(CLI::IsMember({"even", "data"}))
      ->capture_default_str();
  app.add_flag("--verbose", is_verbose, "Say what each stage is doing.");
  CLI11_PARSE(app, argc, argv);
  options.stage.knots_from_data = knots == "data";
  auto before = Clock::now();
  const auto measured = bench::fitting_sequences(fabric, rig);
  std::printf("#%s, %d x %d nodes, %d frames a sequence: measured in %.1f s\n", fabric.c_str(),
              rig.nodes, rig.nodes, rig.frames, seconds_since(before));

  before = Clock::now();
  const double cpu_before = bench::cpu_seconds();
  if (is_verbose)
    options.stage.on_progress = [&](const estimation::StageProgress& p) {
      std::printf("  %6.2f s  %-14s %d points  iteration %2d  cost %.6g\n", seconds_since(before),
                  p.stage.c_str(), p.control_points, p.iteration, p.cost);
      std::fflush(stdout);
      return true;
    };
  model::Model start = model::preset(form).value();
  if (!law.empty())
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
    for (const double knot : term.law.knots) std::printf(" %.3g", knot);
    if (!term.law.knots.empty()) std::printf(" |");
    for (const model::Parameter& p : term.law.parameters) std::printf("  %.4g", p.value);
    std::printf("\n");
  }
  std::printf("staged fit: %.1f s with %d threads (%.1f CPU seconds), peak memory %.0f MB\n",
              seconds, options.stage.threads, cpu_seconds, bench::peak_memory_MB());
  return 0;
}
