// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/noise/scatter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace tenter::diagnosis {
namespace {

using estimation::Sequence;

constexpr std::size_t kFewestValues = 8;  // values that a spread is taken of
constexpr double kSamePose_m = 5e-4;      // poses that are equal
/// Of the median magnitude of n overlapping contrasts of white noise, times sqrt n; of differences
/// of second to sixth order alike (1.4 to 1.6).
constexpr double kMedianError = 1.6;
constexpr std::size_t kOrders = kHighestOrder - kLowestOrder + 1;

/// Where the clips are and what is held, in numbers of metres.
Eigen::VectorXd pose_of(const Sequence& sequence, std::size_t f) {
  constexpr double kArm_m = 0.05;   // of a clip that turns
  constexpr double kNode_m = 1e-2;  // that is held or not
  const estimation::SequenceFrame& frame = sequence.frames[f];
  std::vector<double> numbers;
  for (const mechanics::Pose& clip : frame.clips) {
    numbers.insert(numbers.end(), clip.position_m.data(), clip.position_m.data() + 3);
    for (Eigen::Index k = 0; k < 9; ++k) numbers.push_back(kArm_m * clip.rotation.data()[k]);
  }
  const auto boundary = static_cast<std::size_t>(frame.boundary);
  numbers.push_back(kNode_m * static_cast<double>(sequence.boundaries[boundary].held.size()));
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(),
                                           static_cast<Eigen::Index>(numbers.size()));
}

/// Weights of unit norm on values at these places that no polynomial of degree `order` - 1 shows
/// up in: as many places as `order` + 1.
std::vector<double> beside_polynomials(const std::vector<double>& place) {
  std::vector<double> weights(place.size(), 1.0);
  double norm = 0.0;
  for (std::size_t i = 0; i < place.size(); ++i) {  // those of divided differences
    for (std::size_t j = 0; j < place.size(); ++j)
      if (j != i) weights[i] /= place[i] - place[j];
    norm += weights[i] * weights[i];
  }
  for (double& w : weights) w /= std::sqrt(norm);
  return weights;
}

/// The way of the frames of a block; where they stand nearly still, or all do, by their number.
std::vector<double> way_of(const std::vector<Eigen::VectorXd>& poses, std::size_t first,
                           std::size_t last) {
  constexpr double kStill = 0.2;  // of the mean step
  std::vector<double> step;
  double sum = 0.0;
  for (std::size_t f = first + 1; f < last; ++f) {
    step.push_back((poses[f] - poses[f - 1]).norm());
    sum += step.back();
  }
  const double mean = step.empty() ? 0.0 : sum / static_cast<double>(step.size());
  std::vector<double> way = {0.0};
  for (const double s : step)
    way.push_back(way.back() + (mean > 0.0 ? std::max(s / mean, kStill) : 1.0));
  return way;
}

/// 1.4826 median magnitude; none where there are too few.
std::optional<double> median_spread(std::vector<double> values) {
  if (values.size() < kFewestValues) return std::nullopt;
  for (double& v : values) v = std::abs(v);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return 1.4826 * *middle;
}

Scatter scatter_of(const std::vector<double>& values) {
  Scatter scatter;
  scatter.spread = median_spread(values).value_or(0.0);
  scatter.values = static_cast<int>(values.size());
  return scatter;
}

/// Differences of growing order, as long as the spread falls by more than chance.
Scatter settled_differences(const std::vector<std::vector<double>>& looks) {
  constexpr double kChance = 1.5;  // standard errors
  constexpr double kFalls = 0.9;
  Scatter best = scatter_of(looks[0]);
  if (!(best.spread > 0.0)) return best;
  best.is_bound = true;
  for (std::size_t k = 1; k < kOrders; ++k) {
    const Scatter next = scatter_of(looks[k]);
    if (!(next.spread > 0.0)) return best;
    if (next.spread > std::min(kFalls, std::exp(-kChance * next.error())) * best.spread) {
      best.is_bound = false;
      return best;
    }
    best = next;
    best.is_bound = true;
  }
  return best;
}

}  // namespace

