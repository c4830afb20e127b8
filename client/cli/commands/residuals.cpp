// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "client/cli/scratch.h"
#include "common/report/residual_file.h"
#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

struct Query {
  std::string job;
  std::string frames;
  std::string format = "table";
  int block = -1;
  report::ResidualFilter filter;
};

/// "12", "10:20", "10:", ":20"; both ends belong to it.
Expected<void> set_frames(const std::string& text, report::ResidualFilter& filter) {
  if (text.empty()) return {};
  const auto wrong = [&text] {
    return bad_input("--frames " + text + ": must be A:B, A:, :B or A, with frame numbers A <= B");
  };
  const auto frame = [](const std::string& digits, std::optional<int>& value) {
    if (digits.empty()) return true;
    if (digits.size() > 9 || digits.find_first_not_of("0123456789") != std::string::npos)
      return false;
    value = std::stoi(digits);
    return true;
  };
  const std::size_t colon = text.find(':');
  const std::string first = text.substr(0, colon);
  const std::string last = colon == std::string::npos ? first : text.substr(colon + 1);
  if (text == ":" || !frame(first, filter.first_frame) || !frame(last, filter.last_frame))
    return wrong();
  if (filter.first_frame && filter.last_frame && *filter.first_frame > *filter.last_frame)
    return wrong();
  return {};
}

Expected<std::vector<report::ResidualTable>> tables_of(Context& context, const Query& query,
                                                       std::string& job_id) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(query.job, ignored))
    return report::read_residuals_guarded(query.job, query.filter);
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  const Expected<std::string> job = resolve_job(*client, query.job);
  if (!job) return tl::unexpected(job.error());
  job_id = *job;
  context.details["job_id"] = *job;
  const Expected<ScratchFolder> scratch = ScratchFolder::make();
  if (!scratch) return tl::unexpected(scratch.error());
  const std::filesystem::path file = scratch->path() / "residuals.h5";
  if (const auto fetched = client->fetch_residuals(*job, file); !fetched)
    return tl::unexpected(fetched.error());
  return report::read_residuals_guarded(file.string(), query.filter);
}

double at(const std::vector<double>& values, std::size_t row) {
  return row < values.size() ? values[row] : std::nan("");
}

std::string number(double value, const char* format) {
  if (!std::isfinite(value)) return "";
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// A column by name, and its value in a row.
struct Column {
  const char* name;
  double (*value)(const report::ResidualTable&, std::size_t);
};
using T = report::ResidualTable;
constexpr Column kColumns[] = {
    {"time_s", [](const T& t, std::size_t i) { return at(t.time_s, i); }},
    {"strain_x", [](const T& t, std::size_t i) { return at(t.strain_x, i); }},
    {"strain_y", [](const T& t, std::size_t i) { return at(t.strain_y, i); }},
    {"strain_xy", [](const T& t, std::size_t i) { return at(t.strain_xy, i); }},
    {"measured", [](const T& t, std::size_t i) { return at(t.measured, i); }},
    {"baseline", [](const T& t, std::size_t i) { return at(t.predicted_baseline, i); }},
    {"extended", [](const T& t, std::size_t i) { return at(t.predicted_extended, i); }},
    {"residual_baseline",
     [](const T& t, std::size_t i) { return at(t.measured, i) - at(t.predicted_baseline, i); }},
    {"residual_extended",
     [](const T& t, std::size_t i) { return at(t.measured, i) - at(t.predicted_extended, i); }},
    {"sigma", [](const T& t, std::size_t i) { return at(t.sigma, i); }},
    {"weight", [](const T& t, std::size_t i) { return at(t.weight, i); }},
};

std::string csv_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : report::printable(text)) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string csv(const std::vector<report::ResidualTable>& tables) {
  std::string out = "capture,title,channel,unit,run,block,branch,frame";
  for (const Column& column : kColumns) out += std::string(",") + column.name;
  out += "\n";
  for (const report::ResidualTable& table : tables) {
    const std::string head = table.capture_id + "," + csv_text(table.capture_title) + "," +
                             csv_text(table.channel) + "," + csv_text(table.unit) + ",";
    for (std::size_t i = 0; i < table.size(); ++i) {
      out += head + std::to_string(table.run[i]) + "," + std::to_string(table.block[i]) + "," +
             report::branch_word(table.branch[i]) + "," + std::to_string(table.frame[i]);
      for (const Column& column : kColumns) out += "," + number(column.value(table, i), "%.9g");
      out += "\n";
    }
  }
  return out;
}

