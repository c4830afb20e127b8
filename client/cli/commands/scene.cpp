// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/output.h"
#include "client/cli/scene_run.h"
#include "common/scene/document.h"
#include "common/scene/examples.h"

namespace tenter::cli {

namespace {

Expected<void> list_scenes(const Context& context) {
  Json scenes = Json::array();
  Table table({"scene", ">frames", "description"});
  for (const scene::ExampleText& text : scene::example_texts()) {
    const auto scene = scene::parse_scene(text.json, text.name);
    if (!scene) return tl::unexpected(scene.error());
    scenes.push_back({{"name", scene->name},
                      {"frames", scene->frame_count()},
                      {"description", scene->description}});
    table.add({scene->name, std::to_string(scene->frame_count()), scene->description});
  }
  if (context.json)
    print_json({{"scenes", scenes}});
  else
    print_text(table.text());
  return {};
}

Expected<void> validate_scenes(const Context& context, const std::vector<std::string>& files) {
  Json checked = Json::array();
  for (const std::string& file : files) {
    const auto loaded = load_scene(file);
    if (!loaded) return tl::unexpected(loaded.error());
    const scene::Scene& scene = loaded->scene;
    checked.push_back(
        {{"file", file}, {"name", scene.name}, {"frames", scene.frame_count()}, {"valid", true}});
    if (!context.json)
      print_text(file + ": valid, scene '" + scene.name + "' of " +
                 std::to_string(scene.frame_count()) + " frames\n");
  }
  if (context.json) print_json({{"scenes", checked}});
  return {};
}

}  // namespace

void add_scene(CLI::App& app, Context& context) {
  CLI::App* group = app.add_subcommand("scene", "list, show and check scenes (needs no server)");
  group->require_subcommand(1);

  CLI::App* list = group->add_subcommand("list", "list the shipped scenes");
  list->footer("EXAMPLES\n    tenter scene list\n");
  list->callback([&context] { context.command = [&context] { return list_scenes(context); }; });

  CLI::App* show = group->add_subcommand("show", "print the document of a shipped scene");
  show->footer(
      "Save it, change it, and give the file to `tenter simulate --scene`.\n"
      "EXAMPLES\n    tenter scene show hanging_square > mine.scene.json\n");
  auto name = std::make_shared<std::string>();
  show->add_option("SCENE", *name, "Name of a shipped scene.")->required();
  show->callback([&context, name] {
    context.command = [name]() -> Expected<void> {
      const auto text = scene::example_json(*name);
      if (!text) return tl::unexpected(text.error());
      print_text(*text);
      return {};
    };
  });

  CLI::App* validate = group->add_subcommand("validate", "check scene documents");
  validate->footer(
      "A bad document is named with the path of the bad key, and exit code 2. Whether the nodes "
      "that a scene names are there is known when its mesh is made, by the job.\n"
      "EXAMPLES\n    tenter scene validate mine.scene.json\n");
  auto files = std::make_shared<std::vector<std::string>>();
  validate->add_option("FILE", *files, "Scene files.")->required();
  validate->callback([&context, files] {
    context.command = [&context, files] { return validate_scenes(context, *files); };
  });
}

}  // namespace tenter::cli
