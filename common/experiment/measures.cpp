// SPDX-License-Identifier: Apache-2.0
#include "common/experiment/measures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/experiment/moments.h"
#include "common/experiment/wrinkle_measures.h"

namespace tenter::experiment {

namespace {

using frames::FrameSet;
using scene::Measure;

struct Question {
  const Measure& measure;
  const FrameSet& run;
  const FrameSet& first;
};

/// Mean of strain^power over what its elements stand for; several strains are summed.
Expected<Value> strain_mean(const Question& q, int power) {
  const frames::StrainSeries* series = series_of(q.run, q.measure.strain);
  if (series == nullptr)
    return bad_input("no term of the model has the strain '" + q.measure.strain + "'");
  const auto frame = frame_at(q.run, q.measure.at);
  if (!frame) return Value{{}, series->unit};
  double sum = 0.0, all = 0.0;
  for (std::size_t e = 0; e < series->share.size(); ++e) {
    all += series->share[e];
    for (const std::vector<double>& values : series->values) {
      const double strain = values[*frame * series->share.size() + e];
      sum += series->share[e] * (power == 1 ? strain : strain * strain);
    }
  }
  if (!(all > 0.0)) return bad_input("the strain '" + q.measure.strain + "' acts on no element");
  return Value{power == 1 ? sum / all : std::sqrt(sum / all), series->unit};
}

Expected<Value> mean_strain(const Question& q) {
  return strain_mean(q, 1);
}
Expected<Value> rms_strain(const Question& q) {
  return strain_mean(q, 2);
}
Expected<Value> rms_curvature(const Question& q) {
  auto value = strain_mean(q, 2);
  if (!value) return value;
  if (value->unit != "1/m") return bad_input("'" + q.measure.strain + "' is no bending");
  if (value->number) *value->number /= 3.0;
  return value;
}

Expected<Value> work(const Question& q) {
  const auto clip = clip_index(q.run, q.measure.clip);
  const auto from = frame_at(q.run, q.measure.from.empty() ? "start" : q.measure.from);
  const auto to = frame_at(q.run, q.measure.at);
  if (!clip || !from || !to) return Value{{}, "J"};
  const std::size_t clips = q.run.clips.size();
  double sum = 0.0;
  for (std::size_t f = *from; f < *to; ++f) {
    const auto x0 = vector_at(q.run.clip_position_m, f * clips + *clip);
    const auto x1 = vector_at(q.run.clip_position_m, (f + 1) * clips + *clip);
    const auto f0 = vector_at(q.run.force_N, f * clips + *clip);
    const auto f1 = vector_at(q.run.force_N, (f + 1) * clips + *clip);
    for (std::size_t c = 0; c < 3; ++c) sum -= 0.5 * (f0[c] + f1[c]) * (x1[c] - x0[c]);
  }
  return Value{sum, "J"};
}

Expected<Value> force_difference(const Question& q) {
  const auto clip = clip_index(q.run, q.measure.clip);
  const auto other = clip_index(q.first, q.measure.clip);
  const int count = q.run.frame_count();
  if (!clip || !other || count != q.first.frame_count()) return Value{{}, "1"};
  double most = 0.0, scale = 0.0;
  for (int f = 0; f < count; ++f) {
    const auto frame = static_cast<std::size_t>(f);
    const auto a = vector_at(q.run.force_N, frame * q.run.clips.size() + *clip);
    const auto b = vector_at(q.first.force_N, frame * q.first.clips.size() + *other);
    most = std::max(most, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
    scale = std::max(scale, std::hypot(b[0], b[1], b[2]));
  }
  if (!(scale > 0.0)) return Value{{}, "1"};
  return Value{most / scale, "1"};
}

Expected<Value> kinetic_at(const Question& q) {
  if (q.run.frame_count() > 0 && q.run.kinetic_J.empty())
    return bad_input("equilibria have no kinetic energy");
  const auto frame = frame_at(q.run, q.measure.at);
  if (!frame) return Value{{}, "J"};
  return Value{q.run.kinetic_J[*frame], "J"};
}

/// Of what looks at one run alone.
template <Expected<Value> (*measure)(const Measure&, const FrameSet&)>
Expected<Value> of_run(const Question& q) {
  return measure(q.measure, q.run);
}

struct Row {
  const char* kind;
  Expected<Value> (*value)(const Question&);
};
constexpr Row kRows[] = {
    {"mean_strain", mean_strain},
    {"rms_strain", rms_strain},
    {"rms_curvature", rms_curvature},
    {"work", work},
    {"force_difference", force_difference},
    {"kinetic_energy", kinetic_at},
    {"curvature_change", of_run<curvature_change>},
    {"wrinkle_height", of_run<wrinkle_height>},
    {"wrinkle_likeness", of_run<wrinkle_likeness>},
    {"settling_time", of_run<settling_time>},
};

}  // namespace

Expected<Value> measured(const Measure& measure, const FrameSet& run, const FrameSet& first) {
  if (run.frame_count() == 0) return Value{};
  for (const Row& row : kRows) {
    if (measure.kind != row.kind) continue;
    auto value = row.value({measure, run, first});
    if (value && value->number && !std::isfinite(*value->number)) value->number.reset();
    return value;
  }
  return bad_input("there is no measure of the kind '" + measure.kind + "'");
}

}  // namespace tenter::experiment
