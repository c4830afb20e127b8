// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/csv_import.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/sha256.h"
#include "tests/common/capture/support.h"

namespace tenter::capture {
namespace {

using test::import_text;
using test::message_of;
using test::uniaxial_description;

const std::string kCsv =
    "time_s,displacement_mm,force_N\n0,0,0\n1,0.8,1\n2,1.6,2.5\n3,0.8,0.5\n4,0,-0.1\n";

/// The message without the temporary folder.
std::string refusal(const std::string& csv, const std::string& description) {
  const auto capture = import_text(csv, description);
  if (capture) return "accepted";
  EXPECT_EQ(capture.error().kind, ErrorKind::bad_input);
  std::string message = capture.error().message;
  for (std::size_t at; (at = message.find("/tmp/")) != std::string::npos;)
    message.erase(at, message.find('/', at + 5) + 1 - at);
  EXPECT_EQ(message.back(), '.') << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  return message;
}

TEST(CsvImport, MakesSiOfUnits) {
  const auto capture = import_text(kCsv, uniaxial_description());
  ASSERT_TRUE(capture) << message_of(capture);
  EXPECT_EQ(capture->frame_count(), 5U);
  EXPECT_EQ(capture->time_s, (std::vector<double>{0, 1, 2, 3, 4}));
  ASSERT_EQ(capture->channels.size(), 2U);
  EXPECT_DOUBLE_EQ(capture->find("displacement")->values[2], 1.6e-3);
  EXPECT_EQ(capture->find("displacement")->unit, "m");
  EXPECT_EQ(capture->find("displacement")->source_unit, "mm");
  EXPECT_DOUBLE_EQ(*capture->specimen.width_m, 0.05);
  EXPECT_DOUBLE_EQ(capture->kinematics.x.reference_length_m, 0.08);
  EXPECT_EQ(capture->branch, (std::vector<Branch>{Branch::load, Branch::load, Branch::load,
                                                  Branch::unload, Branch::unload}));
  EXPECT_EQ(capture->runs.size(), 1U);
  EXPECT_EQ(capture->kinematics.xy.fixed_value, 0.0);
  EXPECT_EQ(capture->provenance.imported_from, "pull.csv");
  EXPECT_EQ(capture->provenance.imported_sha256, sha256_hex(kCsv));
}

const std::string kFinite = "E,S\n0,0\n0.5,10\n1.5,20\n";

/// Green strain along x and second Piola-Kirchhoff stress, in another way where `patch` says so.
std::string finite_description(const std::string& patch = "{}") {
  nlohmann::json base = nlohmann::json::parse(uniaxial_description(R"({
    "columns": {"time_s": null, "displacement_mm": null, "force_N": null,
      "E": {"channel": "strain", "quantity": "strain", "measure": "green", "unit": "1"},
      "S": {"channel": "stress", "quantity": "membrane_stress", "measure": "second_piola",
            "unit": "N/m"}},
    "kinematics": {"x": {"channel": "strain", "reference_length": null}},
    "stresses": {"x": "stress"}})"));
  base.merge_patch(nlohmann::json::parse(patch));
  return base.dump();
}

TEST(CsvImport, MakesNominalStressesOfFiniteMeasures) {
  const auto capture = import_text(kFinite, finite_description());
  ASSERT_TRUE(capture) << message_of(capture);
  // stretches 1, sqrt 2 and 2; P = stretch S
  const std::vector<double> stretch = {1.0, std::sqrt(2.0), 2.0};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(capture->find("strain")->values[i], stretch[i] - 1.0, 1e-15);
    EXPECT_NEAR(capture->find("stress")->values[i], 10.0 * static_cast<double>(i) * stretch[i],
                1e-12);
  }
  // shear on fibres that keep their length, the other direction free: P_xy = x S_xy
  const auto sheared = import_text("g,T\n0,0\n0.1,3\n", finite_description(R"({
    "columns": {"E": null, "S": null, "g": {"channel": "shear", "quantity": "shear", "unit": "1"},
      "T": {"channel": "stress", "quantity": "membrane_stress", "measure": "second_piola",
            "unit": "N/m"}},
    "kinematics": {"x": {"role": "fixed", "channel": null, "value": 1.1},
                   "xy": {"role": "prescribed", "channel": "shear"}},
    "stresses": {"x": null, "xy": "stress"}})"));
  ASSERT_TRUE(sheared) << message_of(sheared);
  EXPECT_NEAR(sheared->find("stress")->values[1], 3.3, 1e-12);
}

TEST(CsvImport, RefusesFiniteMeasuresThatTellNoStretch) {
  EXPECT_EQ(refusal("E,S\n0,0\n-0.5,1\n", finite_description()),
            "pull.csv: line 3, column \"E\": a Green strain is above -0.5.");
  EXPECT_EQ(refusal(kFinite, finite_description(R"({"columns": {"S": {"measure": "cauchy"}}})")),
            "pull.json: columns.S.measure must be \"green\" of a strain or \"second_piola\" of a "
            "stress or force.");
  EXPECT_EQ(refusal(kFinite, finite_description(R"({"columns": {"S": {"sigma": 0.1}}})")),
            "pull.json: columns.S.sigma cannot be given in a measure of finite strain.");
  EXPECT_EQ(refusal(kFinite, finite_description(R"({"stresses": {"x": null}})")),
            "pull.json: columns.S.measure \"second_piola\" needs its component in stresses.");
  EXPECT_EQ(
      refusal(kFinite, finite_description(R"({"stresses": {"x": null, "y": "stress"}})")),
      "pull.json: columns.S.measure \"second_piola\" needs the stretch along y as a channel of "
      "stretches or strains, or fixed.");
  EXPECT_EQ(refusal(kFinite, finite_description(
                                 R"({"kinematics": {"xy": {"role": "fixed", "value": 0.1}}})")),
            "pull.json: columns.S.measure \"second_piola\" along x needs a test without shear.");
  EXPECT_EQ(refusal(kFinite, finite_description(
                                 R"({"kinematics": {"y": {"role": "fixed"}},
                                     "stresses": {"x": null, "xy": "stress"}})")),
            "pull.json: columns.S.measure \"second_piola\" of shear needs a y direction free of "
            "stress.");
}

TEST(CsvImport, ChannelsKeepTheOrderOfTheFile) {
  const auto capture =
      import_text("force_N,time_s,displacement_mm\n0,0,0\n1,1,1\n", uniaxial_description());
  ASSERT_TRUE(capture) << message_of(capture);
  EXPECT_EQ(capture->channels[0].name, "force");
  EXPECT_EQ(capture->channels[1].name, "displacement");
}

TEST(CsvImport, RefusesBadDescriptionsWithThePathOfTheKey) {
  const auto patched = [](const std::string& patch) {
    return refusal(kCsv, uniaxial_description(patch));
  };
  EXPECT_EQ(patched(R"({"columns": {"force_N": {"unit": null}}})"),
            "pull.json: columns.force_N.unit is missing; every measured column names its unit "
            "(\"1\" for a plain number).");
  EXPECT_EQ(patched(R"({"columns": {"force_N": {"unit": "kPa"}}})"),
            "pull.json: columns.force_N.unit: unit \"kPa\" cannot be turned into \"N\".");
  EXPECT_EQ(patched(R"({"columns": {"time_s": {"unit": null}}})"),
            "pull.json: columns.time_s.unit is missing; every measured column names its unit "
            "(\"1\" for a plain number).");
  EXPECT_EQ(patched(R"({"columns": {"force_N": {"scale": 2}}})"),
            "pull.json: columns.force_N.scale is not a known key.");
  EXPECT_EQ(patched(R"({"specimen": {"width": {"unit": null}}})"),
            "pull.json: specimen.width.unit is missing.");
  EXPECT_EQ(patched(R"({"specimen": {"width": {"value": 50, "unit": "kg"}}})"),
            "pull.json: specimen.width.unit: unit \"kg\" cannot be turned into \"m\".");
  EXPECT_EQ(patched(R"({"colums": {}})"), "pull.json: colums is not a known key.");
  EXPECT_EQ(patched(R"({"title": null})"), "pull.json: title is missing.");
  EXPECT_EQ(patched(R"({"title": 7})"), "pull.json: title must be a text.");
  EXPECT_EQ(patched(R"({"protocol": {"history": "again"}})"),
            "pull.json: protocol.history is \"again\", not one of continues, virgin_each_run.");
  EXPECT_EQ(patched(R"({"assume_unit_width": true})"),
            "pull.json: assume_unit_width contradicts the size that specimen gives.");
  EXPECT_EQ(refusal(kCsv, "{\"a\": 1,\n\"a\": 2}"),
            "pull.json: has the key \"a\" twice in one object.");
  EXPECT_EQ(refusal(kCsv, "{\n\"a\": ]\n}"), "pull.json: line 2 is not valid JSON.");
  EXPECT_EQ(refusal(kCsv, "[]"), "pull.json: the document must be an object.");
  EXPECT_EQ(refusal(kCsv, std::string(5000, '[')),
            "pull.json: is nested more than 32 levels deep.");
}

TEST(CsvImport, RefusesColumnsThatDoNotMatch) {
  EXPECT_EQ(
      refusal("time_s,displacement_mm\n0,0\n", uniaxial_description()),
      "pull.csv: has no column \"force_N\", which pull.json names at columns; its columns are "
      "time_s, displacement_mm.");
  EXPECT_EQ(refusal("time_s,displacement_mm,force_N,extra\n0,0,0,0\n", uniaxial_description()),
            "pull.csv: column \"extra\" is not described in pull.json; describe it, or mark it "
            "\"ignore\".");
  EXPECT_TRUE(import_text("time_s,displacement_mm,force_N,extra\n0,0,0,0\n1,1,1,1\n",
                          uniaxial_description(R"({"other_columns": "ignore"})")));
  EXPECT_TRUE(import_text("time_s,displacement_mm,force_N,extra\n0,0,0,0\n1,1,1,1\n",
                          uniaxial_description(R"({"columns": {"extra": "ignore"}})")));
}

TEST(CsvImport, RefusesBadCellsWithLineAndColumn) {
  const auto with = [](const std::string& row) {
    return refusal("time_s,displacement_mm,force_N\n0,0,0\n" + row + "\n2,1.6,2.5\n",
                   uniaxial_description());
  };
  EXPECT_EQ(
      with("1,0.8,"),
      "pull.csv: line 3, column \"force_N\": is blank, and pull.json does not declare missing "
      "values there.");
  EXPECT_EQ(with("1,0.8,NaN"),
            "pull.csv: line 3, column \"force_N\": is NaN, and pull.json does not declare missing "
            "values there.");
  EXPECT_EQ(with("1,0.8,inf"),
            "pull.csv: line 3, column \"force_N\": \"inf\" is too large or too small.");
  EXPECT_EQ(with("1,0.8,1e999"),
            "pull.csv: line 3, column \"force_N\": \"1e999\" is too large or too small.");
  EXPECT_EQ(with("1,0.8,1.5N"), "pull.csv: line 3, column \"force_N\": \"1.5N\" is not a number.");
  EXPECT_EQ(with("1,0.8,0x10"), "pull.csv: line 3, column \"force_N\": \"0x10\" is not a number.");
  EXPECT_EQ(with(",0.8,1"),
            "pull.csv: line 3, column \"time_s\": is blank, and pull.json does not declare missing "
            "values there.");
  EXPECT_EQ(with("-1,0.8,1"), "pull.csv: line 3, column \"time_s\": time goes back within run 1.");
  EXPECT_EQ(with("0,0.8,1"),
            "pull.csv: line 3, column \"time_s\": time stands still within run 1.");
  EXPECT_EQ(with("1,0.8"), "pull.csv: line 3 has 2 cells where the header has 3.");
}

TEST(CsvImport, TakesMissingValuesWhereDeclared) {
  const auto capture =
      import_text("time_s,displacement_mm,force_N\n0,0,0\n1,0.8,\n2,1.6,nan\n",
                  uniaxial_description(R"({"columns": {"force_N": {"missing": "allowed"}}})"));
  ASSERT_TRUE(capture) << message_of(capture);
  EXPECT_TRUE(std::isnan(capture->find("force")->values[1]));
  EXPECT_TRUE(std::isnan(capture->find("force")->values[2]));
}

TEST(CsvImport, SizesMustBePositiveAndThere) {
  EXPECT_EQ(refusal(kCsv, uniaxial_description(
                              R"({"specimen": {"width": {"value": -50, "unit": "mm"}}})")),
            "pull.csv with pull.json: specimen.width must be positive, not -0.050000.");
  EXPECT_EQ(refusal(kCsv, uniaxial_description(R"({"specimen": {"width": null}})")),
            "pull.csv with pull.json: stresses.x: the force \"force\" needs specimen.width or "
            "specimen.cross_section.");
  const auto assumed = import_text(
      kCsv, uniaxial_description(R"({"specimen": {"width": null}, "assume_unit_width": true})"));
  ASSERT_TRUE(assumed) << message_of(assumed);
  EXPECT_EQ(*assumed->specimen.width_m, 1.0);
  EXPECT_NE(assumed->provenance.notes.find("1 m is assumed"), std::string::npos);
}

TEST(CsvImport, TimeMayRestartPerRunAndRepeatsAreOneGroup) {
  const std::string csv =
      "run,time_s,displacement_mm,force_N\n4,0,0,0\n4,1,1,1\n9,0,0,0\n9,1,1,1\n";
  const auto capture = import_text(
      csv, uniaxial_description(
               R"({"columns": {"run": {"is": "run"}}, "protocol": {"repeats": true}})"));
  ASSERT_TRUE(capture) << message_of(capture);
  ASSERT_EQ(capture->runs.size(), 2U);
  EXPECT_EQ(capture->runs[0].number, 4);
  EXPECT_EQ(capture->runs[1].number, 9);
  EXPECT_EQ(capture->runs[0].group, "all");
  EXPECT_EQ(capture->runs[1].group, "all");

  EXPECT_EQ(refusal("run,time_s,displacement_mm,force_N\n1,0,0,0\n2,1,1,1\n1,2,0,0\n",
                    uniaxial_description(R"({"columns": {"run": {"is": "run"}}})")),
            "pull.csv: line 4, column \"run\": run \"1\" starts again after another run.");
}

TEST(CsvImport, TextsNameRunsGroupsPhasesAndBranches) {
  const std::string csv =
      "path,dir,stretch_x,s,s_std\nstrip,up,1,0,0.5\nstrip,down,1.1,1,0.5\nequi,up,1,0,1\n";
  const std::string description = R"({
    "kind": "homogeneous_strain", "title": "t",
    "columns": {
      "path": {"is": ["run", "group", "phase"]},
      "dir": {"is": "branch", "values": {"up": "load", "down": "unload"}},
      "stretch_x": {"quantity": "stretch", "unit": "1"},
      "s": {"channel": "stress", "quantity": "stress", "unit": "kPa", "sigma_column": "s_std", "sigma": 2}
    },
    "specimen": {"name": "n", "material": "m", "axis_angle": {"value": 45, "unit": "degree"}},
    "assume_unit_thickness": true,
    "protocol": {"name": "p", "history": "virgin_each_run"},
    "provenance": {"source": "x"},
    "kinematics": {"x": {"role": "prescribed", "channel": "stretch_x"}, "y": {"role": "free"}},
    "stresses": {"x": "stress"}})";
  const auto capture = import_text(csv, description);
  ASSERT_TRUE(capture) << message_of(capture);
  ASSERT_EQ(capture->runs.size(), 2U);
  EXPECT_EQ(capture->runs[1].number, 2);
  EXPECT_EQ(capture->runs[1].group, "equi");
  ASSERT_EQ(capture->protocol.phases.size(), 2U);
  EXPECT_EQ(capture->protocol.phases[1].name, "equi");
  EXPECT_EQ(capture->phase, (std::vector<int>{0, 0, 1}));
  EXPECT_EQ(capture->branch[1], Branch::unload);
  EXPECT_EQ(capture->find("stress")->sigma_per_frame, (std::vector<double>{500, 500, 1000}));
  EXPECT_EQ(capture->find("stress")->sigma, 2000.0);
  EXPECT_EQ(*capture->specimen.thickness_m, 1e-3);
  EXPECT_NEAR(capture->specimen.axis_angle_rad, M_PI / 4, 1e-15);
  EXPECT_TRUE(capture->time_s.empty());

  EXPECT_EQ(
      refusal("path,dir,stretch_x,s,s_std\nstrip,up,1,0,0.5\nstrip,sideways,1.1,1,0.5\n",
              description),
      "pull.csv: line 3, column \"dir\": \"sideways\" is not one of load, unload, hold, other.");
  EXPECT_EQ(refusal("path,dir,stretch_x,s,s_std\nstrip,up,1,0,-0.5\n", description),
            "pull.csv: line 2, column \"s_std\": a standard deviation cannot be negative.");
}

