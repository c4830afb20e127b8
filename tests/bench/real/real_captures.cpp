// SPDX-License-Identifier: GPL-3.0-or-later
// The diagnosis on measured data that is not part of the project, run as jobs are: for each set of
// captures what it says, and at the end one table. Nothing passes or fails here.
//
//   tests/bench/import_shared.sh IMPORTER DATA_DIR OUT_DIR
//   tenter-bench-real OUT_DIR [PART OF A SET'S WORDS ...]
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/sha256.h"
#include "common/base/text_file.h"
#include "common/model/presets.h"
#include "server/jobs/results/run_job.h"

namespace {

namespace fs = std::filesystem;
using namespace tenter;
using nlohmann::json;

struct Set {
  const char* words;
  const char* folder;
  const char* beginning;  ///< of the file names
  const char* model;      ///< a preset, or a file in tests/bench
  bool are_sheets = false;
  const char* options = "{}";  ///< of the job
};

constexpr Set kSets[] = {
    {"warp knit, five biaxial paths", "warpknit-pp-biaxial", "mean_0_90", "stvk_orthotropic"},
    {"acrylic adhesive, stepped shear with holds", "oca-cyclic-shear-relaxation", "",
     "stvk_diagonal"},
    {"acrylic elastomer, cycles and relaxation", "vhb4910-rate-hysteresis", "", "stvk_orthotropic"},
    {"friction damper, nine sines", "friction-damper-hysteresis", "", "stvk_diagonal"},
    {"acrylic garter knit along the wales", "knit-uniaxial-tracked", "acrylic_garter_y",
     "stvk_diagonal"},
    {"cotton garter knit along the courses", "knit-uniaxial-tracked", "cotton_garter_x",
     "stvk_diagonal"},
    {"running-shoe foam, five specimens", "foam-cyclic-tension", "leap_tension", "stvk_diagonal"},
    {"porcine skin, three biaxial protocols", "skin-porcine-biaxial", "porcine",
     "stvk_orthotropic"},
    {"surgical mesh Prolene, five specimens", "surgical-mesh-biaxial", "prolene",
     "stvk_orthotropic"},
    {"surgical mesh Ventralight, five specimens", "surgical-mesh-biaxial", "ventralight",
     "stvk_orthotropic"},
    {"woven wool, weft, warp and shear", "woven-wool-weft-warp-shear", "", "stvk_orthotropic"},
    {"acrylic garter knit along the wales, as a sheet", "knit-uniaxial-tracked",
     "acrylic_garter_y_sheet", "cloth_stvk", true, R"({"resolution": 9, "frames": 40})"},
    {"human skin in vivo, a full field", "skin-invivo-dic", "healthy_dic", "real/skin.model.json",
     true},
};

constexpr std::size_t kMaxBytes = std::size_t{1} << 30;

std::vector<fs::path> files_of(const Set& set, const fs::path& root) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(root / set.folder, none)) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() == ".h5" && stem.starts_with(set.beginning) &&
        (set.are_sheets || !stem.ends_with("_sheet")))
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

Expected<json> diagnose(const Set& set, const std::vector<fs::path>& files) {
  const fs::path file = fs::path(TENTER_BENCH_FOLDER) / set.model;
  const auto model = fs::is_regular_file(file) ? read_text_file(file.string(), kMaxBytes)
                                               : model::preset_json(set.model);
  if (!model) return tl::unexpected(model.error());
  json ids = json::array();
  jobs::JobInput input;
  for (const fs::path& capture : files) {
    const auto bytes = read_text_file(capture.string(), kMaxBytes);
    if (!bytes) return tl::unexpected(bytes.error());
    input.captures.emplace_back(sha256_hex(*bytes), capture);
    ids.push_back(input.captures.back().first);
  }
  input.spec_json = json{{"schema", "tenter.job"},
                         {"version", 1},
                         {"kind", "diagnose"},
                         {"captures", ids},
                         {"options", json::parse(set.options)},
                         {"model", json::parse(*model)}}
                        .dump();
  input.staging = fs::temp_directory_path() / ("tenter-bench-real-" + std::to_string(getpid()));
  fs::create_directories(input.staging);
  const auto done = jobs::run_job(input, [](const jobs::JobProgress&) {}, {});
  const auto text = read_text_file((input.staging / "result.json").string(), kMaxBytes);
  fs::remove_all(input.staging);
  if (!done) return tl::unexpected(done.error());
  if (!text) return tl::unexpected(text.error());
  return json::parse(*text);
}

