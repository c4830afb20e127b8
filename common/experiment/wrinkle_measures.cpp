// SPDX-License-Identifier: Apache-2.0
#include "common/experiment/wrinkle_measures.h"

#include <cmath>
#include <set>
#include <span>

#include "common/experiment/moments.h"
#include "common/experiment/settling.h"
#include "common/experiment/wrinkles.h"

namespace tenter::experiment {

namespace {

using frames::FrameSet;
using scene::Measure;

std::optional<std::size_t> from_frame(const Measure& measure, const FrameSet& run) {
  return frame_at(run, measure.from.empty() ? "start" : measure.from);
}

std::span<const double> of_frame(const std::vector<double>& list, const FrameSet& run,
                                 std::size_t frame) {
  const std::size_t numbers = 3 * static_cast<std::size_t>(run.nodes);
  return std::span(list).subspan(frame * numbers, numbers);
}

Expected<Wrinkles> wrinkles_at(const Measure& measure, const FrameSet& run, std::size_t smooth,
                               std::size_t frame) {
  const frames::Elements* triangles = elements_of(run, "triangle");
  if (triangles == nullptr) return bad_input("wrinkles are those of a sheet");
  return wrinkles_of(triangles->nodes, of_frame(run.position_m, run, smooth),
                     of_frame(run.position_m, run, frame), measure.width_m);
}

}  // namespace

Expected<Value> curvature_change(const Measure& measure, const FrameSet& run) {
  const auto from = from_frame(measure, run), to = frame_at(run, measure.at);
  double sum = 0.0, all = 0.0;
  std::set<std::string> counted;  // friction and damping have the strains of the elastic term
  for (const frames::StrainSeries& series : run.strains) {
    if (series.unit != "1/m" || !counted.insert(series.measure).second) continue;
    const std::size_t count = series.share.size();
    for (std::size_t e = 0; e < count; ++e) {
      all += series.share[e];
      if (!from || !to) continue;
      for (const std::vector<double>& values : series.values) {
        const double change = (values[*to * count + e] - values[*from * count + e]) / 3.0;
        sum += series.share[e] * change * change;
      }
    }
  }
  if (!(all > 0.0)) return bad_input("the model has no bending");
  if (!from || !to) return Value{{}, "1/m"};
  return Value{std::sqrt(sum / all), "1/m"};
}

Expected<Value> wrinkle_height(const Measure& measure, const FrameSet& run) {
  const auto from = from_frame(measure, run), at = frame_at(run, measure.at);
  if (!from || !at) return Value{{}, "m"};
  const auto wrinkles = wrinkles_at(measure, run, *from, *at);
  if (!wrinkles) return tl::unexpected(wrinkles.error());
  return Value{height_m(*wrinkles), "m"};
}

Expected<Value> wrinkle_likeness(const Measure& measure, const FrameSet& run) {
  const auto from = from_frame(measure, run), at = frame_at(run, measure.at),
             like = frame_at(run, measure.like);
  if (!from || !at || !like) return Value{{}, "1"};
  const auto one = wrinkles_at(measure, run, *from, *at);
  if (!one) return tl::unexpected(one.error());
  const auto other = wrinkles_at(measure, run, *from, *like);
  if (!other) return tl::unexpected(other.error());
  if (height_m(*one) < kNoWrinkle_m || height_m(*other) < kNoWrinkle_m) return Value{{}, "1"};
  const auto alike = likeness(*one, *other);
  if (!alike) return tl::unexpected(alike.error());
  return Value{*alike, "1"};
}

Expected<Value> settling_time(const Measure& measure, const FrameSet& run) {
  if (run.velocity_m_s.empty()) return bad_input("equilibria have no speed to settle from");
  const auto from = from_frame(measure, run);
  if (!from) return Value{{}, "s"};
  const auto at_start = wrinkles_at(measure, run, 0, 0);  // for the areas of the nodes
  if (!at_start) return tl::unexpected(at_start.error());
  std::vector<double> speeds;
  for (std::size_t frame = 0; frame < run.time_s.size(); ++frame) {
    const auto velocity = of_frame(run.velocity_m_s, run, frame);
    double sum = 0.0, all = 0.0;
    for (std::size_t n = 0; n < at_start->area_m2.size(); ++n) {
      const double x = velocity[3 * n], y = velocity[3 * n + 1], z = velocity[3 * n + 2];
      sum += at_start->area_m2[n] * (x * x + y * y + z * z);
      all += at_start->area_m2[n];
    }
    speeds.push_back(std::sqrt(sum / all));
  }
  const auto rest = settling(run.time_s, speeds, run.time_s[*from], measure.bound_m_s);
  if (!rest) return tl::unexpected(rest.error());
  if (!rest->is_settled) return Value{{}, "s"};
  return Value{rest->time_s - run.time_s[*from], "s"};
}

}  // namespace tenter::experiment
