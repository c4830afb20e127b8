// SPDX-License-Identifier: GPL-3.0-or-later
// What only sheets show, each hidden in data: named, or in a group that says so.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "server/diagnosis/field/diagnose_sheet.h"
#include "tests/server/diagnosis/field/sheet_of.h"

namespace tenter::diagnosis {
namespace {

using testing::compliant_cloth;
using testing::diagnosed;
using testing::first;
using testing::in_lines;
using testing::sheets_of;
using testing::SheetTruth;

bool is_name(const Verdict& verdict) {
  return verdict.kind == VerdictKind::named || verdict.kind == VerdictKind::sensor ||
         verdict.kind == VerdictKind::ambiguous;
}

/// Of its verdicts the first names `effect`, alone or in a group of three at most, and no other
/// names anything.
void expect_found(const SheetDiagnosis& d, const std::string& effect) {
  const Verdict& verdict = first(d);
  EXPECT_TRUE(is_name(verdict)) << in_lines(d);
  const bool is_held = verdict.effect == effect ||
                       std::count(verdict.alternatives.begin(), verdict.alternatives.end(), effect);
  EXPECT_TRUE(is_held) << in_lines(d);
  EXPECT_LE(verdict.alternatives.size(), 2U) << in_lines(d);
  EXPECT_EQ(std::count_if(d.verdicts.begin(), d.verdicts.end(), is_name), 1) << in_lines(d);
}

TEST(SheetTwins, ASpecimenThatCurlsIsFound) {
  SheetTruth truth{
      .model = compliant_cloth(), .protocols = {"bend_u", "bend_v", "stretch_u"}, .frames = 10};
  truth.model.terms.push_back(new_term(truth.model, "curl", "bend_u", 0.0, "constant_stress"));
  set_parameter(truth.model.terms.back().law, "c", 2e-4);
  expect_found(diagnosed(sheets_of(truth, compliant_cloth())), "rest_shape");
}

/// A seam: nearly twice as stiff along the warp in a patch that no sample of the catalogue lies in.
TEST(SheetTwins, APatchOfOtherStiffnessIsFound) {
  SheetTruth truth{.model = compliant_cloth(), .frames = 12};
  model::Field field;
  field.id = "seam";
  field.width_m = 0.012;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      for (const double place_m : {0.01 + 0.025 * i, 0.015 + 0.025 * j})
        field.positions_m.push_back(place_m);
  truth.model.fields.push_back(field);
  truth.model.terms.push_back(new_term(truth.model, "seam", "green_v", 0.0, "linear"));
  truth.model.terms.back().support = {"rbf", "seam", 6};
  set_parameter(truth.model.terms.back().law, "k", 40.0);
  expect_found(diagnosed(sheets_of(truth, compliant_cloth())), "heterogeneity");
}

/// A yarn that runs across, at none of the angles that the catalogue asks for.
TEST(SheetTwins, AClothThatIsStifferAskewIsFound) {
  SheetTruth truth{.model = compliant_cloth(), .frames = 12};
  truth.model.terms.push_back(new_term(truth.model, "askew", "green_fibre", 0.65, "linear"));
  set_parameter(truth.model.terms.back().law, "k", 15.0);
  expect_found(diagnosed(sheets_of(truth, compliant_cloth())), "anisotropy");
}

/// Between two captures the cameras were touched.
TEST(SheetTwins, CamerasThatMovedAreFound) {
  const SheetTruth truth{.model = compliant_cloth(), .frames = 12};
  SheetRequest request = sheets_of(truth, compliant_cloth());
  const Eigen::Matrix3d turn(Eigen::AngleAxisd(5e-3, Eigen::Vector3d(0.2, 0.3, 1.0).normalized()));
  for (auto& frame : request.sequences[1].sequence.frames)
    frame.points_m = (turn * frame.points_m).colwise() + Eigen::Vector3d(2e-4, 0.0, -1e-4);
  const SheetDiagnosis d = diagnosed(request);
  expect_found(d, "camera_pose");
  EXPECT_EQ(first(d).kind, VerdictKind::sensor) << in_lines(d);
}

/// The picture's origin lies beside the sheet, and its scale is off by four thousandths.
TEST(SheetTwins, AScaleAboutAPlaceOfItsOwnIsAScale) {
  const SheetTruth truth{.model = compliant_cloth(), .frames = 12};
  SheetRequest request = sheets_of(truth, compliant_cloth());
  const Eigen::Vector3d origin(-0.3, 0.2, 0.0);
  for (SheetSequence& s : request.sequences)
    for (auto& frame : s.sequence.frames)
      frame.points_m = (1.004 * (frame.points_m.colwise() - origin)).colwise() + origin;
  const SheetDiagnosis d = diagnosed(request);
  expect_found(d, "camera_scale");
  EXPECT_EQ(first(d).kind, VerdictKind::sensor) << in_lines(d);
}

/// A lens that shows what is far from the middle of the picture too far out: the catalogue has
/// none.
TEST(SheetTwins, WhatALensBendsGetsNoName) {
  const SheetTruth truth{.model = compliant_cloth(), .frames = 12};
  SheetRequest request = sheets_of(truth, compliant_cloth());
  for (SheetSequence& s : request.sequences)
    for (auto& frame : s.sequence.frames)
      for (Eigen::Index p = 0; p < frame.points_m.cols(); ++p) {
        const Eigen::Vector3d from_middle = frame.points_m.col(p) - Eigen::Vector3d(0.05, 0.05, 0);
        frame.points_m.col(p) += 2.0 * from_middle.squaredNorm() * from_middle;
      }
  const SheetDiagnosis d = diagnosed(request);
  EXPECT_EQ(std::count_if(d.verdicts.begin(), d.verdicts.end(), is_name), 0) << in_lines(d);
  EXPECT_EQ(first(d).kind, VerdictKind::unexplained) << in_lines(d);
}

/// One reading of a hundred is another point's.
TEST(SheetTwins, PointsThatAreMisreadAreFoundAndLeftOut) {
  const SheetTruth truth{.model = compliant_cloth(), .frames = 12};
  SheetRequest request = sheets_of(truth, compliant_cloth());
  std::mt19937 engine(8);
  std::size_t count = 0;
  for (SheetSequence& s : request.sequences)
    for (auto& frame : s.sequence.frames)
      for (Eigen::Index p = 0; p < frame.points_m.cols(); ++p)
        if (engine() % 100 == 0) {
          frame.points_m.col(p) += Eigen::Vector3d(2e-3, -2e-3, 1e-3);
          ++count;
        }
  const SheetDiagnosis d = diagnosed(request);
  expect_found(d, "outliers");
  EXPECT_EQ(first(d).kind, VerdictKind::sensor) << in_lines(d);
  EXPECT_GE(d.misread.size(), count - 2);  // of two side by side neither stands alone
  EXPECT_LE(d.misread.size(), count);
}

/// Pulls along both threads say nothing of shear, and next to nothing of bending.
TEST(SheetTwins, WhatCapturesDoNotDetermineDoesNotRunAway) {
  const SheetTruth truth{
      .model = compliant_cloth(), .protocols = {"stretch_u", "stretch_v"}, .frames = 12};
  const SheetDiagnosis d = diagnosed(sheets_of(truth, compliant_cloth()));
  EXPECT_EQ(std::count_if(d.verdicts.begin(), d.verdicts.end(), is_name), 0) << in_lines(d);
  double stiffest = 0.0, softest = 1e300, bending = 1e300;
  for (const model::Term& term : d.extended.at.model.terms) {
    const model::Parameter& p = term.law.parameters.front();
    if (p.unit == "N m") bending = std::min(bending, p.value);
    if (p.unit != "N/m") continue;
    stiffest = std::max(stiffest, p.value);
    softest = std::min(softest, p.value);
  }
  EXPECT_LT(stiffest, 3e4 * softest) << in_lines(d);
  EXPECT_GT(bending, 0.0) << in_lines(d);
}

/// What hides a point draws its neighbours towards the camera by a third of a millimetre.
TEST(SheetTwins, PointsDrawnToWhatHidesTheirNeighboursAreFound) {
  const SheetTruth truth{.model = compliant_cloth(), .frames = 12};
  SheetRequest request = sheets_of(truth, compliant_cloth());
  std::mt19937 engine(4);
  for (SheetSequence& s : request.sequences) {
    const auto points = static_cast<Eigen::Index>(s.sequence.points.size());
    for (auto& frame : s.sequence.frames) {
      for (int k = 0; k < 3; ++k) {
        const auto hidden = static_cast<Eigen::Index>(engine() % static_cast<unsigned>(points));
        const Eigen::Vector2d place =
            s.sequence.points[static_cast<std::size_t>(hidden)].material_m;
        for (Eigen::Index p = 0; p < points; ++p) {
          const double away =
              (s.sequence.points[static_cast<std::size_t>(p)].material_m - place).norm();
          if (away < 0.019) frame.points_m(2, p) += 3e-4;  // the eight around, at 12.5 mm
        }
        frame.points_m.col(hidden).setConstant(std::nan(""));
      }
    }
  }
  const SheetDiagnosis d = diagnosed(request);
  expect_found(d, "occlusion_bias");
  EXPECT_EQ(first(d).kind, VerdictKind::sensor) << in_lines(d);
}

/// The sheet was weighed with something on it: it weighs two thirds of what the capture says.
TEST(SheetTwins, AMassThatIsWrongIsFound) {
  const SheetTruth truth{
      .model = compliant_cloth(),
      .protocols = {"stretch_u", "stretch_v", "bend_u"},
      .frames = 12,
      .otherwise = [](estimation::Sequence& sequence) { sequence.loads.node_mass_kg *= 0.67; }};
  // what these captures do not determine is known
  model::Model baseline = compliant_cloth();
  for (const std::size_t t : {2, 4, 5}) baseline.terms[t].law.parameters[0].fixed = true;
  expect_found(diagnosed(sheets_of(truth, baseline)), "wrong_mass");
}

/// The same sheet, measured once: a grid of 8 cells is stiffer than it by more than the noise, one
/// of its own fineness is not, and needs no name for what the coarse one missed.
TEST(SheetTwins, AGridThatIsTooCoarseIsNoMaterial) {
  SheetTruth truth{.model = compliant_cloth(),
                   .protocols = {"stretch_u", "shear"},
                   .frames = 10,
                   .load_cells = 0.5,
                   .fineness = 4,
                   .has_finer = true};
  const SheetDiagnosis coarse = diagnosed(sheets_of(truth, compliant_cloth()));
  EXPECT_EQ(first(coarse).kind, VerdictKind::numerical) << in_lines(coarse);
  EXPECT_EQ(first(coarse).effect, "mesh_resolution");
  EXPECT_EQ(std::count_if(coarse.verdicts.begin(), coarse.verdicts.end(), is_name), 0)
      << in_lines(coarse);
  truth.fit_fineness = truth.fineness;
  truth.has_finer = false;
  const SheetDiagnosis fine = diagnosed(sheets_of(truth, compliant_cloth()));
  EXPECT_EQ(std::count_if(
                fine.verdicts.begin(), fine.verdicts.end(),
                [](const Verdict& v) { return is_name(v) || v.kind == VerdictKind::numerical; }),
            0)
      << in_lines(fine);
}

}  // namespace
}  // namespace tenter::diagnosis
