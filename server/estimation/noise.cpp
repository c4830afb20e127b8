// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/noise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

namespace tenter::estimation {
namespace {

constexpr int kGridPoints = 30;

/// One block of one channel: residuals (SI) along an increasing coordinate.
struct Segment {
  std::vector<double> x;
  std::vector<double> value;
};

/// Imposed component that moves most over the block; the clock in a hold.
Segment make_segment(const Curves& curves, const Block& block, const std::vector<int>& frames,
                     const std::vector<double>& values) {
  Eigen::Vector3d lo = curves.path.q[static_cast<std::size_t>(block.first)];
  Eigen::Vector3d hi = lo;
  for (int f = block.first; f < block.last; ++f) {
    lo = lo.cwiseMin(curves.path.q[static_cast<std::size_t>(f)]);
    hi = hi.cwiseMax(curves.path.q[static_cast<std::size_t>(f)]);
  }
  int driver = 0;
  double best = -1.0;
  for (int i = 0; i < 3; ++i) {
    if (curves.path.is_free[static_cast<std::size_t>(i)]) continue;
    if (hi[i] - lo[i] > best) {
      best = hi[i] - lo[i];
      driver = i;
    }
  }
  Segment segment;
  const bool hold = block.branch == capture::Branch::hold;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto f = static_cast<std::size_t>(frames[k]);
    const double x = hold
                         ? curves.clock_s[f] - curves.clock_s[static_cast<std::size_t>(block.first)]
                         : curves.path.q[f][driver];
    segment.x.push_back(x);
    segment.value.push_back(values[k]);
  }
  if (segment.x.size() > 1 && segment.x.front() > segment.x.back()) {
    std::reverse(segment.x.begin(), segment.x.end());
    std::reverse(segment.value.begin(), segment.value.end());
  }
  return segment;
}

/// Value at x, linear between samples, and the share of one sample's variance that white noise
/// keeps in it.
struct Interpolated {
  double value = 0.0;
  double kept = 1.0;
};
Interpolated interpolate(const Segment& s, double x) {
  std::size_t k = 1;
  while (k + 1 < s.x.size() && s.x[k] < x) ++k;
  const double span = s.x[k] - s.x[k - 1];
  const double w = span > 0.0 ? std::clamp((x - s.x[k - 1]) / span, 0.0, 1.0) : 0.5;
  return {(1.0 - w) * s.value[k - 1] + w * s.value[k], w * w + (1.0 - w) * (1.0 - w)};
}

/// Mean square of values of which few are none of the noise: those beyond three standard deviations
/// are left out, and what normal values lose by that is put back. It scatters less than the square
/// of a median magnitude, which has the first word on how far three deviations are.
double clipped_square(const double* first, const double* last) {
  constexpr double kReach = 3.0, kKept = 0.97334;  // E[z^2 | |z| < 3]
  std::vector<double> magnitude;
  for (const double* d = first; d != last; ++d) magnitude.push_back(std::abs(*d));
  const auto middle = magnitude.begin() + static_cast<std::ptrdiff_t>(magnitude.size() / 2);
  std::nth_element(magnitude.begin(), middle, magnitude.end());
  double square = std::pow(1.4826 * *middle, 2);
  for (int round = 0; round < 5; ++round) {
    double sum = 0.0, count = 0.0;
    for (const double d : magnitude)
      if (d * d <= kReach * kReach * square) sum += d * d, count += 1.0;
    if (count > 0.0) square = sum / count / kKept;
  }
  return square;
}

/// Standard deviation of white noise from second differences: r[i] - (r[i-1] + r[i+1])/2 has
/// variance 1.5 sigma^2. Noise may grow with the load: squares are averaged over short stretches,
/// of which none, as where a specimen slips, counts for more than four usual ones.
double scatter_sigma(const std::vector<std::vector<double>>& blocks) {
  constexpr std::size_t kStretch = 40;
  constexpr double kLoudest = 4.0;
  std::vector<double> d;
  for (const auto& x : blocks)
    for (std::size_t i = 1; i + 1 < x.size(); ++i) d.push_back(x[i] - 0.5 * (x[i - 1] + x[i + 1]));
  const std::size_t stretches = std::max<std::size_t>(1, d.size() / kStretch);
  std::vector<double> squares;
  for (std::size_t k = 0; k < stretches && !d.empty(); ++k) {
    const double square = clipped_square(d.data() + k * d.size() / stretches,
                                         d.data() + (k + 1) * d.size() / stretches);
    if (square > 0.0) squares.push_back(square);  // a display that stood still says nothing
  }
  if (squares.empty()) return 0.0;
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  const double most = kLoudest * *middle;
  double sum = 0.0;
  for (const double square : squares) sum += std::min(square, most);
  return std::sqrt(sum / static_cast<double>(squares.size()) / 1.5);
}

struct Member {
  int run_order = 0;  ///< position of the run in its group
  Segment segment;
};

using Sequences = std::vector<std::vector<double>>;

/// Repeats of one block on a common grid, each value over the square root of the share of white
/// noise that interpolation keeps there: the scatter between them is that of single readings.
/// Empty where they do not overlap or there are not two.
Sequences aligned(std::vector<Member>& members) {
  std::sort(members.begin(), members.end(),
            [](const Member& a, const Member& b) { return a.run_order < b.run_order; });
  if (members.size() >= 3) members.erase(members.begin());
  if (members.size() < 2) return {};
  double lo = -1e300;
  double hi = 1e300;
  for (const Member& m : members) {
    if (m.segment.x.size() < 3) return {};
    lo = std::max(lo, m.segment.x.front());
    hi = std::min(hi, m.segment.x.back());
  }
  if (!(hi > lo)) return {};
  Sequences values(members.size());
  for (int g = 0; g < kGridPoints; ++g) {
    const double x = lo + (hi - lo) * (g + 0.5) / kGridPoints;
    double kept = 0.0;
    for (std::size_t m = 0; m < members.size(); ++m) {
      const Interpolated at = interpolate(members[m].segment, x);
      values[m].push_back(at.value);
      kept += at.kept / static_cast<double>(members.size());
    }
    for (auto& sequence : values) sequence.back() /= std::sqrt(kept);
  }
  return values;
}

double rms(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double v : x) sum += v * v;
  return x.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(x.size()));
}

