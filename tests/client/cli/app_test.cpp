// SPDX-License-Identifier: Apache-2.0
// The command called as a function: what it prints and with which exit code, for everything that
// needs no server.
#include "client/cli/app.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "client/cli/job_run.h"
#include "client/cli/sheet/fit_options.h"
#include "common/model/document.h"
#include "common/model/presets.h"
#include "common/report/residual_file.h"

namespace tenter::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Outcome {
  int code = 0;
  std::string out;
  std::string err;
};

Outcome call(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "tenter");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.code = run(static_cast<int>(arguments.size()), arguments.data());
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.err = testing::internal::GetCapturedStderr();
  return outcome;
}

class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "tenter-cli-test-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return (path_ / name).string();
  }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

TEST(CommandLine, MistakesGetExitCode2AndOneSentence) {
  const struct {
    std::vector<const char*> arguments;
    const char* says;
  } cases[] = {
      {{"bogus"}, "there is no command 'bogus'"},
      {{"job", "bogus"}, "there is no command 'bogus' here; the commands are submit"},
      {{"job"}, "a command is missing"},
      {{"diagnose"}, "CAPTURE is required (see `tenter diagnose --help`)"},
      {{"diagnose", "x.h5", "--frobnicate"}, "--frobnicate"},
      {{"--domain", "999", "server", "status"}, "999"},
      {{"--timeout", "soon", "server", "status"}, "soon"},
      {{"job", "list", "--state", "asleep"}, "asleep"},
      {{"residuals", "3", "--frames", "9:3"}, "--frames 9:3"},
      {{"residuals", "3", "--frames", ":"}, "--frames :"},
      {{"diagnose", "abcdef", "--set", "novalue"}, "KEY=VALUE"},
      {{"completion", "fish"}, "fish"},
  };
  for (const auto& c : cases) {
    const Outcome outcome = call(c.arguments);
    EXPECT_EQ(outcome.code, 2) << c.says;
    EXPECT_NE(outcome.err.find(c.says), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

TEST(CommandLine, WithJsonAnErrorIsOneObjectOnStandardOutput) {
  for (const std::vector<const char*>& arguments :
       std::vector<std::vector<const char*>>{{"--json", "bogus"},
                                             {"diagnose", "--json"},
                                             {"--json", "model", "show", "jelly"},
                                             {"model", "validate", "/nowhere.json", "--json"},
                                             {"--json", "diagnose", "nowhere.h5"}}) {
    const Outcome outcome = call(arguments);
    const Json value = Json::parse(outcome.out);
    EXPECT_EQ(value["error"]["code"], outcome.code);
    EXPECT_FALSE(value["error"]["message"].get<std::string>().empty());
    EXPECT_EQ(outcome.err, "");
    EXPECT_TRUE(outcome.code == 2 || outcome.code == 3) << outcome.out;
  }
}

TEST(CommandLine, NoServerIsExitCode5) {
  const Outcome outcome = call({"--domain", "231", "--server", "nobody-has-this-name", "--timeout",
                                "0.3", "--json", "job", "list"});
  EXPECT_EQ(outcome.code, 5);
  EXPECT_EQ(Json::parse(outcome.out)["error"]["kind"], "unavailable");
}

TEST(CommandLine, TheCommandWithoutArgumentsExplainsItself) {
  const Outcome outcome = call({});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("SYNOPSIS"), std::string::npos);
  EXPECT_EQ(call({"--version"}).out.rfind("tenter ", 0), 0u);
}

TEST(ModelCommands, ListShowAndValidateAgree) {
  const Json listed = Json::parse(call({"--json", "model", "list"}).out);
  EXPECT_EQ(listed["models"].size(), model::preset_names().size());
  const Json catalogue = Json::parse(call({"--json", "model", "list", "--catalogue"}).out);
  EXPECT_GE(catalogue["laws"].size(), 11u);

  const Folder folder;
  const Outcome shown = call({"model", "show", "stvk_orthotropic"});
  EXPECT_EQ(shown.code, 0);
  const std::string file = folder.write("model.json", shown.out);
  const Outcome valid = call({"--json", "model", "validate", file.c_str()});
  EXPECT_EQ(valid.code, 0) << valid.out;
  EXPECT_EQ(Json::parse(valid.out)["models"][0]["name"], "stvk_orthotropic");

  const std::string bad =
      folder.write("bad.json", R"({"schema": "tenter.model", "version": 1, "name": "m",
    "terms": [{"id": "t", "strain": {"name": "green_u"}, "law": {"name": "linear", "parameters": {"k": "stiff"}}}]})");
  const Outcome invalid = call({"model", "validate", bad.c_str()});
  EXPECT_EQ(invalid.code, 2);
  EXPECT_NE(invalid.err.find("bad.json: terms[0].law.parameters.k:"), std::string::npos)
      << invalid.err;
}

TEST(RunCommands, WhatCannotBeACaptureIsRefusedBeforeTheServerIsAsked) {
  const Folder folder;
  const std::string csv = folder.write("pull.csv", "a,b\n1,2\n");
  const Outcome table = call({"--domain", "231", "--timeout", "0.2", "diagnose", csv.c_str()});
  EXPECT_EQ(table.code, 2);
  EXPECT_NE(table.err.find("capture import"), std::string::npos);
  const Outcome missing = call({"--domain", "231", "--timeout", "0.2", "fit", "nowhere.h5"});
  EXPECT_EQ(missing.code, 3);
  const Outcome model =
      call({"--domain", "231", "--timeout", "0.2", "fit", "abcdef", "--model", "jelly"});
  EXPECT_EQ(model.code, 3);
  EXPECT_NE(model.err.find("stvk_orthotropic"), std::string::npos);
}

TEST(RunCommands, TheDigestIsTheResultWithoutThePointsOfFigures) {
  const Json result = {{"schema", "tenter.result"},
                       {"verdicts", Json::array()},
                       {"figures", {1, 2, 3}},
                       {"noise_floor", 0.1}};
  const Json digest = result_digest(result, "17");
  EXPECT_EQ(digest["job_id"], "17");
  EXPECT_EQ(digest["noise_floor"], 0.1);
  EXPECT_TRUE(digest.contains("verdicts"));
  EXPECT_FALSE(digest.contains("figures"));
}

TEST(ReportCommand, MakesThePageOfAKeptResult) {
  const Folder folder;
  const std::string result = folder.write(
      "result.json",
      R"({"schema": "tenter.result", "version": 1, "kind": "fit", "error_after": 0.05})");
  const std::string page = folder.file("report.html");
  EXPECT_EQ(call({"report", result.c_str(), "-o", page.c_str()}).code, 0);
  EXPECT_GT(std::filesystem::file_size(page), 1000u);
  EXPECT_NE(call({"report", result.c_str()}).out.find("The fit misses 5.0"), std::string::npos);
  EXPECT_EQ(Json::parse(call({"--json", "report", result.c_str()}).out)["error_after"], 0.05);
  const std::string other = folder.write("other.json", "{}");
  EXPECT_EQ(call({"report", other.c_str()}).code, 2);
}

TEST(CaptureCommands, ImportValidateShowAndExportWithoutAServer) {
  const Folder folder;
  const std::string csv = TENTER_TEST_DATA "/knit/acrylic_rib_x.csv";
  const std::string describe = TENTER_TEST_DATA "/knit/acrylic_rib_x.json";
  const std::string file = folder.file("pull.h5");
  const Outcome imported = call({"--json", "capture", "import", csv.c_str(), "--describe",
                                 describe.c_str(), "-o", file.c_str()});
  ASSERT_EQ(imported.code, 0) << imported.out;
  const Json capture = Json::parse(imported.out);
  EXPECT_EQ(capture["id"].get<std::string>().size(), 64u);
  EXPECT_GT(capture["frames"], 100);

  EXPECT_EQ(
      Json::parse(call({"--json", "capture", "validate", file.c_str()}).out)["captures"][0]["id"],
      capture["id"]);
  EXPECT_EQ(Json::parse(call({"--json", "capture", "show", file.c_str()}).out)["title"],
            capture["title"]);
  EXPECT_NE(call({"capture", "show", file.c_str()}).out.find("channels"), std::string::npos);

  const std::string again_csv = folder.file("again.csv");
  EXPECT_EQ(call({"capture", "export", file.c_str(), "-o", again_csv.c_str()}).code, 0);
  EXPECT_EQ(call({"capture", "export", file.c_str(), "-o", again_csv.c_str()}).code, 4);
  const std::string again_json = folder.file("again.json");
  const std::string again = folder.file("again.h5");
  const Outcome back = call({"--json", "capture", "import", again_csv.c_str(), "--describe",
                             again_json.c_str(), "-o", again.c_str()});
  EXPECT_EQ(Json::parse(back.out)["id"], capture["id"]);

  // something else under the same name stays as it is
  folder.write("again.h5", "mine");
  EXPECT_EQ(
      call({"capture", "import", csv.c_str(), "--describe", describe.c_str(), "-o", again.c_str()})
          .code,
      4);
  EXPECT_EQ(std::filesystem::file_size(again), 4u);
  EXPECT_EQ(call({"capture", "import", csv.c_str(), "--describe", describe.c_str(), "-o",
                  again.c_str(), "--force"})
                .code,
            0);
  EXPECT_FALSE(std::filesystem::exists(folder.file("again.h5.importing")));
}

TEST(CaptureCommands, BadInputLeavesNothingBehind) {
  const Folder folder;
  const std::string csv = folder.write("bad.csv", "t,f\n0,1\n1,oops\n");
  const std::string describe = folder.write("bad.json", "{}");
  const std::string file = folder.file("bad.h5");
  const Outcome outcome =
      call({"capture", "import", csv.c_str(), "--describe", describe.c_str(), "-o", file.c_str()});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("bad.json"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(call({"capture", "import", "nowhere.csv", "--describe", "nowhere.json"}).code, 3);
  const std::string text = folder.write("text.h5", "not HDF5");
  EXPECT_EQ(call({"capture", "validate", text.c_str()}).code, 2);
  EXPECT_EQ(call({"capture", "show", text.c_str()}).code, 2);
}

TEST(ResidualsCommand, QueriesAKeptFileInThreeFormats) {
  const Folder folder;
  report::ResidualTable table;
  table.capture_id = std::string(64, 'a');
  table.capture_title = "pull, \"one\"";
  table.channel = "force";
  table.unit = "N/m";
  for (int i = 0; i < 6; ++i) {
    table.frame.push_back(10 + i);
    table.run.push_back(1);
    table.block.push_back(i / 3);
    table.branch.push_back(i / 3);
    table.strain_x.push_back(0.1 * i);
    table.strain_y.push_back(std::nan(""));
    table.strain_xy.push_back(0.0);
    table.measured.push_back(i == 4 ? std::nan("") : 2.0 * i);
    table.predicted_baseline.push_back(1.5 * i);
    table.predicted_extended.push_back(1.75 * i);
    table.sigma.push_back(0.1);
    table.weight.push_back(1.0);
  }
  const std::string file = folder.file("residuals.h5");
  ASSERT_TRUE(report::write_residuals({table}, file));

  const Outcome csv = call({"residuals", file.c_str(), "--format", "csv"});
  EXPECT_EQ(csv.code, 0) << csv.err;
  EXPECT_EQ(csv.out.substr(0, csv.out.find('\n')),
            "capture,title,channel,unit,run,block,branch,frame,time_s,strain_x,strain_y,strain_xy,"
            "measured,baseline,"
            "extended,residual_baseline,residual_extended,sigma,weight");
  EXPECT_NE(csv.out.find(
                ",\"pull, "
                "\"\"one\"\"\",\"force\",\"N/m\",1,0,load,11,,0.1,,0,2,1.5,1.75,0.5,0.25,0.1,1\n"),
            std::string::npos)
      << csv.out;

  const Json json =
      Json::parse(call({"residuals", file.c_str(), "--frames", "12:14", "--json"}).out);
  const Json rows = json["tables"][0]["rows"];
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0]["frame"], 12);
  EXPECT_TRUE(rows[2]["measured"].is_null());

  EXPECT_NE(call({"residuals", file.c_str(), "--block", "1"}).out.find("unload"),
            std::string::npos);
  EXPECT_EQ(call({"residuals", file.c_str(), "--channel", "torque"}).code, 3);
}

