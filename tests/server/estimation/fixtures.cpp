// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/estimation/fixtures.h"

#include <gtest/gtest.h>

#include <random>

#include "common/model/catalogue.h"
#include "common/model/presets.h"

namespace tenter::testing {
namespace {

capture::Channel channel(const std::string& name, capture::Quantity quantity,
                         const std::string& unit, std::size_t frames) {
  capture::Channel result;
  result.name = name;
  result.quantity = quantity;
  result.unit = result.source_unit = unit;
  result.values.assign(frames, 0.0);
  return result;
}

}  // namespace

capture::Capture loop_capture(const LoopPlan& plan) {
  capture::Capture capture;
  capture.kind = "homogeneous_strain";
  capture.title = "loops";
  capture.specimen.name = "swatch";
  capture.specimen.material = "cloth";
  capture.protocol.name = plan.group;
  capture.protocol.phases.push_back({"loop", "cycle", plan.rate_per_s});
  std::vector<double> strain;
  double time = 0.0;
  const double step_s = plan.peak / plan.frames / plan.rate_per_s;
  for (int r = 0; r < plan.runs; ++r) {
    capture.runs.push_back({r + 1, plan.group});
    for (int i = 0; i <= 2 * plan.frames; ++i) {
      const bool up = i <= plan.frames;
      strain.push_back(plan.peak * (up ? i : 2 * plan.frames - i) / plan.frames);
      capture.frame.push_back(i + 1);
      capture.run.push_back(r);
      capture.phase.push_back(0);
      capture.branch.push_back(up ? capture::Branch::load : capture::Branch::unload);
      if (plan.has_time) capture.time_s.push_back(time);
      time += step_s;
    }
  }
  const std::size_t n = strain.size();
  capture.channels = {
      channel("strain_x", capture::Quantity::strain, "1", n),
      channel("stretch_y", capture::Quantity::stretch, "1", n),
      channel("stress_x", capture::Quantity::membrane_stress, "N/m", n),
      channel("stress_y", capture::Quantity::membrane_stress, "N/m", n),
  };
  capture.channels[0].values = strain;
  for (std::size_t i = 0; i < n; ++i)
    capture.channels[1].values[i] = plan.transverse_free ? 1.0 : 1.0 + 0.3 * strain[i];
  using Role = capture::AxisState::Role;
  capture.kinematics.x.role = Role::prescribed;
  capture.kinematics.x.source = capture::AxisState::Source::channel;
  capture.kinematics.x.channel = "strain_x";
  capture.kinematics.y.role = plan.transverse_free ? Role::observed : Role::prescribed;
  capture.kinematics.y.source = capture::AxisState::Source::channel;
  capture.kinematics.y.channel = "stretch_y";
  capture.stresses = {{"x", "stress_x"}};
  if (!plan.transverse_free) capture.stresses.push_back({"y", "stress_y"});
  return capture;
}

std::shared_ptr<estimation::DataSet> data_of(const std::vector<capture::Capture>& captures,
                                             double sigma) {
  auto data = std::make_shared<estimation::DataSet>();
  for (std::size_t i = 0; i < captures.size(); ++i) {
    auto curves = estimation::make_curves(captures[i], "capture" + std::to_string(i));
    EXPECT_TRUE(curves) << (curves ? "" : curves.error().message);
    std::vector<double> sigmas;
    for (const estimation::ObservedChannel& c : curves->channels)
      sigmas.push_back(c.is_stress ? sigma : 1e-3 * sigma);
    data->sigma.push_back(sigmas);
    data->left_out.emplace_back(curves->channels.size(),
                                std::vector<bool>(curves->frame_count(), false));
    data->curves.push_back(std::move(*curves));
  }
  return data;
}

void measure_with(const model::Model& model, double sigma, unsigned seed,
                  estimation::DataSet& data) {
  auto evaluator = estimation::Evaluator::make(model, std::make_shared<estimation::DataSet>(data));
  ASSERT_TRUE(evaluator) << evaluator.error().message;
  Eigen::VectorXd residuals;
  ASSERT_EQ(evaluator->evaluate(estimation::parameter_values(model), residuals, nullptr),
            mechanics::PathStatus::ok);
  const std::vector<double> shown = evaluator->predicted(residuals);
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  for (std::size_t r = 0; r < shown.size(); ++r) {
    const estimation::Row& row = evaluator->rows()[r];
    estimation::ObservedChannel& channel = data.curves[static_cast<std::size_t>(row.curve)]
                                               .channels[static_cast<std::size_t>(row.channel)];
    channel.measured[static_cast<std::size_t>(row.frame)] =
        shown[r] + (channel.is_stress ? sigma : 1e-3 * sigma) * normal(engine);
  }
}

model::Model preset_with(const std::string& name, const std::vector<double>& values) {
  auto model = model::preset(name);
  EXPECT_TRUE(model) << name;
  const std::vector<model::Parameter*> parameters = estimation::parameters_of(*model);
  EXPECT_GE(parameters.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) parameters[i]->value = values[i];
  return *model;
}

void add_correction(model::Model& model, const std::string& type, const std::string& component,
                    double value) {
  const model::CorrectionRow* row = model::find_correction(type);
  ASSERT_NE(row, nullptr) << type;
  model::SensorCorrection correction;
  correction.id = type + "_" + component;
  correction.type = type;
  correction.component = component;
  correction.parameters = model::default_parameters(*row);
  correction.parameters.front().value = value;
  model.corrections.push_back(correction);
}

}  // namespace tenter::testing
