// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <sstream>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/follow.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "client/cli/submit.h"
#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

/// Connects, finds the job, asks, and hands the reply to `show`.
template <class Ask, class Show>
Expected<void> with_job(Context& context, const std::string& name, Ask ask, Show show) {
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  const Expected<std::string> job = resolve_job(*client, name);
  if (!job) return tl::unexpected(job.error());
  context.details["job_id"] = *job;
  const Expected<std::string> reply = ask(*client, *job);
  if (!reply) return tl::unexpected(reply.error());
  const Expected<Json> value = parse_reply(*reply);
  if (!value) return tl::unexpected(value.error());
  if (context.json)
    print_json(*value);
  else
    show(*value);
  return {};
}

/// How long a job has waited, run, or ran.
std::string job_time(const Json& job) {
  const auto at = [&job](const char* key) {
    return job.contains(key) && job[key].is_number() ? job[key].get<double>() / 1000.0 : 0.0;
  };
  const double started = at("started_ms");
  const double ended = at("ended_ms");
  if (started <= 0.0) return "";
  if (ended > 0.0) return seconds_words(ended - started);
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  return seconds_words(now - started);
}

std::string job_table(const Json& jobs) {
  Table table(
      {">job", "state", "kind", "user", ">priority", ">captures", "submitted", ">time", "message"});
  for (const Json& job : jobs) {
    const Json captures = job.value("captures", Json());
    table.add({cell(job, "id"), cell(job, "state"), cell(job, "kind"), cell(job, "user"),
               cell(job, "priority"), captures.is_array() ? std::to_string(captures.size()) : "-",
               clock_words(job, "created_ms"), job_time(job), cell(job, "message")});
  }
  return table.text();
}

Expected<void> list_jobs(Context& context, const client::JobFilter& filter) {
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  client::JobFilter mine = filter;
  if (mine.user == "me") mine.user = client->user();
  const Expected<std::string> reply = client->list_jobs(mine);
  if (!reply) return tl::unexpected(reply.error());
  const Expected<Json> page = parse_reply(*reply);
  if (!page) return tl::unexpected(page.error());
  if (context.json) {
    print_json(*page);
    return {};
  }
  const Json jobs = page->value("jobs", Json::array());
  print_text(job_table(jobs));
  const std::string next =
      page->value("next", Json()).is_string() ? (*page)["next"].get<std::string>() : "";
  if (!next.empty()) print_text("more: tenter job list --cursor " + next + "\n");
  return {};
}

void show_job_text(const Json& job) {
  Table head({"", ""});
  const auto row = [&head](const char* name, const std::string& value) {
    if (!value.empty() && value != "-") head.add({name, value});
  };
  const Json spec = job.value("spec", Json::object());
  row("job", cell(job, "id"));
  row("kind", cell(job, "kind"));
  row("user", cell(job, "user"));
  row("state", cell(job, "state") + (job.value("from_store", false) ? " (from the store)" : ""));
  row("message", cell(job, "message"));
  if (job.contains("progress") && job["progress"].is_object())
    row("at", cell(job["progress"], "stage") + " " + cell(job["progress"], "detail"));
  row("priority", cell(job, "priority"));
  row("attempt", cell(job, "attempt"));
  row("submitted", clock_words(job, "created_ms"));
  row("took", job_time(job));
  if (spec.is_object() && spec.contains("model") && spec["model"].is_object())
    row("model", cell(spec["model"], "name"));
  if (spec.is_object() && spec.contains("options") && !spec["options"].empty())
    row("options", spec["options"].dump());
  for (const Json& capture : job.value("captures", Json::array()))
    row("capture", capture.is_string() ? capture.get<std::string>() : "");
  row("result", cell(job, "result_sha256"));
  const std::string text = head.text();
  print_text(text.substr(text.find('\n') + 1));

  Table history({">", "when", "what", "state", ">attempt", "message"});
  for (const Json& event : job.value("history", Json::array()))
    history.add({cell(event, "number"), clock_words(event, "time_ms"), cell(event, "what"),
                 cell(event, "state"), cell(event, "attempt"), cell(event, "message")});
  print_text("\n" + history.text());
}

Expected<void> watch_job(Context& context, const std::string& name) {
  Interrupt interrupt;
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  const Expected<std::string> job = resolve_job(*client, name);
  if (!job) return tl::unexpected(job.error());
  const Expected<client::JobUpdate> last = follow_job(*client, context, *job, interrupt);
  if (!last) return tl::unexpected(last.error());
  if (!context.json) {
    print_text("job " + *job + " succeeded (tenter report " + *job + ")\n");
    return {};
  }
  const Expected<std::string> reply = client->show_job(*job);
  if (!reply) return tl::unexpected(reply.error());
  const Expected<Json> value = parse_reply(*reply);
  if (!value) return tl::unexpected(value.error());
  print_json(*value);
  return {};
}

CLI::App* job_command(CLI::App* group, const char* name, const char* words, const char* footer,
                      const std::shared_ptr<std::string>& job) {
  CLI::App* command = group->add_subcommand(name, words);
  command->footer(footer);
  command->add_option("JOB", *job, "Number of the job, or `last` for your newest.")->required();
  return command;
}

