// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/noise/field_noise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <variant>

#include "server/diagnosis/field/data/structure.h"
#include "server/diagnosis/field/noise/residual_table.h"
#include "server/diagnosis/field/noise/scatter.h"

namespace tenter::diagnosis {
namespace {

using estimation::ObservationKind;
using estimation::Row;
using estimation::Sequence;

constexpr int kFewest = 20;               // differences of repeats that an rms is taken of
constexpr std::size_t kFewestPoints = 8;  // for neighbours to say anything
constexpr double kAgrees = 1.25;          // a factor within which the stated value stays

/// Points, each less the mean of the nearest ones': a misfit that is smooth over the material goes.
void add_points(const FrameContrasts& frames, const Sequence& sequence, const ResidualTable& table,
                Looks& looks) {
  const auto nearest = nearest_points(sequence, 4);
  std::vector<double> value(3 * nearest.size());
  const auto all = frames.looks();
  for (std::size_t look = 0; look < all.size(); ++look)
    for (const Contrast& contrast : *all[look]) {
      for (std::size_t c = 0; c < value.size(); ++c) value[c] = contrast.of(table[c]);
      for (std::size_t c = 0; c < value.size(); ++c) {
        double sum = 0.0;
        double n = 0.0;
        for (const std::size_t q : nearest[c / 3]) {
          const double there = value[3 * q + c % 3];
          if (std::isnan(there)) continue;
          sum += there;
          n += 1.0;
        }
        if (n >= 3.0) looks.add(look, (value[c] - sum / n) / std::sqrt(1.0 + 1.0 / n));
      }
    }
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
double repeat_spread(const ResidualTable& a, const ResidualTable& b,
                     const std::vector<int>& channels) {
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

/// Takes what is shown where that is surely another value than the stated one. A bound says of a
/// stated value that it is too large, never that it is too small.
void choose(const Scatter& scatter, estimation::NoiseSource source, FieldNoise::Kind& kind) {
  if (!(scatter.spread > 0.0)) return;
  // too little noise names what is none; too much only says less
  constexpr double kLarger = 2.33, kSmaller = 3.0;  // standard errors
  const auto agrees = [&](double errors) {
    return std::max(kAgrees, std::exp(errors * scatter.error()));
  };
  kind.shown = scatter.spread * kind.stated;
  kind.is_bound = scatter.is_bound;
  kind.source = source;
  // a sigma of k readings has a relative error of 1/sqrt(2k)
  kind.known_of = source == estimation::NoiseSource::repeats
                      ? static_cast<double>(scatter.values)
                      : 0.5 / (scatter.error() * scatter.error());
  if (kind.is_guessed) {
    kind.factor = scatter.spread;
    return;
  }
  constexpr double kFiltered = 0.1;
  const bool is_larger = scatter.spread > agrees(kLarger) && !scatter.is_bound;
  // readings so smooth went through a filter, and what is left of their noise is no scatter
  const bool is_filtered = source == estimation::NoiseSource::scatter && scatter.spread < kFiltered;
  if (is_larger || (scatter.spread < 1.0 / agrees(kSmaller) && !is_filtered))
    kind.factor = scatter.spread;
  else if (source == estimation::NoiseSource::scatter)
    kind.source = estimation::NoiseSource::declared;
}

}  // namespace

FieldNoise estimate_field_noise(const FieldData& data, const std::vector<Row>& rows,
                                const Eigen::VectorXd& residuals) {
  FieldNoise noise;
  std::map<ObservationKind, Looks> pooled;
  std::vector<ResidualTable> tables;
  for (std::size_t s = 0; s < data.sequences.size(); ++s)
    tables.push_back(residual_table(data.sequences[s], static_cast<int>(s),
                                    estimation::Observations(data.sequences[s]).count(), rows,
                                    residuals));
  for (std::size_t s = 0; s < data.sequences.size(); ++s) {
    const Sequence& sequence = data.sequences[s];
    const estimation::Observations seen(sequence);
    const FrameContrasts frames(sequence);
    const std::size_t points = sequence.points.size() >= kFewestPoints ? sequence.points.size() : 0;
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
      for (const int c : channels)
        for (const double v : tables[s][static_cast<std::size_t>(c)])
          kind.rows += std::isnan(v) ? 0 : 1;
      // forces are few, and of one rig in all captures
      const bool has_points = kind.kind == ObservationKind::position;
      kind.is_guessed =
          s < data.has_guessed_noise.size() && data.has_guessed_noise[s][has_points ? 0 : 1];
      if (kind.is_guessed) kind.source = estimation::NoiseSource::guess;
      Looks own;
      Looks& looks = has_points ? own : pooled[kind.kind];
      if (has_points && points > 0) add_points(frames, sequence, tables[s], looks);
      for (const int c : channels)
        if (!has_points || static_cast<std::size_t>(c) >= 3 * points)
          looks.add(frames, tables[s][static_cast<std::size_t>(c)]);
      if (has_points) choose(own.scatter(), estimation::NoiseSource::scatter, kind);
      for (std::size_t other = 0; other < s; ++other) {
        if (data.protocols[other] != data.protocols[s] ||
            !same_poses(data.sequences[other], sequence))
          continue;
        kind.factor = 1.0;
        choose({repeat_spread(tables[other], tables[s], channels), kind.rows, false},
               estimation::NoiseSource::repeats, kind);
        break;
      }
      noise.kinds.push_back(kind);
    }
  }
  for (FieldNoise::Kind& kind : noise.kinds) {
    if (kind.kind == ObservationKind::position || kind.source == estimation::NoiseSource::repeats)
      continue;
    choose(pooled[kind.kind].scatter(), estimation::NoiseSource::scatter, kind);
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
        kind.is_bound = later.is_bound;
        kind.known_of = later.known_of;
        kind.factor = later.factor;
        kind.source = later.source;
      }
  return noise;
}

bool is_scatter(const Structure& left, const FieldNoise& noise) {
  constexpr double kWhite = 2.58;     // standard deviations of what white noise has
  constexpr double kByScatter = 0.7;  // of what is left
  constexpr double kLargest = 2.2;    // times what is stated
  const double rows = std::max(1, left.rows);
  const double most = kWhite / std::sqrt(rows);
  if (std::abs(left.in_time) > most || std::max(left.neighbours, left.fixed) > most) return false;
  const double times = std::sqrt(left.chi2 / rows);
  return std::ranges::any_of(noise.kinds, [&](const FieldNoise::Kind& kind) {
    const double taken = kind.stated * kind.factor;
    return kind.sequence == left.sequence && kind.kind == left.kind &&
           kind.shown > kByScatter * times * taken &&
           (kind.is_guessed || times * kind.factor < kLargest);
  });
}

FieldData reweighed(FieldData data, const FieldNoise& noise) {
  data.sigma_known_of.resize(noise.kinds.size(), 0.0);
  for (std::size_t k = 0; k < noise.kinds.size(); ++k) {
    const FieldNoise::Kind& kind = noise.kinds[k];
    if (kind.factor != 1.0) data.sigma_known_of[k] = kind.known_of;
    if (kind.is_guessed && kind.shown > 0.0)  // from now on a value like any other
      data.has_guessed_noise[static_cast<std::size_t>(kind.sequence)]
                            [kind.kind == ObservationKind::position ? 0 : 1] = false;
  }
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
    kind.is_bound = second.kinds[k].is_bound;
    kind.factor *= second.kinds[k].factor;
    kind.source = second.kinds[k].source;
  }
  return first;
}

}  // namespace tenter::diagnosis
