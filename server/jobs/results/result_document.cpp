// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/results/result_document.h"

#include <nlohmann/json.hpp>

#include "server/jobs/results/diagnosis_json.h"
#include "server/jobs/results/json_number.h"
#include "server/jobs/results/result_figures.h"

namespace tenter::jobs {
namespace {

using diagnosis::Diagnosis;
using nlohmann::json;

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
                    {"held_out_before", error_json(score.held_out_before)},
                    {"held_out_after", error_json(score.held_out_after)},
                    {"channels", channels}});
  }
  return list;
}

}  // namespace

json result_document(const Diagnosis& d, const diagnosis::Request& request,
                     const std::string& kind) {
  json document = findings_json(kind, d, d.baseline, d.extended);
  document["captures"] = captures_json(d, request);
  document["figures"] = figures_json(d);
  return document;
}

}  // namespace tenter::jobs
