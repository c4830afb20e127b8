// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/data/field_noise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <variant>

#include "common/base/not_a_number.h"
#include "server/diagnosis/field/data/structure.h"

namespace tenter::diagnosis {
namespace {

using estimation::ObservationKind;
using estimation::Row;
using estimation::Sequence;

constexpr int kFewest = 20;       // differences that a spread is taken of
constexpr double kAgrees = 1.25;  // a factor within which the stated value stays

/// Residuals of a sequence: [channel][frame].
using Table = std::vector<std::vector<double>>;

Table table_of(const Sequence& sequence, int index, int channels, const std::vector<Row>& rows,
               const Eigen::VectorXd& residuals) {
  Table table(static_cast<std::size_t>(channels),
              std::vector<double>(sequence.frames.size(), kNaN));
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows[r].curve == index)
      table[static_cast<std::size_t>(rows[r].channel)][static_cast<std::size_t>(rows[r].frame)] =
          residuals[static_cast<Eigen::Index>(r)];
  return table;
}

/// What a frame's neighbours in its block do not foretell.
std::vector<double> without_neighbours(const Sequence& sequence, const std::vector<double>& r) {
  std::vector<double> left(r.size(), kNaN);
  for (std::size_t f = 1; f + 1 < r.size(); ++f)
    if (sequence.frames[f - 1].block == sequence.frames[f].block &&
        sequence.frames[f + 1].block == sequence.frames[f].block)
      left[f] = (r[f] - 0.5 * (r[f - 1] + r[f + 1])) / std::sqrt(1.5);
  return left;
}

std::vector<std::vector<std::size_t>> nearest_points(const Sequence& sequence) {
  constexpr std::size_t kNearest = 4;
  const std::size_t count = sequence.points.size();
  std::vector<std::vector<std::size_t>> nearest(count);
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (std::size_t i = 0; i < count; ++i) {
    by_distance.clear();
    for (std::size_t j = 0; j < count; ++j)
      if (j != i)
        by_distance.emplace_back(
            (sequence.points[i].material_m - sequence.points[j].material_m).squaredNorm(), j);
    const std::size_t few = std::min(kNearest, by_distance.size());
    std::partial_sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(few),
                      by_distance.end());
    for (std::size_t k = 0; k < few; ++k) nearest[i].push_back(by_distance[k].second);
  }
  return nearest;
}

/// Less the mean of the nearest points', of points' channels.
void take_away_places(const Sequence& sequence, Table& table) {
  const auto nearest = nearest_points(sequence);
  const Table before = table;
  for (std::size_t p = 0; p < nearest.size(); ++p)
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
        double sum = 0.0;
        double n = 0.0;
        for (const std::size_t q : nearest[p]) {
          const double there = before[3 * q + c][f];
          if (std::isnan(there)) continue;
          sum += there;
          n += 1.0;
        }
        double& value = table[3 * p + c][f];
        value = n >= 3.0 ? (value - sum / n) / std::sqrt(1.0 + 1.0 / n) : kNaN;
      }
}

/// Spread of what is normal in the middle; 0: too few. `count`: of how many.
double robust_spread(std::vector<double> values, std::size_t& count) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  count = values.size();
  if (count < kFewest) return 0.0;
  for (double& v : values) v = std::abs(v);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return 1.4826 * *middle;
}

bool same_poses(const Sequence& a, const Sequence& b) {
  constexpr double kSame_m = 5e-4;
  if (a.frames.size() != b.frames.size() || a.points.size() != b.points.size() ||
      a.forces.size() != b.forces.size())
    return false;
  for (std::size_t f = 0; f < a.frames.size(); ++f) {
    if (a.frames[f].clips.size() != b.frames[f].clips.size()) return false;
    for (std::size_t c = 0; c < a.frames[f].clips.size(); ++c)
      if ((a.frames[f].clips[c].position_m - b.frames[f].clips[c].position_m).norm() > kSame_m)
        return false;
  }
  return true;
}

double sigma_rms(const Sequence& sequence, const std::vector<int>& channels) {
  const estimation::Observations seen(sequence);
  double sum = 0.0;
  for (const int c : channels) sum += std::pow(seen.sigma(sequence, c), 2);
  return channels.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(channels.size()));
}

/// rms of half the squared difference of two tables' channels, in sigmas.
double repeat_spread(const Table& a, const Table& b, const std::vector<int>& channels) {
  double sum = 0.0;
  double n = 0.0;
  for (const int c : channels)
    for (std::size_t f = 0; f < a[static_cast<std::size_t>(c)].size(); ++f) {
      const double d = a[static_cast<std::size_t>(c)][f] - b[static_cast<std::size_t>(c)][f];
      if (std::isnan(d)) continue;
      sum += 0.5 * d * d;
      n += 1.0;
    }
  return n >= kFewest ? std::sqrt(sum / n) : 0.0;
}

/// Takes what is shown where that is surely another value than the stated one.
void choose(double spread, std::size_t count, estimation::NoiseSource source,
            FieldNoise::Kind& kind) {
  if (!(spread > 0.0)) return;
  // a median of n overlapping second differences of white noise has a relative error of 1.6/sqrt n
  constexpr double kError = 1.6;
  constexpr double kSurely = 3.0;
  const double agrees = std::max(
      kAgrees,
      std::exp(kSurely * kError / std::sqrt(static_cast<double>(std::max<std::size_t>(1, count)))));
  kind.shown = spread * kind.stated;
  kind.source = source;
  // a sigma of k readings has a relative error of 1/sqrt(2k)
  kind.known_of = source == estimation::NoiseSource::repeats
                      ? static_cast<double>(count)
                      : static_cast<double>(count) / (2.0 * kError * kError);
  if (spread > agrees || spread < 1.0 / agrees)
    kind.factor = spread;
  else if (source == estimation::NoiseSource::scatter)
    kind.source = estimation::NoiseSource::declared;
}

}  // namespace

