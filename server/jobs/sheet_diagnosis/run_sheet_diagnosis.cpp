// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_diagnosis/run_sheet_diagnosis.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "common/base/atomic_write.h"
#include "common/model/document.h"
#include "server/diagnosis/field/diagnose_sheet.h"
#include "server/jobs/sheet_diagnosis/sheet_diagnosis_document.h"
#include "server/jobs/sheet_fit/document/sheet_residuals.h"

namespace tenter::jobs {
namespace {

using nlohmann::json;

/// The options of a sheet among those of the job.
json sheet_part(const json& given) {
  json part = json::object();
  if (given.is_object())
    for (const auto& [key, value] : given.items())
      if (!is_diagnosis_option(key)) part[key] = value;
  part["staged"] = false;  // one joint fit
  return part;
}

bool states_positions(const capture::Sheet& sheet) {
  return sheet.sigma_m > 0.0 || !sheet.sigma_per_vertex_m.empty();
}

bool states_forces(const capture::Sheet& sheet) {
  return std::ranges::all_of(sheet.cords, [](const auto& cord) { return cord.sigma_N > 0.0; });
}

/// Noise that a capture does not state stands to what was measured as a rig's would, until readings
/// show theirs.
void guess_noise(const std::vector<std::pair<std::string, capture::Capture>>& captures,
                 SheetFitOptions& options) {
  constexpr double kOfSize = 2e-4, kOfLargest = 5e-3;
  for (const auto& [id, capture] : captures) {
    if (!capture.sheet) continue;
    if (options.sigma_m == 0.0 && !states_positions(*capture.sheet)) {
      Eigen::AlignedBox2d box;
      for (const auto& place : capture.sheet->material_m)
        box.extend(Eigen::Vector2d(place[0], place[1]));
      options.sigma_m = kOfSize * box.diagonal().norm();
    }
    if (options.sigma_N > 0.0 || states_forces(*capture.sheet)) continue;
    double largest_N = 0.0;
    for (const capture::CordTrack& cord : capture.sheet->cords)
      for (const double tension : cord.tension_N) largest_N = std::fmax(largest_N, tension);
    if (largest_N > 0.0) options.sigma_N = kOfLargest * largest_N;
  }
}

/// `guessed`: of positions, of all else, what does not state its noise has a guess.
diagnosis::SheetRequest request_of(const SheetFindings& found, const diagnosis::Options& options,
                                   const std::array<bool, 2>& guessed) {
  diagnosis::SheetRequest request;
  request.model = found.start;
  request.options = options;
  for (const SheetInput& input : found.inputs) {
    const capture::Sheet& sheet = *input.capture.sheet;
    request.sequences.push_back(
        {input.id,
         input.capture.title,
         input.role,
         input.sequence(),
         input.held_out,
         input.finer,
         !input.sequence().cloth.mesh.triangle_layer.empty(),
         {guessed[0] && !states_positions(sheet), guessed[1] && !states_forces(sheet)}});
  }
  return request;
}

}  // namespace

bool is_diagnosis_option(const std::string& key) {
  static const std::set<std::string> kOwn = {
      "seed",      "null_twins",     "max_effects", "max_frames_per_block",
      "leave_out", "effects",        "rig_strain",  "rig_N_m",
      "rig_N",     "rig_rate_per_s", "rig_seconds", "continues"};
  return kOwn.contains(key);
}

Expected<void> run_sheet_diagnosis(const JobInput& input, const json& spec,
                                   const diagnosis::Options& options,
                                   std::vector<std::pair<std::string, capture::Capture>> captures,
                                   const std::function<void(const JobProgress&)>& report,
                                   const std::stop_token& stop) {
  SheetFindings found;
  auto start = model::parse_model(spec.at("model").dump(), "model");
  if (!start) return tl::unexpected(start.error());
  found.start = std::move(*start);
  std::vector<std::string> ids;
  ids.reserve(captures.size());
  for (const auto& [id, capture] : captures) ids.push_back(id);
  auto read = read_sheet_options(sheet_part(spec.value("options", json::object())), ids);
  if (!read) return tl::unexpected(read.error());
  found.options = std::move(*read);
  if (has_springs(found.start)) found.options.has_graded_grid = false;
  // a material is blamed after the grid; equal cells, as springs need, tell nothing of a finer one
  if (!spec.value("options", json::object()).contains("without_grid_error"))
    found.options.without_grid_error = found.options.has_graded_grid;
  const std::array<bool, 2> may_guess = {found.options.sigma_m == 0.0,
                                         found.options.sigma_N == 0.0};
  guess_noise(captures, found.options);
  report({"prepare", std::to_string(ids.size()) + " captures", 0, 0.0, 0.01});
  auto inputs = sheet_inputs(std::move(captures), found.options);
  if (!inputs) return tl::unexpected(inputs.error());
  found.inputs = std::move(*inputs);

  diagnosis::Control control;
  control.stop = stop;
  control.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  control.report = [&](const diagnosis::Progress& p) {
    report({p.stage, p.detail, p.iteration, p.cost, p.fraction});
  };
  const diagnosis::SheetRequest request = request_of(found, options, may_guess);
  auto diagnosis = diagnosis::diagnose_sheets(request, control);
  if (!diagnosis) return tl::unexpected(diagnosis.error());

  report({"compare", "both models", 0, 0.0, 0.96});
  found.start = diagnosis->baseline.at.model;
  found.fitted = diagnosis->extended.at.model;
  auto before = predictions(found.start, found.inputs, control.threads, stop);
  if (!before) return tl::unexpected(before.error());
  auto after = predictions(found.fitted, found.inputs, control.threads, stop);
  if (!after) return tl::unexpected(after.error());
  found.before = std::move(*before);
  found.after = std::move(*after);

  report({"write", "", 0, 0.0, 0.98});
  json document = sheet_diagnosis_document(*diagnosis, found);
  if (spec.contains("options") && spec["options"].contains("continues"))
    document["continues"] = spec["options"]["continues"];
  const std::string text = document.dump(1) + "\n";
  if (auto written =
          write_atomically((input.staging / "result.json").string(), text.data(), text.size());
      !written)
    return written;
  return report::write_residuals(sheet_residual_tables(found),
                                 (input.staging / "residuals.h5").string(),
                                 sheet_vertex_residuals(found));
}

}  // namespace tenter::jobs
