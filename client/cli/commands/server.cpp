// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/output.h"
#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

std::string status_text(const Json& status) {
  Table table({"", ""});
  const auto row = [&](const char* name, const std::string& value) { table.add({name, value}); };
  row("server", cell(status, "server"));
  row("version", cell(status, "version"));
  if (status.contains("uptime_s") && status["uptime_s"].is_number())
    row("up for", seconds_words(status["uptime_s"].get<double>()));
  row("store", cell(status, "store"));
  if (status.contains("jobs") && status["jobs"].is_object()) {
    std::string jobs;
    for (const auto& [state, count] : status["jobs"].items())
      jobs += (jobs.empty() ? "" : ", ") + count.dump() + " " + state;
    row("jobs", jobs);
  }
  row("workers", cell(status, "workers"));
  row("captures", cell(status, "captures"));
  if (status.contains("clients") && status["clients"].is_array()) {
    std::string clients;
    for (const Json& client : status["clients"])
      clients += (clients.empty() ? "" : ", ") +
                 (client.is_object() ? cell(client, "user") : std::string("?"));
    row("clients", clients.empty() ? "none" : clients);
  }
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