double median_of(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  const std::size_t half = x.size() / 2;
  return x.size() % 2 == 1 ? x[half] : 0.5 * (x[half - 1] + x[half]);
}

constexpr double kLoud = 2.0;  ///< times the median loudness: an accident, no noise

/// Loudness of each repeat about the point-wise median of all: the median does not move with one
/// of three or more, so that an accident is seen in the run that had it and in no other.
std::vector<double> loudness_about_median(const Sequences& values) {
  std::vector<std::vector<double>> about(values.size());
  std::vector<double> here(values.size());
  for (std::size_t g = 0; g < values.front().size(); ++g) {
    for (std::size_t m = 0; m < values.size(); ++m) here[m] = values[m][g];
    const double centre = median_of(here);
    for (std::size_t m = 0; m < values.size(); ++m) about[m].push_back(here[m] - centre);
  }
  std::vector<double> loudness;
  loudness.reserve(about.size());
  for (const auto& sequence : about) loudness.push_back(rms(sequence));
  return loudness;
}

/// Deviations from the mean of those of the repeats that had no accident. With k of them white
/// noise of variance s^2 leaves s^2 (1 - 1/k) in each and s^2 (1 + 1/k) in any other: divided out.
Sequences deviations(const Sequences& values, const std::vector<bool>& accident) {
  std::vector<bool> counts(values.size());
  double k = 0.0;
  for (std::size_t m = 0; m < values.size(); ++m) {
    counts[m] = !accident[m];
    if (counts[m]) k += 1.0;
  }
  if (k < 2.0) {
    counts.assign(values.size(), true);
    k = static_cast<double>(values.size());
  }
  Sequences result(values.size());
  for (std::size_t g = 0; g < values.front().size(); ++g) {
    double mean = 0.0;
    for (std::size_t m = 0; m < values.size(); ++m)
      if (counts[m]) mean += values[m][g] / k;
    for (std::size_t m = 0; m < values.size(); ++m)
      result[m].push_back((values[m][g] - mean) /
                          std::sqrt(counts[m] ? 1.0 - 1.0 / k : 1.0 + 1.0 / k));
  }
  return result;
}

