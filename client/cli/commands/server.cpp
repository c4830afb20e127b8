// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/output.h"
#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

Json member(const Json& object, const char* key) {
  return object.is_object() ? object.value(key, Json::object()) : Json::object();
}

double number(const Json& object, const char* key) {
  const Json value = object.is_object() ? object.value(key, Json()) : Json();
  return value.is_number() ? value.get<double>() : 0.0;
}

std::string status_text(const Json& status) {
  Table table({"", ""});
  const auto row = [&](const char* name, const std::string& value) { table.add({name, value}); };
  const Json server = member(status, "server");
  const Json store = member(status, "store");
  const Json workers = member(status, "workers");
  const std::string name = cell(server, "name");
  row("server", "tenterd " + cell(server, "software") +
                    (name.empty() || name == "-" ? "" : " '" + name + "'") + ", DDS domain " +
                    cell(server, "domain") + ", up for " +
                    seconds_words(number(server, "uptime_s")));
  row("store", cell(store, "path") + ", " + cell(store, "captures") + " captures of " +
                   bytes_words(number(store, "capture_bytes")) + ", " +
                   bytes_words(number(store, "disk_free_bytes")) + " free");
  std::string jobs;
  for (const char* state : {"queued", "running", "succeeded", "failed", "cancelled"})
    jobs += (jobs.empty() ? "" : ", ") + cell(member(status, "jobs"), state) + " " + state;
  row("jobs", jobs);
  row("workers", cell(workers, "busy") + " of " + cell(workers, "slots") + " busy");
  std::string clients;
  for (const Json& client : status.value("clients", Json::array())) {
    const std::string name_of_client = client.value("name", "");
    const std::string who =
        cell(client, "user") + (name_of_client.empty() ? "" : " (" + name_of_client + ")");
    if (clients.find(who) == std::string::npos) clients += (clients.empty() ? "" : ", ") + who;
  }
  row("clients", clients.empty() ? "none" : clients);
  const std::string text = table.text();
  return text.substr(text.find('\n') + 1);  // without the empty head
}

Expected<void> show_status(Context& context) {
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  const Expected<std::string> reply = client->server_status();
  if (!reply) return tl::unexpected(reply.error());
  const Expected<Json> status = parse_reply(*reply);
  if (!status) return tl::unexpected(status.error());
  if (context.json)
    print_json(*status);
  else
    print_text(status_text(*status));
  return {};
}

}  // namespace

void add_server(CLI::App& app, Context& context) {
  CLI::App* group = app.add_subcommand("server", "ask about the server");
  group->require_subcommand(1);
  CLI::App* status =
      group->add_subcommand("status", "show the server's version, load, jobs and clients");
  status->footer("EXAMPLES\n    tenter server status\n    tenter --json server status\n");
  status->callback([&context] { context.command = [&context] { return show_status(context); }; });
}

}  // namespace tenter::cli