FieldNoise estimate_field_noise(const FieldData& data, const std::vector<Row>& rows,
                                const Eigen::VectorXd& residuals) {
  FieldNoise noise;
  std::map<ObservationKind, std::vector<double>> pooled;
  std::vector<Table> tables;
  for (std::size_t s = 0; s < data.sequences.size(); ++s)
    tables.push_back(table_of(data.sequences[s], static_cast<int>(s),
                              estimation::Observations(data.sequences[s]).count(), rows,
                              residuals));
  for (std::size_t s = 0; s < data.sequences.size(); ++s) {
    const Sequence& sequence = data.sequences[s];
    const estimation::Observations seen(sequence);
    Table in_time;
    for (const auto& r : tables[s]) in_time.push_back(without_neighbours(sequence, r));
    Table left = in_time;
    if (sequence.points.size() >= 8) take_away_places(sequence, left);
    std::vector<std::vector<int>> of_kind;  // in the order of first channels, as kind_places() has
    int place_of[3] = {-1, -1, -1};
    for (int c = 0; c < seen.count(); ++c) {
      int& place = place_of[static_cast<int>(seen.kind(sequence, c))];
      if (place < 0) {
        place = static_cast<int>(of_kind.size());
        of_kind.emplace_back();
      }
      of_kind[static_cast<std::size_t>(place)].push_back(c);
    }
    for (const std::vector<int>& channels : of_kind) {
      FieldNoise::Kind kind;
      kind.sequence = static_cast<int>(s);
      kind.kind = seen.kind(sequence, channels.front());
      kind.stated = sigma_rms(sequence, channels);
      std::vector<double> spread;
      for (const int c : channels) {
        const auto& values = left[static_cast<std::size_t>(c)];
        spread.insert(spread.end(), values.begin(), values.end());
        for (const double v : tables[s][static_cast<std::size_t>(c)])
          kind.rows += std::isnan(v) ? 0 : 1;
      }
      if (kind.kind == ObservationKind::position) {
        std::size_t count = 0;
        const double scatter = robust_spread(std::move(spread), count);
        choose(scatter, count, estimation::NoiseSource::scatter, kind);
      } else {  // few, and of one rig in all captures
        auto& all = pooled[kind.kind];
        all.insert(all.end(), spread.begin(), spread.end());
      }
      for (std::size_t other = 0; other < s; ++other) {
        if (data.protocols[other] != data.protocols[s] ||
            !same_poses(data.sequences[other], sequence))
          continue;
        kind.factor = 1.0;
        choose(repeat_spread(tables[other], tables[s], channels),
               static_cast<std::size_t>(kind.rows), estimation::NoiseSource::repeats, kind);
        break;
      }
      noise.kinds.push_back(kind);
    }
  }
  for (FieldNoise::Kind& kind : noise.kinds) {
    if (kind.kind == ObservationKind::position || kind.source == estimation::NoiseSource::repeats)
      continue;
    std::size_t count = 0;
    const double scatter = robust_spread(pooled[kind.kind], count);
    choose(scatter, count, estimation::NoiseSource::scatter, kind);
  }
  // the first of several repeats has what the second one showed with it
  for (FieldNoise::Kind& kind : noise.kinds)
    for (const FieldNoise::Kind& later : noise.kinds)
      if (later.sequence > kind.sequence && later.kind == kind.kind &&
          later.source == estimation::NoiseSource::repeats &&
          kind.source != estimation::NoiseSource::repeats &&
          data.protocols[static_cast<std::size_t>(later.sequence)] ==
              data.protocols[static_cast<std::size_t>(kind.sequence)]) {
        kind.shown = later.shown;
        kind.known_of = later.known_of;
        kind.factor = later.factor;
        kind.source = later.source;
      }
  return noise;
}

FieldData reweighed(FieldData data, const FieldNoise& noise) {
  data.sigma_known_of.resize(noise.kinds.size(), 0.0);
  for (std::size_t k = 0; k < noise.kinds.size(); ++k)
    if (noise.kinds[k].factor != 1.0) data.sigma_known_of[k] = noise.kinds[k].known_of;
  for (const FieldNoise::Kind& kind : noise.kinds) {
    Sequence& sequence = data.sequences[static_cast<std::size_t>(kind.sequence)];
    if (kind.kind == ObservationKind::position) {
      for (auto& point : sequence.points) point.sigma_m *= kind.factor;
      for (auto& scalar : sequence.scalars)
        if (auto* length = std::get_if<estimation::LengthChannel>(&scalar))
          length->sigma_m *= kind.factor;
    } else if (kind.kind == ObservationKind::force) {
      for (auto& force : sequence.forces) force.sigma_N *= kind.factor;
    } else {
      for (auto& scalar : sequence.scalars) {
        if (auto* torque = std::get_if<estimation::TorqueChannel>(&scalar))
          torque->sigma_N_m *= kind.factor;
        if (auto* area = std::get_if<estimation::AreaChannel>(&scalar))
          area->sigma_m2 *= kind.factor;
      }
    }
  }
  return data;
}

FieldNoise combined(FieldNoise first, const FieldNoise& second) {
  for (std::size_t k = 0; k < first.kinds.size() && k < second.kinds.size(); ++k) {
    FieldNoise::Kind& kind = first.kinds[k];
    if (second.kinds[k].factor == 1.0) continue;
    kind.shown = second.kinds[k].shown;
    kind.factor *= second.kinds[k].factor;
    kind.source = second.kinds[k].source;
  }
  return first;
}

}  // namespace tenter::diagnosis