TEST(CsvImport, OneFileGivesSeveralCaptures) {
  const std::string csv =
      "which,time_s,displacement_mm,force_N\na,0,0,0\nb,0,0,0\na,1,1,1\nb,1,2,2\n";
  const auto b = import_text(csv, uniaxial_description(R"({"where": {"which": "b"}})"));
  ASSERT_TRUE(b) << message_of(b);
  EXPECT_EQ(b->find("force")->values, (std::vector<double>{0, 2}));
  EXPECT_EQ(refusal(csv, uniaxial_description(R"({"where": {"which": "c"}})")),
            "pull.csv: no row has the cells that \"where\" of pull.json asks for.");
  EXPECT_EQ(
      refusal(csv, uniaxial_description(R"({"where": {"what": "c"}})")),
      "pull.csv: has no column \"what\", which pull.json names at where; its columns are which, "
      "time_s, displacement_mm, force_N.");
}

TEST(CsvImport, TakesGermanMachines) {
  const auto capture = import_text(
      "Pr\xC3\xBC"
      "fung 7\ntime_s;displacement_mm;force_N\n0;0;0\n1,5;0,8;1e1\n",
      uniaxial_description(R"({"separator": ";", "decimal": ",", "skip_lines": 1})"));
  ASSERT_TRUE(capture) << message_of(capture);
  EXPECT_EQ(capture->time_s[1], 1.5);
  EXPECT_EQ(capture->find("force")->values[1], 10.0);
}

