// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/results/result_document.h"

#include <nlohmann/json.hpp>

#include "common/model/document.h"
#include "server/jobs/results/diagnosis_json.h"
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
  const estimation::FitResult& fit = d.extended.fit;
  return {{"schema", "tenter.result"},
          {"version", 1},
          {"kind", kind},
          {"verdicts", verdicts_json(d.verdicts)},
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
          {"path", path_json(d.path)},
          {"parameters", model_parameters_json(d.extended.model, d.extended.fit.states)},
          {"checklist", checklist_json(d.checklist)},
          {"figures", figures_json(d)},
          {"fit",
           {{"cost", number(fit.chi2)},
            {"iterations", fit.iterations},
            {"status", fit.converged ? "converged" : "not converged"},
            {"message", fit.message}}}};
}

}  // namespace tenter::jobs
