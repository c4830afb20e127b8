// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/results/run_job.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "common/base/atomic_write.h"
#include "common/capture/file/capture_file.h"
#include "common/capture/strips/strip_profiles.h"
#include "common/model/document.h"
#include "server/diagnosis/diagnose.h"
#include "server/diagnosis/effect.h"
#include "server/jobs/friction_test/run_friction_test.h"
#include "server/jobs/results/result_document.h"
#include "server/jobs/scene/run_scene.h"
#include "server/jobs/sheet_diagnosis/run_sheet_diagnosis.h"
#include "server/jobs/sheet_fit/run_sheet_fit.h"

namespace tenter::jobs {
namespace {

using nlohmann::json;

/// A whole number of the options, within bounds; the option's default where it is absent.
template <class T>
Expected<void> read_number(const json& options, const char* key, long long lo, long long hi,
                           T& value) {
  if (!options.contains(key)) return {};
  const json& given = options[key];
  if (!given.is_number_integer() || given.get<long long>() < lo || given.get<long long>() > hi)
    return bad_input(std::string("options.") + key + ": must be a whole number from " +
                     std::to_string(lo) + " to " + std::to_string(hi) + ", not " + given.dump());
  value = static_cast<T>(given.get<long long>());
  return {};
}

/// A limit of the rig, above zero; the option's default where it is absent.
Expected<void> read_limit(const json& options, const char* key, double& value) {
  if (!options.contains(key)) return {};
  const json& given = options[key];
  if (!given.is_number() || !(given.get<double>() > 0.0))
    return bad_input(std::string("options.") + key + ": must be a number above zero, not " +
                     given.dump());
  value = given.get<double>();
  return {};
}

/// Of sheets there are others, which are read where sheets are.
Expected<diagnosis::Options> read_options(const json& spec, bool of_sheets = false) {
  diagnosis::Options options;
  if (!spec.contains("options") || spec["options"].is_null()) return options;
  const json& given = spec["options"];
  if (!given.is_object()) return bad_input("options: must be an object");
  for (const auto& [key, value] : given.items())
    if (!is_diagnosis_option(key) && !of_sheets)
      return bad_input("options." + key + ": no such option");
  for (Expected<void> read :
       {read_number(given, "seed", 0, 1LL << 53, options.seed),
        read_number(given, "null_twins", 100, 100000, options.null_twins),
        read_number(given, "max_effects", 0, 20, options.max_effects),
        read_number(given, "max_frames_per_block", 10, 100000, options.max_frames_per_block)})
    if (!read) return tl::unexpected(read.error());
  for (Expected<void> read : {read_limit(given, "rig_strain", options.rig.largest_strain),
                              read_limit(given, "rig_N_m", options.rig.largest_N_m),
                              read_limit(given, "rig_N", options.rig.largest_N),
                              read_limit(given, "rig_rate_per_s", options.rig.fastest_per_s),
                              read_limit(given, "rig_seconds", options.rig.longest_s)})
    if (!read) return tl::unexpected(read.error());
  if (given.contains("effects")) {
    const json& ids = given["effects"];
    if (!ids.is_array()) return bad_input("options.effects: must be a list of ids of effects");
    for (const json& id : ids) {
      if (!id.is_string() || diagnosis::find_effect(id.get<std::string>()) == nullptr)
        return bad_input("options.effects: " + id.dump() +
                         " is no effect that a model can be extended by (tenter effects list)");
      options.effects.push_back(id.get<std::string>());
    }
  }
  if (given.contains("leave_out")) {
    static const std::set<std::string> kKinds = {"auto", "protocols", "repeats",
                                                 "runs", "blocks",    "none"};
    const json& kind = given["leave_out"];
    if (!kind.is_string() || !kKinds.contains(kind.get<std::string>()))
      return bad_input(
          "options.leave_out: must be auto, protocols, repeats, runs, blocks or none, not " +
          kind.dump());
    options.leave_out = kind.get<std::string>();
  }
  return options;
}

using Captures = std::vector<std::pair<std::string, capture::Capture>>;

Expected<Captures> read_captures(const JobInput& input) {
  Captures captures;
  for (const auto& [sha, path] : input.captures) {
    auto capture = capture::read_capture_guarded(path.string());
    if (!capture) return tl::unexpected(capture.error());
    captures.emplace_back(sha, std::move(*capture));
  }
  return captures;
}

/// Whether the captures are those of a sheet; refused where only some are, or a sheet is not to be
/// fitted.
Expected<bool> are_sheets(const Captures& captures, const std::string& kind) {
  const auto is_sheet = [](const auto& entry) { return entry.second.sheet.has_value(); };
  const auto sheets = std::count_if(captures.begin(), captures.end(), is_sheet);
  if (sheets == 0) return false;
  if (sheets != static_cast<std::ptrdiff_t>(captures.size()))
    return bad_input("captures: some are of a deforming sheet and some are not; fit them apart");
  if (kind == "simulate")
    return bad_input(
        "captures: those of a deforming sheet can be fitted and diagnosed; simulate does not take "
        "them");
  return true;
}

bool has_protocol(const json& spec) {
  return spec.contains("options") && spec["options"].is_object() &&
         spec["options"].contains("protocol");
}

bool goes_on(const json& spec) {
  return spec.contains("options") && spec["options"].is_object() &&
         spec["options"].contains("continues");
}

/// Of captures that a diagnosis goes on with, those without time cannot speak of rates beside those
/// with: titles of what was taken out.
std::vector<std::string> set_aside_timeless(Captures& captures) {
  const auto has_time = [](const auto& entry) { return !entry.second.time_s.empty(); };
  std::vector<std::string> titles;
  if (std::none_of(captures.begin(), captures.end(), has_time)) return titles;
  for (const auto& entry : captures)
    if (!has_time(entry)) titles.push_back(entry.second.title);
  std::erase_if(captures, [&](const auto& entry) { return !has_time(entry); });
  return titles;
}

Expected<diagnosis::Request> read_request(Captures captures, const json& spec) {
  diagnosis::Request request;
  auto model = model::parse_model(spec.at("model").dump(), "model");
  if (!model) return tl::unexpected(model.error());
  request.model = std::move(*model);
  auto options = read_options(spec);
  if (!options) return tl::unexpected(options.error());
  request.options = *options;
  request.captures = std::move(captures);
  return request;
}

Expected<diagnosis::Diagnosis> compute(const std::string& kind, diagnosis::Request& request,
                                       const diagnosis::Control& control) {
  if (kind == "diagnose") return diagnosis::diagnose(request, control);
  if (kind == "simulate")
    for (model::Parameter* p : estimation::parameters_of(request.model)) p->fixed = true;
  return diagnosis::fit_only(request, control);
}

}  // namespace

Expected<void> run_job(const JobInput& input, const std::function<void(const JobProgress&)>& report,
                       const std::stop_token& stop) {
  const json spec = json::parse(input.spec_json, nullptr, false);
  if (spec.is_discarded() || !spec.is_object() || !spec.contains("kind") || !spec.contains("model"))
    return bad_input("the job's specification is not a tenter.job document");
  const std::string kind = spec["kind"].get<std::string>();
  if (spec.contains("scene")) return run_scene(input, spec, report, stop);
  report({"read", std::to_string(input.captures.size()) + " captures", 0, 0.0, 0.01});
  auto captures = read_captures(input);
  if (!captures) return tl::unexpected(captures.error());
  const auto sheets = are_sheets(*captures, kind);
  if (!sheets) return tl::unexpected(sheets.error());
  if (*sheets && kind == "diagnose") {
    const auto options = read_options(spec, true);
    if (!options) return tl::unexpected(options.error());
    return run_sheet_diagnosis(input, spec, *options, std::move(*captures), report, stop);
  }
  if (*sheets) return run_sheet_fit(input, spec, std::move(*captures), report, stop);
  if (has_protocol(spec)) {
    if (kind != "fit") return bad_input("options.protocol: only a fit has one");
    return run_friction_test(input, spec, std::move(*captures), report, stop);
  }
  for (const auto& [id, capture] : *captures)
    if (capture.kind == capture::kStripsKind)
      return bad_input("capture \"" + capture.title +
                       "\": strips are fitted with options.protocol spiral or cantilever");
  std::vector<std::string> timeless;
  if (goes_on(spec)) timeless = set_aside_timeless(*captures);
  auto request = read_request(std::move(*captures), spec);
  if (!request) return tl::unexpected(request.error());

  diagnosis::Control control;
  control.stop = stop;
  control.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  control.report = [&](const diagnosis::Progress& p) {
    report({p.stage, p.detail, p.iteration, p.cost, p.fraction});
  };
  auto found = compute(kind, *request, control);
  if (!found) return tl::unexpected(found.error());

  report({"write", "", 0, 0.0, 0.98});
  for (const std::string& title : timeless)
    found->checklist.push_back(
        {"WARNING", "set aside: " + title, "it has no time, and what it is continued with has"});
  json document = result_document(*found, *request, kind);
  if (goes_on(spec)) document["continues"] = spec["options"]["continues"];
  const std::string text = document.dump(1) + "\n";
  if (auto written =
          write_atomically((input.staging / "result.json").string(), text.data(), text.size());
      !written)
    return written;
  return report::write_residuals(residual_tables(*found),
                                 (input.staging / "residuals.h5").string());
}

}  // namespace tenter::jobs