TEST(CsvImport, LeavesOutARowOfUnits) {
  const std::string csv = "time_s,displacement_mm,force_N\ns,mm,N\n0,0,0\n1,1,2\n";
  EXPECT_NE(refusal(csv, uniaxial_description("{}")).find("\"skip_rows\": 1 in pull.json"),
            std::string::npos);
  const auto capture = import_text(csv, uniaxial_description(R"({"skip_rows": 1})"));
  ASSERT_TRUE(capture) << message_of(capture);
  EXPECT_EQ(capture->find("force")->values, (std::vector<double>{0, 2}));
  EXPECT_NE(refusal(csv, uniaxial_description(R"({"skip_rows": 101})"))
                .find("skip_rows must be a whole number from 0 to 100"),
            std::string::npos);
}

TEST(CsvImport, KinematicsMustNameWhatIsThere) {
  EXPECT_EQ(
      refusal(kCsv, uniaxial_description(R"({"kinematics": {"x": {"channel": "force"}}})")),
      "pull.csv with pull.json: kinematics.x names channel \"force\", which measures force, not "
      "a stretch or length.");
  EXPECT_EQ(
      refusal(kCsv, uniaxial_description(R"({"kinematics": {"x": {"reference_length": null}}})")),
      "pull.csv with pull.json: kinematics.x needs a positive reference length.");
  EXPECT_EQ(refusal(kCsv, uniaxial_description(R"({"stresses": {"x": "displacement"}})")),
            "pull.csv with pull.json: stresses.x names channel \"displacement\", which measures "
            "displacement, not a force or stress.");
  EXPECT_EQ(refusal(kCsv, uniaxial_description(R"({"stresses": {"z": "force"}})")),
            "pull.csv with pull.json: stresses.z: a component is x, y or xy.");
}

TEST(CsvImport, MissingFilesAreNotFound) {
  const auto capture = import_csv("/nowhere/a.csv", "/nowhere/a.json");
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().kind, ErrorKind::not_found);
  EXPECT_EQ(capture.error().message, "/nowhere/a.json: No such file or directory.");
}

}  // namespace
}  // namespace tenter::capture
