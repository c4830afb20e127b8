// SPDX-License-Identifier: Apache-2.0
#include "client/cli/scene_run.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "client/cli/follow.h"
#include "client/cli/names.h"
#include "client/cli/output.h"
#include "client/cli/progress.h"
#include "common/base/atomic_write.h"
#include "common/frames/frames_file.h"
#include "common/model/document.h"
#include "common/report/experiment/figure.h"
#include "common/report/html_report.h"
#include "common/scene/examples.h"

namespace tenter::cli {

namespace {

namespace fs = std::filesystem;

std::string number_words(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

Expected<void> make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return bad_input(folder.string() + ": cannot be made: " + error.message());
  return {};
}

Expected<void> fetch_files(client::Client& client, const std::string& job_id,
                           const fs::path& folder) {
  if (auto made = make_folder(folder); !made) return made;
  const fs::path frames = folder / "frames.h5";
  if (const auto got = client.fetch_frames(job_id, frames); !got)
    return tl::unexpected(got.error());
  return frames::write_xdmf(frames.string(), (folder / "frames.xdmf").string());
}

void print_reactions(const Json& last) {
  Table table(
      {"clip", ">F_x (N)", ">F_y (N)", ">F_z (N)", ">T_x (N m)", ">T_y (N m)", ">T_z (N m)"});
  for (const auto& [clip, wrench] : last.at("reactions").items()) {
    std::vector<std::string> row = {clip};
    for (const char* key : {"force_N", "torque_N_m"})
      for (const auto& value : wrench.at(key)) row.push_back(number_words(value.get<double>()));
    table.add(row);
  }
  print_text(table.text());
}

void print_energies(const Json& last) {
  Table table({"term", ">energy (J)"});
  for (const auto& [term, energy] : last.at("energies_J").items())
    table.add({term, number_words(energy.get<double>())});
  print_text(table.text());
}

/// The summary that a person reads.
void print_summary(const Json& result, const std::string& output, const std::string& job_id) {
  const Json& rows = result.at("frames");
  int iterations = 0;
  for (const Json& row : rows) iterations += row.at("iterations").get<int>();
  print_text("scene " + result.at("scene").get<std::string>() + " with " +
             result.at("model").get<std::string>() + ": " + std::to_string(rows.size()) + " of " +
             std::to_string(result.at("frames_asked").get<int>()) + " frames, " +
             std::to_string(result.at("nodes").get<int>()) + " nodes, " +
             std::to_string(iterations) + " iterations\n\nAt the last frame:\n");
  const Json& last = rows.back();
  if (!last.at("reactions").empty()) {
    print_reactions(last);
    print_text("\n");
  }
  print_energies(last);
  if (output.empty())
    print_text("\njob " + job_id + "; the same command with -o DIR brings its frames, at once\n");
  else
    print_text("\nframes written to " + (fs::path(output) / "frames.h5").string() +
               ", for ParaView " + (fs::path(output) / "frames.xdmf").string() + "\n");
}

Expected<void> present(Context& context, const SceneJob& job, const std::string& job_id,
                       const std::string& text) {
  Expected<Json> result = parse_reply(text);
  if (!result) return tl::unexpected(result.error());
  const auto schema = result->find("schema");
  if (schema == result->end() || *schema != "tenter.simulation" || (*result)["frames"].empty())
    return fail(ErrorKind::internal, "the server's result is no simulated scene");
  const bool completed = result->value("completed", false);
  if (context.json && completed) {
    Json digest = {{"job_id", job_id}};
    if (!job.output.empty()) digest["output"] = job.output;
    if (!job.figure.empty()) digest["figure"] = job.figure;
    if (!job.report.empty()) digest["report"] = job.report;
    digest.update(*result);
    print_json(digest);
  } else if (!context.json) {
    print_summary(*result, job.output, job_id);
    if (const auto numbers = report::experiment_text(text)) print_text("\n" + *numbers);
    if (!job.report.empty()) print_text("report written to " + job.report + "\n");
  }
  if (completed) return {};
  if (!job.output.empty()) context.details["output"] = job.output;
  return fail(ErrorKind::job_failed,
              "the scene was not completed: " + (*result)["reason"].get<std::string>() + "; " +
                  std::to_string((*result)["frames"].size()) + " frames before it are kept");
}

Expected<void> write_figure(const std::string& path, const std::string& result) {
  const auto svg = report::experiment_svg(result);
  if (!svg) return fail(svg.error().kind, "--figure: " + svg.error().message);
  return write_atomically(path, svg->data(), svg->size());
}

Expected<void> write_page(const std::string& path, const std::string& result) {
  const auto page = report::render_html(result);
  if (!page) return fail(page.error().kind, "--report: " + page.error().message);
  return write_atomically(path, page->data(), page->size());
}

/// The mesh file of the scene goes to the server, and its name into the scene.
Expected<void> send_mesh(client::Client& client, const Context& context, scene::SceneFile& scene,
                         Interrupt& interrupt) {
  if (scene.mesh_file.empty()) return {};
  ProgressDisplay display(std::cerr, isatty(STDERR_FILENO) == 1, terminal_width(STDERR_FILENO));
  const std::string what = "sending " + fs::path(scene.mesh_file).filename().string();
  const auto sent = client.upload_capture(
      scene.mesh_file,
      [&](const client::TransferProgress& p) {
        if (!context.quiet) display.show_transfer(what, p);
      },
      interrupt.token());
  if (!sent) {
    if (interrupt.interrupted())
      return fail(ErrorKind::cancelled, "stopped while sending " + scene.mesh_file +
                                            "; the same command goes on where it stopped");
    return tl::unexpected(about_file(scene.mesh_file, sent.error()));
  }
  scene.text = scene::with_stored_mesh(scene.text, sent->sha256);
  std::get<scene::FileMesh>(scene.scene.mesh).sha256 = sent->sha256;
  return {};
}

std::string specification(const scene::SceneFile& scene, const model::Model& model) {
  nlohmann::json spec = {{"schema", "tenter.job"}, {"version", 1}, {"kind", "simulate"}};
  spec["captures"] = nlohmann::json::array();
  const auto* file = std::get_if<scene::FileMesh>(&scene.scene.mesh);
  if (file != nullptr) spec["captures"].push_back(file->sha256);
  spec["scene"] = nlohmann::json::parse(scene.text);
  spec["model"] = nlohmann::json::parse(model::write_model(model));
  return spec.dump();
}

Expected<model::Model> model_of(const SceneJob& job, const scene::Scene& scene) {
  const std::string usual = !scene.model.empty()          ? scene.model
                            : scene::is_solid(scene.mesh) ? "solid_neo_hookean"
                                                          : "cloth_stvk";
  Expected<model::Model> model = load_model(job.model.empty() ? usual : job.model);
  if (!model) return model;
  for (const std::string& assignment : job.sets)
    if (auto set = set_parameter(*model, assignment); !set) return tl::unexpected(set.error());
  return model;
}

}  // namespace

Expected<scene::SceneFile> load_scene(const std::string& name_or_file) {
  std::error_code ignored;
  Expected<std::string> shipped = scene::example_json(name_or_file);
  if (shipped) {
    auto scene = scene::parse_scene(*shipped, name_or_file);
    if (!scene) return tl::unexpected(scene.error());
    return scene::SceneFile{std::move(*shipped), std::move(*scene), ""};
  }
  if (!fs::exists(name_or_file, ignored))
    return fail(ErrorKind::not_found,
                "there is no scene file '" + name_or_file + "', and " + shipped.error().message);
  return scene::read_scene_file(name_or_file);
}

Expected<void> set_parameter(model::Model& model, const std::string& assignment) {
  const std::size_t equal = assignment.find('=');
  const std::size_t dot = equal == std::string::npos ? equal : assignment.rfind('.', equal);
  if (dot == std::string::npos || dot == 0)
    return bad_input("--set " + assignment + ": must be TERM.PARAMETER=VALUE");
  const std::string id = assignment.substr(0, dot);
  const std::string name = assignment.substr(dot + 1, equal - dot - 1);
  const std::string text = assignment.substr(equal + 1);
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value))
    return bad_input("--set " + assignment + ": '" + text + "' is not a number");
  std::string known;
  for (model::Term& term : model.terms)
    for (model::Parameter& parameter : term.law.parameters) {
      if (term.id == id && parameter.name == name) {
        parameter.value = value;
        if (auto sound = model::validate(model); !sound)
          return fail(sound.error().kind, "--set " + assignment + ": " + sound.error().message);
        return {};
      }
      known += (known.empty() ? "" : ", ") + term.id + "." + parameter.name;
    }
  return bad_input("--set " + assignment + ": the model has no such parameter; it has " + known);
}

