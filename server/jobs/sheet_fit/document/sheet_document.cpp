// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/document/sheet_document.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/model/document.h"
#include "common/model/export/curves.h"
#include "common/model/export/term_curve.h"
#include "common/model/usual_ranges.h"
#include "server/estimation/staged/splines/spline_refinement.h"
#include "server/estimation/uncertainty/caveats.h"
#include "server/jobs/results/json_number.h"
#include "server/jobs/sheet_fit/document/sheet_figures.h"
#include "server/jobs/sheet_fit/progress/stage_json.h"
#include "server/jobs/sheet_fit/requests/requests_json.h"

namespace tenter::jobs {
namespace {

using estimation::ObservationKind;
using estimation::ParameterState;
using nlohmann::json;

constexpr double kCorrelated = 0.9;
constexpr const char* kUnread = "the cord of a free clip was not measured";
constexpr const char* kSlack = "the capture says that the sheet is slack there";

double rms(double square, int rows) {
  return std::sqrt(square / rows);
}

/// Null where nothing of the kind was compared.
json errors_json(const Misfit& before, const Misfit& after) {
  if (after.rows == 0) return nullptr;
  const bool has_before = before.rows > 0;
  return {
      {"rows", after.rows},
      {"sigma", rms(after.sigma_square, after.rows)},
      {"rms_before", has_before ? json(rms(before.square, before.rows)) : json(nullptr)},
      {"rms_after", rms(after.square, after.rows)},
      {"before_sigmas", has_before ? json(rms(before.square_sigmas, before.rows)) : json(nullptr)},
      {"after_sigmas", rms(after.square_sigmas, after.rows)}};
}

json dropped_json(const SheetInput& input, const Prediction& after) {
  json list = json::array();
  for (const std::size_t frame : input.captured.use.dropped_frames)
    list.push_back({{"frame", input.capture.frame[frame]}, {"reason", kUnread}});
  for (const std::size_t frame : input.captured.use.slack_frames)
    list.push_back({{"frame", input.capture.frame[frame]}, {"reason", kSlack}});
  for (const estimation::RestlessFrame& frame : after.restless)
    list.push_back({{"frame", input.frame_number(static_cast<std::size_t>(frame.frame))},
                    {"reason", frame.reason}});
  return list;
}

json capture_json(const SheetFindings& found, std::size_t i) {
  const SheetInput& input = found.inputs[i];
  const auto errors = [&](ObservationKind kind) {
    return errors_json(misfit(input.sequence(), found.before[i], kind),
                       misfit(input.sequence(), found.after[i], kind));
  };
  const json force = errors(ObservationKind::force);
  const json position = errors(ObservationKind::position);
  json notes = {estimation::in_words(input.captured.use)};
  if (!found.before[i].restless.empty())
    notes.push_back("the starting model has no rest in " +
                    std::to_string(found.before[i].restless.size()) + " frames");
  const auto rows = [](const json& of) { return of.is_null() ? 0 : of["rows"].get<int>(); };
  return {{"id", input.id},
          {"title", input.capture.title},
          {"synthetic", input.capture.provenance.synthetic},
          {"specimen", input.capture.specimen.name},
          {"material", input.capture.specimen.material},
          {"licence", input.capture.provenance.licence},
          {"role", role_name(input.role)},
          {"held_out", input.held_out},
          {"weight", input.sequence().weight},
          {"frames", input.sequence().frames.size() - found.after[i].restless.size()},
          {"dropped", dropped_json(input, found.after[i])},
          {"points", input.captured.use.points},
          {"rows", rows(force) + rows(position)},
          {"notes", notes},
          {"force", force},
          {"position", position}};
}

json total_json(const SheetFindings& found, bool held_out) {
  json total;
  for (const auto& [key, kind] : {std::pair{"force", ObservationKind::force},
                                  std::pair{"position", ObservationKind::position}}) {
    Misfit before, after;
    for (std::size_t i = 0; i < found.inputs.size(); ++i) {
      if (found.inputs[i].held_out != held_out) continue;
      before += misfit(found.inputs[i].sequence(), found.before[i], kind);
      after += misfit(found.inputs[i].sequence(), found.after[i], kind);
    }
    total[key] = errors_json(before, after);
  }
  return total["force"].is_null() && total["position"].is_null() ? json(nullptr) : total;
}

json stage_json(const estimation::StageRecord& stage, const std::vector<std::string>& terms) {
  json at_bound = json::array(), without_effect = json::array(), flat = json::array();
  for (const auto& named : stage.not_free) {
    if (named.state == ParameterState::at_bound) at_bound.push_back(named.parameter);
    if (named.state == ParameterState::zero_gradient) without_effect.push_back(named.parameter);
    if (named.state == ParameterState::flat) flat.push_back(named.parameter);
  }
  json dropped = json::array();
  for (const auto& frame : stage.dropped)
    dropped.push_back(
        {{"capture", frame.sequence}, {"frame", frame.frame}, {"reason", frame.reason}});
  // a stage that solved no frame has no cost
  const auto cost = [&](double value) { return stage.rows > 0 ? number(value) : json(nullptr); };
  int points = 0;
  for (const auto& refinement : stage.refinements)
    if (refinement.kept) points = refinement.control_points;
  return {{"name", stage.name},
          {"terms", terms},
          {"done", stage.done},
          {"converged", stage.converged},
          {"message", stage.message},
          {"guessed", stage.guessed},
          {"guess_message", stage.guess_message},
          {"control_points", points > 0 ? json(points) : json(nullptr)},
          {"cost_at_start", cost(stage.cost_at_start)},
          {"cost_before", cost(stage.cost_before)},
          {"cost_after", cost(stage.cost_after)},
          {"rows", stage.rows},
          {"iterations", stage.iterations},
          {"at_bound", at_bound},
          {"zero_gradient", without_effect},
          {"flat", flat},
          {"dropped", dropped}};
}

/// Null where there is none.
json profile_json(const SheetFindings& found, std::size_t parameter) {
  const auto end = [](const std::optional<double>& value) {
    return value ? number(*value) : json(nullptr);
  };
  for (const estimation::Profile& profile : found.profiles)
    if (profile.parameter == static_cast<int>(parameter))
      return {{"word", estimation::words_of(profile.determined)},
              {"lo", end(profile.lo)},
              {"hi", end(profile.hi)},
              {"found_better", profile.found_better},
              {"fits", profile.fits},
              {"failed", profile.failed}};
  return nullptr;
}

/// Of a term that a stage held because its captures do not tell it, and no later one told.
bool is_held(const SheetFindings& found, const std::string& parameter) {
  const auto names = estimation::parameter_names(found.fitted);
  const auto all = estimation::parameters_of(found.fitted);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == parameter && !all[i]->fixed) return false;
  for (std::size_t s = 0; s < found.stages.size(); ++s) {
    const auto& terms = found.stage_terms[s];
    if (found.stages[s].held && std::find(terms.begin(), terms.end(),
                                          parameter.substr(0, parameter.rfind('.'))) != terms.end())
      return true;
  }
  return false;
}

json parameters_json(const SheetFindings& found) {
  json list = json::array();
  const auto names = estimation::parameter_names(found.fitted);
  const auto all = estimation::parameters_of(found.fitted);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const model::Parameter& p = *all[i];
    const bool has_interval = p.interval_lo && p.interval_hi;
    list.push_back(
        {{"name", names[i]},
         {"value", number(p.value)},
         {"unit", p.unit},
         {"std_error", p.std_error ? number(*p.std_error) : json(nullptr)},
         {"interval", has_interval ? json{*p.interval_lo, *p.interval_hi} : json(nullptr)},
         {"profile", profile_json(found, i)},
         {"held", is_held(found, names[i])},
         {"state", state_word(i < found.optimum.states.size() ? found.optimum.states[i]
                                                              : ParameterState::fixed)}});
  }
  return list;
}

