// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_diagnosis/run_sheet_diagnosis.h"

#include <algorithm>
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

diagnosis::SheetRequest request_of(const SheetFindings& found, const diagnosis::Options& options) {
  diagnosis::SheetRequest request;
  request.model = found.start;
  request.options = options;
  for (const SheetInput& input : found.inputs)
    request.sequences.push_back({input.id, input.capture.title, input.role, input.sequence(),
                                 input.held_out, input.finer,
                                 !input.sequence().cloth.mesh.triangle_layer.empty()});
  return request;
}

}  // namespace

bool is_diagnosis_option(const std::string& key) {
  static const std::set<std::string> kOwn = {
      "seed",       "null_twins", "max_effects",    "max_frames_per_block", "leave_out", "effects",
      "rig_strain", "rig_N_m",    "rig_rate_per_s", "rig_seconds",          "continues"};
  return kOwn.contains(key);
}

Expected<void> run_sheet_diagnosis(const JobInput& input, const json& spec,
                                   const diagnosis::Options& options,
                                   std::vector<std::pair<std::string, capture::Capture>> captures,
                                   const std::function<void(const JobProgress&)>& report,
                                   const std::stop_token& stop) {
  for (const char* limit : {"rig_strain", "rig_N_m", "rig_rate_per_s", "rig_seconds"})
    if (spec.contains("options") && spec["options"].contains(limit))
      return bad_input(std::string("options.") + limit +
                       ": the next capture of a sheet is proposed in words, which know no limits");
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
  const diagnosis::SheetRequest request = request_of(found, options);
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
