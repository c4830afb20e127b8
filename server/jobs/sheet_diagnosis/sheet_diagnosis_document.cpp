// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_diagnosis/sheet_diagnosis_document.h"

#include <nlohmann/json.hpp>

#include "server/jobs/results/diagnosis_json.h"
#include "server/jobs/results/json_number.h"
#include "server/jobs/sheet_fit/document/sheet_figures.h"

namespace tenter::jobs {
namespace {

using estimation::ObservationKind;
using nlohmann::json;

const char* kind_word(ObservationKind kind) {
  return kind == ObservationKind::position ? "points"
         : kind == ObservationKind::force  ? "forces"
                                           : "others";
}

/// Fitted sequences come first among the scores, then those held out.
const diagnosis::SheetScore* score_of(const diagnosis::SheetDiagnosis& d, const std::string& id) {
  for (std::size_t s = 0; s < d.data.ids.size() && s < d.scores.size(); ++s)
    if (d.data.ids[s] == id) return &d.scores[s];
  for (std::size_t s = 0; s < d.held_out.ids.size(); ++s)
    if (d.held_out.ids[s] == id && d.data.ids.size() + s < d.scores.size())
      return &d.scores[d.data.ids.size() + s];
  return nullptr;
}

json channels_json(const diagnosis::SheetDiagnosis& d, const std::string& id, std::string& words) {
  json list = json::array();
  for (const diagnosis::FieldNoise::Kind& kind : d.noise.kinds) {
    if (d.data.ids[static_cast<std::size_t>(kind.sequence)] != id || kind.rows == 0) continue;
    words = estimation::noise_source_words(kind.source);
    list.push_back({{"name", kind_word(kind.kind)},
                    {"unit", kind.kind == ObservationKind::position ? "m" : "N"},
                    {"sigma", number(kind.stated * kind.factor)},
                    {"sigma_source", words}});
  }
  return list;
}

json captures_json(const diagnosis::SheetDiagnosis& d, const SheetFindings& found) {
  json list = json::array();
  for (const SheetInput& input : found.inputs) {
    const diagnosis::SheetScore* score = score_of(d, input.id);
    std::string noise_words;
    const json channels = channels_json(d, input.id, noise_words);
    int blocks = 0;
    for (const auto& frame : input.sequence().frames) blocks = std::max(blocks, frame.block + 1);
    const auto figure = [&](double diagnosis::Score::*part, bool after, bool held_out) {
      if (score == nullptr || score->held_out != held_out) return json(nullptr);
      return number((after ? score->after : score->before).*part);
    };
    list.push_back({{"id", input.id},
                    {"title", input.capture.title},
                    {"synthetic", input.capture.provenance.synthetic},
                    {"specimen", input.capture.specimen.name},
                    {"material", input.capture.specimen.material},
                    {"licence", input.capture.provenance.licence},
                    {"source", input.capture.provenance.source},
                    {"held_out", input.held_out},
                    {"frames", input.sequence().frames.size()},
                    {"blocks", blocks},
                    {"points", input.captured.use.points},
                    {"notes", json::array({estimation::in_words(input.captured.use)})},
                    {"noise_floor", score ? number(score->noise_floor) : json(nullptr)},
                    {"noise_source", noise_words},
                    {"error_before", figure(&diagnosis::Score::error, false, false)},
                    {"error_after", figure(&diagnosis::Score::error, true, false)},
                    {"held_out_before", figure(&diagnosis::Score::error, false, true)},
                    {"held_out_after", figure(&diagnosis::Score::error, true, true)},
                    {"points_before_m", score ? number(score->points_before_m) : json(nullptr)},
                    {"points_after_m", score ? number(score->points_after_m) : json(nullptr)},
                    {"channels", channels}});
  }
  return list;
}

json structure_json(const diagnosis::SheetDiagnosis& d,
                    const std::vector<diagnosis::Structure>& structure) {
  json list = json::array();
  for (const diagnosis::Structure& s : structure) {
    if (s.rows == 0) continue;
    list.push_back({{"capture", d.data.ids[static_cast<std::size_t>(s.sequence)]},
                    {"kind", kind_word(s.kind)},
                    {"rows", s.rows},
                    {"independent", number(s.independent)},
                    {"chi2", number(s.chi2)},
                    {"in_time", number(s.in_time)},
                    {"neighbours", number(s.neighbours)},
                    {"fixed_to_material", number(s.fixed)},
                    {"at_free_edges", number(s.at_edges)},
                    {"with_place_in_space", number(s.with_place)}});
  }
  return list;
}

}  // namespace

json sheet_diagnosis_document(const diagnosis::SheetDiagnosis& d, const SheetFindings& found) {
  json document = findings_json("diagnose", d, d.baseline.at, d.extended.at);
  document["captures"] = captures_json(d, found);
  document["figures"] = sheet_figures(found);
  document["meshes"] = sheet_meshes(found);
  document["structure"] = {{"before", structure_json(d, d.structure)},
                           {"after", structure_json(d, d.structure_left)}};
  return document;
}

}  // namespace tenter::jobs