json correlations_json(const SheetFindings& found) {
  json list = json::array();
  const auto names = estimation::parameter_names(found.fitted);
  const auto& correlation = found.optimum.correlation;
  for (Eigen::Index a = 0; a < correlation.rows(); ++a)
    for (Eigen::Index b = a + 1; b < correlation.cols(); ++b)
      if (std::abs(correlation(a, b)) > kCorrelated)
        list.push_back({{"a", names[static_cast<std::size_t>(a)]},
                        {"b", names[static_cast<std::size_t>(b)]},
                        {"value", correlation(a, b)}});
  return list;
}

/// What the starting model answered to these strains; null where its curve is not known.
json starting_curve(const model::Model& start, const model::CurveTable& curve) {
  for (const model::Term& term : start.terms) {
    if (term.id != curve.term) continue;
    const bool is_chosen =
        !estimation::is_spline(term.law) || term.law.range_hi > term.law.range_lo;
    const auto table = is_chosen ? model::TermCurve::of(term.law, model::Domain::membrane)
                                 : std::optional<model::TermCurve>();
    if (!table) return nullptr;
    json stress = json::array();
    for (const double strain : curve.strain)
      stress.push_back(number(table->stress(term.law, strain)));
    return stress;
  }
  return nullptr;
}

/// Samples that share the background's numbers share its curve, which the first of them tells.
bool is_told_already(const SheetFindings& found, const model::Term& term) {
  if (!found.requested.samples || term.support.name != "rbf") return false;
  const std::vector<int>& released = found.requested.samples->fit.released;
  const auto is_released = [&](int sample) {
    return std::find(released.begin(), released.end(), sample) != released.end();
  };
  int first = 0;
  while (is_released(first)) ++first;
  return !is_released(term.support.sample - 1) && term.support.sample - 1 != first;
}

