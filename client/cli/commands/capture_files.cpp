// SPDX-License-Identifier: Apache-2.0
// capture import, validate, show, export: files only, no server.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "client/cli/commands/capture.h"
#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "client/cli/scratch.h"
#include "common/base/sha256.h"
#include "common/base/text_file.h"
#include "common/capture/csv/csv_export.h"
#include "common/capture/csv/csv_import.h"
#include "common/capture/file/capture_file.h"
#include "common/capture/run_selection.h"
#include "common/capture/sheet/sheet_export.h"
#include "common/capture/sheet_import/sheet_description.h"
#include "common/capture/sheet_import/sheet_import.h"
#include "common/capture/show.h"
#include "common/capture/strips/strip_photographs.h"

namespace tenter::cli {

namespace {

struct Import {
  std::string csv;  ///< or a description that names its tables
  std::string describe;
  std::string output;
  std::vector<int> runs;  ///< empty: all
  bool force = false;
};

Json capture_json(const capture::Capture& capture, const std::string& file, const std::string& id) {
  Json channels = Json::array();
  for (const capture::Channel& channel : capture.channels)
    channels.push_back({{"name", channel.name}, {"unit", channel.unit}, {"sigma", channel.sigma}});
  Json out = {{"file", file},
              {"id", id},
              {"kind", capture.kind},
              {"title", capture.title},
              {"synthetic", capture.provenance.synthetic},
              {"specimen", capture.specimen.name},
              {"material", capture.specimen.material},
              {"protocol", capture.protocol.name},
              {"runs", capture.runs.size()},
              {"frames", capture.frame_count()},
              {"has_time", !capture.time_s.empty()},
              {"channels", channels}};
  if (capture.sheet)
    out["sheet"] = {{"vertices", capture.sheet->vertex_count()},
                    {"triangles", capture.sheet->triangles.size()},
                    {"clips", capture.sheet->clips.size()},
                    {"cords", capture.sheet->cords.size()},
                    {"supports", capture.sheet->supports.size()}};
  return out;
}

std::string counted(std::size_t count, const std::string& one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

std::string counts(const capture::Capture& capture) {
  const std::string frames = std::to_string(capture.frame_count()) + " frames in " +
                             counted(capture.runs.size(), "run") + ", ";
  if (!capture.sheet) return frames + std::to_string(capture.channels.size()) + " channels";
  return frames + std::to_string(capture.sheet->vertex_count()) +
         (capture.sheet->triangles.empty() ? " points, " : " vertices, ") +
         counted(capture.sheet->clips.size(), "clip") + ", " +
         counted(capture.sheet->cords.size(), "cord");
}

/// A CSV with its description, or the description of a sheet, which may name all of its tables.
Expected<capture::Capture> read_source(const Import& order) {
  const bool is_alone = order.describe.empty();
  if (is_alone && std::filesystem::path(order.csv).extension() != ".json")
    return bad_input(order.csv + ": --describe FILE must say what its columns are");
  const std::string& describe = is_alone ? order.csv : order.describe;
  constexpr std::size_t kMaxDescriptionBytes = 16000000;
  const Expected<std::string> text = read_text_file(describe, kMaxDescriptionBytes);
  if (!text) return tl::unexpected(text.error());
  if (capture::describes_strip_photographs(*text)) {
    if (is_alone) return capture::import_strip_photographs(describe);
    return bad_input(describe + ": names photographs; give it alone, without " + order.csv);
  }
  if (is_alone || capture::describes_sheet(*text))
    return capture::import_sheet(describe, is_alone ? "" : order.csv);
  return capture::import_csv(order.csv, order.describe);
}

/// Imports into a file beside the output first, so that what is there stays if anything is wrong.
Expected<void> import_capture(const Context& context, const Import& order) {
  namespace fs = std::filesystem;
  Expected<capture::Capture> capture = read_source(order);
  if (capture && !order.runs.empty()) {
    capture = capture::with_runs(std::move(*capture), order.runs);
    if (!capture) return bad_input("--runs: " + capture.error().message);
  }
  if (!capture) return tl::unexpected(capture.error());
  const fs::path output =
      order.output.empty() ? fs::path(order.csv).replace_extension(".h5") : fs::path(order.output);
  const fs::path draft = output.string() + ".importing";
  std::error_code failed;
  const auto drop_draft = [&] { fs::remove(draft, failed); };
  if (auto written = capture::write_capture(*capture, draft.string()); !written) {
    drop_draft();
    return written;
  }
  const Expected<std::string> id = sha256_file(draft);
  if (!id) {
    drop_draft();
    return tl::unexpected(id.error());
  }
  if (fs::exists(output, failed) && !order.force) {
    const Expected<std::string> there = sha256_file(output);
    if (!there || *there != *id) {
      drop_draft();
      return fail(ErrorKind::refused,
                  output.string() + ": exists and holds something else; --force replaces it");
    }
  }
  fs::rename(draft, output, failed);
  if (failed) {
    const std::string reason = failed.message();
    drop_draft();
    return fail(ErrorKind::no_space, output.string() + ": cannot be written: " + reason);
  }
  if (context.json)
    print_json(capture_json(*capture, output.string(), *id));
  else
    print_text(output.string() + ": " + counts(*capture) + "\n" + *id + "\n");
  return {};
}

Expected<void> validate_captures(const Context& context, const std::vector<std::string>& files) {
  Json checked = Json::array();
  for (const std::string& file : files) {
    std::vector<std::string> ignored;
    const Expected<capture::Capture> capture = capture::read_capture_guarded(file, &ignored);
    if (!capture) return tl::unexpected(capture.error());
    const Expected<std::string> id = sha256_file(file);
    if (!id) return tl::unexpected(id.error());
    Json entry = capture_json(*capture, file, *id);
    entry["valid"] = true;
    entry["ignored"] = ignored;
    checked.push_back(std::move(entry));
    if (context.json) continue;
    print_text(file + ": valid, " + counts(*capture) +
               (capture->provenance.synthetic ? " [SYNTHETIC]" : "") + "\n");
    for (const std::string& object : ignored)
      print_text("  not known to this version, ignored: " + object + "\n");
  }
  if (context.json) print_json({{"captures", checked}});
  return {};
}

/// A file, or a capture of the server fetched into `scratch`; with the name that people know it by.
Expected<std::filesystem::path> local_capture(const Context& context, const std::string& name,
                                              const ScratchFolder& scratch) {
  std::error_code ignored;
  if (std::filesystem::exists(name, ignored)) return std::filesystem::path(name);
  if (!looks_like_hash(name))
    return fail(
        ErrorKind::not_found,
        name + ": there is no such file, and it is no capture's SHA-256 (6 digits of it or more)");
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  const Expected<std::string> id = resolve_capture(*client, name);
  if (!id) return tl::unexpected(id.error());
  const std::filesystem::path file = scratch.path() / (id->substr(0, 12) + ".h5");
  if (const auto fetched = client->download_capture(*id, file); !fetched)
    return tl::unexpected(fetched.error());
  return file;
}

Expected<void> show_capture(const Context& context, const std::string& name) {
  const Expected<ScratchFolder> scratch = ScratchFolder::make();
  if (!scratch) return tl::unexpected(scratch.error());
  const Expected<std::filesystem::path> file = local_capture(context, name, *scratch);
  if (!file) return tl::unexpected(file.error());
  const Expected<capture::Capture> capture = capture::read_capture_guarded(file->string());
  if (!capture) return tl::unexpected(capture.error());
  const Expected<std::string> id = sha256_file(*file);
  if (!id) return tl::unexpected(id.error());
  if (context.json) {
    Json shown = {{"id", *id}};
    shown.update(capture::show_json(*capture));
    print_json(shown);
  } else {
    print_text(capture::show_text(*capture));
  }
  return {};
}

struct Export {
  std::string name;
  std::string output;
  std::string describe;
  bool force = false;
};

/// A sheet becomes several tables; the description that joins them is what `-o` names.
Expected<void> export_sheet_files(const Context& context, const Export& order,
                                  const capture::Capture& capture,
                                  const std::filesystem::path& source) {
  const std::string& given = order.describe.empty() ? order.output : order.describe;
  if (given == "-")
    return bad_input(order.name +
                     ": is a deforming sheet, which becomes several files; -o names a file");
  const std::filesystem::path describe =
      std::filesystem::path(given.empty() ? source.string() : given).replace_extension(".json");
  const auto files = capture::export_sheet(capture, describe.string(), order.force);
  if (!files) return tl::unexpected(files.error());
  if (context.json) {
    print_json(
        {{"describe", describe.string()}, {"files", *files}, {"frames", capture.frame_count()}});
    return {};
  }
  for (const std::string& path : *files) print_text(path + " written\n");
  return {};
}

/// An export never writes over the CSV that a capture was made of.
Expected<void> export_capture(const Context& context, const Export& order) {
  namespace fs = std::filesystem;
  const Expected<ScratchFolder> scratch = ScratchFolder::make();
  if (!scratch) return tl::unexpected(scratch.error());
  const Expected<fs::path> file = local_capture(context, order.name, *scratch);
  if (!file) return tl::unexpected(file.error());
  const Expected<capture::Capture> capture = capture::read_capture_guarded(file->string());
  if (!capture) return tl::unexpected(capture.error());
  const fs::path source = fs::exists(order.name) ? fs::path(order.name) : file->filename();
  if (capture->sheet) return export_sheet_files(context, order, *capture, source);
  if (order.output == "-") {
    print_text(capture::export_csv(*capture).csv);
    return {};
  }
  const fs::path csv =
      order.output.empty() ? fs::path(source).replace_extension(".csv") : fs::path(order.output);
  const fs::path describe =
      order.describe.empty() ? fs::path(csv).replace_extension(".json") : fs::path(order.describe);
  for (const fs::path& target : {csv, describe}) {
    std::error_code ignored;
    if (!order.force && fs::exists(target, ignored))
      return fail(ErrorKind::refused, target.string() + ": exists; --force replaces it");
  }
  if (auto written = capture::write_csv_export(*capture, csv.string(), describe.string()); !written)
    return written;
  if (context.json)
    print_json({{"csv", csv.string()},
                {"describe", describe.string()},
                {"frames", capture->frame_count()}});
  else
    print_text(csv.string() + " and " + describe.string() + " written\n");
  return {};
}

void add_import(CLI::App& group, Context& context) {
  CLI::App* command =
      group.add_subcommand("import", "make a capture of CSV tables and their description");
  command->footer(
      "The description is a small JSON file that names the columns, their units, the specimen and "
      "the protocol; see "
      "common/capture/README.md. What cannot be understood is refused with file, line and column, "
      "exit code 2, and "
      "nothing is written. Of a deforming sheet (kind deforming_sheet, see "
      "common/capture/sheet_import/README.md) FILE may be the description itself, which then names "
      "all of its tables; so it is with photographs of strips (kind strip_profiles with a list of "
      "photographs, see common/capture/strips/README.md). Prints the SHA-256 that names the "
      "capture.\n"
      "EXAMPLES\n"
      "    tenter capture import pull.csv --describe pull.json\n"
      "    tenter capture import pull.csv --describe pull.json -o captures/pull.h5\n"
      "    tenter capture import sheet.json\n"
      "    tenter capture import pulls.csv --describe pull.json --runs 5 -o held_out.h5\n");
  auto order = std::make_shared<Import>();
  command
      ->add_option("FILE", order->csv,
                   "The CSV file, or the description of a sheet and its tables, or of photographs.")
      ->required();
  command->add_option("--describe", order->describe, "What the columns of the CSV are (JSON).")
      ->type_name("FILE");
  command
      ->add_option("-o,--output", order->output,
                   "The capture file to write. Default: FILE with .h5 in place of its extension.")
      ->type_name("FILE");
  command
      ->add_option("--runs", order->runs,
                   "Keep only these runs of the source, so that others can be held out: 2,3,4.")
      ->type_name("N,...")
      ->delimiter(',');
  command->add_flag("--force", order->force, "Replace an output file that holds something else.");
  command->callback([&context, order] {
    context.command = [&context, order] { return import_capture(context, *order); };
  });
}

void add_validate(CLI::App& group, Context& context) {
  CLI::App* command = group.add_subcommand("validate", "check capture files");
  command->footer(
      "Reads each file in a process with limits. A bad one is named with the bad group and why, "
      "exit code 2.\n"
      "EXAMPLES\n    tenter capture validate *.h5\n");
  auto files = std::make_shared<std::vector<std::string>>();
  command->add_option("FILE", *files, "Capture files (.h5).")->required();
  command->callback([&context, files] {
    context.command = [&context, files] { return validate_captures(context, *files); };
  });
}

void add_show(CLI::App& group, Context& context) {
  CLI::App* command = group.add_subcommand("show", "show what a capture holds");
  command->footer(
      "Specimen, protocol, runs, channels with their units, noise and ranges, and where the "
      "numbers come from.\n"
      "EXAMPLES\n    tenter capture show pull.h5\n    tenter --json capture show 3fa9c1\n");
  auto name = std::make_shared<std::string>();
  command
      ->add_option("CAPTURE", *name,
                   "A capture file (.h5), or the SHA-256 (6 digits or more) of one on the server.")
      ->required();
  command->callback([&context, name] {
    context.command = [&context, name] { return show_capture(context, *name); };
  });
}

void add_export(CLI::App& group, Context& context) {
  CLI::App* command = group.add_subcommand(
      "export", "write a capture as CSV and the description that imports it again");
  command->footer(
      "Values are SI in their shortest exact form; import gives the same capture back, bit for "
      "bit. A deforming sheet becomes several tables and an OBJ file beside the description.\n"
      "EXAMPLES\n    tenter capture export pull.h5 -o again.csv\n    tenter capture export 3fa9c1 "
      "-o -\n");
  auto order = std::make_shared<Export>();
  command
      ->add_option("CAPTURE", order->name,
                   "A capture file (.h5), or the SHA-256 (6 digits or more) of one on the server.")
      ->required();
  command
      ->add_option("-o,--output", order->output,
                   "The CSV file (of a sheet: its description); - is standard output. Default: "
                   "CAPTURE with .csv.")
      ->type_name("FILE");
  command
      ->add_option("--describe", order->describe,
                   "The description (JSON). Default: the CSV file with .json.")
      ->type_name("FILE");
  command->add_flag("--force", order->force, "Replace files that are there.");
  command->callback([&context, order] {
    context.command = [&context, order] { return export_capture(context, *order); };
  });
}

}  // namespace

void add_capture_files(CLI::App& group, Context& context) {
  add_import(group, context);
  add_validate(group, context);
  add_show(group, context);
  add_export(group, context);
}

void add_capture(CLI::App& app, Context& context) {
  CLI::App* group =
      app.add_subcommand("capture", "import, check, show, export, send and list captures");
  group->require_subcommand(1);
  add_capture_files(*group, context);
  add_capture_server(*group, context);
}

}  // namespace tenter::cli
