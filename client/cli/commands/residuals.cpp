// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "client/cli/scratch.h"
#include "client/cli/sheet/vertex_table.h"
#include "common/report/residual_file.h"
#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

struct Query {
  std::string job;
  std::string frames;
  std::string format = "table";
  int block = -1;
  bool vertices = false;
  std::string vertex;
  report::ResidualFilter filter;
};

/// "12", "10:20", "10:", ":20"; both ends belong to it. `option` and `what` are for the message.
Expected<void> set_range(const std::string& text, const char* option, const char* what,
                         std::optional<int>& first, std::optional<int>& last) {
  if (text.empty()) return {};
  const auto wrong = [&] {
    return bad_input(std::string(option) + " " + text + ": must be A:B, A:, :B or A, with " + what +
                     " numbers A <= B");
  };
  const auto read = [](const std::string& digits, std::optional<int>& value) {
    if (digits.empty()) return true;
    if (digits.size() > 9 || digits.find_first_not_of("0123456789") != std::string::npos)
      return false;
    value = std::stoi(digits);
    return true;
  };
  const std::size_t colon = text.find(':');
  const std::string from = text.substr(0, colon);
  const std::string to = colon == std::string::npos ? from : text.substr(colon + 1);
  if (text == ":" || !read(from, first) || !read(to, last)) return wrong();
  if (first && last && *first > *last) return wrong();
  return {};
}

/// What `read` finds in the job's residuals.h5, or in a file of that kind.
template <class Read>
auto read_of(Context& context, const Query& query, std::string& job_id, const Read& read)
    -> decltype(read(std::string())) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(query.job, ignored)) return read(query.job);
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
  return read(file.string());
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
    {"displacement_m", [](const T& t, std::size_t i) { return at(t.displacement_m, i); }},
};

/// All of them, the last one only where a table has it.
std::span<const Column> columns_of(const std::vector<report::ResidualTable>& tables) {
  const bool displaced = std::any_of(tables.begin(), tables.end(),
                                     [](const T& t) { return !t.displacement_m.empty(); });
  return std::span(kColumns).first(std::size(kColumns) - (displaced ? 0 : 1));
}

std::string csv_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : report::printable(text)) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string csv(const std::vector<report::ResidualTable>& tables) {
  std::string out = "capture,title,channel,unit,run,block,branch,frame";
  const auto columns = columns_of(tables);
  for (const Column& column : columns) out += std::string(",") + column.name;
  out += "\n";
  for (const report::ResidualTable& table : tables) {
    const std::string head = table.capture_id + "," + csv_text(table.capture_title) + "," +
                             csv_text(table.channel) + "," + csv_text(table.unit) + ",";
    for (std::size_t i = 0; i < table.size(); ++i) {
      out += head + std::to_string(table.run[i]) + "," + std::to_string(table.block[i]) + "," +
             report::branch_word(table.branch[i]) + "," + std::to_string(table.frame[i]);
      for (const Column& column : columns) out += "," + number(column.value(table, i), "%.9g");
      out += "\n";
    }
  }
  return out;
}

Json json(const std::vector<report::ResidualTable>& tables, const std::string& job_id) {
  Json list = Json::array();
  const auto columns = columns_of(tables);
  for (const report::ResidualTable& table : tables) {
    Json rows = Json::array();
    for (std::size_t i = 0; i < table.size(); ++i) {
      Json row = {{"run", table.run[i]},
                  {"block", table.block[i]},
                  {"branch", report::branch_word(table.branch[i])},
                  {"frame", table.frame[i]}};
      for (const Column& column : columns) {
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
  const auto columns = columns_of(tables);
  for (const report::ResidualTable& table : tables) {
    out += (out.empty() ? "" : "\n") + report::printable(table.capture_title) + "  " +
           table.capture_id.substr(0, 12) + "  " + report::printable(table.channel) + " (" +
           report::printable(table.unit) + ")\n";
    std::vector<std::string> head = {">run",        ">block",    "branch",    ">frame",
                                     ">time s",     ">strain x", ">strain y", ">shear",
                                     ">measured",   ">baseline", ">extended", ">left before",
                                     ">left after", ">sigma",    ">weight"};
    if (columns.size() == std::size(kColumns)) head.emplace_back(">displ. m");
    Table lines(std::move(head));
    for (std::size_t i = 0; i < table.size(); ++i) {
      std::vector<std::string> cells = {
          std::to_string(table.run[i]), std::to_string(table.block[i]),
          report::branch_word(table.branch[i]), std::to_string(table.frame[i])};
      for (const Column& column : columns) {
        const std::string shown = number(column.value(table, i), "%.5g");
        cells.push_back(shown.empty() ? "-" : shown);
      }
      lines.add(std::move(cells));
    }
    out += lines.text();
  }
  return out;
}

Expected<void> show_vertices(Context& context, const Query& query) {
  if (!query.filter.channel.empty() || query.block >= 0)
    return bad_input("--channel and --block are for channels, not for --vertices");
  report::VertexFilter filter{query.filter.capture, query.filter.first_frame,
                              query.filter.last_frame, std::nullopt, std::nullopt};
  if (auto set =
          set_range(query.vertex, "--vertex", "vertex", filter.first_vertex, filter.last_vertex);
      !set)
    return set;
  std::string job_id;
  const auto blocks = read_of(context, query, job_id, [&](const std::string& path) {
    return report::read_vertex_residuals_guarded(path, filter);
  });
  if (!blocks) return tl::unexpected(blocks.error());
  if (blocks->empty()) return fail(ErrorKind::not_found, "no vertex of this job passes the filter");
  if (context.json || query.format == "json")
    print_json(vertex_json(*blocks, job_id));
  else
    print_text(query.format == "csv" ? vertex_csv(*blocks) : vertex_text(*blocks));
  return {};
}

Expected<void> show_residuals(Context& context, Query query) {
  if (auto set = set_range(query.frames, "--frames", "frame", query.filter.first_frame,
                           query.filter.last_frame);
      !set)
    return set;
  if (query.vertices || !query.vertex.empty()) return show_vertices(context, query);
  if (query.block >= 0) query.filter.block = query.block;
  std::string job_id;
  const auto tables = read_of(context, query, job_id, [&](const std::string& path) {
    return report::read_residuals_guarded(path, query.filter);
  });
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
      "\n"
      "Of a fit to captures of a sheet the channels are clip forces, the baseline is the starting "
      "model and the extended model the fitted one. --vertices prints what is left at every "
      "measured vertex, one row per frame and vertex.\n"
      "EXAMPLES\n"
      "    tenter residuals last --block 3\n"
      "    tenter residuals 17 --capture 3fa9c1 --channel force --frames 100:200 --format csv > "
      "some.csv\n"
      "    tenter residuals 17 --vertices --capture 3fa9c1 --frames 12 --format csv > field.csv\n"
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
  command->add_flag("--vertices", query->vertices,
                    "What is left at the vertices of a sheet, instead of its channels.");
  command
      ->add_option("--vertex", query->vertex,
                   "Only these vertices: A:B (both included), A:, :B or A. Means --vertices.")
      ->type_name("A:B");
  command->add_option("--format", query->format, "table, csv or json. Default: table.")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"table", "csv", "json"}));
  command->callback([&context, query] {
    context.command = [&context, query] { return show_residuals(context, *query); };
  });
}

}  // namespace tenter::cli