json curves_json(const SheetFindings& found) {
  json list = json::array();
  for (const model::CurveTable& curve : model::curves_of(found.fitted, 61).curves) {
    const auto term = std::find_if(found.fitted.terms.begin(), found.fitted.terms.end(),
                                   [&](const model::Term& t) { return t.id == curve.term; });
    if (is_told_already(found, *term)) continue;
    const json reached =
        curve.reached ? json{curve.reached->first, curve.reached->second} : json(nullptr);
    const json points =
        estimation::is_spline(term->law) ? json(term->law.parameters.size()) : json(nullptr);
    json start = starting_curve(found.start, curve);
    list.push_back({{"term", curve.term},
                    {"law", term->law.name},
                    {"x", {{"name", curve.strain_measure}, {"unit", curve.strain_unit}}},
                    {"y", {{"name", "stress"}, {"unit", curve.stress_unit}}},
                    {"strain", curve.strain},
                    {"start", start.is_null() ? json::array() : start},
                    {"stress", curve.stress.value},
                    {"lo", curve.stress.lo},
                    {"hi", curve.stress.hi},
                    {"reached", reached},
                    {"control_points", points}});
  }
  return list;
}

json check(const char* level, const std::string& what, const std::string& why) {
  return {{"level", level}, {"what", what}, {"why", why}};
}

/// "at bound: weft.k": what a caveat is about.
std::string heading(const estimation::Caveat& caveat) {
  std::string words(estimation::words_of(caveat.kind));
  std::replace(words.begin(), words.end(), '_', ' ');
  return words + ": " + caveat.subject;
}

std::vector<estimation::DroppedFrames> dropped_frames(const SheetFindings& found) {
  std::vector<estimation::DroppedFrames> all;
  for (std::size_t i = 0; i < found.inputs.size(); ++i) {
    const SheetInput& input = found.inputs[i];
    std::vector<int> unread, slack, restless;
    for (const std::size_t frame : input.captured.use.dropped_frames)
      unread.push_back(input.capture.frame[frame]);
    for (const std::size_t frame : input.captured.use.slack_frames)
      slack.push_back(input.capture.frame[frame]);
    for (const estimation::RestlessFrame& frame : found.after[i].restless)
      restless.push_back(input.frame_number(static_cast<std::size_t>(frame.frame)));
    all.push_back({input.capture.title, unread, kUnread});
    all.push_back({input.capture.title, slack, kSlack});
    all.push_back({input.capture.title, restless, "the fitted model has no rest there"});
  }
  for (const estimation::StageRecord& stage : found.stages)
    for (const auto& frame : stage.dropped)
      all.push_back({frame.sequence + " in stage " + stage.name, {frame.frame}, frame.reason});
  return all;
}