/// Deviations between the repeats of all places of one channel. One run's accident (a slip, a
/// drift) must not pass for noise: it has no say in the centre, and what is louder than kLoud times
/// the median is brought down to that.
Sequences deviations_of_channel(const std::vector<Sequences>& places) {
  std::vector<std::vector<double>> loudness;
  std::vector<double> all;
  for (const Sequences& values : places) {
    loudness.push_back(loudness_about_median(values));
    all.insert(all.end(), loudness.back().begin(), loudness.back().end());
  }
  const double loud = kLoud * median_of(all);
  Sequences result;
  for (std::size_t p = 0; p < places.size(); ++p) {
    std::vector<bool> accident(places[p].size(), false);
    if (places[p].size() >= 3 && loud > 0.0)
      for (std::size_t m = 0; m < accident.size(); ++m) accident[m] = loudness[p][m] > loud;
    for (auto& sequence : deviations(places[p], accident)) result.push_back(std::move(sequence));
  }
  if (result.size() < 3) return result;
  all.clear();
  for (const auto& sequence : result) all.push_back(rms(sequence));
  const double limit = kLoud * median_of(all);
  for (std::size_t i = 0; i < result.size(); ++i)
    if (all[i] > limit && limit > 0.0)
      for (double& v : result[i]) v *= limit / all[i];
  return result;
}

/// Along which axis, and which directions are free, which are moved and which are held.
std::string setup_of(const Curves& curves) {
  std::string setup = " " + std::to_string(curves.path.axis_angle_rad) + " ";
  for (int i = 0; i < 3; ++i) {
    double lo = 1e300, hi = -1e300;
    for (const Eigen::Vector3d& q : curves.path.q) lo = std::min(lo, q[i]), hi = std::max(hi, q[i]);
    const bool is_free = curves.path.is_free[static_cast<std::size_t>(i)];
    setup += is_free ? 'f' : hi > lo ? 'm' : 'h';
  }
  return setup;
}

/// Captures of one set-up have one noise, of which the scatter of each says more or less by what it
/// did. One that scatters much further has a noise of its own, one that scatters much less keeps
/// some of its weight.
void pool_scatter(const DataSet& data, Noise& noise) {
  std::map<std::string, std::pair<double, double>> squares;  // their sum, how many
  std::vector<std::string> setups;
  for (const Curves& curves : data.curves) setups.push_back(setup_of(curves));
  const auto each = [&](auto&& visit) {
    for (std::size_t i = 0; i < data.curves.size(); ++i)
      for (std::size_t c = 0; c < noise.channels[i].size(); ++c)
        if (noise.channels[i][c].source == NoiseSource::scatter)
          visit(squares[data.curves[i].channels[c].name + setups[i]], noise.channels[i][c]);
  };
  each([](auto& sum, const ChannelNoise& entry) {
    sum.first += entry.sigma * entry.sigma;
    sum.second += 1.0;
  });
  each([](const auto& sum, ChannelNoise& entry) {
    constexpr double kFurther = 1.5, kLess = 0.25;
    const double pooled = std::sqrt(sum.first / sum.second);
    if (entry.sigma > kFurther * pooled) return;
    const double sigma = std::min(pooled, entry.sigma / kLess);
    if (entry.floor_sigma == entry.sigma) entry.floor_sigma = sigma;
    entry.sigma = sigma;
  });
}

}  // namespace

const char* noise_source_words(NoiseSource source) {
  switch (source) {
    case NoiseSource::declared:
      return "declared by the capture";
    case NoiseSource::repeats:
      return "scatter between repeats";
    case NoiseSource::scatter:
      return "scatter of neighbouring samples";
    case NoiseSource::guess:
      return "guessed, for the capture states none and shows none";
  }
  return "";
}

