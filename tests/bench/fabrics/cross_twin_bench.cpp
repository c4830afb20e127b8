// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-cross-twin [fabric] [nodes] [frames] [friction 0|1|2] [twist 0|1] [beta] [span]: the
// five sequences of a twin from the smooth sheet, which shares nothing with the fit, are fitted on
// a grid; then how far the curves are off, and how well the two sequences that were left out are
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
#include <string>

#include "common/model/catalogue.h"
#include "server/estimation/fit.h"
#include "server/estimation/least_squares/dissipation.h"
#include "server/estimation/sequences/material/grid_layout.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/estimation/staged/refit/grid_free_fit.h"
#include "server/estimation/staged/splines/strain_histogram.h"
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

/// Largest shear in the measured sheet without outliers, as stages choose it: beside free corners
/// it is more than the picture frame's, and a curve that ended there would be wrong to make up for
/// what is beyond.
double local_shear(const Sequence& picture_frame, const model::Model& model) {
  constexpr double kOutliers = 0.005;
  const auto mesh = mechanics::MeshModel::make(model, picture_frame.cloth).value();
  std::vector<mechanics::State> states;
  for (const auto& frame : picture_frame.frames) states.push_back(*frame.start);
  const auto [lo, hi] = estimation::strain_histograms(mesh, states)[2].range(kOutliers);
  return std::max(-lo, hi);
}

