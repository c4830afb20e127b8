// SPDX-License-Identifier: GPL-3.0-or-later
// The shipped experiments as figures, without a server: every scene with an `experiment`, or those
// named, is run as the job would and drawn.
//
//   tenter-bench-figures FOLDER [SCENE or FILE.scene.json ...]
//
// FOLDER gets NAME.svg (figure) and NAME/result.json, NAME/frames.h5. Printed: the numbers of every
// run and CPU seconds; of strips that unroll, how far they are from one dimension.
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/text_file.h"
#include "common/model/presets.h"
#include "common/report/experiment/figure.h"
#include "common/scene/document.h"
#include "common/scene/examples.h"
#include "server/jobs/results/run_job.h"
#include "tests/bench/figures/spiral_check.h"

namespace {

namespace fs = std::filesystem;
using namespace tenter;
using nlohmann::json;

struct Experiment {
  std::string name, text;
  scene::Scene scene;
};

Expected<Experiment> load(const std::string& name_or_file) {
  auto text = scene::example_json(name_or_file);
  if (!text) text = read_text_file(name_or_file, scene::kMaxDocumentBytes);
  if (!text) return tl::unexpected(text.error());
  auto read = scene::parse_scene(*text, name_or_file);
  if (!read) return tl::unexpected(read.error());
  if (!read->experiment) return bad_input(name_or_file + ": the scene has no experiment");
  return Experiment{read->name, std::move(*text), std::move(*read)};
}

Expected<std::string> run(const Experiment& experiment, const fs::path& folder) {
  const std::string& named = experiment.scene.model;
  const auto model = model::preset_json(named.empty() ? "cloth_stvk" : named);
  if (!model) return tl::unexpected(model.error());
  const json spec = {{"schema", "tenter.job"},      {"version", 1},
                     {"kind", "simulate"},          {"captures", json::array()},
                     {"options", json::object()},   {"scene", json::parse(experiment.text)},
                     {"model", json::parse(*model)}};
  fs::create_directories(folder);
  const jobs::JobInput input{spec.dump(), {}, folder, {}};
  std::string last;
  const auto report = [&last](const jobs::JobProgress& progress) {
    const std::string run = progress.detail.substr(0, progress.detail.find(':'));
    if (run == last || progress.stage == "mesh") return;
    last = run;
    std::fprintf(stderr, "  %s\n", run.c_str());
  };
  if (auto done = jobs::run_job(input, report, {}); !done) return tl::unexpected(done.error());
  return read_text_file((folder / "result.json").string(), std::size_t{1} << 30);
}

bool draw(const std::string& name, const fs::path& folder) {
  const auto experiment = load(name);
  if (!experiment) {
    std::fprintf(stderr, "%s\n", experiment.error().message.c_str());
    return false;
  }
  std::fprintf(stderr, "%s\n", experiment->name.c_str());
  const std::clock_t start = std::clock();
  const auto result = run(*experiment, folder / experiment->name);
  if (!result) {
    std::fprintf(stderr, "%s: %s\n", experiment->name.c_str(), result.error().message.c_str());
    return false;
  }
  const double cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  const auto svg = report::experiment_svg(*result);
  const auto words = report::experiment_text(*result);
  if (!svg || !words) return false;
  std::ofstream(folder / (experiment->name + ".svg")) << *svg;
  std::printf("== %s, %.1f s of CPU\n%s\n", experiment->name.c_str(), cpu_s, words->c_str());
  const scene::Scene& scene = experiment->scene;
  const bool is_spiral = scene.start.place == scene::Start::Place::wound;
  const bool good = !is_spiral || bench::check_spirals(scene, experiment->text);
  std::fflush(stdout);
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: tenter-bench-figures FOLDER [SCENE ...]\n");
    return 2;
  }
  std::vector<std::string> names(argv + 2, argv + argc);
  if (names.empty())
    for (const scene::ExampleText& example : scene::example_texts())
      if (const auto scene = scene::parse_scene(example.json, example.name);
          scene && scene->experiment)
        names.emplace_back(example.name);
  bool good = true;
  for (const std::string& name : names) good = draw(name, argv[1]) && good;
  return good ? 0 : 1;
}
