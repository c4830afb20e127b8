// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/estimation/sequences/sensors/corrected.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/model/catalogue.h"
#include "server/estimation/prediction.h"
#include "tests/server/estimation/sequences/bars.h"
#include "tests/server/estimation/sequences/picture_frame.h"

namespace tenter::estimation::testing {

using mechanics::Pose;

Sequence six_by_six(const std::string& name) {
  constexpr int kNodes = 6;
  constexpr double kSide_m = 0.1;
  Sequence sequence;
  sequence.name = name;
  const mechanics::Grid grid{kNodes, kNodes, kSide_m, kSide_m};
  sequence.cloth = cloth_of_grid(grid, mechanics::Diagonals::alternating).value();
  const auto& mesh = sequence.cloth.mesh;
  sequence.start.x.resize(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    const Eigen::Vector2d at = mesh.material_m.col(n);
    sequence.start.x.segment<3>(3 * n) << at.x(), at.y(),
        -0.01 * at.y() * (kSide_m - at.y()) / 2e-3;
  }
  std::vector<int> low, high;
  for (int i = 0; i < kNodes; ++i) {
    low.push_back(grid.node(i, 0));
    high.push_back(grid.node(i, kNodes - 1));
  }
  sequence.boundaries.resize(1);
  sequence.boundaries[0].clips = {clip_on("first", low, sequence.start.x, Pose{}),
                                  clip_on("second", high, sequence.start.x, Pose{})};
  sequence.boundaries[0].clips[1].mass_kg = 0.003;
  sequence.boundaries[0].clips[1].centre_of_mass_m = {0.05, 0.1, 0.01};
  sequence.start.clips.resize(2);
  const auto masses = mechanics::lumped_masses_kg(mesh, 0.3);
  sequence.loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  for (const double u : {0.03, 0.05, 0.07})
    for (const double v : {0.03, 0.05, 0.07}) sequence.points.push_back({{u, v}, 2e-5});
  sequence.forces = {{1, Eigen::Vector3d::UnitY(), 2e-3, true, "pull"},
                     {1, Eigen::Vector3d::UnitZ(), 2e-3, false, "lift"},
                     {0, Eigen::Vector3d(0.6, -0.8, 0.0), 2e-3, false, "hold"}};
  sequence.scalars = {TorqueChannel{{{1, 1.0}}, {0.05, 0.05, 0.0}, Eigen::Vector3d(1, 0, 0), 1e-4}};
  constexpr double kOut[] = {0.001, 0.003, 0.006, 0.008, 0.005, 0.003, 0.006, 0.009};
  constexpr double kDuration_s[] = {0.0, 0.5, 0.7, 0.4, 0.6, 0.5, 0.3, 0.9};
  for (int f = 0; f < 8; ++f) {
    SequenceFrame frame;
    Pose pose;
    pose.position_m = {0.3 * kOut[f], kOut[f], 0.2 * kOut[f]};
    pose.rotation = mechanics::rotation_of({0.01 * f, 0.0, 0.004 * f});
    frame.clips = {Pose{}, pose};
    frame.points_m.setZero(3, 9);
    if (f == 2 || f == 5)
      frame.points_m.col(4).setConstant(std::numeric_limits<double>::quiet_NaN());
    frame.forces_N.setZero(3);
    frame.scalars.setZero(1);
    frame.duration_s = kDuration_s[f];
    sequence.frames.push_back(frame);
  }
  return sequence;
}

model::Model sheet_model(bool remembers) {
  return remembers ? rubbing_cloth(rubbing_values()) : cloth_model(true_values());
}

int add_correction(model::Model& model, const std::string& type, const std::string& component,
                   const std::vector<double>& values, const std::string& capture) {
  const model::CorrectionRow* row = model::find_correction(type, model::Seen::sheets);
  EXPECT_NE(row, nullptr) << type;
  const auto first = static_cast<int>(parameters_of(model).size());
  model::SensorCorrection correction;
  correction.id = type + "_" + std::to_string(first);
  correction.type = type;
  correction.capture = capture;
  correction.component = component;
  correction.parameters = model::default_parameters(*row);
  EXPECT_EQ(correction.parameters.size(), values.size());
  for (std::size_t k = 0; k < values.size(); ++k) correction.parameters[k].value = values[k];
  model.corrections.push_back(correction);
  return first;
}

}  // namespace tenter::estimation::testing