/// "weft": stiffness that no garment has; rarely right.
void put_unusual(const model::Model& fitted, json& list) {
  for (const model::Term& term : fitted.terms) {
    const auto usual = model::usual_range(term);
    if (!usual) continue;
    for (const model::Parameter& p : term.law.parameters) {
      if (p.value >= usual->lo && p.value <= usual->hi) continue;
      char why[200];
      std::snprintf(why, sizeof why,
                    "%.3g %s; ten garment fabrics have %.2g to %.2g: right for what is no garment, "
                    "else look at units, scale and what the captures tell of it",
                    p.value, p.unit.c_str(), usual->lo, usual->hi);
      list.push_back(check("WARNING", "unusual: " + term.id + "." + p.name, why));
    }
  }
}

/// What a reader must not overlook: stages that were not done, captures without a rest, the fit's
/// own caveats, and how far the errors are from the noise.
json checklist_json(const SheetFindings& found) {
  json list = json::array();
  for (std::size_t i = 0; i < found.inputs.size(); ++i)
    if (found.after[i].restless.size() == found.inputs[i].sequence().frames.size())
      list.push_back(check("ERROR", "No frame of " + found.inputs[i].capture.title + " has a rest",
                           found.after[i].restless.front().reason));
  if (!found.optimum.usable)
    list.push_back(check("ERROR", "No intervals could be found", found.optimum.message));
  for (const auto& stage : found.stages)
    if (!stage.done)
      list.push_back(check("WARNING", "Stage " + stage.name + " was not done", stage.message));
  estimation::CaveatOptions limits;
  limits.correlation = kCorrelated;
  for (const estimation::Caveat& caveat : estimation::caveats(
           found.fitted, found.optimum, {}, found.profiles, dropped_frames(found), limits)) {
    if (caveat.kind == estimation::CaveatKind::frozen && is_held(found, caveat.subject)) {
      list.push_back(check("WARNING", "held: " + caveat.subject,
                           caveat.sentence + "; the captures do not tell it"));
      continue;
    }
    const bool is_wanted = caveat.kind == estimation::CaveatKind::frozen;  // by the document
    list.push_back(check(is_wanted ? "OK" : "WARNING", heading(caveat), caveat.sentence));
  }
  put_unusual(found.fitted, list);
  put_request_checks(found, list);
  const json fitted = total_json(found, false);
  for (const char* kind : {"force", "position"}) {
    if (fitted.is_null() || fitted[kind].is_null()) continue;
    const double sigmas = fitted[kind]["after_sigmas"].get<double>();
    char why[80];
    std::snprintf(why, sizeof why, "%.2g standard deviations of a reading", sigmas);
    list.push_back(check(sigmas > 2.0 ? "WARNING" : "OK",
                         std::string(kind) + " error against the noise", why));
  }
  return list;
}

}  // namespace

json sheet_document(const SheetFindings& found) {
  json captures = json::array();
  for (std::size_t i = 0; i < found.inputs.size(); ++i) captures.push_back(capture_json(found, i));
  json stages = json::array();
  int iterations = 0;
  bool all_done = true;
  for (std::size_t s = 0; s < found.stages.size(); ++s) {
    stages.push_back(stage_json(found.stages[s], found.stage_terms[s]));
    iterations += found.stages[s].iterations;
    all_done &= found.stages[s].done;
  }
  json document = {{"schema", "tenter.sheet_fit"},
                   {"version", 1},
                   {"kind", "fit"},
                   {"options", options_json(found.options)},
                   {"starting_model", json::parse(model::write_model(found.start))},
                   {"model", json::parse(model::write_model(found.fitted))},
                   {"captures", captures},
                   {"fitted", total_json(found, false)},
                   {"held_out", total_json(found, true)},
                   {"stages", stages},
                   {"parameters", parameters_json(found)},
                   {"correlations", correlations_json(found)},
                   {"curves", curves_json(found)},
                   {"figures", sheet_figures(found)},
                   {"meshes", sheet_meshes(found)},
                   {"checklist", checklist_json(found)},
                   {"fit",
                    {{"cost", number(found.stages.empty() ? NAN : found.stages.back().cost_after)},
                     {"iterations", iterations},
                     {"status", all_done ? "every stage done" : "not every stage done"},
                     {"message", found.stages.empty() ? "" : found.stages.back().message}}}};
  put_requests(found, document);
  return document;
}

}  // namespace tenter::jobs