Json json(const std::vector<report::ResidualTable>& tables, const std::string& job_id) {
  Json list = Json::array();
  for (const report::ResidualTable& table : tables) {
    Json rows = Json::array();
    for (std::size_t i = 0; i < table.size(); ++i) {
      Json row = {{"run", table.run[i]},
                  {"block", table.block[i]},
                  {"branch", report::branch_word(table.branch[i])},
                  {"frame", table.frame[i]}};
      for (const Column& column : kColumns) {
        const double value = column.value(table, i);
        row[column.name] = std::isfinite(value) ? Json(value) : Json(nullptr);
      }
      rows.push_back(std::move(row));
    }
    list.push_back({{"capture", table.capture_id},
                    {"title", table.capture_title},
                    {"channel", table.channel},
                    {"unit", table.unit},
                    {"rows", std::move(rows)}});
  }
  return {{"job_id", job_id}, {"tables", std::move(list)}};
}

std::string text(const std::vector<report::ResidualTable>& tables) {
  std::string out;
  for (const report::ResidualTable& table : tables) {
    out += (out.empty() ? "" : "\n") + report::printable(table.capture_title) + "  " +
           table.capture_id.substr(0, 12) + "  " + report::printable(table.channel) + " (" +
           report::printable(table.unit) + ")\n";
    Table lines({">run", ">block", "branch", ">frame", ">time s", ">strain x", ">strain y",
                 ">shear", ">measured", ">baseline", ">extended", ">left before", ">left after",
                 ">sigma", ">weight"});
    for (std::size_t i = 0; i < table.size(); ++i) {
      std::vector<std::string> cells = {
          std::to_string(table.run[i]), std::to_string(table.block[i]),
          report::branch_word(table.branch[i]), std::to_string(table.frame[i])};
      for (const Column& column : kColumns) {
        const std::string shown = number(column.value(table, i), "%.5g");
        cells.push_back(shown.empty() ? "-" : shown);
      }
      lines.add(std::move(cells));
    }
    out += lines.text();
  }
  return out;
}

Expected<void> show_residuals(Context& context, Query query) {
  if (auto set = set_frames(query.frames, query.filter); !set) return set;
  if (query.block >= 0) query.filter.block = query.block;
  std::string job_id;
  const auto tables = tables_of(context, query, job_id);
  if (!tables) return tl::unexpected(tables.error());
  if (tables->empty())
    return fail(ErrorKind::not_found, "no residual of this job passes the filter");
  if (context.json || query.format == "json")
    print_json(json(*tables, job_id));
  else
    print_text(query.format == "csv" ? csv(*tables) : text(*tables));
  return {};
}

}  // namespace

void add_residuals(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand(
      "residuals", "query what is left between measurement and models, frame by frame");
  command->footer(
      "One row per frame and channel: strains, measured stress, what the baseline and the extended "
      "model predict, and "
      "what either leaves. A row with weight 0 was left out as an outlier. Missing values are "
      "blank in CSV and null in "
      "JSON.\n"
      "EXAMPLES\n"
      "    tenter residuals last --block 3\n"
      "    tenter residuals 17 --capture 3fa9c1 --channel force --frames 100:200 --format csv > "
      "some.csv\n"
      "    tenter --json residuals 17 | jq '[.tables[].rows[] | select(.weight == 0)]'\n");
  auto query = std::make_shared<Query>();
  command
      ->add_option("JOB", query->job,
                   "Number of the job, `last` for your newest, or a residuals.h5 file.")
      ->required();
  command
      ->add_option("--capture", query->filter.capture,
                   "Only this capture: its SHA-256 (6 digits or more) or title.")
      ->type_name("CAPTURE");
  command->add_option("--channel", query->filter.channel, "Only this channel.")->type_name("NAME");
  command->add_option("--block", query->block, "Only this block, counted from 0.")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--frames", query->frames,
                   "Only these frames: A:B (both included), A:, :B or A.")
      ->type_name("A:B");
  command->add_option("--format", query->format, "table, csv or json. Default: table.")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"table", "csv", "json"}));
  command->callback([&context, query] {
    context.command = [&context, query] { return show_residuals(context, *query); };
  });
}

}  // namespace tenter::cli
