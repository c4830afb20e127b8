// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-cross-twin [fabric] [nodes] [frames] [friction 0|1|2] [twist 0|1] [beta] [span]: the
// five sequences of a twin from the smooth sheet, which shares nothing with the fit, are fitted on a
// grid; then how far the curves are off, and how well the two sequences that were left out are
// predicted, beside the noise; then the same without the error of the grid itself
// (staged/refit). Friction: 0 none; 1 in the data, fitted by an elastic model; 2 also in the model.
// These five sequences hardly see twist: with 1 its stiffness is given, to tell what that costs.
// beta: of the graded grid (default: as fits have it); 0: equal cells. span: longest distance of
// the smooth sheet's knots (4.2 mm).
//
// What no fit of the model can do better than is not the noise alone: the true curves on the same
// grid have the grid's error and, where only the data have friction, the loops. Both are printed.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>

#include "common/model/catalogue.h"
#include "server/estimation/fit.h"
#include "server/estimation/sequences/discretisation/grid_error.h"
#include "server/estimation/sequences/material/grid_layout.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/estimation/staged/unseen.h"
#include "server/mechanics/law.h"
#include "tests/bench/fabrics/frame_errors.h"
#include "tests/twin/fabrics/sequences/coverage.h"
#include "tests/twin/fabrics/sequences/cross_twin.h"
#include "tests/twin/fabrics/sequences/fabric_model.h"
#include "tests/twin/fabrics/sequences/rig_noise.h"

namespace {

using namespace tenter;
using estimation::Sequence;
using estimation::SequenceEvaluator;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int frames_asked_for = 20;

/// Largest strain of a mode in the frames of the sequences for fits, which do not all stop where a
/// motion ends: what its curve is judged over.
double reach(const twin::Fabric& cloth, twin::Mode mode) {
  const auto green = [](double e) { return e + 0.5 * e * e; };
  const auto frames_of = [&](const char* name) {
    return twin::make_protocol(cloth, name, {.frames = frames_asked_for});
  };
  double most = 0.0;
  switch (mode) {
    case twin::Mode::stretch_u:
    case twin::Mode::stretch_v: {
      const auto pull = frames_of(mode == twin::Mode::stretch_u ? "stretch_u" : "stretch_v");
      const double free_m = pull.side_m * (1.0 - 2.0 / pull.cells);
      for (const auto& frame : pull.frames)
        most = std::max(most, frame.poses[1].position_m.norm() / free_m);
      return green(most);
    }
    case twin::Mode::shear: {
      const auto frame_protocol = frames_of("shear");
      for (const auto& frame : frame_protocol.frames)
        most = std::max(most, std::abs(frame.poses[0].rotation(0, 1)));
      return most * (1.0 + cloth.limits.frame_u) * (1.0 + cloth.limits.frame_v);
    }
    default:
      return 40.0;  // 1/m
  }
}

/// The fabric's own form, but a shear curve over what the data reach, and bending constant: all of
/// it can be found.
model::Model fitted_form(const twin::Fabric& cloth, bool knows_twist) {
  model::Model model = twin::fabric_model(cloth);
  const double true_twist = model.terms[5].law.parameters[0].value;
  for (std::size_t m = 2; m < model.terms.size(); ++m) {
    model::Law& law = model.terms[m].law;
    const bool is_curve = law.parameters.size() > 1 && m == 2;
    const double stiffness = law.parameters[law.parameters.size() / 2].value;
    law.name = is_curve ? "hermite_stiffness" : "linear";
    law.range_hi = is_curve ? std::min(law.range_hi, reach(cloth, twin::Mode::shear)) : 0.0;
    law.range_lo = is_curve ? -law.range_hi : 0.0;
    law.parameters =
        model::default_parameters(*model::find_law(law.name), is_curve ? 5 : 1,
                                  m < 3 ? model::Domain::membrane : model::Domain::hinge);
    for (model::Parameter& parameter : law.parameters) parameter.value = stiffness;
  }
  // twist is hardly seen in these sequences: it may not run away from the other bending
  const auto stiffness = [&](std::size_t term) {
    return model.terms[term].law.parameters[0].value;
  };
  constexpr double kMost = 2.0;
  const double most = kMost * std::max(stiffness(3), stiffness(4));
  model = twin::poor_start(model);
  model::Parameter& twist = model.terms[5].law.parameters[0];
  twist.upper = most;
  twist.fixed = knows_twist;
  if (knows_twist) twist.value = true_twist;
  return model;
}

bool is_bend(const std::string& sequence) {
  return sequence.starts_with("bend");
}

/// Thesis 3.4.1: stretch is fitted to forces, shear to those along the clips, bending to positions.
Sequence as_fitted(Sequence sequence) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (auto& frame : sequence.frames) {
    if (!is_bend(sequence.name)) frame.points_m.setConstant(kNone);
    for (Eigen::Index k = 0; k < frame.forces_N.size(); ++k)
      if (sequence.name == "shear" && k % 2 == 0) frame.forces_N[k] = kNone;
  }
  return sequence;
}

