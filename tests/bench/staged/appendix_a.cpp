// SPDX-License-Identifier: GPL-3.0-or-later
// Tables A.1 to A.4 of the thesis for the twin fabrics: three models in four variants, fitted to
// five sequences; beside them the two held-out sequences, and the second specimens.
//
//   tenter-bench-appendix-a --help
//
// Entries as in the thesis: N for stretch (all clips), N along the clips for shear, mm over free
// points for bending; held out: N and mm. Rows are fitted at the same time, one thread each.
// The page holds the plots of the nonlinear orthotropic variants: loops, bends, sheets.
#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/estimation/staged/tables/variants.h"
#include "tests/bench/staged/appendix_page.h"
#include "tests/bench/staged/twin_rig.h"

namespace {

using namespace tenter;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Cell {
  estimation::AppendixRow row;
  std::string error;
  double cpu_seconds = 0.0;  ///< of its thread
};

double entry(const estimation::ScenarioResidual& r) {
  return estimation::rows_of(r.role, estimation::Channels::thesis) == estimation::GapRows::positions
             ? r.position_mm
             : r.force_N;
}

void print(const std::string& fabric, const std::vector<Cell>& cells) {
  std::printf("\nSample #%s\n%-17s %-12s %9s %9s %7s %7s %7s | %-19s %-19s| second specimen: %s\n",
              fabric.c_str(), "Fit Variants", "Cloth Model", "Stretch-X", "Stretch-Y", "Shear",
              "Bend-X", "Bend-Y", "complex shear N mm", "corner pull N mm",
              "Stretch-X Stretch-Y Shear Bend-X Bend-Y, complex shear, corner pull");
  for (const Cell& cell : cells) {
    std::printf("%-17s %-12s", words_of(cell.row.variant).c_str(),
                words_of(cell.row.variant.cloth).c_str());
    if (!cell.error.empty()) {
      std::printf(" %s\n", cell.error.c_str());
      continue;
    }
    int dropped = 0;
    for (const auto& stage : cell.row.fit.stages) dropped += static_cast<int>(stage.dropped.size());
    for (const auto& r : cell.row.training) std::printf(" %8.4f", entry(r));
    std::printf(" |");
    int restless = 0;
    for (const auto& r : cell.row.others) {
      restless += r.restless;
      if (r.role == estimation::Role::evaluation)
        std::printf(" %8.4f %8.4f ", r.force_N, r.position_mm);
      else
        std::printf(" %8.4f", entry(r));
    }
    std::printf(" (%.1f CPU s", cell.cpu_seconds);
    if (dropped > 0) std::printf(", %d frames dropped", dropped);
    if (restless > 0) std::printf(", %d frames without a rest", restless);
    std::printf(")\n");
  }
  std::fflush(stdout);
}

nlohmann::json to_json(const std::string& fabric, const Cell& cell) {
  nlohmann::json row = {{"fabric", fabric},
                        {"variant", words_of(cell.row.variant)},
                        {"model", words_of(cell.row.variant.cloth)},
                        {"cpu_seconds", cell.cpu_seconds},
                        {"error", cell.error}};
  for (const auto* list : {&cell.row.training, &cell.row.others})
    for (const auto& r : *list)
      row[list == &cell.row.training ? "training" : "others"].push_back(
          {{"sequence", r.sequence},
           {"force_N", r.force_N},
           {"position_mm", r.position_mm},
           {"frames", r.frames},
           {"restless", r.restless}});
  for (const auto& stage : cell.row.fit.stages) {
    nlohmann::json record = {{"name", stage.name},
                             {"message", stage.message},
                             {"cost_before", stage.cost_before},
                             {"cost_after", stage.cost_after},
                             {"rows", stage.rows},
                             {"dropped", stage.dropped.size()}};
    for (const auto& p : stage.not_free) record["not_free"].push_back(p.parameter);
    row["stages"].push_back(record);
  }
  return row;
}

}  // namespace

int main(int argc, char** argv) {
  const auto start = Clock::now();
  bench::RigSettings rig;
  rig.frames = 20;
  int threads = 2, points = 5;
  int early_frames = 10;  // half of 20: every branch of the loops and its end are still seen
  std::string curves, page_file, file;
  std::vector<std::string> fabrics = {"4", "12", "14", "18"};
  CLI::App app("Tables A.1 to A.4 of the thesis for the twin fabrics.");
  bench::add_rig_options(app, rig);
  app.add_option("--threads", threads)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--fabrics", fabrics, "4, 12, 14, 18.")->delimiter(',')->capture_default_str();
  app.add_option("--curves", curves, "Law of nonlinear curves: hermite_stiffness, ...");
  app.add_option("--points", points, "Control points at most.")->capture_default_str();
  app.add_option("--early", early_frames, "Frames of early stages.")->capture_default_str();
  app.add_option("--json", file, "File for the numbers.");
  app.add_option("--html", page_file, "File for the plots.");
  CLI11_PARSE(app, argc, argv);
  bench::AppendixPage page;
  nlohmann::json document = nlohmann::json::array();
  for (const std::string& fabric : fabrics) {
    const auto training = bench::fitting_sequences(fabric, rig);
    auto others = bench::evaluation_sequences(fabric, rig);
    auto drawn = training;
    drawn.insert(drawn.end(), others.begin(), others.end());
    bench::RigSettings again = rig;
    again.seed = rig.seed + 1;
    for (auto&& sequences : {bench::fitting_sequences(fabric + ".2", again),
                             bench::evaluation_sequences(fabric + ".2", again)})
      others.insert(others.end(), sequences.begin(), sequences.end());
    auto variants = estimation::all_variants();
    for (estimation::Variant& variant : variants) variant.curves = curves;
    std::vector<Cell> cells(variants.size());
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t k = next++; k < variants.size(); k = next++) {
        const double before = timing::thread_cpu_seconds();
        estimation::StagedOptions options;
        options.stage.threads = 1;
        options.stage.most_points = points;
        options.early_frames = early_frames;
        cells[k].row.variant = variants[k];
        auto row = estimation::appendix_row(variants[k], training, others, options);
        if (row)
          cells[k].row = std::move(*row);
        else
          cells[k].error = row.error().message;
        cells[k].cpu_seconds = timing::thread_cpu_seconds() - before;
      }
    };
    std::vector<std::thread> workers;
    for (int t = 1; t < threads; ++t) workers.emplace_back(work);
    work();
    for (std::thread& worker : workers) worker.join();
    print(fabric, cells);
    for (const Cell& cell : cells) {
      document.push_back(to_json(fabric, cell));
      const auto& variant = cell.row.variant;
      if (page_file.empty() || !cell.error.empty() || !variant.is_nonlinear || variant.is_isotropic)
        continue;
      if (auto ok = page.add(fabric, cell.row, drawn); !ok)
        std::fprintf(stderr, "page: %s\n", ok.error().message.c_str());
    }
  }
  if (!file.empty()) std::ofstream(file) << document.dump(1) << "\n";
  if (!page_file.empty()) {
    const auto html = page.html();
    if (!html) {
      std::fprintf(stderr, "page: %s\n", html.error().message.c_str());
      return 1;
    }
    std::ofstream(page_file) << *html;
  }
  std::printf(
      "\n%d x %d nodes, %d frames a sequence: %.0f s with %d threads (%.0f CPU seconds), peak "
      "memory %.0f MB\n",
      rig.nodes, rig.nodes, rig.frames, seconds_since(start), threads, bench::cpu_seconds(),
      bench::peak_memory_MB());
  return 0;
}
