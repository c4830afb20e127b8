// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/results/diagnosis_json.h"

#include <nlohmann/json.hpp>

#include "server/diagnosis/verdicts.h"
#include "server/jobs/results/json_number.h"

namespace tenter::jobs {

using nlohmann::json;

namespace {

/// The proposed pull for machines: strains, rates and seconds.
json design_json(const diagnosis::Design& design) {
  json steps = json::array();
  for (const diagnosis::ExperimentStep& step : design.plan.steps)
    steps.push_back(step.is_hold ? json{{"kind", "hold"}, {"seconds", step.seconds}}
                                 : json{{"kind", "ramp"},
                                        {"strain", number(step.strain)},
                                        {"rate_per_s", number(step.rate_per_s)}});
  return {{"mounted_as", design.mounted_as},
          {"component", estimation::component_name(design.plan.component)},
          {"steps", steps},
          {"duration_s", number(design.plan.duration_s())},
          {"largest_force_N_m", number(design.separation.largest_N_m)},
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

}  // namespace

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

}  // namespace tenter::jobs