/// The fabric's own form, but a shear curve over what the data reach, and bending constant: all of
/// it can be found.
model::Model elastic_form(const twin::Fabric& cloth, const Sequence& picture_frame,
                          bool knows_twist) {
  const model::Model truth = twin::fabric_model(cloth);
  model::Model model = truth;
  const double true_twist = model.terms[5].law.parameters[0].value;
  for (std::size_t m = 2; m < model.terms.size(); ++m) {
    model::Law& law = model.terms[m].law;
    const bool is_curve = law.parameters.size() > 1 && m == 2;
    const double stiffness = law.parameters[law.parameters.size() / 2].value;
    law.name = is_curve ? "hermite_stiffness" : "linear";
    law.range_hi = is_curve ? std::min(law.range_hi, local_shear(picture_frame, truth)) : 0.0;
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

/// Dahl's friction beside stretch, shear and bending, small to begin with. Its bound follows the
/// strain, by the square too where stretch stiffens; that of the fabrics follows the stress.
model::Model with_friction(model::Model model, const twin::Fabric& cloth) {
  for (std::size_t m = 0; m < 5; ++m) {
    const model::Term& of = model.terms[m];
    const auto mode = static_cast<twin::Mode>(m);
    const double k = of.law.parameters.front().value;
    const double most = twin::strain_scale(mode) * reach(cloth, mode);
    model::Term term;
    term.id = of.id + "_friction";
    term.strain = of.strain;
    term.law.name = "dahl";
    term.law.parameters = model::default_parameters(
        *model::find_law("dahl"), 1, m < 3 ? model::Domain::membrane : model::Domain::hinge);
    const double values[] = {0.01 * k * most, 0.2 * k, 0.0, 0.1 * most};
    for (std::size_t i = 0; i < 4; ++i) term.law.parameters[i].value = values[i];
    term.law.parameters[2].fixed = m > 1;
    model.terms.push_back(std::move(term));
  }
  return model;
}

bool is_bend(const std::string& sequence) {
  return sequence.starts_with("bend");
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
  const model::Law& shear = fitted.terms[2].law;
  std::printf("  shear's stiffness, of %g to %g, with standard errors, and the true one:",
              shear.range_lo, shear.range_hi);
  for (std::size_t i = 0; i < shear.parameters.size(); ++i) {
    const double strain = shear.range_lo + (shear.range_hi - shear.range_lo) *
                                               static_cast<double>(i) /
                                               std::max(1.0, shear.parameters.size() - 1.0);
    std::printf("  %.2f +- %.2f (%.2f)", shear.parameters[i].value,
                shear.parameters[i].std_error.value_or(0.0),
                cloth.curve(twin::Mode::shear).stiffness(strain));
  }
  std::printf("\n");
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

/// Of the fitted curves; then the floor, which is the noise and what the true curves miss; and how
/// many times that the fit misses.
void print_error(const char* what, double of_fit, double of_truth) {
  std::printf("  %s %7.2f, true curves %7.2f: %5.2f floors", what, of_fit, of_truth,
              of_fit / std::max(1.0, of_truth));
}

void print_prediction(const Sequence& sequence, const model::Model& fitted,
                      const Sequence& for_truth, const model::Model& truth) {
  const auto frames = twin::frame_errors(sequence, fitted);
  const twin::MeanErrors of_fit = mean_errors(frames),
                         of_truth = mean_errors(twin::frame_errors(for_truth, truth));
  std::printf("  %-13s", sequence.name.c_str());
  print_error("position", of_fit.position, of_truth.position);
  if (!sequence.forces.empty()) print_error("force", of_fit.force, of_truth.force);
  if (of_fit.meaningless > 0)
    std::printf("  without %d folded frames position %.2f", of_fit.meaningless,
                of_fit.position_where_meaningful);
  if (of_fit.lost > 0) std::printf("  %d frames without rest", of_fit.lost);
  std::printf("\n");
  print_folds(frames);
  std::fflush(stdout);
}

using estimation::OnTwoGrids;
constexpr std::size_t kTraining = 5;
constexpr estimation::Role kRoles[] = {estimation::Role::stretch_u, estimation::Role::stretch_v,
                                       estimation::Role::shear, estimation::Role::bend_u,
                                       estimation::Role::bend_v};

struct Asked {
  std::string id = "18";
  int nodes = 25;
  int frames = 20;
  int friction = 0;
  bool knows_twist = false;
  double beta = estimation::LayoutOptions().beta;
  double span_mm = 4.2;
};

/// Every sequence on the grid and on one of half its spacing. Of bending on equal cells a third,
/// which leaves the table's edge half way between two lines.
Expected<std::vector<OnTwoGrids>> make_twins(const twin::Fabric& cloth, const Asked& asked) {
  std::vector<OnTwoGrids> twins;
  twin::Random random(twin::stream_seed(1, "rig"));
  for (const std::string& name : twin::protocol_names()) {
    const double begin = seconds();
    twin::CrossOptions options;
    options.grid.holds_line_beyond_edge = true;
    options.grid.grading = asked.beta;
    options.sheet.span_m = 1e-3 * asked.span_mm;
    const int finer = is_bend(name) && asked.beta == 0.0 ? 3 : 2;
    auto made = twin::cross_twins(
        cloth, twin::make_protocol(cloth, name, {.frames = asked.frames, .cells = asked.nodes - 1}),
        options, {asked.nodes, finer * (asked.nodes - 1) + 1});
    if (!made) return tl::unexpected(made.error());
    std::printf("  %-14s made in %5.1f s: %d unknowns, %d steps of Newton's method\n", name.c_str(),
                seconds() - begin, made->front().unknowns, made->front().iterations);
    std::fflush(stdout);
    OnTwoGrids& twin = twins.emplace_back();
    twin.is_fitted = twins.size() <= kTraining;
    twin.coarse = {twin.is_fitted ? kRoles[twins.size() - 1] : estimation::Role::evaluation,
                   std::move((*made)[0].sequence)};
    twin.fine = std::move((*made)[1].sequence);
    twin.order = estimation::order_of(twin.coarse.sequence, asked.beta > 0.0);
    twin::add_rig_noise({}, random, twin.coarse.sequence);
    measure_as(twin.coarse.sequence, twin.fine);
  }
  return twins;
}

/// Without the grid's error as the model has it; sigmas stay those of the readings.
Sequence corrected(const OnTwoGrids& twin, const model::Model& model) {
  estimation::GridErrorOptions options;
  options.share_as_sigma = 0.0;
  options.of_positions = true;
  options.order = twin.order;
  options.threads = 2;
  const Sequence& coarse = twin.coarse.sequence;
  return without_grid_error(coarse,
                            estimation::grid_error(model, coarse, twin.fine, options).value());
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
  estimation::FitOptions options;
  options.friction = estimation::friction_places(model);
  const estimation::FitResult fitted = fit(*evaluator, model, options);
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

Asked read(int count, char** arguments) {
  Asked asked;
  if (count > 1) asked.id = arguments[1];
  if (count > 2) asked.nodes = std::atoi(arguments[2]);
  if (count > 3) asked.frames = std::atoi(arguments[3]);
  if (count > 4) asked.friction = std::atoi(arguments[4]);
  if (count > 5) asked.knows_twist = std::atoi(arguments[5]) != 0;
  if (count > 6) asked.beta = std::atof(arguments[6]);
  if (count > 7) asked.span_mm = std::atof(arguments[7]);
  frames_asked_for = asked.frames;
  return asked;
}

void print_all(const twin::Fabric& cloth, const std::vector<OnTwoGrids>& twins,
               const model::Model& model, bool less_grid_error) {
  std::printf(" curves, in parts of the stress at the end of what the data reach\n");
  print_curves(cloth, model);
  std::printf(" residuals in units of the noise, of the sequences fitted to\n");
  const model::Model truth = twin::fabric_model(cloth);
  for (std::size_t s = 0; s < twins.size(); ++s) {
    if (s == kTraining) std::printf(" of those left out; the goal is twice the floor\n");
    const Sequence& as_it_is = twins[s].coarse.sequence;
    if (less_grid_error)
      print_prediction(corrected(twins[s], model), model, corrected(twins[s], truth), truth);
    else
      print_prediction(as_it_is, model, as_it_is, truth);
  }
}

}  // namespace

int main(int count, char** arguments) {
  const Asked asked = read(count, arguments);
  const twin::Fabric cloth =
      asked.friction > 0 ? twin::fabric(asked.id) : twin::without_friction(twin::fabric(asked.id));
  constexpr const char* kFrictions[] = {"no friction", "friction in the data",
                                        "friction in data and model"};
  std::printf(
      "#%s %s, %d x %d nodes, %d frames a sequence, %s, twist %s, beta %.1f, span %.1f mm\n",
      asked.id.c_str(), cloth.name.c_str(), asked.nodes, asked.nodes, asked.frames,
      kFrictions[std::clamp(asked.friction, 0, 2)], asked.knows_twist ? "given" : "fitted",
      asked.beta, asked.span_mm);
  const auto twins = make_twins(cloth, asked);
  if (!twins) {
    std::printf("  %s\n", twins.error().message.c_str());
    return 1;
  }
  model::Model model = elastic_form(cloth, (*twins)[2].coarse.sequence, asked.knows_twist);
  if (asked.friction > 1) model = with_friction(std::move(model), cloth);
  std::printf("fitted on the grid as it is\n");
  std::vector<Sequence> fitted_to;
  for (std::size_t s = 0; s < kTraining; ++s)
    fitted_to.push_back(observed((*twins)[s].coarse, estimation::Channels::thesis));
  if (!fit_to(fitted_to, model)) return 1;
  print_all(cloth, *twins, model, false);

  std::printf("without the grid's error, estimated at the fitted curves\n");
  estimation::GridFreeOptions options;
  options.stage.threads = 2;
  options.stage.tolerance = 1e-6;
  const double begin = seconds();
  const auto fit = estimation::grid_free_fit(model, *twins, options);
  if (!fit) {
    std::printf("  %s\n", fit.error().message.c_str());
    return 1;
  }
  for (const estimation::StageRecord& round : fit->stages)
    std::printf(" %s: %s, %d iterations, %zu frames dropped\n", round.name.c_str(),
                round.message.c_str(), round.iterations, round.dropped.size());
  for (std::size_t s = 0; s < twins->size(); ++s)
    if (const auto without =
            std::count_if(fit->errors[s].frames.begin(), fit->errors[s].frames.end(),
                          [](const auto& frame) { return !frame.rests; });
        without > 0)
      std::printf(" %td frames of %s have no estimate\n", without,
                  (*twins)[s].coarse.sequence.name.c_str());
  std::printf(" %s: the estimate changed by %.2f of a reading; %.1f s\n",
              fit->settled ? "settled" : "not settled", fit->change_sigmas, seconds() - begin);
  print_all(cloth, *twins, fit->model, true);
  return 0;
}
