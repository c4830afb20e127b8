// SPDX-License-Identifier: Apache-2.0
// Sensor corrections in documents: of curves in N/m, of sheets in N, told apart by what they have.
#include <gtest/gtest.h>

#include "common/model/catalogue.h"
#include "common/model/document.h"

namespace tenter::model {
namespace {

/// A document with one correction.
Expected<Model> with_correction(const std::string& correction) {
  return parse_model(
      R"({"schema": "tenter.model", "version": 1, "name": "m", "terms": [{"id": "t",
          "strain": {"name": "green_u"}, "law": {"name": "linear"}}], "corrections": [)" +
          correction + "]}",
      "FILE");
}

TEST(Corrections, UnitsAndNamesTellSheetsFromCurves) {
  const auto of_curves =
      with_correction(R"({"id": "c", "type": "offset", "parameters": {"value": 0.5}})");
  ASSERT_TRUE(of_curves) << of_curves.error().message;
  EXPECT_EQ(of_curves->corrections[0].parameters[0].unit, "N/m");
  EXPECT_TRUE(fits(of_curves->corrections[0], *find_correction("offset")));
  const auto of_sheets = with_correction(
      R"({"id": "c", "type": "offset", "component": "left_cord", "capture": "A title",
          "parameters": {"value": {"value": 0.5, "unit": "N"}}})");
  ASSERT_TRUE(of_sheets) << of_sheets.error().message;
  EXPECT_EQ(of_sheets->corrections[0].parameters[0].unit, "N");
  EXPECT_FALSE(fits(of_sheets->corrections[0], *find_correction("offset")));
  EXPECT_TRUE(fits(of_sheets->corrections[0], *find_correction("offset", Seen::sheets)));
  // names alone
  const auto slip =
      with_correction(R"({"id": "c", "type": "clip_slip", "parameters": {"length": 0.001}})");
  ASSERT_TRUE(slip) << slip.error().message;
  EXPECT_EQ(slip->corrections[0].parameters[0].unit, "m");
  EXPECT_TRUE(slip->corrections[0].parameters[1].fixed);
  const auto mass = with_correction(R"({"id": "c", "type": "mass_scale"})");
  ASSERT_TRUE(mass) << mass.error().message;
  EXPECT_EQ(mass->corrections[0].parameters[0].value, 1.0);
  for (const auto* model : {&*of_curves, &*of_sheets, &*slip, &*mass}) {
    const auto again = parse_model(write_model(*model), "FILE");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(write_model(*again), write_model(*model));
  }
}

TEST(Corrections, OnlySheetsHaveChannelsWithNamesAndCapturesWithTitles) {
  const auto error_of = [](const std::string& correction) {
    const auto model = with_correction(correction);
    return model ? std::string("accepted") : model.error().message;
  };
  EXPECT_EQ(error_of(R"({"id": "c", "type": "offset", "component": "left_cord"})"),
            "FILE: corrections[0].component: must be 'x', 'y' or 'xy', not 'left_cord'");
  EXPECT_EQ(error_of(R"({"id": "c", "type": "offset", "capture": "A title"})"),
            "FILE: corrections[0].capture: must be the SHA-256 of a capture");
  EXPECT_EQ(error_of(R"({"id": "c", "type": "gain", "component": "left_cord"})"), "accepted");
  EXPECT_EQ(error_of(R"({"id": "c", "type": "gain", "component": "two words"})"),
            "FILE: corrections[0].component: must be 'x', 'y' or 'xy', not 'two words'");
  EXPECT_EQ(error_of(R"({"id": "c", "type": "drift", "parameters": {"rate": {"value": 1,
                         "unit": "N/h"}}})"),
            "FILE: corrections[0].parameters.rate.unit: is 'N/h', must be 'N/(m s)'");
  EXPECT_EQ(error_of(R"({"id": "c", "type": "glare"})"),
            "FILE: corrections[0].type: there is no sensor correction 'glare'");
}

}  // namespace
}  // namespace tenter::model
