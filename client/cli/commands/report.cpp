// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/follow.h"
#include "client/cli/job_run.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "common/base/atomic_write.h"
#include "common/base/text_file.h"
#include "common/report/html_report.h"
#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

struct Source {
  std::string text;
  std::string job_id;  ///< "" where it came from a file
};

Expected<Source> result_of(Context& context, const std::string& name) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(name, ignored)) {
    const Expected<std::string> text = read_text_file(name, 512u << 20);
    if (!text) return tl::unexpected(text.error());
    return Source{*text, ""};
  }
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  const Expected<std::string> job = resolve_job(*client, name);
  if (!job) return tl::unexpected(job.error());
  context.details["job_id"] = *job;
  const Expected<std::string> text = fetch_result_text(*client, *job);
  if (!text) return tl::unexpected(text.error());
  return Source{*text, *job};
}

Expected<void> make_report(Context& context, const std::string& name, const std::string& output) {
  const Expected<Source> source = result_of(context, name);
  if (!source) return tl::unexpected(source.error());
  if (!output.empty()) {
    const Expected<std::string> page = report::render_html(source->text);
    if (!page) return tl::unexpected(page.error());
    if (output == "-") {
      print_text(*page);
      return {};
    }
    if (auto written = write_atomically(output, page->data(), page->size()); !written)
      return written;
    if (context.json)
      print_json({{"job_id", source->job_id}, {"report", output}, {"bytes", page->size()}});
    else
      print_text("report written to " + output + "\n");
    return {};
  }
  if (context.json) {
    const Expected<Json> result = parse_reply(source->text);
    if (!result) return tl::unexpected(result.error());
    print_json(result_digest(*result, source->job_id));
    return {};
  }
  const Expected<std::string> text =
      report::render_text(source->text, {terminal_width(STDOUT_FILENO), context.colour_output()});
  if (!text) return tl::unexpected(text.error());
  print_text(*text);
  return {};
}

}  // namespace

void add_report(CLI::App& app, Context& context) {
  CLI::App* command =
      app.add_subcommand("report", "show what a job found, as text or as one HTML page");
  command->footer(
      "The page needs no network. Without --output the verdicts are printed.\n"
      "EXAMPLES\n    tenter report last\n    tenter report 17 -o report.html\n    tenter report "
      "result.json -o report.html\n");
  auto name = std::make_shared<std::string>();
  auto output = std::make_shared<std::string>();
  command
      ->add_option("JOB", *name,
                   "Number of the job, `last` for your newest, or a result document that was kept "
                   "(--output of diagnose).")
      ->required();
  command->add_option("-o,--output", *output, "Write the HTML page here; - is standard output.")
      ->type_name("FILE");
  command->callback([&context, name, output] {
    context.command = [&context, name, output] { return make_report(context, *name, *output); };
  });
}

}  // namespace tenter::cli