void print_curves(const twin::Fabric& cloth, const model::Model& fitted) {
  std::printf("  %-12s %14s %14s\n", "mode", "stress rms", "largest");
  for (int m = 0; m < 5; ++m) {
    const auto mode = static_cast<twin::Mode>(m);
    const auto& description = fitted.terms[static_cast<std::size_t>(m)].law;
    const auto law = mechanics::make_law(description, 1).value();
    std::vector<double> parameters;
    for (const auto& parameter : description.parameters) parameters.push_back(parameter.value);
    double squares = 0.0, largest = 0.0;
    constexpr int kSteps = 50;
    const double size = cloth.curve(mode).at(reach(cloth, mode)).stress;
    for (int k = 1; k <= kSteps; ++k) {
      const double strain = reach(cloth, mode) * k / kSteps;
      const double eps = twin::strain_scale(mode) * strain;
      mechanics::LawOutput out;
      law->clear(out);
      law->evaluate({.strain = &eps, .parameters = parameters.data()}, out);
      const double off = (out.stress[0] - cloth.curve(mode).at(strain).stress) / size;
      squares += off * off / kSteps;
      largest = std::max(largest, std::abs(off));
    }
    std::printf("  %-12s %13.2f%% %13.2f%%\n", fitted.terms[static_cast<std::size_t>(m)].id.c_str(),
                100.0 * std::sqrt(squares), 100.0 * largest);
  }
  const auto k = [&](std::size_t term) { return fitted.terms[term].law.parameters[0].value; };
  const double twist = 3.0 * k(5) + 0.75 * (k(3) + k(4));
  std::printf("  %-12s %13.2f%%\n", "twist",
              100.0 * (twist / cloth.curve(twin::Mode::bend_twist).stiffness(0.0) - 1.0));
}

/// Frames whose distances of points say nothing, with the measures that do (thesis 3.6).
void print_folds(const std::vector<twin::FrameError>& frames) {
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (frames[f].means_something()) continue;
    const auto& [measured, simulated, likeness, positions] = frames[f].folds;
    std::printf(
        "    frame %2zu: %s; measured %.2f mm high, %.1f mm long, %.0f degrees,"
        " simulated %.2f, %.1f, %.0f; likeness %.2f\n",
        f + 1, std::string(estimation::words_of(positions)).c_str(), 1e3 * measured.height_m,
        1e3 * measured.wavelength_m, measured.direction_rad * 180.0 / M_PI,
        1e3 * simulated.height_m, 1e3 * simulated.wavelength_m,
        simulated.direction_rad * 180.0 / M_PI, likeness);
  }
}

/// Of the fitted curves, then of the true ones: what the grid alone costs.
void print_prediction(const Sequence& sequence, const model::Model& fitted,
                      const Sequence& for_truth, const model::Model& truth) {
  const auto frames = twin::frame_errors(sequence, fitted);
  const twin::MeanErrors of_fit = mean_errors(frames),
                         of_truth = mean_errors(twin::frame_errors(for_truth, truth));
  std::printf("  %-14s position %7.2f, true curves %7.2f", sequence.name.c_str(), of_fit.position,
              of_truth.position);
  if (!sequence.forces.empty())
    std::printf("   force %7.2f, true curves %7.2f", of_fit.force, of_truth.force);
  if (of_fit.meaningless > 0)
    std::printf("   without %d folded frames position %.2f", of_fit.meaningless,
                of_fit.position_where_meaningful);
  if (of_fit.lost > 0) std::printf("   %d frames without rest", of_fit.lost);
  std::printf("\n");
  print_folds(frames);
  std::fflush(stdout);
}

/// A sequence on the grid and on one of half its spacing, with the same measured values. Of bending
/// on equal cells a third, which leaves the table's edge half way between two lines; it converges
/// by the second order.
struct TwoGrids {
  Sequence coarse, fine;
  double order;  ///< that tenter-bench-discretisation finds
};
constexpr std::size_t kTraining = 5;
constexpr double kShareAsSigma = 0.15;

Expected<std::vector<TwoGrids>> make_twins(const twin::Fabric& cloth, int nodes, int frames,
                                           double beta) {
  std::vector<TwoGrids> twins;
  twin::Random random(twin::stream_seed(1, "rig"));
  for (const std::string& name : twin::protocol_names()) {
    const double begin = seconds();
    twin::CrossOptions options;
    options.grid.holds_line_beyond_edge = true;
    options.grid.grading = beta;
    const int finer = is_bend(name) && beta == 0.0 ? 3 : 2;
    auto made = twin::cross_twins(
        cloth, twin::make_protocol(cloth, name, {.frames = frames, .cells = nodes - 1}), options,
        {nodes, finer * (nodes - 1) + 1});
    if (!made) return tl::unexpected(made.error());
    std::printf("  %-14s made in %5.1f s: %d unknowns, %d steps of Newton's method\n", name.c_str(),
                seconds() - begin, made->front().unknowns, made->front().iterations);
    std::fflush(stdout);
    const double order = is_bend(name) ? 2.0 : beta > 0.0 ? 1.7 : 1.3;
    twins.push_back({std::move((*made)[0].sequence), std::move((*made)[1].sequence), order});
    TwoGrids& twin = twins.back();
    twin::add_rig_noise({}, random, twin.coarse);
    for (std::size_t f = 0; f < twin.coarse.frames.size(); ++f) {
      twin.fine.frames[f].points_m = twin.coarse.frames[f].points_m;
      twin.fine.frames[f].forces_N = twin.coarse.frames[f].forces_N;
    }
  }
  return twins;
}

