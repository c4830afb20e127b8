// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/noise/misread.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/not_a_number.h"
#include "server/diagnosis/field/noise/residual_table.h"

namespace tenter::diagnosis {
namespace {

using estimation::Row;
using estimation::Sequence;

constexpr double kFar = 7.0;      // robust standard deviations
constexpr double kALittle = 4.0;  // from here to there are tails
constexpr std::size_t kNearest = 6;
constexpr int kWindow = 4;  // frames on either side

/// Of the values that are there; NaN where fewer than three are.
double median(std::vector<double>& values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  if (values.size() < 3) return kNaN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What each coordinate has beside what is near it: NaN where nothing is.
struct Beside {
  ResidualTable in_time, in_space;
  ResidualTable alone;  ///< least magnitude, over the points near it
};

Beside beside(const Sequence& sequence, const ResidualTable& table) {
  const auto nearest = nearest_points(sequence, kNearest);
  const auto frames = static_cast<int>(sequence.frames.size());
  const ResidualTable none(table.size(), std::vector<double>(sequence.frames.size(), kNaN));
  Beside result{none, none, none};
  std::vector<double> near;
  for (std::size_t c = 0; c < table.size(); ++c)
    for (int f = 0; f < frames; ++f) {
      const auto at = static_cast<std::size_t>(f);
      near.clear();
      for (int g = std::max(0, f - kWindow); g <= std::min(frames - 1, f + kWindow); ++g)
        if (g != f) near.push_back(table[c][static_cast<std::size_t>(g)]);
      result.in_time[c][at] = table[c][at] - median(near);
      near.clear();
      for (const std::size_t q : nearest[c / 3]) near.push_back(table[3 * q + c % 3][at]);
      const bool is_beside_hidden =
          std::any_of(near.begin(), near.end(), [](double v) { return std::isnan(v); });
      const bool is_drawn = std::abs(sequence.camera_axis[static_cast<Eigen::Index>(c % 3)]) > 0.5;
      if (is_beside_hidden && is_drawn) continue;
      const double reading = table[c][at];
      for (const double v : near)
        result.alone[c][at] = std::fmin(result.alone[c][at], std::abs(reading - v));
      result.in_space[c][at] = reading - median(near);
    }
  return result;
}

/// Robust spread of one coordinate of all points; no less than a tenth of what is stated, of
/// readings that hardly move.
double spread_of(const ResidualTable& values, std::size_t coordinate) {
  constexpr double kLeast = 0.1;
  std::vector<double> far;
  for (std::size_t c = coordinate; c < values.size(); c += 3)
    for (const double v : values[c]) far.push_back(std::abs(v));
  const double middle = median(far);
  return std::isnan(middle) ? kLeast : std::max(kLeast, 1.4826 * middle);
}

/// Points of one sequence that are far off, and how many are a little way off.
struct Found {
  std::vector<Misread> far;
  std::size_t a_little = 0;
};

Found look_at(const Sequence& sequence, int index, const ResidualTable& table) {
  const Beside off = beside(sequence, table);
  std::array<double, 3> in_time, in_space;
  for (std::size_t c = 0; c < 3; ++c) {
    in_time[c] = spread_of(off.in_time, c);
    in_space[c] = spread_of(off.in_space, c);
  }
  Found found;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f)
    for (std::size_t p = 0; p < sequence.points.size(); ++p) {
      Misread worst{index, static_cast<int>(f), static_cast<int>(p), 0.0, 0.0};
      for (std::size_t c = 0; c < 3; ++c) {
        const double t = off.in_time[3 * p + c][f] / in_time[c];
        const double s = off.in_space[3 * p + c][f] / in_space[c];
        if (!(t * s > 0.0)) continue;  // nor where nothing is near
        const double score = std::min(std::abs(t), off.alone[3 * p + c][f] / in_space[c]);
        if (score <= worst.score) continue;
        worst.score = score;
        worst.off_m = -off.in_space[3 * p + c][f] * sequence.points[p].sigma_m;
      }
      if (worst.score >= kFar)
        found.far.push_back(worst);
      else if (worst.score >= kALittle)
        ++found.a_little;
    }
  return found;
}

}  // namespace

std::vector<Misread> find_misread(const std::vector<Sequence>& sequences,
                                  const std::vector<Row>& rows, const Eigen::VectorXd& residuals) {
  std::vector<Misread> all;
  constexpr double kMostOfAll = 0.05;
  std::size_t a_little = 0;
  double readings = 0.0;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const int index = static_cast<int>(s);
    if (sequences[s].points.empty()) continue;
    const int coordinates = 3 * static_cast<int>(sequences[s].points.size());
    Found found = look_at(sequences[s], index,
                          residual_table(sequences[s], index, coordinates, rows, residuals));
    a_little += found.a_little;
    readings += static_cast<double>(sequences[s].points.size() * sequences[s].frames.size());
    all.insert(all.end(), found.far.begin(), found.far.end());
  }
  if (a_little > all.size() || static_cast<double>(all.size()) > kMostOfAll * readings) all.clear();
  return all;
}

void set_aside(const std::vector<Misread>& misread, std::vector<Sequence>& sequences) {
  for (const Misread& m : misread) {
    estimation::SequenceFrame& frame =
        sequences[static_cast<std::size_t>(m.sequence)].frames[static_cast<std::size_t>(m.frame)];
    frame.points_m.col(m.point).setConstant(kNaN);
    frame.misread.push_back(m.point);
  }
}

}  // namespace tenter::diagnosis