TEST(CommandLine, ModelsGoToOtherFormatsAndComeBack) {
  const Folder folder;
  const Outcome curves =
      call({"model", "export", "stvk_diagonal", "--to", "csv", "--samples", "3"});
  EXPECT_EQ(curves.code, 0) << curves.err;
  EXPECT_NE(curves.out.find("\nweft,green_u,1,N/m,N/m,0.25,25,"), std::string::npos) << curves.out;
  const std::string file = folder.file("denim.json");
  const Outcome out = call({"model", "export", "cloth_stvk", "--to", "arcsim", "--area-density",
                            "0.2", "-o", file.c_str()});
  EXPECT_EQ(out.code, 0) << out.err;
  const Outcome back = call({"model", "import", file.c_str(), "--from", "arcsim"});
  EXPECT_EQ(back.code, 0) << back.err;
  const auto model = model::parse_model(back.out, "back");
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->name, "denim");
  EXPECT_EQ(model->terms.size(), 6u);
  EXPECT_EQ(call({"model", "export", "cloth_stvk", "--to", "arcsim"}).code, 2);
  const Outcome refused =
      call({"model", "export", "springs", "--to", "arcsim", "--area-density", "1"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("term"), std::string::npos);
}

TEST(FitOptions, OfASheetNameCapturesAsTheUserDid) {
  SheetFitDraft draft;
  draft.roles = {"data/pull u=1.h5=stretch_u", "b.h5=shear", "cccccc=evaluation"};
  draft.weights = {"b.h5=2.5"};
  draft.held_out = {"cccccc"};
  draft.resolution = 9;
  draft.grid = "equal";
  draft.at_once = true;
  draft.without_grid_error = true;
  draft.hold_unseen = "2.5e-5";
  const std::vector<std::string> names = {"data/pull u=1.h5", "data/b.h5", "cccccccc"};
  const std::vector<std::string> ids = {std::string(64, 'a'), std::string(64, 'b'),
                                        std::string(64, 'c')};
  nlohmann::json options = nlohmann::json::object();
  ASSERT_TRUE(complete_options(draft, names, ids, options));
  EXPECT_EQ(
      options,
      (nlohmann::json{{"roles", {{ids[0], "stretch_u"}, {ids[1], "shear"}, {ids[2], "evaluation"}}},
                      {"weights", {{ids[1], 2.5}}},
                      {"held_out", {ids[2]}},
                      {"resolution", 9},
                      {"grid", "equal"},
                      {"staged", false},
                      {"without_grid_error", true},
                      {"hold_unseen", 2.5e-5}}));
  for (const auto& [role, words] :
       {std::pair{"d.h5=shear", "--role d.h5: is none of the captures given"},
        std::pair{"b.h5", "must be CAPTURE=VALUE"}, std::pair{"b.h5=", "must be CAPTURE=VALUE"}}) {
    draft.roles = {role};
    const auto refused = complete_options(draft, names, ids, options);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(words), std::string::npos) << refused.error().message;
  }
}