std::string figure(const json& value) {
  if (!value.is_number()) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", value.get<double>());
  return text;
}

std::string per_cent(const json& value) {
  if (!value.is_number()) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", 100.0 * value.get<double>());
  return text;
}

std::string verdicts_of(const json& result) {
  std::string cell;
  for (const json& v : result["verdicts"]) {
    const std::string word = v["verdict"];
    if (word == "NOT_EXCITED") continue;
    cell += (cell.empty() ? "" : "; ") + word;
    if (v["effect"].is_string()) cell += " " + v["effect"].get<std::string>();
    for (const json& other : v["alternatives"]) cell += " or " + other.get<std::string>();
    if (v["effect"].is_string()) cell += " " + per_cent(v["size"]);
  }
  return cell;
}

/// What was added and dropped, with the error that the fit then had.
std::string path_of(const json& result) {
  std::string cell;
  for (const json& step : result["path"]) {
    const std::string action = step["action"];
    if (action == "reject") continue;
    if (action == "add") cell += " + ";
    if (action == "drop") cell += " - ";
    if (step["effect"].is_string()) cell += step["effect"].get<std::string>() + " ";
    cell += figure(step["error"]);
  }
  return cell;
}

std::string row_of(const Set& set, const json& r) {
  std::string row = std::string("| ") + set.words + " | " + verdicts_of(r) + " | " + path_of(r);
  row += " | " + figure(r["error_before"]) + " to " + figure(r["error_after"]);
  row += " | " + figure(r["noise_floor"]) + " | ";
  row += r["held_out_kind"].is_string()
             ? r["held_out_kind"].get<std::string>() + ": " + figure(r["held_out_before"]) +
                   " to " + figure(r["held_out_after"]) + ", R2 " +
                   figure(r["held_out_r2_before"]) + " to " + figure(r["held_out_r2_after"])
             : "-";
  return row + " |";
}

std::string run(const Set& set, const fs::path& root) {
  const std::vector<fs::path> files = files_of(set, root);
  std::printf("\n%s (%zu captures, from %s)\n", set.words, files.size(), set.model);
  if (files.empty()) return std::string("| ") + set.words + " | no captures | | | | |";
  const auto start = std::chrono::steady_clock::now();
  const auto result = diagnose(set, files);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!result) {
    std::printf("  %s\n", result.error().message.c_str());
    return std::string("| ") + set.words + " | refused: " + result.error().message + " | | | | |";
  }
  for (const json& v : (*result)["verdicts"])
    if (v["verdict"] != "NOT_EXCITED") std::printf("  %s\n", v["words"].get<std::string>().c_str());
  for (const json& step : (*result)["path"])
    std::printf(
        "    %-6s %s: error %s; %s\n", step["action"].get<std::string>().c_str(),
        step["effect"].is_string() ? step["effect"].get<std::string>().c_str() : "the model",
        figure(step["error"]).c_str(), step["why"].get<std::string>().c_str());
  std::printf("  [%.1f s]\n", seconds);
  std::fflush(stdout);
  return row_of(set, *result);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: tenter-bench-real FOLDER_OF_IMPORTED_CAPTURES [PART ...]\n");
    return 2;
  }
  const std::vector<std::string> parts(argv + 2, argv + argc);
  std::vector<std::string> rows;
  for (const Set& set : kSets)
    if (parts.empty() || std::any_of(parts.begin(), parts.end(), [&](const std::string& part) {
          return std::string(set.words).find(part) != std::string::npos;
        }))
      rows.push_back(run(set, argv[1]));
  std::printf(
      "\n| data | verdicts | path, error | error | noise floor | left out |\n| --- | --- | --- | "
      "--- "
      "| --- | --- |\n");
  for (const std::string& row : rows) std::printf("%s\n", row.c_str());
  return 0;
}