Expected<void> run_scene(Context& context, const SceneJob& job) {
  Expected<scene::SceneFile> scene = load_scene(job.scene);
  if (!scene) return tl::unexpected(scene.error());
  if (!job.figure.empty() && !scene->scene.experiment)
    return bad_input("--figure: the scene has no 'experiment' that says what to show");
  const Expected<model::Model> model = model_of(job, scene->scene);
  if (!model) return tl::unexpected(model.error());
  if (!job.output.empty())
    if (auto made = make_folder(job.output); !made) return made;

  Interrupt interrupt;
  auto client = context.connect();
  if (!client) return tl::unexpected(client.error());
  if (auto sent = send_mesh(*client, context, *scene, interrupt); !sent) return sent;
  const Expected<client::SubmitResult> submitted =
      submit_job(*client, specification(*scene, *model), job.submit);
  if (!submitted) return tl::unexpected(submitted.error());
  if (job.detach) {
    print_submitted(context, *submitted);
    return {};
  }
  const auto last = follow_job(*client, context, submitted->job_id, interrupt);
  if (!last) return tl::unexpected(last.error());
  const std::string keep =
      job.output.empty() ? "" : (fs::path(job.output) / "result.json").string();
  const Expected<std::string> result = fetch_result_text(*client, submitted->job_id, keep);
  if (!result) return tl::unexpected(result.error());
  if (!job.output.empty())
    if (auto files = fetch_files(*client, submitted->job_id, job.output); !files) return files;
  if (!job.figure.empty())
    if (auto drawn = write_figure(job.figure, *result); !drawn) return drawn;
  if (!job.report.empty())
    if (auto written = write_page(job.report, *result); !written) return written;
  return present(context, job, submitted->job_id, *result);
}

}  // namespace tenter::cli
