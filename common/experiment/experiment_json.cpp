// SPDX-License-Identifier: Apache-2.0
#include "common/experiment/experiment_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/experiment/curves.h"
#include "common/experiment/measures.h"
#include "common/experiment/moments.h"

namespace tenter::experiment {

namespace {

using nlohmann::json;

tl::unexpected<Error> about(const char* list, const std::string& id, const Error& error) {
  return fail(error.kind, std::string("experiment.") + list + " '" + id + "': " + error.message);
}

json picture_of(const scene::Picture& picture, const frames::FrameSet& run) {
  const auto frame = frame_at(run, picture.at);
  json points = json::array();
  const auto nodes = static_cast<std::size_t>(run.nodes);
  if (frame)
    for (std::size_t n = 0; n < nodes; ++n) {
      const auto x = vector_at(run.position_m, *frame * nodes + n);
      json point = json::array();
      for (const double v : x) point.push_back(std::round(1e6 * v) / 1e6);
      points.push_back(std::move(point));
    }
  json result = {{"title", picture.title},
                 {"eye", picture.eye},
                 {"up", picture.up},
                 {"position_m", std::move(points)}};
  if (frame && !run.time_s.empty()) result["time_s"] = run.time_s[*frame];
  return result;
}

json triangles_of(const frames::FrameSet& run) {
  json list = json::array();
  const frames::Elements* triangles = elements_of(run, "triangle");
  if (triangles == nullptr) return list;
  for (std::size_t t = 0; t < static_cast<std::size_t>(triangles->count()); ++t)
    list.push_back(
        {triangles->nodes[3 * t], triangles->nodes[3 * t + 1], triangles->nodes[3 * t + 2]});
  return list;
}

}  // namespace

Expected<json> experiment_json(const scene::Experiment& experiment,
                               const std::vector<FoundRun>& runs) {
  json measures = json::array();
  for (const scene::Measure& measure : experiment.measures)
    measures.push_back({{"id", measure.id}, {"words", measure.words}, {"unit", ""}});
  json found = json::array();
  for (const FoundRun& run : runs) {
    json one = {{"name", run.name},
                {"completed", run.reason.empty()},
                {"reason", run.reason.empty() ? json(nullptr) : json(run.reason)},
                {"measures", json::object()},
                {"curves", json::array()},
                {"pictures", json::array()}};
    for (std::size_t m = 0; m < experiment.measures.size(); ++m) {
      const scene::Measure& measure = experiment.measures[m];
      const auto value = measured(measure, *run.frames, *runs.front().frames);
      if (!value) return about("measures", measure.id, value.error());
      if (!value->unit.empty()) measures[m]["unit"] = value->unit;
      one["measures"][measure.id] = value->number ? json(*value->number) : json(nullptr);
    }
    for (const scene::Curve& curve : experiment.curves) {
      const auto line = line_of(curve, *run.frames);
      if (!line) return about("curves", curve.id, line.error());
      one["curves"].push_back(
          {{"id", curve.id},
           {"words", curve.words},
           {"x", {{"name", line->x_name}, {"unit", line->x_unit}, {"values", line->x}}},
           {"y", {{"name", line->y_name}, {"unit", line->y_unit}, {"values", line->y}}}});
    }
    for (const scene::Picture& picture : experiment.pictures)
      one["pictures"].push_back(picture_of(picture, *run.frames));
    if (!experiment.pictures.empty()) one["triangles"] = triangles_of(*run.frames);
    found.push_back(std::move(one));
  }
  return json{{"measures", std::move(measures)}, {"runs", std::move(found)}};
}

}  // namespace tenter::experiment
