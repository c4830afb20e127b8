// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/diagnose_sheet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "common/model/presets.h"
#include "tests/server/diagnosis/field/sheet_of.h"

namespace tenter::diagnosis {
namespace {

using testing::compliant_cloth;
using testing::diagnosed;
using testing::first;
using testing::in_lines;
using testing::sheets_of;
using testing::SheetTruth;

/// What the rig states of its noise is three times too little here.
TEST(DiagnoseSheet, FindsNothingWhereNothingIsWrong) {
  const SheetTruth truth{.model = compliant_cloth(), .frames = 10, .noise = 3.0};
  const SheetDiagnosis d = diagnosed(sheets_of(truth, compliant_cloth()));
  EXPECT_EQ(first(d).kind, VerdictKind::nothing_found) << in_lines(d);
  EXPECT_TRUE(d.findings.empty());
  for (const FieldNoise::Kind& kind : d.noise.kinds) {
    if (kind.kind != estimation::ObservationKind::position) continue;
    EXPECT_NEAR(kind.factor, 3.0, 0.5);
  }
  EXPECT_NEAR(d.baseline.at.model.terms[0].law.parameters[0].value, 60.0, 2.0);
  // bending that pulls hardly show may not grow without end: E t L^2, with L the diagonal
  for (const model::Term& term : d.baseline.at.model.terms)
    for (const model::Parameter& p : term.law.parameters)
      if (p.unit == "N m") {
        ASSERT_TRUE(p.upper) << term.id;
        EXPECT_GT(*p.upper, 0.1);
        EXPECT_LT(*p.upper, 100.0);
        EXPECT_LE(p.value, *p.upper);
      }
}

TEST(DiagnoseSheet, NamesStiffnessThatGrowsWithStrain) {
  SheetTruth truth{.model = compliant_cloth()};
  model::Law& law = truth.model.terms[0].law;
  law = new_term({}, "weft", "green_u", 0.0, "convex_spline", 4).law;
  law.range_hi = 0.1;
  for (std::size_t k = 0; k < 4; ++k)
    law.parameters[k].value = 50.0 + 20.0 * static_cast<double>(k);
  const SheetRequest request = sheets_of(truth, compliant_cloth());
  const SheetDiagnosis d = diagnosed(request);
  EXPECT_EQ(first(d).kind, VerdictKind::named) << in_lines(d);
  EXPECT_EQ(first(d).effect, "nonlinear_stiffness") << in_lines(d);
  ASSERT_EQ(d.findings.size(), 1U);
  EXPECT_EQ(d.findings[0].trial.variant.words, "weft");
  // what is left is noise, and the extended model says where it is from
  EXPECT_LT(d.extended.at.fit.chi2, 1.1 * static_cast<double>(d.extended.rows.size()));
  EXPECT_GT(d.baseline.at.fit.chi2, 1.2 * d.extended.at.fit.chi2);
  ASSERT_TRUE(d.extended.at.model.lineage);
  EXPECT_EQ(d.extended.at.model.lineage->added, std::vector<std::string>{"nonlinear_stiffness"});
  ASSERT_TRUE(d.held_out_before && d.held_out_after);
  EXPECT_LT(d.held_out_after->error, 0.8 * d.held_out_before->error);
}

/// Five frames a branch of a force that grows tenfold faster than the model's: its curve is no
/// noise.
TEST(DiagnoseSheet, TakesNoCurveForNoise) {
  SheetTruth truth{
      .model = compliant_cloth(), .protocols = {"stretch_u", "stretch_v"}, .frames = 10};
  model::Law& law = truth.model.terms[0].law;
  law = new_term({}, "weft", "green_u", 0.0, "convex_spline", 4).law;
  law.range_hi = 0.1;
  for (std::size_t k = 0; k < 4; ++k)
    law.parameters[k].value = 40.0 * std::pow(10.0, static_cast<double>(k) / 2.0);
  model::Model baseline = compliant_cloth();
  for (const std::size_t t : {2, 3, 4, 5}) baseline.terms[t].law.parameters[0].fixed = true;
  const SheetDiagnosis d = diagnosed(sheets_of(truth, baseline));
  ASSERT_GT(d.baseline.at.fit.chi2, 3.0 * static_cast<double>(d.baseline.rows.size()))
      << in_lines(d);
  for (const FieldNoise::Kind& kind : d.noise.kinds)
    if (kind.kind == estimation::ObservationKind::force) {
      EXPECT_LT(kind.factor, 2.0) << in_lines(d);
      EXPECT_GT(kind.factor, 0.5) << in_lines(d);
    }
  EXPECT_EQ(first(d).kind, VerdictKind::named) << in_lines(d);
  EXPECT_EQ(first(d).effect, "nonlinear_stiffness") << in_lines(d);
}

TEST(DiagnoseSheet, NamesFrictionThatTwoRatesTellFromViscosity) {
  SheetTruth truth{.model = compliant_cloth(), .protocols = {"stretch_v"}, .two_rates = true};
  truth.model.terms.push_back(new_term(truth.model, "friction", "green_v", 0.0, "dahl"));
  model::Law& law = truth.model.terms.back().law;
  set_parameter(law, "a", 0.3);
  set_parameter(law, "b", 0.0, true);
  set_parameter(law, "tau", 0.01);
  model::Model baseline = compliant_cloth();
  // one pull along the warp tells nothing of the others
  for (const std::size_t t : {0, 2, 3, 4, 5}) baseline.terms[t].law.parameters[0].fixed = true;
  const SheetDiagnosis d = diagnosed(sheets_of(truth, baseline));
  EXPECT_EQ(first(d).kind, VerdictKind::named) << in_lines(d);
  EXPECT_EQ(first(d).effect, "internal_friction") << in_lines(d);
}

TEST(DiagnoseSheet, NamesAnisotropyWithTheSameBytesForAnyNumberOfThreads) {
  model::Model isotropic = model::preset("stvk_isotropic").value();
  const model::Model cloth = compliant_cloth();
  for (std::size_t t = 3; t < cloth.terms.size(); ++t) isotropic.terms.push_back(cloth.terms[t]);
  SheetTruth truth{.model = isotropic, .protocols = {"stretch_u", "stretch_v"}, .frames = 8};
  truth.model.terms.push_back(new_term(truth.model, "own", "green_v", 0.0, "linear"));
  truth.model.terms[0].law.parameters[0].value = 40.0;
  truth.model.terms[1].law.parameters[0].value = 25.0;
  set_parameter(truth.model.terms.back().law, "k", 20.0);
  const SheetRequest request = sheets_of(truth, isotropic);
  const SheetDiagnosis d = diagnosed(request, 2);
  EXPECT_EQ(first(d).kind, VerdictKind::named) << in_lines(d);
  EXPECT_EQ(first(d).effect, "anisotropy") << in_lines(d);
  const SheetDiagnosis again = diagnosed(request, 1);
  EXPECT_EQ(d.extended.at.fit.parameters, again.extended.at.fit.parameters);
  EXPECT_EQ(d.extended.at.fit.residuals, again.extended.at.fit.residuals);
  EXPECT_EQ(in_lines(d.verdicts), in_lines(again.verdicts));
}

/// The warp is softer than the rest: no stiffness that is added along one direction says that, and
/// none may be taken away.
TEST(DiagnoseSheet, NamesAnisotropyOfOneDirectionThatIsSofter) {
  model::Model isotropic = model::preset("stvk_isotropic").value();
  const model::Model cloth = compliant_cloth();
  for (std::size_t t = 3; t < cloth.terms.size(); ++t) isotropic.terms.push_back(cloth.terms[t]);
  SheetTruth truth{.model = isotropic, .frames = 10};
  const auto add = [&](const char* measure, double k) {
    truth.model.terms.push_back(new_term(truth.model, "own", measure, 0.0, "linear"));
    set_parameter(truth.model.terms.back().law, "k", k);
  };
  add("green_u", 8.0);
  add("green_uv", 4.0);
  truth.model.terms[0].law.parameters[0].value = 30.0;
  truth.model.terms[1].law.parameters[0].value = 21.0;
  const SheetDiagnosis d = diagnosed(sheets_of(truth, isotropic));
  EXPECT_EQ(first(d).kind, VerdictKind::named) << in_lines(d);
  EXPECT_EQ(first(d).effect, "anisotropy") << in_lines(d);
  ASSERT_EQ(d.findings.size(), 1U);
  EXPECT_EQ(d.findings[0].trial.variant.words, "an own stiffness along weft and shear");
}

/// One of two cells that pull on the same cloth shows 20 mN too much.
TEST(DiagnoseSheet, BlamesALoadCellForItsZero) {
  const SheetTruth truth{
      .model = compliant_cloth(), .protocols = {"stretch_u", "stretch_v"}, .frames = 10};
  SheetRequest request = sheets_of(truth, compliant_cloth());
  for (auto& frame : request.sequences[0].sequence.frames) frame.forces_N[1] += 0.02;
  const SheetDiagnosis d = diagnosed(request);
  EXPECT_EQ(first(d).kind, VerdictKind::sensor) << in_lines(d);
  EXPECT_EQ(first(d).effect, "load_cell_offset") << in_lines(d);
  ASSERT_EQ(d.extended.at.model.corrections.size(), 1U);
  EXPECT_EQ(d.extended.at.model.corrections[0].component, "stretch_u_2");
  EXPECT_NEAR(d.extended.at.model.corrections[0].parameters[0].value, 0.02, 0.004);
}

TEST(DiagnoseSheet, StopsWhenItIsToldTo) {
  const SheetTruth truth{.model = compliant_cloth(), .protocols = {"stretch_u"}, .frames = 4};
  std::stop_source source;
  Control control;
  control.stop = source.get_token();
  int reports = 0;
  control.report = [&](const Progress&) {
    ++reports;
    source.request_stop();
  };
  const auto found = diagnose_sheets(sheets_of(truth, compliant_cloth()), control);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, ErrorKind::cancelled) << found.error().message;
  EXPECT_GE(reports, 1);
}

}  // namespace
}  // namespace tenter::diagnosis
