// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-knit-table MODEL.json DESCRIBE_DIR DATA_DIR [NAME...]: each knit that has a
// description as a sheet between clamps, fitted to force and pins of pulls 2 to 4. Pulls 5 and 1
// are foretold, by the model and by the mean of pulls 2 to 4 at the same distance of the clamps,
// and each pin that was left out. Imports as `tenter capture import --runs` does.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <tuple>

#include "common/base/text_file.h"
#include "common/capture/run_selection.h"
#include "common/capture/sheet_import/sheet_import.h"
#include "common/model/document.h"
#include "server/estimation/fit.h"
#include "server/estimation/sequences/from_capture.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/bench/cpu_time.h"

namespace tenter::bench {
namespace {

using namespace estimation;
namespace fs = std::filesystem;

const std::vector<int> kFitted = {2, 3, 4};
constexpr int kFrames = 60;
constexpr int kPoints = 6;  // of the curve along the pull
constexpr int kNodes = 17;  // on a side of a square of the same area

struct Knit {
  capture::Capture whole;
  double stretch = 1.0;  ///< the largest
};

Expected<CapturedSequence> pulls(const Knit& knit, const std::vector<int>& runs) {
  auto capture = capture::with_runs(knit.whole, runs);
  if (!capture) return tl::unexpected(capture.error());
  return sequence_from_capture(*capture, {.nodes_u = kNodes, .most_frames = kFrames});
}

/// The curve along the pull over the strains of this knit.
model::Model starting(const model::Model& given, const Knit& knit) {
  model::Model model = given;
  for (model::Term& term : model.terms)
    if (term.law.name == "convex_spline") {
      term.law.range_hi = 0.525 * (knit.stretch * knit.stretch - 1.0);
      term.law.parameters.resize(kPoints);
    }
  return model;
}

Expected<model::Model> fitted(model::Model model, Sequence sequence, int without) {
  if (without >= 0)
    for (SequenceFrame& frame : sequence.frames)
      frame.points_m.col(without).setConstant(std::numeric_limits<double>::quiet_NaN());
  auto evaluator = SequenceEvaluator::make(model, {std::move(sequence)});
  if (!evaluator) return tl::unexpected(evaluator.error());
  FitOptions how;
  how.method = FitMethod::bounded_marquardt;
  how.loss = {.kind = Loss::cauchy, .scale = 2.385};  // figures of the gauge were misread
  how.tolerance = 1e-4;
  how.max_iterations = 80;
  const FitResult found = fit(*evaluator, model, how);
  if (!found.usable) return bad_input(found.message + " " + evaluator->failure());
  store(found, model);
  return model;
}

struct Errors {
  double force_N = 0.0;
  std::vector<double> pin_mm;  ///< of the length of what is missed
};

double rms(const std::vector<double>& squares) {
  double sum = 0.0;
  for (const double square : squares) sum += square;
  return squares.empty() ? std::nan("") : std::sqrt(sum / static_cast<double>(squares.size()));
}

Expected<Errors> errors(const model::Model& model, const Sequence& sequence) {
  auto evaluator = SequenceEvaluator::make(model, {sequence});
  if (!evaluator) return tl::unexpected(evaluator.error());
  Eigen::VectorXd r;
  if (evaluator->evaluate(parameter_values(model), r, nullptr) != mechanics::PathStatus::ok)
    return bad_input(evaluator->failure());
  const auto points = static_cast<int>(sequence.points.size());
  std::vector<double> force;
  std::vector<std::vector<double>> pin(sequence.points.size());
  for (std::size_t i = 0; i < evaluator->rows().size(); ++i) {
    const int channel = evaluator->rows()[i].channel;
    const double value = r[static_cast<Eigen::Index>(i)];
    if (channel >= 3 * points)
      force.push_back(std::pow(value * sequence.forces[0].sigma_N, 2));
    else
      pin[static_cast<std::size_t>(channel / 3)].push_back(
          2e6 *
          std::pow(value * sequence.points[static_cast<std::size_t>(channel / 3)].sigma_m, 2));
  }
  Errors all;
  all.force_N = rms(force);
  for (const auto& squares : pin) all.pin_mm.push_back(rms(squares));
  return all;
}

/// Force of a run at a distance, linear between the frames about it; NaN beyond them.
double force_at(const capture::Capture& capture, int run, double distance_m) {
  const capture::Sheet& sheet = *capture.sheet;
  double below = -1.0, above = 1e9, at_below = 0.0, at_above = 0.0;
  for (std::size_t f = 0; f < capture.frame_count(); ++f) {
    if (capture.runs[static_cast<std::size_t>(capture.run[f])].number != run) continue;
    const double here = sheet.distance_m(sheet.slack->clips, f);
    const double force = sheet.cords[0].tension_N[f];
    if (here <= distance_m && here > below) std::tie(below, at_below) = std::pair(here, force);
    if (here > distance_m && here < above) std::tie(above, at_above) = std::pair(here, force);
  }
  if (below < 0.0 || above > 1e8) return std::nan("");
  return at_below + (distance_m - below) / (above - below) * (at_above - at_below);
}

/// What the mean of the fitted pulls is off by.
double error_of_mean_N(const Knit& knit, int run, const CapturedSequence& held_out) {
  const auto alone = capture::with_runs(knit.whole, {run});
  std::vector<double> squares;
  for (const std::size_t f : held_out.frame) {
    const double distance = alone->sheet->distance_m(alone->sheet->slack->clips, f);
    double mean = 0.0;
    for (const int other : kFitted)
      mean += force_at(knit.whole, other, distance) / static_cast<double>(kFitted.size());
    if (!std::isnan(mean))
      squares.push_back(std::pow(alone->sheet->cords[0].tension_N[f] - mean, 2));
  }
  return rms(squares);
}

Expected<Knit> read(const fs::path& describe, const fs::path& data) {
  auto capture =
      capture::import_sheet(describe.string(), (data / describe.stem()).string() + ".csv");
  if (!capture) return tl::unexpected(capture.error());
  if (!capture->sheet->slack || capture->sheet->cords.size() != 1)
    return bad_input(describe.string() + ": needs a slack distance and one gauge");
  Knit knit{std::move(*capture)};
  const capture::Sheet& sheet = *knit.whole.sheet;
  double longest = 0.0, high = 0.0;
  for (std::size_t f = 0; f < knit.whole.frame_count(); ++f)
    longest = std::max(longest, sheet.distance_m(sheet.slack->clips, f));
  for (const capture::Vec2& corner : sheet.outline_m) high = std::max(high, corner[1]);
  knit.stretch = longest / high;
  return knit;
}

Expected<void> row(const model::Model& given, const fs::path& describe, const fs::path& data) {
  const double before = timing::thread_cpu_seconds();
  const auto knit = read(describe, data);
  if (!knit) return tl::unexpected(knit.error());
  const auto seen = pulls(*knit, kFitted);
  if (!seen) return tl::unexpected(seen.error());
  const auto model = fitted(starting(given, *knit), seen->sequence, -1);
  if (!model) return tl::unexpected(model.error());
  const auto training = errors(*model, seen->sequence);
  if (!training) return tl::unexpected(training.error());
  std::printf("%-22s %7.2f  %8.3f", describe.stem().c_str(), knit->stretch, training->force_N);
  for (const int run : {5, 1}) {
    const auto held_out = pulls(*knit, {run});
    if (!held_out) return tl::unexpected(held_out.error());
    const auto foretold = errors(*model, held_out->sequence);
    if (!foretold) return tl::unexpected(foretold.error());
    std::printf("  %8.3f %8.3f", foretold->force_N, error_of_mean_N(*knit, run, *held_out));
  }
  std::printf("  ");
  for (int pin = 0; pin < static_cast<int>(seen->sequence.points.size()); ++pin) {
    const auto others = fitted(*model, seen->sequence, pin);
    if (!others) return tl::unexpected(others.error());
    const auto missed = errors(*others, seen->sequence);
    if (!missed) return tl::unexpected(missed.error());
    std::printf(" %5.2f/%.2f", missed->pin_mm[static_cast<std::size_t>(pin)],
                training->pin_mm[static_cast<std::size_t>(pin)]);
  }
  std::printf("  %6.1f\n", timing::thread_cpu_seconds() - before);
  std::fflush(stdout);
  return {};
}

int run(int argc, char** argv) {
  const auto text = read_text_file(argv[1], model::kMaxDocumentBytes);
  const auto given = text ? model::parse_model(*text, argv[1])
                          : Expected<model::Model>(tl::unexpected(text.error()));
  if (!given) {
    std::fprintf(stderr, "%s\n", given.error().message.c_str());
    return 2;
  }
  std::vector<fs::path> described;
  for (int k = 4; k < argc; ++k)
    described.push_back(fs::path(argv[2]) / (argv[k] + std::string(".json")));
  if (described.empty())
    for (const auto& entry : fs::directory_iterator(argv[2])) described.push_back(entry.path());
  std::ranges::sort(described);
  std::printf(
      "root mean squares: force in N (by the model, by the mean of pulls 2 to 4), pins in mm "
      "(left out / fitted)\n"
      "%-22s stretch   pulls2-4   pull 5            pull 1               right      left    "
      "bottom       top    centre   CPU s\n",
      "");
  for (const fs::path& one : described)
    if (auto ok = row(*given, one, argv[3]); !ok)
      std::printf("%-22s %s\n", one.stem().c_str(), ok.error().message.c_str());
  return 0;
}

}  // namespace
}  // namespace tenter::bench

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr,
                 "usage: tenter-bench-knit-table MODEL.json DESCRIBE_DIR DATA_DIR [NAME...]\n");
    return 2;
  }
  return tenter::bench::run(argc, argv);
}