TEST(Residuals, VerticesOfASheetAsTableCsvAndJson) {
  const Folder folder;
  const std::string file = folder.file("residuals.h5");
  report::VertexResiduals block;
  block.capture_id = std::string(64, 'c');
  block.capture_title = "pull";
  block.frame = {3, 4};
  block.vertex = {7, 9};
  block.material_m = {0.01, 0.02, 0.03, 0.04};
  block.sigma_m = {1e-4, 1e-4};
  block.measured_m = {0, 0, 0, 1, 1, std::nan(""), 2, 2, 2, 3, 3, 3};
  block.start_m.assign(12, 0.5);
  block.fitted_m = {0, 0, 0.001, 1, 1, 1, 2, 2, 2, 3, 3, 3};
  ASSERT_TRUE(report::write_residuals({}, file, {block}));
  const Outcome csv =
      call({"residuals", file.c_str(), "--vertices", "--frames", "3", "--format", "csv"});
  EXPECT_EQ(csv.code, 0) << csv.err;
  EXPECT_NE(csv.out.find(",3,7,0.01,0.02,0,0,0,0.5,0.5,0.5,0,0,0.001,0.001,0.0001\n"),
            std::string::npos)
      << csv.out;
  EXPECT_NE(csv.out.find(",3,9,0.03,0.04,1,1,,0.5"), std::string::npos) << csv.out;
  EXPECT_EQ(csv.out.find(",4,"), std::string::npos);
  const Outcome table = call({"residuals", file.c_str(), "--vertex", "7:8"});
  EXPECT_NE(table.out.find("in sigmas"), std::string::npos);
  EXPECT_EQ(table.out.find(" 9 "), std::string::npos);
  const Json json = Json::parse(call({"--json", "residuals", file.c_str(), "--vertex", "9"}).out);
  ASSERT_EQ(json["vertices"][0]["rows"].size(), 2U);
  EXPECT_TRUE(json["vertices"][0]["rows"][0]["measured_z_m"].is_null());
  EXPECT_EQ(call({"residuals", file.c_str(), "--vertex", "8"}).code, 3);
  EXPECT_EQ(call({"residuals", file.c_str(), "--vertices", "--channel", "force"}).code, 2);
  EXPECT_NE(call({"residuals", file.c_str(), "--vertex", "9:8"}).err.find("vertex numbers A <= B"),
            std::string::npos);
}

}  // namespace
}  // namespace tenter::cli
