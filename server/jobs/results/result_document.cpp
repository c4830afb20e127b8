// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/results/result_document.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "common/model/document.h"
#include "server/diagnosis/verdicts.h"
#include "server/jobs/results/json_number.h"
#include "server/jobs/results/result_figures.h"

namespace tenter::jobs {
namespace {

using diagnosis::Diagnosis;
using nlohmann::json;

template <class T>
json maybe(const std::optional<T>& value) {
  return value ? json(*value) : json(nullptr);
}

json error_of(const std::optional<diagnosis::Score>& score) {
  return score ? number(score->error) : json(nullptr);
}
json r2_of(const std::optional<diagnosis::Score>& score) {
  return score ? number(score->r2) : json(nullptr);
}

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

json captures_json(const Diagnosis& d, const diagnosis::Request& request) {
  json list = json::array();
  for (std::size_t i = 0; i < d.curves.size(); ++i) {
    const estimation::Curves& curves = d.curves[i];
    const capture::Capture& capture = request.captures[i].second;
    const diagnosis::CaptureScore& score = d.captures[i];
    json channels = json::array();
    std::string noise_words;
    for (std::size_t c = 0; c < curves.channels.size(); ++c) {
      const estimation::ChannelNoise& noise = d.noise.channels[i][c];
      noise_words = estimation::noise_source_words(noise.source);
      channels.push_back({{"name", curves.channels[c].name},
                          {"unit", curves.channels[c].unit},
                          {"sigma", number(noise.sigma)},
                          {"sigma_source", noise_words}});
    }
    list.push_back({{"id", curves.id},
                    {"title", curves.title},
                    {"synthetic", capture.provenance.synthetic},
                    {"specimen", capture.specimen.name},
                    {"material", capture.specimen.material},
                    {"licence", capture.provenance.licence},
                    {"source", capture.provenance.source},
                    {"frames", curves.frame_count()},
                    {"blocks", curves.blocks.size()},
                    {"noise_floor", number(score.noise_floor)},
                    {"noise_source", noise_words},
                    {"error_before", number(score.before.error)},
                    {"error_after", number(score.after.error)},
                    {"held_out_before", error_of(score.held_out_before)},
                    {"held_out_after", error_of(score.held_out_after)},
                    {"channels", channels}});
  }
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

json path_json(const Diagnosis& d) {
  json list = json::array();
  for (const diagnosis::PathStep& step : d.path) {
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

const char* state_word(estimation::ParameterState state) {
  switch (state) {
    case estimation::ParameterState::free:
      return "free";
    case estimation::ParameterState::fixed:
      return "fixed";
    case estimation::ParameterState::at_bound:
      return "at_bound";
    case estimation::ParameterState::zero_gradient:
      return "zero_gradient";
    case estimation::ParameterState::flat:
      return "flat";
  }
  return "";
}

}  // namespace

json model_parameters_json(const model::Model& model,
                           const std::vector<estimation::ParameterState>& states) {
  json list = json::array();
  const auto names = estimation::parameter_names(model);
  const auto all = estimation::parameters_of(model);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const model::Parameter& p = *all[i];
    list.push_back({{"name", names[i]},
                    {"value", number(p.value)},
                    {"unit", p.unit},
                    {"std_error", maybe(p.std_error)},
                    {"interval",
                     p.interval_lo ? json::array({*p.interval_lo, *p.interval_hi}) : json(nullptr)},
                    {"state", state_word(states[i])}});
  }
  return list;
}

json result_document(const Diagnosis& d, const diagnosis::Request& request,
                     const std::string& kind) {
  json verdicts = json::array();
  for (const diagnosis::Verdict& v : d.verdicts) verdicts.push_back(verdict_json(v));
  json checklist = json::array();
  for (const diagnosis::Check& c : d.checklist)
    checklist.push_back({{"level", c.level}, {"what", c.what}, {"why", c.why}});
  const estimation::FitResult& fit = d.extended.fit;
  return {{"schema", "tenter.result"},
          {"version", 1},
          {"kind", kind},
          {"verdicts", verdicts},
          {"noise_floor", number(d.noise_floor)},
          {"error_before", number(d.before.error)},
          {"error_after", number(d.after.error)},
          {"r2_before", number(d.before.r2)},
          {"r2_after", number(d.after.r2)},
          {"held_out_before", error_of(d.held_out_before)},
          {"held_out_after", error_of(d.held_out_after)},
          {"held_out_r2_before", r2_of(d.held_out_before)},
          {"held_out_r2_after", r2_of(d.held_out_after)},
          {"held_out_kind", d.held_out_kind.empty() ? json(nullptr) : json(d.held_out_kind)},
          {"unexplained_share", number(d.unexplained_share)},
          {"baseline_model", json::parse(model::write_model(d.baseline.model))},
          {"model", json::parse(model::write_model(d.extended.model))},
          {"captures", captures_json(d, request)},
          {"screen", screen_json(d.first_screen)},
          {"path", path_json(d)},
          {"parameters", model_parameters_json(d.extended.model, d.extended.fit.states)},
          {"checklist", checklist},
          {"figures", figures_json(d)},
          {"fit",
           {{"cost", number(fit.chi2)},
            {"iterations", fit.iterations},
            {"status", fit.converged ? "converged" : "not converged"},
            {"message", fit.message}}}};
}

}  // namespace tenter::jobs
