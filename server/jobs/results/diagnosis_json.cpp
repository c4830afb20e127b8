// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/results/diagnosis_json.h"

#include <nlohmann/json.hpp>

#include "common/model/document.h"
#include "server/diagnosis/verdicts/verdict_words.h"
#include "server/jobs/results/json_number.h"
#include "server/jobs/results/parameters_json.h"

namespace tenter::jobs {

using nlohmann::json;

namespace {

/// The proposed pull for machines: strains, rates and seconds.
json design_json(const diagnosis::Design& design) {
  const bool of_clips = design.plan.component == diagnosis::kWayOfClips;
  json steps = json::array();
  for (const diagnosis::ExperimentStep& step : design.plan.steps)
    steps.push_back(step.is_hold ? json{{"kind", "hold"}, {"seconds", step.seconds}}
                                 : json{{"kind", "ramp"},
                                        {"strain", number(step.strain)},
                                        {"rate_per_s", number(step.rate_per_s)}});
  return {
      {"mounted_as", design.mounted_as},
      {"component", diagnosis::name_of_component(design.plan)},
      {"steps", steps},
      {"duration_s", number(design.plan.duration_s())},
      {of_clips ? "largest_force_N" : "largest_force_N_m", number(design.separation.largest_force)},
      {"expected_separation", number(design.separation.of_noise())},
      {"pulls_considered", design.considered}};
}

json verdict_json(const diagnosis::Verdict& v) {
  json protocol = nullptr;
  if (v.next_protocol) {
    json phases = json::array();
    for (const auto& phase : v.next_protocol->phases)
      phases.push_back({{"kind", phase.kind}, {"words", phase.words}});
    protocol = {
        {"name", v.next_protocol->name}, {"words", v.next_protocol->words}, {"phases", phases}};
    if (v.design) protocol["design"] = design_json(*v.design);
  }
  json evidence = json::object();
  for (const auto& [name, value] : v.evidence) evidence[name] = number(value);
  const bool sized = v.kind != diagnosis::VerdictKind::not_excited &&
                     v.kind != diagnosis::VerdictKind::nothing_found;
  const bool has_interval = sized && v.size_hi > v.size_lo;
  return {{"verdict", diagnosis::verdict_name(v.kind)},
          {"effect", v.effect.empty() ? json(nullptr) : json(v.effect)},
          {"words", v.words},
          {"size", sized ? number(v.size) : json(nullptr)},
          {"interval",
           has_interval ? json::array({number(v.size_lo), number(v.size_hi)}) : json(nullptr)},
          {"p_value", v.p_value ? number(*v.p_value) : json(nullptr)},
          {"alternatives", v.alternatives},
          {"next_protocol", protocol},
          {"evidence", evidence}};
}

json verdicts_json(const std::vector<diagnosis::Verdict>& verdicts) {
  json list = json::array();
  for (const diagnosis::Verdict& v : verdicts) list.push_back(verdict_json(v));
  return list;
}

json screen_json(const diagnosis::Screen& screen) {
  json list = json::array();
  for (const diagnosis::ScreenRow& row : screen.table) {
    json grid = json::object();
    for (const auto& [address, value] : row.grid) grid[address] = number(value);
    list.push_back({{"effect", row.effect->id},
                    {"gain", number(row.gain)},
                    {"df", row.df},
                    {"ratio", number(row.ratio)},
                    {"status", row.status},
                    {"grid", grid}});
  }
  return list;
}

json path_json(const std::vector<diagnosis::PathStep>& path) {
  json list = json::array();
  for (const diagnosis::PathStep& step : path) {
    list.push_back({{"action", step.action},
                    {"effect", step.effect.empty() ? json(nullptr) : json(step.effect)},
                    {"why", step.why},
                    {"error", number(step.error)},
                    {"held_out", step.held_out ? number(*step.held_out) : json(nullptr)},
                    {"chi2", number(step.chi2)},
                    {"parameters", step.parameters},
                    {"bic", number(step.information)},
                    {"p_value", step.p_value ? number(*step.p_value) : json(nullptr)}});
  }
  return list;
}

json checklist_json(const std::vector<diagnosis::Check>& checklist) {
  json list = json::array();
  for (const diagnosis::Check& c : checklist)
    list.push_back({{"level", c.level}, {"what", c.what}, {"why", c.why}});
  return list;
}

json r2_json(const std::optional<diagnosis::Score>& score) {
  return score ? number(score->r2) : json(nullptr);
}

}  // namespace

json error_json(const std::optional<diagnosis::Score>& score) {
  return score ? number(score->error) : json(nullptr);
}

json findings_json(const std::string& kind, const diagnosis::Findings& d,
                   const diagnosis::Reference& baseline, const diagnosis::Reference& extended) {
  const estimation::FitResult& fit = extended.fit;
  return {{"schema", "tenter.result"},
          {"version", 1},
          {"kind", kind},
          {"verdicts", verdicts_json(d.verdicts)},
          {"noise_floor", number(d.noise_floor)},
          {"error_before", number(d.before.error)},
          {"error_after", number(d.after.error)},
          {"r2_before", number(d.before.r2)},
          {"r2_after", number(d.after.r2)},
          {"held_out_before", error_json(d.held_out_before)},
          {"held_out_after", error_json(d.held_out_after)},
          {"held_out_r2_before", r2_json(d.held_out_before)},
          {"held_out_r2_after", r2_json(d.held_out_after)},
          {"held_out_kind", d.held_out_kind.empty() ? json(nullptr) : json(d.held_out_kind)},
          {"unexplained_share", number(d.unexplained_share)},
          {"baseline_model", json::parse(model::write_model(baseline.model))},
          {"model", json::parse(model::write_model(extended.model))},
          {"screen", screen_json(d.first_screen)},
          {"path", path_json(d.path)},
          {"parameters", model_parameters_json(extended.model, fit.states)},
          {"checklist", checklist_json(d.checklist)},
          {"fit",
           {{"cost", number(fit.chi2)},
            {"iterations", fit.iterations},
            {"status", fit.converged ? "converged" : "not converged"},
            {"message", fit.message}}}};
}

}  // namespace tenter::jobs
