// SPDX-License-Identifier: Apache-2.0
#include "common/experiment/curves.h"

#include <array>
#include <cmath>
#include <map>

#include "common/experiment/moments.h"

namespace tenter::experiment {

namespace {

using frames::FrameSet;
using scene::Curve;

std::array<double, 3> unit_vector(const std::array<double, 3>& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

Expected<Line> force_travel(const Curve& curve, const FrameSet& run) {
  Line line{"travel", "m", "force", "N", {}, {}};
  const auto clip = clip_index(run, curve.clip);
  if (!clip) return line;
  const std::array<double, 3> along = unit_vector(curve.direction);
  const std::size_t clips = run.clips.size();
  const auto start = vector_at(run.clip_position_m, *clip);
  for (std::size_t f = 0; f < static_cast<std::size_t>(run.frame_count()); ++f) {
    const auto x = vector_at(run.clip_position_m, f * clips + *clip);
    const auto force = vector_at(run.force_N, f * clips + *clip);
    double travel = 0.0, pull = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      travel += along[c] * (x[c] - start[c]);
      pull -= along[c] * force[c];
    }
    line.x.push_back(travel);
    line.y.push_back(pull);
  }
  return line;
}

Expected<Line> curvature_along(const Curve& curve, const FrameSet& run) {
  Line line{"along the material", "m", "curvature", "1/m", {}, {}};
  const frames::StrainSeries* series = series_of(run, curve.strain);
  if (series == nullptr)
    return bad_input("no term of the model has the strain '" + curve.strain + "'");
  const frames::Elements* hinges = elements_of(run, "hinge");
  if (series->kind != "hinge" || hinges == nullptr)
    return bad_input("'" + curve.strain + "' is no bending");
  const auto frame = frame_at(run, curve.at);
  if (!frame) return line;
  const std::array<double, 3> along = unit_vector(curve.direction);
  struct Bin {
    double share = 0.0, sum = 0.0;
  };
  std::map<long long, Bin> bins;  // by nanometres
  for (std::size_t e = 0; e < series->share.size(); ++e) {
    if (!(series->share[e] > 0.0)) continue;
    double place = 0.0;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const auto node = static_cast<std::size_t>(hinges->nodes[4 * e + corner]);
      for (std::size_t c = 0; c < static_cast<std::size_t>(run.coordinates); ++c)
        place +=
            0.25 * along[c] * run.material_m[node * static_cast<std::size_t>(run.coordinates) + c];
    }
    Bin& bin = bins[std::llround(1e9 * place)];
    bin.share += series->share[e];
    bin.sum += series->share[e] * series->values[0][*frame * series->share.size() + e] / 3.0;
  }
  for (const auto& [place, bin] : bins) {
    line.x.push_back(1e-9 * static_cast<double>(place));
    line.y.push_back(bin.sum / bin.share);
  }
  return line;
}

Expected<Line> kinetic_line(const Curve&, const FrameSet& run) {
  if (run.frame_count() > 0 && run.kinetic_J.empty())
    return bad_input("equilibria have no kinetic energy");
  return Line{"time", "s", "kinetic energy", "J", run.time_s, run.kinetic_J};
}

struct CurveRow {
  const char* kind;
  Expected<Line> (*line)(const Curve&, const FrameSet&);
};
constexpr CurveRow kCurves[] = {
    {"force_travel", force_travel},
    {"curvature_along", curvature_along},
    {"kinetic_energy", kinetic_line},
};

}  // namespace

Expected<Line> line_of(const Curve& curve, const FrameSet& run) {
  if (run.frame_count() == 0) return Line{};
  for (const CurveRow& row : kCurves)
    if (curve.kind == row.kind) return row.line(curve, run);
  return bad_input("there is no curve of the kind '" + curve.kind + "'");
}

}  // namespace tenter::experiment
