// SPDX-License-Identifier: Apache-2.0
#include "client/cli/job_run.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "client/cli/continued.h"
#include "client/cli/follow.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "client/cli/progress.h"
#include "common/base/atomic_write.h"
#include "common/model/document.h"
#include "common/report/html_report.h"
#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

bool is_file(const std::string& name) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(name, ignored);
}

/// What can be refused before anything is sent.
Expected<void> check_names(const std::vector<std::string>& captures) {
  for (const std::string& name : captures) {
    if (is_file(name)) {
      if (std::filesystem::path(name).extension() == ".csv")
        return bad_input(name +
                         ": is a CSV file; make a capture of it first (tenter capture import " +
                         name + " --describe FILE.json)");
      continue;
    }
    if (!looks_like_hash(name))
      return fail(
          ErrorKind::not_found,
          name +
              ": there is no such file, and it is no capture's SHA-256 (6 digits of it or more)");
  }
  return {};
}

/// The SHA-256 of every capture; files are sent unless the server has them.
Expected<std::vector<std::string>> bring_captures(client::Client& client, const Context& context,
                                                  const std::vector<std::string>& names,
                                                  Interrupt& interrupt) {
  std::vector<std::string> ids;
  ProgressDisplay display(std::cerr, isatty(STDERR_FILENO) == 1, terminal_width(STDERR_FILENO));
  for (const std::string& name : names) {
    if (!is_file(name)) {
      const Expected<std::string> id = resolve_capture(client, name);
      if (!id) return tl::unexpected(id.error());
      ids.push_back(*id);
      continue;
    }
    const std::string what = "sending " + std::filesystem::path(name).filename().string();
    const Expected<client::UploadResult> sent = client.upload_capture(
        name,
        [&](const client::TransferProgress& p) {
          if (!context.quiet) display.show_transfer(what, p);
        },
        interrupt.token());
    if (!sent) {
      if (interrupt.interrupted())
        return fail(ErrorKind::cancelled, "stopped while sending " + name +
                                              "; the same command goes on where it stopped");
      return tl::unexpected(about_file(name, sent.error()));
    }
    ids.push_back(sent->sha256);
  }
  return ids;
}

Expected<std::string> specification(const JobRun& run, const std::vector<std::string>& captures,
                                    const model::Model& model) {
  nlohmann::json spec = {{"schema", "tenter.job"},
                         {"version", 1},
                         {"kind", run.kind},
                         {"captures", captures},
                         {"options", run.options}};
  if (run.complete_options)
    if (auto done = run.complete_options(captures, spec["options"]); !done)
      return tl::unexpected(done.error());
  spec["model"] = nlohmann::json::parse(model::write_model(model));
  return spec.dump();
}

Expected<void> write_file(const std::string& path, const std::string& text) {
  return write_atomically(path, text.data(), text.size());
}

Expected<void> present(Context& context, const JobRun& run, const std::string& job_id,
                       const std::string& result_text) {
  const Expected<Json> result = parse_reply(result_text);
  if (!result) return tl::unexpected(result.error());
  if (!run.report.empty()) {
    const Expected<std::string> page = report::render_html(result_text);
    if (!page) return tl::unexpected(page.error());
    if (auto written = write_file(run.report, *page); !written) return written;
  }
  if (!run.save_model.empty()) {
    const Expected<model::Model> model =
        model::parse_model(result->value("model", Json()).dump(), "the result's model");
    if (!model) return tl::unexpected(model.error());
    if (auto written = write_file(run.save_model, model::write_model(*model)); !written)
      return written;
  }
  if (context.json) {
    print_json(result_digest(*result, job_id));
    return {};
  }
  const Expected<std::string> text =
      report::render_text(result_text, {terminal_width(STDOUT_FILENO), context.colour_output()});
  if (!text) return tl::unexpected(text.error());
  print_text(*text);
  print_text("\n");
  if (!run.report.empty())
    print_text("report written to " + run.report + "\n");
  else
    print_text("job " + job_id + "; the whole report: tenter report " + job_id +
               " -o report.html\n");
  if (!run.save_model.empty()) print_text("model written to " + run.save_model + "\n");
  return {};
}

}  // namespace

nlohmann::ordered_json result_digest(const nlohmann::ordered_json& result,
                                     const std::string& job_id) {
  Json digest = {{"job_id", job_id}};
  for (const auto& [key, value] : result.items())
    if (key != "figures" && key != "meshes") digest[key] = value;
  return digest;
}

namespace {

/// Captures and options of the diagnosis that `run` goes on from, before its own; its model where
/// `run` names none.
Expected<model::Model> take_over(client::Client& client, JobRun& run) {
  auto before = continue_from(client, run.continues);
  if (!before) return tl::unexpected(before.error());
  run.captures.insert(run.captures.begin(), before->captures.begin(), before->captures.end());
  for (const auto& [key, value] : before->options.items())
    if (!run.options.contains(key)) run.options[key] = value;
  if (!run.model.empty()) return load_model(run.model);
  return model::parse_model(before->model_json, "the model of job " + run.continues);
}

/// A capture that is named twice, by file and by hash or by both jobs, is one.
void drop_repeated(std::vector<std::string>& ids) {
  std::vector<std::string> once;
  for (std::string& id : ids)
    if (std::find(once.begin(), once.end(), id) == once.end()) once.push_back(std::move(id));
  ids = std::move(once);
}

}  // namespace

Expected<void> run_job(Context& context, const JobRun& asked) {
  JobRun run = asked;
  const bool goes_on = !run.continues.empty();
  Expected<model::Model> model = goes_on ? model::Model() : load_model(run.model);
  if (!model) return tl::unexpected(model.error());
  if (auto checked = check_names(run.captures); !checked) return checked;

  Interrupt interrupt;
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  if (goes_on) {
    model = take_over(*client, run);
    if (!model) return tl::unexpected(model.error());
  }
  Expected<std::vector<std::string>> captures =
      bring_captures(*client, context, run.captures, interrupt);
  if (!captures) return tl::unexpected(captures.error());
  if (goes_on) drop_repeated(*captures);
  if (interrupt.interrupted())
    return fail(ErrorKind::cancelled, "stopped before the job was submitted");
  const Expected<std::string> spec = specification(run, *captures, *model);
  if (!spec) return tl::unexpected(spec.error());
  const Expected<client::SubmitResult> job = submit_job(*client, *spec, run.submit);
  if (!job) return tl::unexpected(job.error());
  if (run.detach) {
    print_submitted(context, *job);
    return {};
  }
  const Expected<client::JobUpdate> last = follow_job(*client, context, job->job_id, interrupt);
  if (!last) return tl::unexpected(last.error());
  const Expected<std::string> result = fetch_result_text(*client, job->job_id, run.output);
  if (!result) return tl::unexpected(result.error());
  return present(context, run, job->job_id, *result);
}

}  // namespace tenter::cli
