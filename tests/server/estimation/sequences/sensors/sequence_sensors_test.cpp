// SPDX-License-Identifier: GPL-3.0-or-later
// Sensor corrections of sheets: derivatives beside differences of whole solves, values beside what
// their header says, and what is refused.
#include "server/estimation/sequences/sensors/sequence_sensors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/model/document.h"
#include "server/estimation/fit.h"
#include "server/estimation/prediction.h"
#include "server/estimation/sequences/sensors/hidden_points.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/server/estimation/sequences/picture_frame.h"
#include "tests/server/estimation/sequences/sensors/corrected.h"

namespace tenter::estimation {
namespace {

using mechanics::PathStatus;
using testing::add_correction;
using testing::measure;
using testing::sheet_model;
using testing::six_by_six;

struct Added {
  const char* type;
  const char* component;
  std::vector<double> values;
};

/// Away from where they are off, and from each other's kinks.
const Added kEvery[] = {{"offset", "pull", {0.02}},
                        {"gain", "", {1.07}},
                        {"drift", "lift", {0.013}},
                        {"delay", "", {0.17}},
                        {"cord_friction", "pull", {0.08}},
                        {"saturation", "pull", {0.6, 0.11}},
                        {"camera_scale", "", {1.012}},
                        {"camera_pose", "", {0.03, -0.02, 0.05, 0.001, -0.002, 0.0015}},
                        {"occlusion_bias", "", {0.0007, 2.0}},
                        {"clip_slip", "pull", {0.0011, 3.0}},
                        {"mass_scale", "", {1.2}}};

/// Columns of the Jacobian beside central differences of whole evaluations.
void expect_differences(const model::Model& model, const std::vector<Sequence>& sequences,
                        const std::vector<int>& columns) {
  SequenceOptions options;
  options.threads = 2;
  options.tolerance_N = 1e-12;
  auto evaluator = SequenceEvaluator::make(model, sequences, options);
  ASSERT_TRUE(evaluator) << evaluator.error().message;
  const Eigen::VectorXd at = parameter_values(model);
  Eigen::VectorXd residuals, high, low;
  RowMatrix jacobian;
  ASSERT_EQ(evaluator->evaluate(at, residuals, &jacobian), PathStatus::ok) << evaluator->failure();
  for (const int p : columns) {
    const double h = 1e-4 * std::abs(at[p]);
    ASSERT_GT(h, 0.0) << p;
    Eigen::VectorXd up = at, down = at;
    up[p] += h;
    down[p] -= h;
    ASSERT_EQ(evaluator->evaluate(up, high, nullptr), PathStatus::ok) << evaluator->failure();
    ASSERT_EQ(evaluator->evaluate(down, low, nullptr), PathStatus::ok) << evaluator->failure();
    const Eigen::VectorXd column = (high - low) / (2.0 * h);
    EXPECT_GT(column.norm() * std::abs(at[p]), 1.0) << p;  // sigmas: it says something
    EXPECT_LT((jacobian.col(p) - column).norm(), 1e-5 * column.norm()) << p;
  }
}

/// All parameters but at_frame and reach, which have no derivative.
std::vector<int> columns_of(const Added& added, int first) {
  std::vector<int> columns = {first};
  const std::string type = added.type;
  if (type == "clip_slip" || type == "occlusion_bias") return columns;
  for (int k = 1; k < static_cast<int>(added.values.size()); ++k) columns.push_back(first + k);
  return columns;
}

TEST(SequenceSensors, EveryCorrectionFollowsWholeSolves) {
  for (const Added& added : kEvery) {
    SCOPED_TRACE(added.type);
    model::Model model = sheet_model(false);
    const int first = add_correction(model, added.type, added.component, added.values);
    std::vector<int> columns = columns_of(added, first);
    columns.push_back(1);  // a stiffness, through the instrument
    expect_differences(model, {six_by_six("one")}, columns);
  }
}

TEST(SequenceSensors, AllTogetherFollowWholeSolvesAlsoOfAPath) {
  for (const bool remembers : {false, true}) {
    SCOPED_TRACE(remembers);
    model::Model model = sheet_model(remembers);
    std::vector<int> columns = {1, 2};
    for (const Added& added : kEvery)
      for (const int p :
           columns_of(added, add_correction(model, added.type, added.component, added.values)))
        columns.push_back(p);
    expect_differences(model, {six_by_six("one")}, columns);
  }
}

TEST(SequenceSensors, BytesDoNotDependOnThreads) {
  model::Model model = sheet_model(true);
  for (const Added& added : kEvery)
    add_correction(model, added.type, added.component, added.values);
  const std::vector<Sequence> sequences = {six_by_six("one"), six_by_six("other")};
  const Eigen::VectorXd at = parameter_values(model);
  Eigen::VectorXd residuals[2];
  RowMatrix jacobian[2];
  for (const int threads : {1, 2}) {
    auto evaluator = SequenceEvaluator::make(model, sequences, {.threads = threads}).value();
    ASSERT_EQ(evaluator.evaluate(at, residuals[threads - 1], &jacobian[threads - 1]),
              PathStatus::ok);
  }
  EXPECT_EQ(residuals[0], residuals[1]);
  EXPECT_EQ(jacobian[0], jacobian[1]);
}

/// Predicted values of a channel over the frames.
Eigen::VectorXd channel_of(const model::Model& model, const Sequence& sequence, int channel) {
  auto evaluator = SequenceEvaluator::make(model, {sequence}, {1, 1e-12}).value();
  Eigen::VectorXd residuals;
  EXPECT_EQ(evaluator.evaluate(parameter_values(model), residuals, nullptr), PathStatus::ok);
  const Observations channels(sequence);
  Eigen::VectorXd values(static_cast<Eigen::Index>(sequence.frames.size()));
  values.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (int r = 0; r < evaluator.row_count(); ++r) {
    const Row& row = evaluator.rows()[static_cast<std::size_t>(r)];
    if (row.channel == channel)
      values[row.frame] = residuals[r] * channels.sigma(sequence, channel);
  }
  return values;
}

constexpr int kPull = 27;

TEST(SequenceSensors, ForcesPassTheInstrumentAsItsHeaderSays) {
  const Sequence sequence = six_by_six("one");
  const Eigen::VectorXd bare = channel_of(sheet_model(false), sequence, kPull);
  EXPECT_GT(bare.tail(6).minCoeff(), 0.05);  // N
  const auto with = [&](const char* type, const std::vector<double>& values,
                        const char* component = "pull") {
    model::Model model = sheet_model(false);
    add_correction(model, type, component, values);
    return channel_of(model, sequence, kPull);
  };
  const double tiny = 1e-9 * bare.cwiseAbs().maxCoeff();
  EXPECT_LT((with("offset", {0.4}) - bare).array().operator-(0.4).matrix().norm(), tiny);
  EXPECT_LT((with("gain", {1.3}) - 1.3 * bare).norm(), tiny);
  EXPECT_LT((with("gain", {1.3}, "lift") - bare).norm(), tiny);
  Eigen::VectorXd clock(8);
  clock << 0.0, 0.5, 1.2, 1.6, 2.2, 2.7, 3.0, 3.9;
  EXPECT_LT((with("drift", {0.2}) - bare - 0.2 * clock).norm(), tiny);
  // a tenth of a second ago, of the way from frame 2 to frame 3
  const Eigen::VectorXd late = with("delay", {0.1});
  EXPECT_NEAR(late[3], bare[2] + 0.3 / 0.4 * (bare[3] - bare[2]), tiny);
  EXPECT_EQ(late[0], bare[0]);
  EXPECT_GT(std::abs(late[3] - bare[3]), 1e-3);
  // out in frames 0 to 3, back in 4 and 5, on in 6 and 7
  Eigen::VectorXd way(8);
  way << 1, 1, 1, 1, -1, -1, 1, 1;
  EXPECT_LT(
      (with("cord_friction", {0.1}) - bare.cwiseProduct((1.0 + 0.1 * way.array()).matrix())).norm(),
      tiny);
  const double cap = 0.5 * bare.maxCoeff();
  EXPECT_LT((with("saturation", {1.0, cap}) - bare.cwiseMin(cap)).norm(), tiny);
}

TEST(SequenceSensors, MassAndSlipAreWhatTheyAreOnTheRig) {
  const Sequence sequence = six_by_six("one");
  model::Model model = sheet_model(false);
  add_correction(model, "mass_scale", "", {1.5});
  Sequence heavier = sequence;
  heavier.loads.node_mass_kg *= 1.5;
  model::Model slipped = sheet_model(false);
  add_correction(slipped, "clip_slip", "lift", {0.002, 4.0});
  Sequence moved = sequence;
  for (std::size_t f = 4; f < moved.frames.size(); ++f)
    moved.frames[f].clips[1].position_m.z() -= 0.002;
  for (const int channel : {8, kPull, kPull + 1}) {
    const Eigen::VectorXd bare = channel_of(sheet_model(false), sequence, channel);
    const Eigen::VectorXd heavy = channel_of(model, sequence, channel);
    const Eigen::VectorXd slip = channel_of(slipped, sequence, channel);
    EXPECT_GT((heavy - bare).norm(), 1e-3 * bare.norm());
    EXPECT_LT((heavy - channel_of(sheet_model(false), heavier, channel)).norm(),
              1e-7 * bare.norm());
    EXPECT_EQ(slip.head(4), bare.head(4));
    EXPECT_GT((slip - bare).norm(), 1e-3 * bare.norm());
    EXPECT_LT((slip - channel_of(sheet_model(false), moved, channel)).norm(), 1e-7 * bare.norm());
  }
}

TEST(SequenceSensors, CamerasMoveWhatTheySeeAboutTheMiddle) {
  Sequence sequence = six_by_six("one");
  for (Eigen::Index k = 0; k < 9; ++k)
    sequence.frames[0].points_m.col(k) =
        Eigen::Vector3d(0.2, 0.1, 0.3) + Eigen::Vector3d(0.01, -0.02, 0.0) * double(k - 4);
  const auto place = [&](const model::Model& model, int point, int frame) {
    Eigen::Vector3d x;
    for (int c = 0; c < 3; ++c) x[c] = channel_of(model, sequence, 3 * point + c)[frame];
    return x;
  };
  const Eigen::Vector3d middle(0.2, 0.1, 0.3);
  const Eigen::Vector3d turn(0.3, -0.2, 0.5), shift(0.01, 0.02, -0.03);
  const Eigen::Vector3d bare = place(sheet_model(false), 7, 3);
  model::Model model = sheet_model(false);
  add_correction(model, "camera_scale", "", {1.1});
  EXPECT_LT((place(model, 7, 3) - middle - 1.1 * (bare - middle)).norm(), 1e-9);
  model = sheet_model(false);
  add_correction(model, "camera_pose", "",
                 {turn.x(), turn.y(), turn.z(), shift.x(), shift.y(), shift.z()});
  EXPECT_LT(
      (place(model, 7, 3) - middle - shift - mechanics::rotation_of(turn) * (bare - middle)).norm(),
      1e-9);
  // point 4 hides in frame 2: those about it are drawn; in frame 3 none is
  model = sheet_model(false);
  add_correction(model, "occlusion_bias", "", {0.004, 2.0});
  EXPECT_LT(
      (place(model, 7, 2) - place(sheet_model(false), 7, 2) - Eigen::Vector3d(0, 0, 0.004)).norm(),
      1e-9);
  EXPECT_LT((place(model, 7, 3) - bare).norm(), 1e-9);
}

/// Also from what is no channel; places that are held are not hidden. Spacing: 0.02 m.
TEST(SequenceSensors, DistancesToWhatAFrameDidNotSee) {
  Sequence sequence = six_by_six("one");
  const auto count = [&](std::size_t frame, double most) {
    const auto distances = hidden_distances(sequence);
    return std::count_if(distances[frame].begin(), distances[frame].end(),
                         [&](double distance) { return distance <= most; });
  };
  EXPECT_EQ(count(1, 100.0), 0);
  EXPECT_EQ(count(2, 1.5), 8);
  EXPECT_EQ(count(2, 1.01), 4);
  for (int k = 0; k < static_cast<int>(sequence.points.size()); ++k)
    if (sequence.frames[2].points_m.col(k).array().isNaN().all())
      sequence.frames[2].misread.push_back(k);
  ASSERT_EQ(sequence.frames[2].misread.size(), 1U);
  EXPECT_EQ(count(2, 100.0), 0);
  sequence.frames[2].misread.clear();
  sequence.frames[1].hidden_m = {{0.03, 0.01}};  // beside (0.03, 0.03) and (0.05, 0.03)
  EXPECT_EQ(count(1, 1.5), 2);
  sequence.spacing_m = 0.01;
  EXPECT_EQ(count(1, 1.5), 0);
  EXPECT_EQ(count(2, 1.5), 0);
  sequence.spacing_m = 0.0;
  const auto middle = static_cast<int>(6 * 2 + 2);
  sequence.boundaries[0].held = {middle, middle + 1, middle + 6, middle + 7};
  EXPECT_EQ(count(2, 100.0), 0);
  EXPECT_NEAR(spacing_m({{0.0, 0.0}, {0.3, 0.0}, {0.0, 0.1}, {0.0, 0.25}, {0.31, 0.02}}), 0.1,
              1e-12);
}

TEST(SequenceSensors, ABiasReachesAsFarAsPatchesDo) {
  EXPECT_EQ(drawn_share(1.5, 2.0), 1.0);
  EXPECT_DOUBLE_EQ(drawn_share(2.0, 2.0), 0.5);
  EXPECT_EQ(drawn_share(2.5, 2.0), 0.0);
  EXPECT_EQ(drawn_share(std::numeric_limits<double>::infinity(), 2.0), 0.0);
  EXPECT_EQ(drawn_share(0.0, 0.0), 0.0);
}

TEST(SequenceSensors, OneSequenceMayHaveACorrectionOfItsOwn) {
  const std::vector<Sequence> sequences = {six_by_six("one"), six_by_six("other")};
  model::Model model = sheet_model(false);
  const int gain = add_correction(model, "gain", "pull", {1.2}, "other");
  const int mass = add_correction(model, "mass_scale", "", {0.8}, "other");
  auto evaluator = SequenceEvaluator::make(model, sequences, {2}).value();
  Eigen::VectorXd residuals;
  RowMatrix jacobian;
  ASSERT_EQ(evaluator.evaluate(parameter_values(model), residuals, &jacobian), PathStatus::ok);
  double of_one = 0.0, of_other = 0.0;
  for (int r = 0; r < evaluator.row_count(); ++r) {
    const bool is_other = evaluator.rows()[static_cast<std::size_t>(r)].curve == 1;
    (is_other ? of_other : of_one) +=
        jacobian(r, gain) * jacobian(r, gain) + jacobian(r, mass) * jacobian(r, mass);
  }
  EXPECT_EQ(of_one, 0.0);
  EXPECT_GT(of_other, 1.0);
}

TEST(SequenceSensors, JacobiansBySomeParametersAreThoseByAll) {
  model::Model model = sheet_model(false);
  const int mass = add_correction(model, "mass_scale", "", {0.8});
  const int gain = add_correction(model, "gain", "", {1.2});
  const Eigen::VectorXd at = parameter_values(model);
  SequenceOptions options;
  auto all = SequenceEvaluator::make(model, {six_by_six("one")}, options).value();
  options.moving = {mass};
  auto some = SequenceEvaluator::make(model, {six_by_six("one")}, options).value();
  Eigen::VectorXd residuals, of_some;
  RowMatrix by_all, by_some;
  ASSERT_EQ(all.evaluate(at, residuals, &by_all), PathStatus::ok);
  ASSERT_EQ(some.evaluate(at, of_some, &by_some), PathStatus::ok);
  EXPECT_EQ(residuals, of_some);
  EXPECT_GT(by_all.col(mass).norm(), 1.0);
  EXPECT_LT((by_some.col(mass) - by_all.col(mass)).norm(), 1e-12 * by_all.col(mass).norm());
  EXPECT_GT(by_all.col(gain).norm(), 1.0);
  EXPECT_EQ(by_some.col(gain).norm(), 0.0);
  EXPECT_EQ(by_some.col(0).norm(), 0.0);
  // the gradient of the cost, too
  double cost = 0.0;
  Eigen::VectorXd gradient;
  ASSERT_EQ(all.evaluate_gradient(at, cost, gradient), PathStatus::ok);
  EXPECT_NEAR(cost, residuals.squaredNorm(), 1e-12 * cost);
  EXPECT_LT((gradient - 2.0 * by_all.transpose() * residuals).norm(), 1e-12 * gradient.norm());
}

/// Stiffness, a load cell's zero, a clip's slip and the sheet's mass, all from noisy data.
TEST(SequenceSensors, AFitFindsWhatWasHidden) {
  model::Model model = sheet_model(false);
  const int zero = add_correction(model, "offset", "pull", {0.0});
  const int slip = add_correction(model, "clip_slip", "pull", {0.0, 4.0});
  const int mass = add_correction(model, "mass_scale", "", {1.0});
  Eigen::VectorXd truth = parameter_values(model);
  truth[zero] = 0.03;
  truth[slip] = 0.001;
  truth[mass] = 1.3;
  const auto parameters = parameters_of(model);
  for (const int known : {0, 3, 4, 5}) parameters[static_cast<std::size_t>(known)]->fixed = true;
  parameters[1]->value *= 1.2;
  parameters[2]->value *= 0.8;
  Sequence sequence = six_by_six("one");
  sequence.scalars.clear();
  for (SequenceFrame& frame : sequence.frames) frame.scalars.resize(0);
  measure(sequence, model, truth, 1.0, 5);
  auto evaluator = SequenceEvaluator::make(model, {sequence}, {2}).value();
  const FitResult result = fit(evaluator, model, {});
  ASSERT_TRUE(result.usable) << result.message << evaluator.failure();
  EXPECT_TRUE(result.converged) << result.message;
  for (const int p : {1, 2, zero, slip, mass})
    EXPECT_NEAR(result.parameters[p], truth[p], 4.0 * result.std_error[p]) << p;
  EXPECT_LT(result.std_error[zero], 0.1 * 0.03);
  EXPECT_LT(result.std_error[slip], 0.1 * 0.001);
  EXPECT_LT(result.std_error[mass], 0.3 * 0.3);
}

TEST(SequenceSensors, WhatIsNotThereIsRefusedByName) {
  const auto refused = [](const char* type, const char* component,
                          const std::vector<double>& values, const char* capture,
                          const Sequence& sequence) {
    model::Model model = sheet_model(false);
    add_correction(model, type, component, values, capture);
    const auto made = SequenceEvaluator::make(model, {sequence});
    return made ? std::string() : made.error().message;
  };
  const Sequence sequence = six_by_six("one");
  const std::string who = "the sensor correction \"";
  EXPECT_EQ(refused("gain", "", {1.0}, "two", sequence),
            who + "gain_6\" is of a sequence \"two\", which there is not");
  EXPECT_EQ(refused("gain", "push", {1.0}, "", sequence),
            who + "gain_6\" is of a force \"push\", which there is not");
  EXPECT_EQ(refused("camera_scale", "pull", {1.0}, "", sequence),
            who + "camera_scale_6\" is of whole sequences, not of the channel \"pull\"");
  EXPECT_EQ(refused("clip_slip", "", {0.0, 0.0}, "", sequence),
            who + "clip_slip_6\" does not say by a channel which clip slipped");
  Sequence free = sequence;
  free.boundaries[0].clips[1].is_free = true;
  free.forces.erase(free.forces.begin());
  free.scalars.clear();
  for (SequenceFrame& frame : free.frames) {
    frame.forces_N.setZero(2);
    frame.scalars.resize(0);
  }
  EXPECT_EQ(refused("clip_slip", "lift", {0.0, 0.0}, "", free),
            who + "clip_slip_6\" is of a free clip, which goes where the cloth does");

  model::Model model = sheet_model(false);
  add_correction(model, "offset", "pull", {0.0});
  model.corrections[0].parameters[0].unit = "N/m";
  EXPECT_EQ(SequenceEvaluator::make(model, {sequence}).error().message,
            who + "offset_6\" does not have the parameters of a sheet's offset: value (N)");
  model.corrections[0].type = "camera_length";
  EXPECT_EQ(SequenceEvaluator::make(model, {sequence}).error().message,
            who + "offset_6\" is of type camera_length, which sheets do not have");

  Sequence twice = sequence;
  twice.forces[1].name = "pull";
  EXPECT_EQ(check(twice).error().message, "sequence \"one\": two forces are called \"pull\"");
}

/// Documents keep them, each with its own units.
TEST(SequenceSensors, ModelsWithThemSurviveTheirDocument) {
  model::Model model = sheet_model(false);
  for (const Added& added : kEvery)
    add_correction(model, added.type, added.component, added.values, "a capture's title");
  ASSERT_TRUE(model::validate(model)) << model::validate(model).error().message;
  const auto read = model::parse_model(model::write_model(model), "FILE");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->corrections.size(), std::size(kEvery));
  EXPECT_EQ(read->corrections[0].parameters[0].unit, "N");
  EXPECT_EQ(parameter_values(*read), parameter_values(model));
  EXPECT_EQ(read->corrections[5].component, "pull");
  auto evaluator = SequenceEvaluator::make(*read, {six_by_six("a capture's title")});
  EXPECT_TRUE(evaluator) << evaluator.error().message;
}

}  // namespace
}  // namespace tenter::estimation
