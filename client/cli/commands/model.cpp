// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "common/model/catalogue.h"
#include "common/model/document.h"
#include "common/model/presets.h"

namespace tenter::cli {

namespace {

Json parameters_json(const std::vector<model::ParameterRow>& rows) {
  Json list = Json::array();
  for (const model::ParameterRow& row : rows)
    list.push_back({{"name", row.name},
                    {"unit", row.unit},
                    {"min", row.lower ? Json(*row.lower) : Json(nullptr)},
                    {"max", row.upper ? Json(*row.upper) : Json(nullptr)},
                    {"value", row.value}});
  return list;
}

Json catalogue_json() {
  Json catalogue = {
      {"strains", Json::array()}, {"laws", Json::array()}, {"corrections", Json::array()}};
  for (const model::StrainRow& row : model::strain_catalogue())
    catalogue["strains"].push_back({{"name", row.name},
                                    {"strains", row.strains},
                                    {"has_angle", row.has_angle},
                                    {"domain", model::words_of(row.domain)},
                                    {"words", row.words}});
  for (const model::LawRow& row : model::law_catalogue())
    catalogue["laws"].push_back({{"name", row.name},
                                 {"strains", row.strains},
                                 {"spline", row.spline},
                                 {"path_dependent", row.path_dependent},
                                 {"rate_dependent", row.rate_dependent},
                                 {"parameters", parameters_json(row.parameters)},
                                 {"words", row.words}});
  for (const model::CorrectionRow& row : model::correction_catalogue())
    catalogue["corrections"].push_back({{"name", row.name},
                                        {"parameters", parameters_json(row.parameters)},
                                        {"words", row.words}});
  return catalogue;
}

std::string parameter_words(const std::vector<model::ParameterRow>& rows) {
  std::string text;
  for (const model::ParameterRow& row : rows) {
    text += (text.empty() ? "" : ", ") + std::string(row.name);
    if (row.unit != "1") text += " [" + std::string(row.unit) + "]";
  }
  return text;
}

std::string spline_words(const model::LawRow& row) {
  const std::string name(row.parameters.front().name);
  return name + "1, " + name + "2, ... [" + std::string(row.parameters.front().unit) + "]";
}

std::string catalogue_text() {
  std::string out;
  Table strains({"strain measure", "strains", "lives on", "meaning"});
  for (const model::StrainRow& row : model::strain_catalogue())
    strains.add({std::string(row.name), std::to_string(row.strains),
                 std::string(model::words_of(row.domain)), std::string(row.words)});
  Table laws({"law", "parameters", "meaning"});
  for (const model::LawRow& row : model::law_catalogue())
    laws.add({std::string(row.name),
              row.spline ? spline_words(row) : parameter_words(row.parameters),
              std::string(row.words)});
  Table corrections({"sensor correction", "parameters", "meaning"});
  for (const model::CorrectionRow& row : model::correction_catalogue())
    corrections.add(
        {std::string(row.name), parameter_words(row.parameters), std::string(row.words)});
  return strains.text() + "\n" + laws.text() + "\n" + corrections.text();
}

Expected<void> list_models(const Context& context, bool catalogue) {
  if (catalogue) {
    if (context.json)
      print_json(catalogue_json());
    else
      print_text(catalogue_text());
    return {};
  }
  Json models = Json::array();
  Table table({"model", ">terms", ">parameters", "description"});
  for (const std::string& name : model::preset_names()) {
    const Expected<model::Model> preset = model::preset(name);
    if (!preset) return tl::unexpected(preset.error());
    std::size_t parameters = 0;
    for (const model::Term& term : preset->terms) parameters += term.law.parameters.size();
    models.push_back({{"name", name},
                      {"terms", preset->terms.size()},
                      {"parameters", parameters},
                      {"description", preset->description}});
    table.add({name, std::to_string(preset->terms.size()), std::to_string(parameters),
               preset->description});
  }
  if (context.json)
    print_json({{"models", models}});
  else
    print_text(table.text());
  return {};
}

/// The document itself: what is shown can be saved, changed and used.
Expected<void> show_model(const std::string& name) {
  const Expected<model::Model> model = load_model(name);
  if (!model) return tl::unexpected(model.error());
  print_text(model::write_model(*model));
  return {};
}

Expected<void> validate_models(const Context& context, const std::vector<std::string>& files) {
  Json checked = Json::array();
  for (const std::string& file : files) {
    const Expected<model::Model> model = load_model(file);
    if (!model) return tl::unexpected(model.error());
    checked.push_back(
        {{"file", file}, {"name", model->name}, {"terms", model->terms.size()}, {"valid", true}});
    if (!context.json)
      print_text(file + ": valid, model '" + model->name + "' of " +
                 std::to_string(model->terms.size()) + " terms\n");
  }
  if (context.json) print_json({{"models", checked}});
  return {};
}

}  // namespace

void add_model(CLI::App& app, Context& context) {
  CLI::App* group = app.add_subcommand("model", "list, show and check models (needs no server)");
  group->require_subcommand(1);

  CLI::App* list =
      group->add_subcommand("list", "list the shipped models, or what models are made of");
  list->footer("EXAMPLES\n    tenter model list\n    tenter model list --catalogue\n");
  auto catalogue = std::make_shared<bool>(false);
  list->add_flag("--catalogue", *catalogue,
                 "The strain measures, laws and sensor corrections of which models are made.");
  list->callback([&context, catalogue] {
    context.command = [&context, catalogue] { return list_models(context, *catalogue); };
  });

  CLI::App* show = group->add_subcommand("show", "print a model document");
  show->footer(
      "Prints the whole document with every bound, as JSON. Save it, change it, and give the file "
      "to --model.\n"
      "EXAMPLES\n    tenter model show stvk_orthotropic > fabric.json\n");
  auto name = std::make_shared<std::string>();
  show->add_option("MODEL", *name, "Name of a shipped model, or a model file.")->required();
  show->callback([&context, name] { context.command = [name] { return show_model(*name); }; });

  CLI::App* validate = group->add_subcommand("validate", "check model documents");
  validate->footer(
      "A bad document is named with the path of the bad key, and exit code 2.\n"
      "EXAMPLES\n    tenter model validate fabric.json\n");
  auto files = std::make_shared<std::vector<std::string>>();
  validate->add_option("FILE", *files, "Model files; - is standard input.")->required();
  validate->callback([&context, files] {
    context.command = [&context, files] { return validate_models(context, *files); };
  });
}

}  // namespace tenter::cli
