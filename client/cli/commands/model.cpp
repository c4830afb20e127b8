// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "common/base/atomic_write.h"
#include "common/model/catalogue.h"
#include "common/model/document.h"
#include "common/model/export/arcsim.h"
#include "common/model/export/curves.h"
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
                                        {"of", model::words_of(row.seen)},
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
  Table corrections({"sensor correction", "of", "parameters", "meaning"});
  for (const model::CorrectionRow& row : model::correction_catalogue())
    corrections.add({std::string(row.name), std::string(model::words_of(row.seen)),
                     parameter_words(row.parameters), std::string(row.words)});
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

struct Conversion {
  std::string source;
  std::string format;
  std::string output = "-";
  double area_density_kg_m2 = 0.0;
  int samples = 101;
};

/// The text to its place, what was lost to standard error.
Expected<void> deliver(const Context& context, const Conversion& wanted, const std::string& text,
                       const std::vector<std::string>& losses) {
  if (wanted.output != "-")
    if (auto written = write_atomically(wanted.output, text.data(), text.size()); !written)
      return written;
  if (context.json)
    print_json({{"format", wanted.format},
                {"output", wanted.output == "-" ? Json(nullptr) : Json(wanted.output)},
                {"losses", losses},
                {"text", wanted.output == "-" ? Json(text) : Json(nullptr)}});
  else if (wanted.output == "-")
    print_text(text);
  else
    print_text(wanted.format + " written to " + wanted.output + "\n");
  if (!context.json && !context.quiet)
    for (const std::string& loss : losses) std::fprintf(stderr, "lost: %s\n", loss.c_str());
  return {};
}

Expected<model::Exported> exported(const model::Model& model, const Conversion& wanted) {
  if (wanted.format == "csv") return model::write_curves_csv(model, wanted.samples);
  if (wanted.format == "json") return model::write_curves_json(model, wanted.samples);
  if (!(wanted.area_density_kg_m2 > 0.0))
    return bad_input(
        "a model says nothing of mass: --area-density is needed for arcsim, in kg/m^2");
  return model::write_arcsim(model, wanted.area_density_kg_m2);
}

Expected<void> export_model(const Context& context, const Conversion& wanted) {
  const Expected<model::Model> model = load_model(wanted.source);
  if (!model) return tl::unexpected(model.error());
  const Expected<model::Exported> file = exported(*model, wanted);
  if (!file) return tl::unexpected(file.error());
  return deliver(context, wanted, file->text, file->losses);
}

Expected<void> import_model(const Context& context, const Conversion& wanted) {
  const Expected<std::string> text = read_input(wanted.source, 64u << 20);
  if (!text) return tl::unexpected(text.error());
  if (wanted.format == "json") {
    const Expected<model::Model> model = model::read_curves_json(*text, wanted.source);
    if (!model) return tl::unexpected(model.error());
    return deliver(context, wanted, model::write_model(*model), {});
  }
  const std::string name = wanted.source == "-"
                               ? std::string("material")
                               : std::filesystem::path(wanted.source).stem().string();
  const auto read = model::read_arcsim(*text, wanted.source, name);
  if (!read) return tl::unexpected(read.error());
  return deliver(context, wanted, model::write_model(read->model), read->losses);
}

void add_model_export(CLI::App& group, Context& context) {
  CLI::App* command = group.add_subcommand("export", "write a model as other programs read it");
  command->footer(
      "csv: curves of stress and stiffness with their bands, one row a sample. json: the same with "
      "units, intervals and the whole model. arcsim: a material of the cloth simulator ARCSim; "
      "what "
      "it cannot take is refused, what it takes in part is said on standard error.\n"
      "EXAMPLES\n    tenter model export fabric.json --to csv -o curves.csv\n    tenter model "
      "export "
      "fabric.json --to arcsim --area-density 0.18 -o arcsim.json\n");
  auto wanted = std::make_shared<Conversion>();
  command->add_option("MODEL", wanted->source, "Name of a shipped model, or a model file.")
      ->required();
  command->add_option("--to", wanted->format, "arcsim, csv or json.")
      ->required()
      ->check(CLI::IsMember({"arcsim", "csv", "json"}));
  command->add_option("-o,--output", wanted->output, "Write here; - is standard output.")
      ->type_name("FILE");
  command->add_option("--area-density", wanted->area_density_kg_m2, "kg/m^2, for arcsim.")
      ->check(CLI::PositiveNumber);
  command->add_option("--samples", wanted->samples, "Strains in each curve (csv, json).")
      ->check(CLI::Range(2, 100000));
  command->callback([&context, wanted] {
    context.command = [&context, wanted] { return export_model(context, *wanted); };
  });
}

void add_model_import(CLI::App& group, Context& context) {
  CLI::App* command = group.add_subcommand("import", "make a model document of another format");
  command->footer(
      "The document goes to standard output, what the model cannot say to standard error.\n"
      "EXAMPLES\n    tenter model import denim.json --from arcsim -o denim.model.json\n");
  auto wanted = std::make_shared<Conversion>();
  command->add_option("FILE", wanted->source, "The file; - is standard input.")->required();
  command->add_option("--from", wanted->format, "arcsim, or json (what export --to json wrote).")
      ->required()
      ->check(CLI::IsMember({"arcsim", "json"}));
  command->add_option("-o,--output", wanted->output, "Write here; - is standard output.")
      ->type_name("FILE");
  command->callback([&context, wanted] {
    context.command = [&context, wanted] { return import_model(context, *wanted); };
  });
}

}  // namespace

void add_model(CLI::App& app, Context& context) {
  CLI::App* group =
      app.add_subcommand("model", "list, show, check and convert models (needs no server)");
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

  add_model_export(*group, context);
  add_model_import(*group, context);
}

}  // namespace tenter::cli
