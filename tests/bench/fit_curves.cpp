// SPDX-License-Identifier: GPL-3.0-or-later
// How long a fit takes: 10,000 readings of loops, about 20 free parameters, friction included, from
// a start far off.
//
//   tenter-bench-fit [REPEATS]        prints rows, parameters, medians in milliseconds as JSON
//
// The answer is checked before its time counts: the parameters of a clean capture must come back.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "server/estimation/fit.h"

namespace {

using namespace tenter;

/// A strip pulled in x and y by loops of growing size and changing ratio; 5,000 frames of two
/// stresses.
capture::Capture loops() {
  constexpr int kLoops = 20;
  constexpr int kFrames = 125;
  capture::Capture capture;
  capture.kind = "homogeneous_strain";
  capture.title = "bench";
  capture.specimen.name = "swatch";
  capture.protocol.name = "loops";
  capture.protocol.phases.push_back({"loops", "cycle", 0.002});
  for (const char* name : {"stretch_x", "stretch_y", "shear", "stress_x", "stress_y"}) {
    capture::Channel channel;
    channel.name = name;
    channel.quantity = name[2] == 'e' && name[3] == 'a' ? capture::Quantity::shear
                       : std::string(name).size() == 9  ? capture::Quantity::stretch
                                                        : capture::Quantity::membrane_stress;
    channel.unit = channel.quantity == capture::Quantity::membrane_stress ? "N/m" : "1";
    capture.channels.push_back(channel);
  }
  for (int loop = 0; loop < kLoops; ++loop) {
    capture.runs.push_back({loop + 1, ""});
    const double peak = 0.02 + 0.004 * loop;
    const double angle = 1.5707963 * (loop % 5) / 4.0;
    for (int i = 0; i < 2 * kFrames; ++i) {
      const bool up = i < kFrames;
      const double share = (up ? i : 2.0 * kFrames - i) / kFrames;
      capture.run.push_back(loop);
      capture.frame.push_back(i + 1);
      capture.phase.push_back(0);
      capture.branch.push_back(up ? capture::Branch::load : capture::Branch::unload);
      capture.time_s.push_back(0.5 * static_cast<double>(capture.time_s.size()));
      capture.channels[0].values.push_back(1.0 + peak * share * std::cos(angle));
      capture.channels[1].values.push_back(1.0 + peak * share * std::sin(angle));
      capture.channels[2].values.push_back(0.5 * peak * share * (loop % 2));
      capture.channels[3].values.push_back(0.0);
      capture.channels[4].values.push_back(0.0);
    }
  }
  using Axis = capture::AxisState;
  int channel = 0;
  for (Axis* axis : {&capture.kinematics.x, &capture.kinematics.y, &capture.kinematics.xy}) {
    axis->role = Axis::Role::prescribed;
    axis->source = Axis::Source::channel;
    axis->channel = capture.channels[static_cast<std::size_t>(channel++)].name;
  }
  capture.stresses = {{"x", "stress_x"}, {"y", "stress_y"}};
  return capture;
}

model::Term term(const std::string& id, const std::string& measure, double angle_rad,
                 const std::string& law, const std::vector<double>& values) {
  model::Term result;
  result.id = id;
  result.strain.name = measure;
  result.strain.angle_rad = angle_rad;
  result.law.name = law;
  result.law.parameters =
      model::default_parameters(*model::find_law(law), static_cast<int>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) result.law.parameters[i].value = values[i];
  return result;
}

/// Splines along both directions, coupling, shear, friction in two directions, Maxwell in one.
model::Model cloth() {
  model::Model model;
  model.name = "bench";
  model.terms = {term("weft", "green_u", 0.0, "convex_spline", {500, 550, 650, 800}),
                 term("warp", "green_v", 0.0, "convex_spline", {700, 720, 760, 900}),
                 term("coupling", "green_pair", 0.0, "bilinear", {150}),
                 term("shear", "green_uv", 0.0, "linear", {80}),
                 term("friction_weft", "green_u", 0.0, "dahl", {1.5, 6.0}),
                 term("friction_warp", "green_v", 0.0, "dahl", {1.0, 4.0}),
                 term("creep", "green_u", 0.0, "maxwell", {60.0, 20.0})};
  for (model::Term& t : model.terms)
    if (t.law.name == "dahl")
      for (model::Parameter& p : t.law.parameters) {
        if (p.name == "tau") p.value = 0.004;
        if (p.name == "a") p.value = 1.5;
        if (p.name == "b") p.value = 10.0;
        p.fixed = p.name == "c";
      }
  return model;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

template <class Work>
double milliseconds(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

int run(int repeats) {
  auto data = std::make_shared<estimation::DataSet>();
  auto curves = estimation::make_curves(loops(), "bench");
  if (!curves) {
    std::fprintf(stderr, "%s\n", curves.error().message.c_str());
    return 1;
  }
  data->curves.push_back(std::move(*curves));
  data->sigma = {{0.05, 0.05}};
  data->left_out = {{std::vector<bool>(data->curves[0].frame_count(), false),
                     std::vector<bool>(data->curves[0].frame_count(), false)}};
  model::Model truth = cloth();
  estimation::adapt_spline_ranges(truth, data->curves);
  const Eigen::VectorXd values = estimation::parameter_values(truth);
  auto first = estimation::Evaluator::make(truth, data);
  Eigen::VectorXd residuals;
  estimation::RowMatrix jacobian;
  if (!first || first->evaluate(values, residuals, nullptr) != mechanics::PathStatus::ok) return 1;
  const std::vector<double> shown = first->predicted(residuals);
  for (std::size_t r = 0; r < shown.size(); ++r) {
    const estimation::Row& row = first->rows()[r];
    data->curves[0]
        .channels[static_cast<std::size_t>(row.channel)]
        .measured[static_cast<std::size_t>(row.frame)] = shown[r];
  }
  auto evaluator = estimation::Evaluator::make(truth, data);
  if (!evaluator) return 1;
  model::Model start = truth;
  for (model::Parameter* p : estimation::parameters_of(start))
    if (!p->fixed) p->value *= 1.5;
  std::vector<double> fits, values_only, with_jacobian;
  int iterations = 0;
  int free = 0;
  for (const model::Parameter* p : estimation::parameters_of(truth)) free += p->fixed ? 0 : 1;
  double worst = 0.0;
  for (int k = 0; k < repeats; ++k) {
    estimation::FitResult found;
    fits.push_back(milliseconds([&] { found = estimation::fit(*evaluator, start, {}); }));
    if (!found.usable || found.chi2 > 1.0) {
      std::fprintf(stderr, "the fit did not find the model: chi2 %g\n", found.chi2);
      return 1;
    }
    iterations = found.iterations;
    worst = std::max(worst, std::sqrt(found.chi2 / static_cast<double>(found.residuals.size())));
    mechanics::PathStatus status = mechanics::PathStatus::ok;
    values_only.push_back(
        milliseconds([&] { status = evaluator->evaluate(values, residuals, nullptr); }));
    with_jacobian.push_back(
        milliseconds([&] { status = evaluator->evaluate(values, residuals, &jacobian); }));
    if (status != mechanics::PathStatus::ok) return 1;
  }
  std::printf(
      "{\"rows\": %d, \"free_parameters\": %d, \"iterations\": %d, \"threads\": 1, \"fit_ms\": "
      "%.1f, \"evaluation_ms\": %.2f, \"evaluation_with_jacobian_ms\": %.2f, "
      "\"rms_over_sigma\": %.1e}\n",
      evaluator->row_count(), free, iterations, median(fits), median(values_only),
      median(with_jacobian), worst);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc > 1 ? std::max(1, std::atoi(argv[1])) : 5);
}
