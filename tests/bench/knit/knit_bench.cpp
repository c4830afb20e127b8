// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-knit-specimen DATA.csv WIDTH_MM MODEL.json: a knit between two clamps, simulated and
// fitted to the force and five pins of pulls 2 to 4; pulls 5 and 1, and each pin in turn, are left
// out and foretold. Beside it what differs from pull to pull.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <limits>
#include <sstream>

#include "common/model/document.h"
#include "server/estimation/fit.h"
#include "server/estimation/heterogeneity/material_samples.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/bench/knit/knit_data.h"
#include "tests/bench/knit/knit_places.h"

namespace tenter::bench {
namespace {

using namespace estimation;

const std::vector<int> kFitted = {1, 2, 3};         // pulls from 0
const std::vector<int> kAfterFirst = {1, 2, 3, 4};  // the first one is another
constexpr int kLeftOut = 4, kFirst = 0;
constexpr int kRounds = 20;       // of material and places in turn, at most
constexpr double kEnough = 1e-3;  // relative fall of the cost in a round after which none follows

double cpu_s() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Only what the fit may see: pulls, and all pins but one (-1: all).
Sequence seen(const KnitData& data, const std::vector<int>& pulls, int without_pin) {
  Sequence s = data.sequence;
  for (SequenceFrame& frame : s.frames)
    for (int pull = 0; pull < data.pulls; ++pull) {
      const bool is_seen = std::ranges::find(pulls, pull) != pulls.end();
      if (!is_seen) frame.forces_N[pull] = std::numeric_limits<double>::quiet_NaN();
      for (int pin = 0; pin < kPins; ++pin)
        if (!is_seen || pin == without_pin)
          frame.points_m.col(kPins * pull + pin)
              .setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  return s;
}

/// Predicted less measured.
struct Misfit {
  struct Frame {
    std::vector<double> force_N;
    Eigen::Matrix2Xd pin_m;  ///< as PointChannels
  };
  std::vector<Frame> frames;
};

Expected<Misfit> misfit(const model::Model& model, const KnitData& data) {
  const Sequence& s = data.sequence;
  auto evaluator = SequenceEvaluator::make(model, {s});
  if (!evaluator) return tl::unexpected(evaluator.error());
  Eigen::VectorXd r;
  if (evaluator->evaluate(parameter_values(model), r, nullptr) != mechanics::PathStatus::ok)
    return bad_input(evaluator->failure());
  Misfit result;
  result.frames.resize(s.frames.size());
  const auto points = static_cast<int>(s.points.size());
  for (Misfit::Frame& frame : result.frames) {
    frame.force_N.resize(s.forces.size());
    frame.pin_m.setZero(2, points);
  }
  for (std::size_t i = 0; i < evaluator->rows().size(); ++i) {
    const Row& row = evaluator->rows()[i];
    Misfit::Frame& frame = result.frames[static_cast<std::size_t>(row.frame)];
    const double value = r[static_cast<Eigen::Index>(i)];
    if (row.channel >= 3 * points) {
      const auto force = static_cast<std::size_t>(row.channel - 3 * points);
      frame.force_N[force] = value * s.forces[force].sigma_N;
    } else {
      const int point = row.channel / 3;
      frame.pin_m(row.channel % 3, point) =
          value * s.points[static_cast<std::size_t>(point)].sigma_m;
    }
  }
  return result;
}

/// Root mean square over pulls and distances; of pins, of the length of what is missed.
double force_error_N(const Misfit& misfit, const std::vector<int>& pulls) {
  double squares = 0.0;
  for (const auto& frame : misfit.frames)
    for (const int pull : pulls)
      squares += std::pow(frame.force_N[static_cast<std::size_t>(pull)], 2);
  return std::sqrt(squares / static_cast<double>(misfit.frames.size() * pulls.size()));
}
double pin_error_mm(const Misfit& misfit, const std::vector<int>& pulls,
                    const std::vector<int>& pins) {
  double squares = 0.0;
  for (const auto& frame : misfit.frames)
    for (const int pull : pulls)
      for (const int pin : pins) squares += frame.pin_m.col(kPins * pull + pin).squaredNorm();
  return 1e3 * std::sqrt(squares /
                         static_cast<double>(misfit.frames.size() * pulls.size() * pins.size()));
}
const std::vector<int> kAllPins = {0, 1, 2, 3, 4};

/// How far a pin goes from the taut distance to the last, seen from the clamp at the top.
double travel_mm(const KnitData& data, int pull, int pin) {
  const Sequence& s = data.sequence;
  const Eigen::Index column = kPins * pull + pin;
  return 1e3 * (s.frames.back().points_m.col(column) - s.frames[kTautFrame].points_m.col(column))
                   .head<2>()
                   .norm();
}

/// What is measured, less its mean over `pulls`, in the place of a misfit.
Misfit from_mean(const KnitData& data, const std::vector<int>& pulls) {
  Misfit result;
  // so that the mean of n squares is the variance, whose mean took one of n
  const double n = static_cast<double>(pulls.size());
  const double scale = std::sqrt(n / (n - 1.0));
  for (const SequenceFrame& frame : data.sequence.frames) {
    double force = 0.0;
    Eigen::Matrix<double, 2, kPins> pins;
    pins.setZero();
    for (const int pull : pulls) {
      force += frame.forces_N[pull] / n;
      pins += frame.points_m.block<2, kPins>(0, kPins * pull) / n;
    }
    Misfit::Frame& out = result.frames.emplace_back();
    out.pin_m.resize(2, frame.points_m.cols());
    for (int pull = 0; pull < data.pulls; ++pull) {
      out.force_N.push_back(scale * (frame.forces_N[pull] - force));
      out.pin_m.middleCols<kPins>(kPins * pull) =
          scale * (frame.points_m.block<2, kPins>(0, kPins * pull) - pins);
    }
  }
  return result;
}

double force_size_N(const KnitData& data, const std::vector<int>& pulls) {
  double squares = 0.0;
  for (const SequenceFrame& frame : data.sequence.frames)
    for (const int pull : pulls) squares += std::pow(frame.forces_N[pull], 2);
  return std::sqrt(squares / static_cast<double>(data.sequence.frames.size() * pulls.size()));
}

/// The material and the places of the pins in turn; the last of `data` are those of the result.
Expected<FitResult> fit_to(model::Model& model, KnitData& data, int without_pin) {
  FitOptions how;
  how.method = FitMethod::bounded_marquardt;
  how.tolerance = 1e-4;
  how.max_iterations = 60;
  FitResult result;
  for (int round = 0; round < kRounds; ++round) {
    auto evaluator = SequenceEvaluator::make(model, {seen(data, kFitted, without_pin)});
    if (!evaluator) return tl::unexpected(evaluator.error());
    const double before = result.chi2;
    const int iterations = result.iterations;
    result = fit(*evaluator, model, how);
    if (!result.usable) return bad_input(result.message + " " + evaluator->failure());
    store(result, model);
    result.iterations += iterations;
    if (round > 0 && before - result.chi2 < kEnough * result.chi2) break;
    if (round + 1 == kRounds) break;
    Eigen::VectorXd r;
    if (evaluator->evaluate(result.parameters, r, nullptr) != mechanics::PathStatus::ok)
      return bad_input(evaluator->failure());
    place_pins(evaluator->states().front(), kFitted, without_pin, data);
  }
  return result;
}

void print_row(const char* what, const Misfit& misfit, const KnitData& data,
               const std::vector<int>& pulls) {
  const double force = force_error_N(misfit, pulls);
  std::printf("    %-28s force %6.3f N (%5.2f %% of its rms)   pins %6.3f mm  (", what, force,
              100.0 * force / force_size_N(data, pulls), pin_error_mm(misfit, pulls, kAllPins));
  for (int pin = 0; pin < kPins; ++pin)
    std::printf("%s%s %.2f", pin > 0 ? ", " : "", kPinNames[static_cast<std::size_t>(pin)],
                pin_error_mm(misfit, pulls, {pin}));
  std::printf(")\n");
}

void print_parameters(const model::Model& model) {
  for (const model::Term& term : model.terms) {
    if (term.law.parameters.front().fixed) continue;
    std::printf("    %-10s", term.id.c_str());
    for (const model::Parameter& p : term.law.parameters) std::printf(" %9.3g", p.value);
    std::printf("  %s\n", term.law.parameters.front().unit.c_str());
  }
}

/// A model, and the pulls with the pins where it has them.
struct Placed {
  model::Model model;
  KnitData data;
};

/// Fits and prints errors: first of a fit that sees all pins, from starts[0], then with each pin
/// left out, from the others in turn, which have not seen it either. They become what was fitted.
Expected<void> fit_and_foretell(const char* what, std::vector<Placed>& starts) {
  const double start_s = cpu_s();
  Placed& seen = starts.front();
  const auto found = fit_to(seen.model, seen.data, -1);
  if (!found) return tl::unexpected(found.error());
  const auto all = misfit(seen.model, seen.data);
  if (!all) return tl::unexpected(all.error());
  std::printf("%s: chi2 %.4g of %td rows after %d iterations, %.1f s of CPU\n", what, found->chi2,
              found->residuals.size(), found->iterations, cpu_s() - start_s);
  print_parameters(seen.model);
  print_row("fitted, pulls 2 to 4", *all, seen.data, kFitted);
  print_row("left out, pull 5", *all, seen.data, {kLeftOut});
  print_row("left out, pull 1", *all, seen.data, {kFirst});
  for (int pin = 0; pin < kPins; ++pin) {
    Placed& without = starts[static_cast<std::size_t>(pin) + 1];
    const auto fitted = fit_to(without.model, without.data, pin);
    const auto foretold = fitted ? misfit(without.model, without.data)
                                 : Expected<Misfit>(tl::unexpected(fitted.error()));
    if (!foretold) {
      std::printf("    without the %-6s pin: no fit, %s\n",
                  kPinNames[static_cast<std::size_t>(pin)], foretold.error().message.c_str());
      continue;
    }
    std::printf(
        "    without the %-6s pin: it goes %5.1f mm, missed by %.2f mm on pulls 2 to 4, %.2f mm on "
        "pull 5; force on pull 5 by %.3f N\n",
        kPinNames[static_cast<std::size_t>(pin)], travel_mm(without.data, kLeftOut, pin),
        pin_error_mm(*foretold, kFitted, {pin}), pin_error_mm(*foretold, {kLeftOut}, {pin}),
        force_error_N(*foretold, {kLeftOut}));
  }
  std::printf("    %.1f s of CPU in all\n", cpu_s() - start_s);
  return {};
}

Expected<void> run(const std::string& csv, double width_m, const std::string& document) {
  std::ostringstream text;
  text << std::ifstream(document).rdbuf();
  const auto model = model::parse_model(text.str(), document);
  if (!model) return tl::unexpected(model.error());
  const auto data = read_knit(csv, width_m, kFitted);
  if (!data) return tl::unexpected(data.error());
  const Sequence& s = data->sequence;
  std::printf("%zu clamp distances of %.1f to %.1f mm (%.1f mm at rest), %d pulls, %d nodes\n",
              s.frames.size(), 1e3 * data->distances_m.front(), 1e3 * data->distances_m.back(),
              1e3 * data->rest_length_m, data->pulls, s.cloth.mesh.node_count());
  std::printf("from pull to pull: one standard deviation\n");
  const Misfit floor = from_mean(*data, kAfterFirst);
  print_row("pulls 2 to 5", floor, *data, kAfterFirst);
  std::vector<Placed> fits(kPins + 1, Placed{*model, *data});
  if (auto ok = fit_and_foretell("one material", fits); !ok) return ok;

  MaterialSamples samples = even_samples(2, 1, width_m, data->rest_length_m);
  samples.terms = {"warp", "coupling"};
  for (Placed& placed : fits) {
    auto halves = with_samples(placed.model, samples);
    if (!halves) return tl::unexpected(halves.error());
    placed.model = std::move(*halves);
  }
  return fit_and_foretell("left and right half differ", fits);
}

}  // namespace
}  // namespace tenter::bench

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (argc != 4) {
    std::fprintf(stderr, "tenter-bench-knit-specimen DATA.csv WIDTH_MM MODEL.json\n");
    return 2;
  }
  const auto done = tenter::bench::run(argv[1], 1e-3 * std::atof(argv[2]), argv[3]);
  if (!done) std::fprintf(stderr, "%s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
