// SPDX-License-Identifier: Apache-2.0
// capture submit, list: captures on the server.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "client/cli/commands/capture.h"
#include "client/cli/context.h"
#include "client/cli/interrupt.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "client/cli/progress.h"

namespace tenter::cli {

namespace {

Expected<void> submit_captures(Context& context, const std::vector<std::string>& files) {
  Interrupt interrupt;
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  ProgressDisplay display(std::cerr, isatty(STDERR_FILENO) == 1, terminal_width(STDERR_FILENO));
  Json sent = Json::array();
  for (const std::string& file : files) {
    const std::string what = "sending " + std::filesystem::path(file).filename().string();
    const auto progress = [&](const client::TransferProgress& p) {
      if (!context.quiet) display.show_transfer(what, p);
    };
    const Expected<client::UploadResult> upload =
        client->upload_capture(file, progress, interrupt.token());
    display.finish();
    if (!upload) {
      if (interrupt.interrupted())
        return fail(ErrorKind::cancelled, "stopped while sending " + file +
                                              "; the same command goes on where it stopped");
      return tl::unexpected(about_file(file, upload.error()));
    }
    Json entry = {{"file", file},
                  {"id", upload->sha256},
                  {"already_stored", upload->already_stored},
                  {"bytes", upload->bytes_total},
                  {"bytes_resumed", upload->bytes_resumed}};
    const Json summary = Json::parse(upload->summary_json, nullptr, false);
    if (!summary.is_discarded()) entry["summary"] = summary;
    sent.push_back(std::move(entry));
    if (!context.json)
      print_text(upload->sha256 + "  " + file + (upload->already_stored ? "  (was there)" : "") +
                 "\n");
  }
  if (context.json) print_json({{"captures", sent}});
  return {};
}

Expected<void> list_captures(Context& context, int limit, const std::string& cursor) {
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  const Expected<std::string> reply = client->list_captures(limit, cursor);
  if (!reply) return tl::unexpected(reply.error());
  const Expected<Json> page = parse_reply(*reply);
  if (!page) return tl::unexpected(page.error());
  if (context.json) {
    print_json(*page);
    return {};
  }
  Table table({"capture", "kind", ">frames", ">size", "user", "stored", "title"});
  for (const Json& capture : page->value("captures", Json::array())) {
    const Json summary = capture.value("summary", Json::object());
    const bool synthetic =
        summary.is_object() && summary.contains("synthetic") && summary["synthetic"] == true;
    const double bytes = capture.contains("bytes") && capture["bytes"].is_number()
                             ? capture["bytes"].get<double>()
                             : 0.0;
    table.add({cell(capture, "id").substr(0, 12), cell(capture, "kind"),
               cell(capture.contains("frames") ? capture : summary, "frames"), bytes_words(bytes),
               cell(capture, "user"), clock_words(capture, "created_ms"),
               cell(capture, "title") + (synthetic ? " [SYNTHETIC]" : "")});
  }
  print_text(table.text());
  const Json next = page->value("next", Json());
  if (next.is_string() && !next.get<std::string>().empty())
    print_text("more: tenter capture list --cursor " + next.get<std::string>() + "\n");
  return {};
}

}  // namespace

void add_capture_server(CLI::App& group, Context& context) {
  CLI::App* submit = group.add_subcommand("submit", "send captures to the server");
  submit->footer(
      "What the server has is not sent again, and an interrupted transfer goes on where it "
      "stopped. Prints the SHA-256 "
      "that names each capture.\n"
      "EXAMPLES\n    tenter capture submit pull.h5\n    tenter --json capture submit *.h5 | jq -r "
      "'.captures[].id'\n");
  auto files = std::make_shared<std::vector<std::string>>();
  submit->add_option("FILE", *files, "Capture files (.h5).")->required()->check(CLI::ExistingFile);
  submit->callback([&context, files] {
    context.command = [&context, files] { return submit_captures(context, *files); };
  });

  CLI::App* list = group.add_subcommand("list", "list the captures on the server");
  list->footer("EXAMPLES\n    tenter capture list --limit 20\n");
  auto limit = std::make_shared<int>(100);
  auto cursor = std::make_shared<std::string>();
  list->add_option("--limit", *limit, "How many at most, 1 to 1000. Default: 100.")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  list->add_option("--cursor", *cursor, "Where the page before ended.")->type_name("CURSOR");
  list->callback([&context, limit, cursor] {
    context.command = [&context, limit, cursor] { return list_captures(context, *limit, *cursor); };
  });
}

}  // namespace tenter::cli
