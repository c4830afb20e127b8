// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/scene/run_scene.h"

#include <nlohmann/json.hpp>
#include <string>

#include "common/base/atomic_write.h"
#include "common/base/text_file.h"
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

}  // namespace

Expected<void> run_scene(const JobInput& input, const json& spec,
                         const std::function<void(const JobProgress&)>& report,
                         const std::stop_token& stop) {
  const std::string scene_json = spec.at("scene").dump();
  auto scene = scene::parse_scene(scene_json, "scene");
  if (!scene) return tl::unexpected(scene.error());
  if (auto taken = take_mesh(input, *scene); !taken)
    return fail(taken.error().kind, "scene: " + taken.error().message);
  const auto model = model::parse_model(spec.at("model").dump(), "model");
  if (!model) return tl::unexpected(model.error());
  if (spec.contains("options") && !spec["options"].empty())
    return bad_input("options." + spec["options"].begin().key() +
                     ": a simulated scene has no options");

  report({"mesh", "", 0, 0.0, 0.01});
  auto run = mechanics::SceneRun::make(*scene, *model);
  if (!run) return fail(run.error().kind, "scene: " + run.error().message);
  FrameCollector frames(*run, run->model());
  Expected<void> kept;
  mechanics::SceneHooks hooks;
  hooks.on_frame = [&](const mechanics::SceneFrame& frame) { kept = frames.add(frame); };
  hooks.go_on = [&](int frame, int iterations) {
    report({scene->dynamics ? "motion" : "equilibrium", words_of(*scene, frame), iterations, 0.0,
            0.02 + 0.96 * frame / scene->frame_count()});
    return kept && !stop.stop_requested();
  };
  const auto end = run->walk(hooks);
  if (!end) return fail(end.error().kind, "scene: " + end.error().message);
  if (!kept) return kept;
  if (end->how == SceneEnd::How::stopped)
    return fail(ErrorKind::cancelled, "the simulation was stopped");
  if (end->frames == 0) return fail(ErrorKind::job_failed, end->reason);

  report({"write", "", 0, 0.0, 0.98});
  frames::FrameSet set = frames.set();
  set.scene_json = scene_json;
  const std::string text = simulation_document(*scene, run->model(), set, *end).dump(1) + "\n";
  if (auto written =
          write_atomically((input.staging / "result.json").string(), text.data(), text.size());
      !written)
    return written;
  return frames::write_frames(set, (input.staging / "frames.h5").string());
}

}  // namespace tenter::jobs
