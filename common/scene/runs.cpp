// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "common/scene/document.h"
#include "common/scene/experiment_read.h"

namespace tenter::scene {

Expected<std::vector<Run>> add_variants(std::string_view json_text, std::string_view source_name,
                                        const Experiment& experiment) {
  std::vector<Run> runs;
  for (std::size_t i = 0; i < experiment.variants.size(); ++i) {
    const Variant& variant = experiment.variants[i];
    auto document = JsonNode::Json::parse(json_text);
    document.erase("experiment");
    if (!variant.patch.empty()) document.merge_patch(JsonNode::Json::parse(variant.patch));
    auto scene = parse_scene(document.dump(), std::string(source_name) + ": experiment.variants[" +
                                                  std::to_string(i) + "].scene");
    if (!scene) return tl::unexpected(scene.error());
    for (Phase& phase : scene->protocol)
      if (phase.duration_s) *phase.duration_s /= variant.pace;
    runs.push_back({variant.name, std::move(*scene), variant.without_laws});
  }
  return runs;
}

Expected<std::vector<Run>> runs_of(std::string_view json_text, std::string_view source_name) {
  auto scene = parse_scene(json_text, source_name);
  if (!scene) return tl::unexpected(scene.error());
  if (!scene->experiment) return std::vector<Run>{{"", std::move(*scene), {}}};
  const Experiment experiment = *scene->experiment;
  auto variants = add_variants(json_text, source_name, experiment);
  if (!variants) return variants;
  scene->experiment.reset();
  variants->insert(variants->begin(), Run{experiment.run, std::move(*scene), {}});
  return variants;
}

}  // namespace tenter::scene
