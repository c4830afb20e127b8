// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/trials/at_rest.h"

#include <gtest/gtest.h>

namespace tenter::diagnosis {
namespace {

constexpr double kOffset_N_m = 2.0;
constexpr double kSigma_N_m = 0.1;

/// A pull of ten frames from a stretch on, read by one cell.
DataPointer pull_from(double stretch) {
  estimation::Curves curves;
  curves.id = "pull";
  estimation::ObservedChannel force;
  force.name = "stress_x";
  for (int f = 0; f < 10; ++f) {
    curves.path.q.emplace_back(stretch + 0.01 * f, 1.0, 0.0);
    curves.path.duration_s.push_back(1.0);
    curves.path.start.push_back(mechanics::FrameStart::next);
    curves.block_of.push_back(0);
    force.measured.push_back(1.0);
  }
  curves.blocks.push_back({0, capture::Branch::load, 0, 10});
  curves.runs.push_back({1, "", 0, 10});
  curves.channels.push_back(std::move(force));
  auto data = std::make_shared<estimation::DataSet>();
  data->curves.push_back(std::move(curves));
  data->sigma = {{kSigma_N_m}};
  data->left_out = {{std::vector<bool>(10, false)}};
  return data;
}

/// A model with an offset that misses the first reading by `missed_N_m` and meets the others.
Trial with_offset(const DataPointer& data, double missed_N_m) {
  Trial trial;
  trial.effect = find_effect("load_cell_offset");
  model::SensorCorrection offset;
  offset.id = "offset_x";
  offset.type = "offset";
  offset.component = "x";
  model::Parameter value;
  value.name = "value";
  value.unit = "N/m";
  value.value = kOffset_N_m;
  offset.parameters.push_back(value);
  trial.variant.corrections.push_back(offset);
  trial.model.corrections.push_back(offset);
  trial.fit.residuals = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(data->rows().size()));
  trial.fit.residuals[0] = missed_N_m / kSigma_N_m;
  return trial;
}

TEST(AtRest, AnOffsetThatIsNotSeenThereIsNone) {
  const DataPointer data = pull_from(1.0);
  EXPECT_EQ(objection_at_rest(with_offset(data, kOffset_N_m), data),
            "readings at rest do not show it");
  EXPECT_EQ(objection_at_rest(with_offset(data, 0.2 * kOffset_N_m), data), "");
}

TEST(AtRest, NothingIsSaidWhereNothingRests) {
  const DataPointer data = pull_from(1.02);
  EXPECT_EQ(objection_at_rest(with_offset(data, kOffset_N_m), data), "");
}

}  // namespace
}  // namespace tenter::diagnosis
