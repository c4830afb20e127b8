// SPDX-License-Identifier: GPL-3.0-or-later
// How often a fit reaches the best basin: from poor starts as they are, and with the equation gap
// between start and fit. Cases: all six curves jointly from one sequence, which the thesis calls
// fraught with local minima (3.4), and from all five.
//
//   tenter-bench-first-guess --help
//
// The costs of every way, sorted, are the waterfalls of the JSON.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/model/presets.h"
#include "server/estimation/staged/splines/spline_refinement.h"
#include "server/estimation/staged/start/multi_start.h"
#include "tests/bench/staged/twin_rig.h"
#include "tests/twin/fabrics/sequences/fabric_model.h"

namespace {

using namespace tenter;
using Clock = std::chrono::steady_clock;

/// Curves over the ranges of the truth, with the truth's mean stiffness.
model::Model form_of(const std::string& fabric, int points) {
  const model::Model truth = twin::fabric_model(twin::fabric(fabric));
  model::Model model = model::preset("cloth_stvk_spline").value();
  for (std::size_t t = 0; t < model.terms.size(); ++t) {
    const model::Law& from = truth.terms[t].law;
    model::Law& law = model.terms[t].law;
    double mean = 0.0;
    for (const model::Parameter& p : from.parameters)
      mean += p.value / static_cast<double>(from.parameters.size());
    law = estimation::as_constant(law);
    law.parameters.front().value = mean;
    if (!(from.range_hi > from.range_lo)) continue;
    law.range_lo = from.range_lo;
    law.range_hi = from.range_hi;
    law = estimation::with_points(law, points).value();
  }
  return model;
}

}  // namespace

int main(int argc, char** argv) {
  bench::RigSettings rig;
  rig.nodes = 13;
  rig.frames = 10;
  std::string fabric = "12", file;
  int count = 16, points = 3, threads = 2;
  double widest = 30.0;
  CLI::App app("How often a fit reaches the best basin, with and without the equation gap.");
  bench::add_rig_options(app, rig);
  app.add_option("--fabric", fabric, "4, 12, 14 or 18.")->capture_default_str();
  app.add_option("--starts", count)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--widest", widest, "Factor by which starts are off at most.")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--points", points, "Control points of a curve.")->capture_default_str();
  app.add_option("--threads", threads)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--json", file, "File for the waterfalls.");
  CLI11_PARSE(app, argc, argv);
  const model::Model model = form_of(fabric, points);
  const estimation::ParameterTies ties = estimation::no_ties(model);

  std::vector<estimation::Sequence> five, one;
  for (auto& s : bench::fitting_sequences(fabric, rig)) five.push_back(std::move(s.sequence));
  one.push_back(bench::evaluation_sequences(fabric, rig).back().sequence);  // corner pull
  const auto starts = estimation::random_starts(ties, count, widest, 7);
  nlohmann::json document = nlohmann::json::array();
  std::printf(
      "#%s, %d numbers, %d starts off by up to a factor of %.0f; %d x %d nodes, %d frames\n",
      fabric.c_str(), static_cast<int>(ties.free.size()), count, widest, rig.nodes, rig.nodes,
      rig.frames);
  for (const auto* sequences : {&one, &five}) {
    double best = INFINITY;
    std::vector<std::vector<estimation::StartOutcome>> ways;
    std::vector<double> seconds;
    for (const bool guess : {false, true}) {
      estimation::MultiStartOptions options;
      options.threads = threads;
      options.fit.max_iterations = 60;
      options.fit.tolerance = 1e-5;
      options.weighting.rule = estimation::WeightingRule::by_noise;
      options.guess = guess;
      const auto before = Clock::now();
      auto outcomes = estimation::multi_start(model, ties, *sequences, starts, options);
      if (!outcomes) {
        std::fprintf(stderr, "%s\n", outcomes.error().message.c_str());
        return 1;
      }
      seconds.push_back(std::chrono::duration<double>(Clock::now() - before).count());
      best = std::min(best, outcomes->front().cost);
      ways.push_back(std::move(*outcomes));
    }
    for (std::size_t w = 0; w < ways.size(); ++w) {
      int reached = 0, failed = 0, iterations = 0;
      nlohmann::json costs = nlohmann::json::array();
      for (const auto& o : ways[w]) {
        reached += o.usable && o.cost <= 1.05 * best ? 1 : 0;
        failed += o.usable ? 0 : 1;
        iterations += o.iterations;
        if (o.usable) costs.push_back(o.cost);
      }
      const std::string name = sequences == &one ? "one sequence" : "five sequences";
      const char* way = w == 0 ? "as they are" : "by equation gap";
      std::printf(
          "%-15s %-16s best basin %2d of %d, %d without a rest, median cost %.4g, best "
          "%.4g, %d iterations, %.0f s\n",
          name.c_str(), way, reached, count, failed, ways[w][ways[w].size() / 2].cost,
          ways[w].front().cost, iterations, seconds[w]);
      document.push_back({{"case", name}, {"way", way}, {"costs", costs}, {"failed", failed}});
    }
  }
  if (!file.empty()) std::ofstream(file) << document.dump(1) << "\n";
  return 0;
}