Sequence corrected(const TwoGrids& twin, const model::Model& model, double share_as_sigma) {
  estimation::GridErrorOptions options;
  options.share_as_sigma = share_as_sigma;
  options.of_positions = true;
  options.order = twin.order;
  return without_grid_error(twin.coarse,
                            estimation::grid_error(model, twin.coarse, twin.fine, options).value());
}

/// Begins where `model` is, and stores what it finds there.
bool fit_to(const std::vector<Sequence>& sequences, model::Model& model) {
  estimation::SequenceOptions how;
  how.threads = 2;
  auto evaluator = SequenceEvaluator::make(model, sequences, how);
  if (!evaluator) {
    std::printf("  %s\n", evaluator.error().message.c_str());
    return false;
  }
  const double begin = seconds();
  const estimation::FitResult fitted = fit(*evaluator, model, {});
  std::printf(" fit: %s %s, %d iterations, %.1f s\n", fitted.usable ? "usable," : "not usable,",
              fitted.message.c_str(), fitted.iterations, seconds() - begin);
  if (!fitted.usable) {
    std::printf("  %s\n", evaluator->failure().c_str());
    return false;
  }
  store(fitted, model);
  // as staged fits do (staged/unseen.h)
  const std::vector<std::string> twist = {model.terms[5].id};
  if (estimation::are_held(model, twist) || estimation::is_seen(model, twist, fitted)) return true;
  estimation::hold_at(estimation::stand_in(model, sequences.front().cloth.mesh), twist, model);
  std::printf(" twist is not seen: held at %.3g N m\n", model.terms[5].law.parameters[0].value);
  return fit_to(sequences, model);
}

}  // namespace

int main(int count, char** arguments) {
  const std::string id = count > 1 ? arguments[1] : "18";
  const int nodes = count > 2 ? std::atoi(arguments[2]) : 25;
  const int frames = count > 3 ? std::atoi(arguments[3]) : 20;
  const bool has_friction = count > 4 && std::atoi(arguments[4]) != 0;
  const bool knows_twist = count > 5 && std::atoi(arguments[5]) != 0;
  const twin::Fabric cloth =
      has_friction ? twin::fabric(id) : twin::without_friction(twin::fabric(id));
  const double beta = count > 6 ? std::atof(arguments[6]) : estimation::LayoutOptions().beta;
  std::printf("#%s %s, %d x %d nodes, %d frames a sequence, %s friction, twist %s, beta %.1f\n",
              id.c_str(), cloth.name.c_str(), nodes, nodes, frames,
              has_friction ? "with" : "without", knows_twist ? "given" : "fitted", beta);
  const auto twins = make_twins(cloth, nodes, frames, beta);
  if (!twins) {
    std::printf("  %s\n", twins.error().message.c_str());
    return 1;
  }
  const model::Model truth = twin::fabric_model(cloth);
  model::Model model = fitted_form(cloth, knows_twist);
  constexpr int kRounds = 4;  // the error is estimated at the curves of the round before
  for (int round = 0; round < kRounds; ++round) {
    const bool less_grid_error = round > 0;
    if (round < 2)
      std::printf("%s\n", less_grid_error
                              ? "without the grid's error, estimated at the curves of the last fit"
                              : "fitted on the grid as it is");
    std::vector<Sequence> fitted_to;
    for (std::size_t s = 0; s < kTraining; ++s) {
      Sequence sequence = (*twins)[s].coarse;
      if (less_grid_error) sequence = corrected((*twins)[s], model, kShareAsSigma);
      fitted_to.push_back(as_fitted(sequence));
    }
    if (!fit_to(fitted_to, model)) return 1;
    if (less_grid_error && round + 1 < kRounds) continue;
    std::printf(" curves, in parts of the stress at the end of what the data reach\n");
    print_curves(cloth, model);
    std::printf(" residuals in units of the noise, of the sequences fitted to\n");
    for (std::size_t s = 0; s < twins->size(); ++s) {
      if (s == kTraining) std::printf(" of those left out; the goal is 2\n");
      const TwoGrids& twin = (*twins)[s];
      if (less_grid_error)
        print_prediction(corrected(twin, model, 0.0), model, corrected(twin, truth, 0.0), truth);
      else
        print_prediction(twin.coarse, model, twin.coarse, truth);
    }
  }
  return 0;
}