double Contrast::of(const std::vector<double>& values) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < frames.size(); ++k)
    sum += weights[k] * values[static_cast<std::size_t>(frames[k])];
  return sum;
}

FrameContrasts::FrameContrasts(const Sequence& sequence) : differences(kOrders) {
  const std::size_t count = sequence.frames.size();
  std::vector<Eigen::VectorXd> poses, motion(count);
  for (std::size_t f = 0; f < count; ++f) poses.push_back(pose_of(sequence, f));
  for (std::size_t first = 0; first < count;) {
    std::size_t last = first + 1;
    while (last < count && sequence.frames[last].block == sequence.frames[first].block) ++last;
    const std::vector<double> way = way_of(poses, first, last);
    for (std::size_t f = first; f < last && last - first > 1; ++f)
      motion[f] = f + 1 < last ? poses[f + 1] - poses[f] : poses[f] - poses[f - 1];
    for (std::size_t k = 0; k < kOrders; ++k) {
      const std::size_t frames = k + kLowestOrder + 1;
      for (std::size_t f = first; f + frames <= last; ++f) {
        Contrast contrast;
        std::vector<double> place;
        for (std::size_t i = f; i < f + frames; ++i) {
          contrast.frames.push_back(static_cast<int>(i));
          place.push_back(way[i - first]);
        }
        contrast.weights = beside_polynomials(place);
        differences[k].push_back(std::move(contrast));
      }
    }
    first = last;
  }
  // each frame with the next one that is where it was
  const double half = std::sqrt(0.5);
  for (std::size_t f = 0; f < count; ++f) {
    bool has_repeat = false, has_return = false;
    for (std::size_t g = f + 1; g < count && !(has_repeat && has_return); ++g) {
      if (sequence.frames[f].block == sequence.frames[g].block) continue;
      if ((poses[f] - poses[g]).norm() > kSamePose_m) continue;
      const Contrast pair{{static_cast<int>(f), static_cast<int>(g)}, {half, -half}};
      if (!has_return) returns.push_back(pair);
      has_return = true;
      const bool is_known = motion[f].size() > 0 && motion[g].size() > 0;
      if (!is_known || has_repeat || motion[f].dot(motion[g]) <= 0.0) continue;
      repeats.push_back(pair);
      has_repeat = true;
    }
  }
}

std::vector<const std::vector<Contrast>*> FrameContrasts::looks() const {
  std::vector<const std::vector<Contrast>*> all;
  for (const auto& of_order : differences) all.push_back(&of_order);
  all.push_back(&repeats);
  all.push_back(&returns);
  return all;
}

double Scatter::error() const {
  return kMedianError / std::sqrt(static_cast<double>(std::max(1, values)));
}

Looks::Looks() : values_(kOrders + 2) {}

void Looks::add(const FrameContrasts& frames, const std::vector<double>& values) {
  const auto looks = frames.looks();
  for (std::size_t k = 0; k < looks.size(); ++k)
    for (const Contrast& contrast : *looks[k]) add(k, contrast.of(values));
}

void Looks::add(std::size_t look, double value) {
  if (!std::isnan(value)) values_[look].push_back(value);
}

Scatter Looks::scatter() const {
  std::vector<Scatter> all = {settled_differences(values_), scatter_of(values_[kOrders]),
                              scatter_of(values_[kOrders + 1])};
  all[2].is_bound = true;
  std::erase_if(all, [](const Scatter& s) { return !(s.spread > 0.0); });
  if (all.empty()) return {};
  const auto at_most = [](const Scatter& s) { return s.spread * std::exp(s.error()); };
  const auto smallest =
      std::min_element(all.begin(), all.end(),
                       [&](const Scatter& a, const Scatter& b) { return at_most(a) < at_most(b); });
  Scatter best = *smallest;
  for (auto other = all.begin(); other != all.end(); ++other)
    if (other != smallest &&
        std::log(other->spread / best.spread) < std::hypot(other->error(), best.error()))
      best.is_bound = false;
  return best;
}

}  // namespace tenter::diagnosis
