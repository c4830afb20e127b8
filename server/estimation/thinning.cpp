// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/thinning.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tenter::estimation {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Those of the frames [from, to) that have a reading; all where none has.
std::vector<std::size_t> read_frames(const Curves& curves,
                                     const std::vector<std::vector<bool>>& left_out, int from,
                                     int to) {
  std::vector<std::size_t> all, read;
  for (auto f = static_cast<std::size_t>(from); f < static_cast<std::size_t>(to); ++f) {
    all.push_back(f);
    for (std::size_t c = 0; c < curves.channels.size(); ++c)
      if (!left_out[c][f] && std::isfinite(curves.channels[c].measured[f])) {
        read.push_back(f);
        break;
      }
  }
  return read.empty() ? all : read;
}

}  // namespace

Curves thin(const Curves& curves, int max_frames, const std::vector<std::vector<bool>>& left_out) {
  Curves result = curves;
  const std::array<std::vector<double>, 3> motion = {
      last_motions_of(curves, 0), last_motions_of(curves, 1), last_motions_of(curves, 2)};
  for (auto& component : result.mean_last_motion) component.clear();
  result.path.q.clear();
  result.path.duration_s.clear();
  result.path.start.clear();
  result.clock_s.clear();
  result.frame.clear();
  result.origin.clear();
  result.block_of.clear();
  for (ObservedChannel& channel : result.channels) {
    channel.measured.clear();
    channel.sigma_per_frame.clear();
  }
  for (std::size_t b = 0; b < curves.blocks.size(); ++b) {
    const Block& block = curves.blocks[b];
    const int length = block.last - block.first;
    const int pieces = std::min(length, max_frames);
    result.blocks[b].first = static_cast<int>(result.path.q.size());
    for (int piece = 0; piece < pieces; ++piece) {
      const int from = block.first + static_cast<int>(static_cast<long>(length) * piece / pieces);
      const int to =
          block.first + static_cast<int>(static_cast<long>(length) * (piece + 1) / pieces);
      const std::vector<std::size_t> members = read_frames(curves, left_out, from, to);
      Eigen::Vector3d q = Eigen::Vector3d::Zero();
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      double clock = 0.0;
      for (const std::size_t f : members) {
        q += curves.path.q[f];
        clock += curves.clock_s[f];
        moved += Eigen::Vector3d(motion[0][f], motion[1][f], motion[2][f]);
      }
      const auto count = static_cast<double>(members.size());
      result.path.q.push_back(q / count);
      result.clock_s.push_back(clock / count);
      for (int i = 0; i < 3; ++i)
        result.mean_last_motion[static_cast<std::size_t>(i)].push_back(moved[i] / count);
      result.frame.push_back(curves.frame[static_cast<std::size_t>(from)]);
      result.origin.push_back(curves.origin[static_cast<std::size_t>(from)]);
      result.block_of.push_back(static_cast<int>(b));
      auto start = mechanics::FrameStart::next;
      for (int f = from; f < to; ++f)
        if (curves.path.start[static_cast<std::size_t>(f)] != mechanics::FrameStart::next)
          start = curves.path.start[static_cast<std::size_t>(f)];
      result.path.start.push_back(start);
      const auto i = result.clock_s.size() - 1;
      const bool starts_run = from == curves.runs[static_cast<std::size_t>(block.run)].first;
      const bool no_step =
          i == 0 || start != mechanics::FrameStart::next ||
          (starts_run && curves.path.duration_s[static_cast<std::size_t>(from)] == 0.0);
      result.path.duration_s.push_back(no_step ? 0.0 : result.clock_s[i] - result.clock_s[i - 1]);
      for (std::size_t c = 0; c < curves.channels.size(); ++c) {
        double sum = 0.0;
        double variance = 0.0;
        int used = 0;
        for (int f = from; f < to; ++f) {
          const auto k = static_cast<std::size_t>(f);
          if (left_out[c][k] || !std::isfinite(curves.channels[c].measured[k])) continue;
          sum += curves.channels[c].measured[k];
          if (!curves.channels[c].sigma_per_frame.empty())
            variance += curves.channels[c].sigma_per_frame[k];
          ++used;
        }
        result.channels[c].measured.push_back(used > 0 ? sum / used : kMissing);
        if (!curves.channels[c].sigma_per_frame.empty())
          result.channels[c].sigma_per_frame.push_back(used > 0 ? variance / used : kMissing);
      }
    }
    result.blocks[b].last = static_cast<int>(result.path.q.size());
  }
  for (CurveRun& run : result.runs) {
    run.first = static_cast<int>(result.path.q.size());
    run.last = 0;
  }
  for (const Block& block : result.blocks) {
    CurveRun& run = result.runs[static_cast<std::size_t>(block.run)];
    run.first = std::min(run.first, block.first);
    run.last = std::max(run.last, block.last);
  }
  return result;
}

}  // namespace tenter::estimation