Noise estimate_noise(const DataSet& data, const std::vector<Row>& rows,
                     const Eigen::VectorXd& residuals) {
  Noise noise;
  // residuals (SI) of every curve, channel and block
  using BlockRows = std::map<int, std::pair<std::vector<int>, std::vector<double>>>;
  std::vector<std::vector<BlockRows>> by_block(data.curves.size());
  for (std::size_t i = 0; i < data.curves.size(); ++i)
    by_block[i].resize(data.curves[i].channels.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row& row = rows[r];
    const auto i = static_cast<std::size_t>(row.curve);
    const auto c = static_cast<std::size_t>(row.channel);
    const int block = data.curves[i].block_of[static_cast<std::size_t>(row.frame)];
    auto& entry = by_block[i][c][block];
    entry.first.push_back(row.frame);
    entry.second.push_back(-residuals[static_cast<Eigen::Index>(r)] * data.sigma[i][c]);
  }
  // repeats: same group, same place of the block within its run, same channel
  std::map<std::string, int> runs_in_group;
  std::map<std::pair<std::string, std::string>, std::vector<Member>> members;
  for (std::size_t i = 0; i < data.curves.size(); ++i) {
    const Curves& curves = data.curves[i];
    std::vector<int> order;
    for (const CurveRun& run : curves.runs) order.push_back(runs_in_group[run.group]++);
    std::vector<int> blocks_so_far(curves.runs.size(), 0);
    for (std::size_t b = 0; b < curves.blocks.size(); ++b) {
      const auto run = static_cast<std::size_t>(curves.blocks[b].run);
      const std::string place = curves.runs[run].group + "#" + std::to_string(blocks_so_far[run]++);
      for (std::size_t c = 0; c < curves.channels.size(); ++c) {
        const auto found = by_block[i][c].find(static_cast<int>(b));
        if (found == by_block[i][c].end() || found->second.first.size() < 3) continue;
        members[{curves.channels[c].name, place}].push_back(
            {order[run],
             make_segment(curves, curves.blocks[b], found->second.first, found->second.second)});
      }
    }
  }
  std::map<std::string, std::vector<Sequences>> places;  // by channel name, SI
  for (auto& [key, list] : members)
    if (Sequences values = aligned(list); !values.empty())
      places[key.first].push_back(std::move(values));
  std::map<std::string, Sequences> repeats;
  for (const auto& [name, of_channel] : places) repeats[name] = deviations_of_channel(of_channel);
  std::map<std::string, double> repeat_sigma;
  for (const auto& [name, sequences] : repeats) {
    double sum = 0.0;
    for (const auto& s : sequences) sum += rms(s) * rms(s);
    repeat_sigma[name] = std::sqrt(sum / static_cast<double>(sequences.size()));
  }

  noise.channels.resize(data.curves.size());
  for (std::size_t i = 0; i < data.curves.size(); ++i) {
    for (std::size_t c = 0; c < data.curves[i].channels.size(); ++c) {
      const ObservedChannel& channel = data.curves[i].channels[c];
      std::vector<std::vector<double>> blocks;
      double range_lo = 0.0;
      double range_hi = 0.0;
      for (const auto& [block, entry] : by_block[i][c]) {
        blocks.push_back(entry.second);
        for (const int f : entry.first) {
          range_lo = std::min(range_lo, channel.measured[static_cast<std::size_t>(f)]);
          range_hi = std::max(range_hi, channel.measured[static_cast<std::size_t>(f)]);
        }
      }
      ChannelNoise entry;
      entry.repeat_sigma = repeat_sigma.contains(channel.name) ? repeat_sigma[channel.name] : 0.0;
      entry.scatter_sigma = scatter_sigma(blocks);
      if (channel.sigma > 0.0) {
        entry.sigma = channel.sigma;
        entry.source = NoiseSource::declared;
      } else if (entry.repeat_sigma > 0.0) {
        entry.sigma = entry.repeat_sigma;
        entry.source = NoiseSource::repeats;
      } else {
        entry.sigma = entry.scatter_sigma;
        entry.source = NoiseSource::scatter;
      }
      // never finer than the instrument resolves, nor than numbers can be trusted
      entry.sigma = std::max(
          {entry.sigma, channel.resolution / std::sqrt(12.0), 1e-5 * (range_hi - range_lo), 1e-12});
      entry.floor_sigma = entry.repeat_sigma > 0.0 ? entry.repeat_sigma : entry.sigma;
      if (!channel.sigma_per_frame.empty()) {
        // a scatter given frame by frame (between specimens, say) sets the floor, not the weights:
        // it is no noise of single readings
        double sum = 0.0;
        for (const double v : channel.sigma_per_frame) sum += std::isfinite(v) ? v * v : 0.0;
        entry.floor_sigma = std::sqrt(sum / static_cast<double>(channel.sigma_per_frame.size()));
      }
      noise.channels[i].push_back(entry);
    }
  }
  pool_scatter(data, noise);
  // whitened pool: every sequence over the sigma of its channel
  for (const auto& [name, sequences] : repeats) {
    double sigma = 0.0;
    for (std::size_t i = 0; i < data.curves.size() && sigma == 0.0; ++i)
      for (std::size_t c = 0; c < data.curves[i].channels.size(); ++c)
        if (data.curves[i].channels[c].name == name) sigma = noise.channels[i][c].sigma;
    for (std::vector<double> s : sequences) {
      for (double& v : s) v /= sigma;
      noise.sequences.push_back(std::move(s));
    }
  }
  return noise;
}

