// SPDX-License-Identifier: Apache-2.0
#include "common/effects/effects.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/output.h"

namespace tenter::cli {

namespace {

Json effect_json(const effects::Row& row) {
  Json phases = Json::array();
  for (const effects::Phase& phase : row.protocol.phases)
    phases.push_back({{"kind", phase.kind}, {"words", phase.words}});
  return {{"id", row.id},
          {"kind", effects::kind_name(row.kind)},
          {"words", row.words},
          {"signature", row.signature},
          {"extension", row.extension},
          {"mistaken_for", row.mistaken_for},
          {"protocol",
           {{"name", row.protocol.name}, {"words", row.protocol.words}, {"phases", phases}}}};
}

Expected<void> list_effects(const Context& context) {
  Json list = Json::array();
  Table table({"effect", "kind", "what it is"});
  for (const effects::Row& row : effects::catalogue()) {
    list.push_back(effect_json(row));
    table.add({row.id, std::string(effects::kind_name(row.kind)), row.words});
  }
  if (context.json)
    print_json({{"effects", list}});
  else
    print_text(table.text());
  return {};
}

std::string effect_text(const effects::Row& row) {
  std::string neighbours;
  for (const std::string& id : row.mistaken_for)
    neighbours += (neighbours.empty() ? "" : ", ") + id;
  std::string text = row.id + " (" + std::string(effects::kind_name(row.kind)) + ")\n\n";
  text += "what it is     " + row.words + "\n";
  text += "signature      " + row.signature + "\n";
  text += "extension      " + row.extension + "\n";
  text += "mistaken for   " + neighbours + "\n";
  text += "protocol       " + row.protocol.name + ": " + row.protocol.words + "\n";
  for (const effects::Phase& phase : row.protocol.phases)
    text += "               - " + phase.kind + ": " + phase.words + "\n";
  return text;
}

Expected<void> show_effect(const Context& context, const std::string& id) {
  const effects::Row* row = effects::find(id);
  if (row == nullptr)
    return fail(ErrorKind::not_found,
                "there is no effect '" + id + "'; `tenter effects list` names them all");
  if (context.json)
    print_json(effect_json(*row));
  else
    print_text(effect_text(*row));
  return {};
}

}  // namespace

void add_effects(CLI::App& app, Context& context) {
  CLI::App* group = app.add_subcommand(
      "effects", "the causes of misfit that a diagnosis knows (needs no server)");
  group->require_subcommand(1);

  CLI::App* list = group->add_subcommand("list", "list every effect of the catalogue");
  list->footer("EXAMPLES\n    tenter effects list\n");
  list->callback([&context] { context.command = [&context] { return list_effects(context); }; });

  CLI::App* show = group->add_subcommand(
      "show", "what an effect looks like, what expresses it, and the protocol that shows it");
  show->footer(
      "With --json: id, kind, words, signature, extension, mistaken_for, protocol.\n"
      "EXAMPLES\n    tenter effects show viscosity\n");
  auto id = std::make_shared<std::string>();
  show->add_option("EFFECT", *id, "Id of an effect.")->required();
  show->callback(
      [&context, id] { context.command = [&context, id] { return show_effect(context, *id); }; });
}

}  // namespace tenter::cli