void add_list(CLI::App* group, Context& context) {
  CLI::App* list = group->add_subcommand("list", "list jobs, newest first");
  list->footer(
      "EXAMPLES\n    tenter job list --of me --state running\n    tenter --json job list --limit "
      "1000\n");
  auto filter = std::make_shared<client::JobFilter>();
  list->add_option("--of", filter->user, "Only this user's; `me` for your own.")->type_name("USER");
  list->add_option("--state", filter->state, "Only those in this state.")
      ->type_name("STATE")
      ->check(CLI::IsMember({"queued", "running", "succeeded", "failed", "cancelled"}));
  list->add_option("--kind", filter->kind, "Only fit, simulate or diagnose.")
      ->type_name("KIND")
      ->check(CLI::IsMember({"fit", "simulate", "diagnose"}));
  list->add_option("--limit", filter->limit, "How many at most, 1 to 1000. Default: 100.")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  list->add_option("--cursor", filter->cursor, "Where the page before ended.")->type_name("CURSOR");
  list->callback([&context, filter] {
    context.command = [&context, filter] { return list_jobs(context, *filter); };
  });
}

void add_submit(CLI::App* group, Context& context) {
  CLI::App* submit = group->add_subcommand("submit", "submit a job specification as it is");
  submit->footer(
      "The specification is a JSON object: {\"schema\": \"tenter.job\", \"version\": 1, \"kind\": "
      "\"fit\", \"simulate\" or "
      "\"diagnose\", \"captures\": [SHA-256, ...], \"model\": {model document}, \"options\": "
      "{...}}. The captures must be on "
      "the server (tenter capture submit). The same specification twice is done once.\n"
      "EXAMPLES\n    tenter job submit spec.json --priority 10\n    tenter --json job submit - < "
      "spec.json\n");
  auto file = std::make_shared<std::string>();
  auto how = std::make_shared<SubmitOptions>();
  submit->add_option("SPEC", *file, "File with the specification; - is standard input.")
      ->required();
  add_submit_options(*submit, *how);
  submit->callback([&context, file, how] {
    context.command = [&context, file, how]() -> Expected<void> {
      const Expected<std::string> spec = read_input(*file, 1u << 20);
      if (!spec) return tl::unexpected(spec.error());
      auto client = context.connect();
      if (!client) return tl::unexpected(client.error());
      const Expected<client::SubmitResult> job = submit_job(*client, *spec, *how);
      if (!job) return tl::unexpected(job.error());
      print_submitted(context, *job);
      return {};
    };
  });
}

}  // namespace

void add_job(CLI::App& app, Context& context) {
  CLI::App* group = app.add_subcommand("job", "submit, list, show, watch, cancel and retry jobs");
  group->require_subcommand(1);
  add_submit(group, context);
  add_list(group, context);
  auto job = std::make_shared<std::string>();

  CLI::App* show =
      job_command(group, "show", "show a job: its specification, state and history",
                  "EXAMPLES\n    tenter job show last\n    tenter --json job show 17\n", job);
  show->callback([&context, job] {
    context.command = [&context, job] {
      return with_job(
          context, *job, [](client::Client& c, const std::string& id) { return c.show_job(id); },
          show_job_text);
    };
  });

  CLI::App* log = job_command(group, "log", "print the end of what the job's worker wrote",
                              "EXAMPLES\n    tenter job log last\n", job);
  log->callback([&context, job] {
    context.command = [&context, job] {
      return with_job(
          context, *job, [](client::Client& c, const std::string& id) { return c.job_log(id); },
          [](const Json& reply) {
            std::string text = cell(reply, "text"), line;
            std::istringstream lines(text);
            while (std::getline(lines, line)) print_text(report::printable(line) + "\n");
          });
    };
  });

  CLI::App* watch =
      job_command(group, "watch", "follow a job until it ends",
                  "Ctrl-C stops watching; the job goes on. The exit code is 0 if the job "
                  "succeeded, 7 if it failed, 8 if it was cancelled or you stopped watching.\n"
                  "EXAMPLES\n    tenter job watch last\n",
                  job);
  watch->callback(
      [&context, job] { context.command = [&context, job] { return watch_job(context, *job); }; });

  const auto changed = [](const Json& reply) {
    print_text("job " + cell(reply, "job_id") + " is " + report::printable(cell(reply, "state")) +
               "\n");
  };
  CLI::App* cancel = job_command(group, "cancel", "ask a job to stop",
                                 "EXAMPLES\n    tenter job cancel 17\n", job);
  cancel->callback([&context, job, changed] {
    context.command = [&context, job, changed] {
      return with_job(
          context, *job, [](client::Client& c, const std::string& id) { return c.cancel(id); },
          changed);
    };
  });
  CLI::App* retry = job_command(group, "retry", "run a failed or cancelled job again",
                                "EXAMPLES\n    tenter job retry 17\n", job);
  retry->callback([&context, job, changed] {
    context.command = [&context, job, changed] {
      return with_job(
          context, *job, [](client::Client& c, const std::string& id) { return c.retry(id); },
          changed);
    };
  });
}

}  // namespace tenter::cli