int later_repeats(const DataSet& data) {
  std::map<std::string, int> runs;
  for (const Curves& curves : data.curves)
    for (const CurveRun& run : curves.runs) ++runs[run.group];
  int most = 0;
  for (const auto& [group, count] : runs) most = std::max(most, count >= 3 ? count - 1 : count);
  return most;
}

Eigen::VectorXd repeat_difference(const DataSet& data, const std::vector<Row>& rows,
                                  const Eigen::VectorXd& residuals, int which) {
  struct Piece {
    int run_order = 0;
    std::size_t first = 0;  ///< rows [first, last)
    std::size_t last = 0;
    bool reversed = false;
    Segment segment;
  };
  std::map<std::string, int> runs_in_group;
  std::vector<std::vector<int>> order(data.curves.size());
  for (std::size_t i = 0; i < data.curves.size(); ++i)
    for (const CurveRun& run : data.curves[i].runs) order[i].push_back(runs_in_group[run.group]++);
  std::map<std::pair<std::string, std::string>, std::vector<Piece>> places;
  for (std::size_t first = 0; first < rows.size();) {
    const Row& row = rows[first];
    Piece piece;
    std::vector<int> frames;
    std::vector<double> values;
    std::size_t last = first;
    for (; last < rows.size() && rows[last].block == row.block && rows[last].channel == row.channel;
         ++last) {
      frames.push_back(rows[last].frame);
      values.push_back(residuals[static_cast<Eigen::Index>(last)]);
    }
    const Curves& curves = data.curves[static_cast<std::size_t>(row.curve)];
    const int local = curves.block_of[static_cast<std::size_t>(row.frame)];
    const Block& block = curves.blocks[static_cast<std::size_t>(local)];
    const auto run = static_cast<std::size_t>(block.run);
    int place = 0;
    for (int b = 0; b < local; ++b)
      place += curves.blocks[static_cast<std::size_t>(b)].run == block.run ? 1 : 0;
    if (frames.size() >= 3) {
      piece.run_order = order[static_cast<std::size_t>(row.curve)][run];
      piece.first = first;
      piece.last = last;
      piece.segment = make_segment(curves, block, frames, values);
      piece.reversed = piece.segment.value.front() != values.front();
      places[{curves.channels[static_cast<std::size_t>(row.channel)].name,
              curves.runs[run].group + "#" + std::to_string(place)}]
          .push_back(std::move(piece));
    }
    first = last;
  }
  Eigen::VectorXd difference =
      Eigen::VectorXd::Constant(residuals.size(), std::numeric_limits<double>::quiet_NaN());
  for (auto& [key, pieces] : places) {
    std::sort(pieces.begin(), pieces.end(),
              [](const Piece& a, const Piece& b) { return a.run_order < b.run_order; });
    if (pieces.size() >= 3) pieces.erase(pieces.begin());
    const auto k = static_cast<std::size_t>(which);
    if (pieces.size() < 2 || k >= pieces.size()) continue;
    const Piece& one = pieces[k];
    const Segment& other = pieces[(k + 1) % pieces.size()].segment;
    const std::size_t n = one.segment.x.size();
    for (std::size_t s = 0; s < n; ++s) {
      const double x = one.segment.x[s];
      if (x < other.x.front() || x > other.x.back()) continue;
      const Interpolated there = interpolate(other, x);
      const std::size_t r = one.reversed ? one.last - 1 - s : one.first + s;
      difference[static_cast<Eigen::Index>(r)] =
          (one.segment.value[s] - there.value) / std::sqrt(1.0 + there.kept);
    }
  }
  return difference;
}

}  // namespace tenter::estimation
