// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/scene/run_scene.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/base/atomic_write.h"
#include "common/base/text_file.h"
#include "common/experiment/experiment_json.h"
#include "common/frames/frames_file.h"
#include "common/model/document.h"
#include "common/scene/document.h"
#include "server/jobs/scene/frame_collector.h"
#include "server/jobs/scene/simulation_document.h"

namespace tenter::jobs {
namespace {

using mechanics::SceneEnd;
using nlohmann::json;

/// The bytes of the mesh file that the scene names, which came as the job's only capture.
Expected<void> take_mesh(const JobInput& input, scene::Scene& scene) {
  auto* file = std::get_if<scene::FileMesh>(&scene.mesh);
  if (file == nullptr) return {};
  for (const auto& [sha256, path] : input.captures) {
    if (sha256 != file->sha256) continue;
    auto bytes = read_text_file(path.string(), scene::kMaxMeshBytes);
    if (!bytes) return tl::unexpected(bytes.error());
    file->bytes = std::move(*bytes);
    return {};
  }
  return bad_input("mesh: the job has no file " + file->sha256.substr(0, 12));
}

/// "closer, frame 3 of 15"
std::string words_of(const scene::Scene& scene, int frame) {
  const int last = scene.frame_count() - 1;
  if (frame == 0) return "start";
  int before = 0;
  for (const scene::Phase& phase : scene.protocol) {
    before += phase.frames;
    if (frame <= before)
      return phase.name + ", frame " + std::to_string(frame) + " of " + std::to_string(last);
  }
  return "";
}

/// A run of the scene, walked.
struct WalkedRun {
  model::Model model;  ///< as it was run
  frames::FrameSet frames;
  SceneEnd end;
};

model::Model without(model::Model model, const std::vector<std::string>& laws) {
  std::erase_if(model.terms, [&laws](const model::Term& term) {
    return std::find(laws.begin(), laws.end(), term.law.name) != laws.end();
  });
  return model;
}

using Report = std::function<void(const JobProgress&)>;

Expected<WalkedRun> walk_run(const JobInput& input, scene::Run run, const model::Model& given,
                             const Report& report, const std::stop_token& stop) {
  if (auto taken = take_mesh(input, run.scene); !taken) return tl::unexpected(taken.error());
  const model::Model model = without(given, run.without_laws);
  if (auto sound = model::validate(model); !sound) return tl::unexpected(sound.error());
  const std::string of_run = run.name.empty() ? "" : run.name + ": ";
  report({"mesh", of_run, 0, 0.0, 0.01});
  auto walk = mechanics::SceneRun::make(run.scene, model);
  if (!walk) return tl::unexpected(walk.error());
  FrameCollector frames(*walk, walk->model());
  Expected<void> kept;
  mechanics::SceneHooks hooks;
  hooks.on_frame = [&](const mechanics::SceneFrame& frame) { kept = frames.add(frame); };
  hooks.go_on = [&](int frame, int iterations) {
    report({run.scene.dynamics ? "motion" : "equilibrium", of_run + words_of(run.scene, frame),
            iterations, 0.0, 0.02 + 0.96 * frame / run.scene.frame_count()});
    return kept && !stop.stop_requested();
  };
  auto end = walk->walk(hooks);
  if (!end) return tl::unexpected(end.error());
  if (!kept) return tl::unexpected(kept.error());
  if (end->how == SceneEnd::How::stopped)
    return fail(ErrorKind::cancelled, "the simulation was stopped");
  return WalkedRun{walk->model(), frames.set(), std::move(*end)};
}

/// Every run, one after the other.
Expected<std::vector<WalkedRun>> walk_all(const JobInput& input,
                                          const std::vector<scene::Run>& runs,
                                          const model::Model& model, const Report& report,
                                          const std::stop_token& stop) {
  std::vector<WalkedRun> walked;
  for (const scene::Run& run : runs) {
    const auto share = [&](const JobProgress& progress) {
      JobProgress all = progress;
      all.fraction = 0.98 * (static_cast<double>(walked.size()) + progress.fraction) /
                     static_cast<double>(runs.size());
      report(all);
    };
    auto one = walk_run(input, run, model, share, stop);
    if (!one) {
      if (one.error().kind == ErrorKind::cancelled) return tl::unexpected(one.error());
      const std::string of_run = walked.empty() ? "" : "run '" + run.name + "': ";
      return fail(one.error().kind, "scene: " + of_run + one.error().message);
    }
    walked.push_back(std::move(*one));
    if (walked.front().end.frames == 0)
      return fail(ErrorKind::job_failed, walked.front().end.reason);
  }
  return walked;
}

Expected<json> found_by(const scene::Experiment& experiment, const std::vector<scene::Run>& runs,
                        const std::vector<WalkedRun>& walked) {
  std::vector<experiment::FoundRun> found;
  for (std::size_t i = 0; i < runs.size(); ++i)
    found.push_back({runs[i].name, &walked[i].frames, walked[i].end.reason});
  auto document = experiment::experiment_json(experiment, found);
  if (!document) return fail(document.error().kind, "scene: " + document.error().message);
  return document;
}

}  // namespace

Expected<void> run_scene(const JobInput& input, const json& spec, const Report& report,
                         const std::stop_token& stop) {
  const std::string scene_json = spec.at("scene").dump();
  const auto scene = scene::parse_scene(scene_json, "scene");
  if (!scene) return tl::unexpected(scene.error());
  const auto runs = scene::runs_of(scene_json, "scene");
  if (!runs) return tl::unexpected(runs.error());
  const auto model = model::parse_model(spec.at("model").dump(), "model");
  if (!model) return tl::unexpected(model.error());
  if (spec.contains("options") && !spec["options"].empty())
    return bad_input("options." + spec["options"].begin().key() +
                     ": a simulated scene has no options");
  auto walked = walk_all(input, *runs, *model, report, stop);
  if (!walked) return tl::unexpected(walked.error());

  report({"write", "", 0, 0.0, 0.98});
  WalkedRun& first = walked->front();
  json document = simulation_document(*scene, first.model, first.frames, first.end);
  if (scene->experiment) {
    auto found = found_by(*scene->experiment, *runs, *walked);
    if (!found) return tl::unexpected(found.error());
    document["experiment"] = std::move(*found);
  }
  const std::string text = document.dump(1) + "\n";
  if (auto written =
          write_atomically((input.staging / "result.json").string(), text.data(), text.size());
      !written)
    return written;
  first.frames.scene_json = scene_json;
  return frames::write_frames(first.frames, (input.staging / "frames.h5").string());
}

}  // namespace tenter::jobs
