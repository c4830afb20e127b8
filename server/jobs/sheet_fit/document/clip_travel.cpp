// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/document/clip_travel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tenter::jobs {
namespace {

using estimation::Sequence;

// a clip whose way is a smaller share than this of the farthest one's stays
constexpr double kStays = 0.2;
// it waits within this share of its way from its least pull, where another is beyond the second
constexpr double kWaits = 0.1;
constexpr double kIsPulled = 0.25;

/// The middle of the clip's material, one column a frame. A clip that turns has no other point that
/// says where it is.
Eigen::Matrix3Xd middles(const Sequence& sequence, std::size_t clip) {
  Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(sequence.frames.size()));
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const estimation::SequenceFrame& frame = sequence.frames[f];
    const auto& places =
        sequence.boundaries[static_cast<std::size_t>(frame.boundary)].clips[clip].place_m;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& place : places) middle += place;
    middle /= static_cast<double>(std::max<std::size_t>(1, places.size()));
    all.col(static_cast<Eigen::Index>(f)) = frame.clips[clip].to_space(middle);
  }
  return all;
}

Eigen::Matrix3Xd since_first(const Eigen::Matrix3Xd& place) {
  const Eigen::Vector3d first = place.col(0);
  return place.colwise() - first;
}

Eigen::Vector3d direction_of(const Eigen::Matrix3Xd& way) {
  Eigen::Index most = 0;
  const double length = way.colwise().norm().maxCoeff(&most);
  return length > 0.0 ? Eigen::Vector3d(way.col(most) / length) : Eigen::Vector3d::Zero();
}

/// A clip's way along its direction.
struct Way {
  Eigen::VectorXd along;
  bool is_pulled = false;  ///< out of the sheet; counted from the least pull

  double range() const { return along.maxCoeff() - along.minCoeff(); }
};

Way way_of(const Eigen::Matrix3Xd& place, const Eigen::Vector3d& centre) {
  const Eigen::Matrix3Xd way = since_first(place);
  Eigen::Vector3d direction = direction_of(way);
  const Eigen::Vector3d outwards = (place.col(0) - centre).normalized();
  const double pull = direction.dot(outwards);
  if (std::abs(pull) < 0.5) return {way.transpose() * direction, false};
  if (pull < 0.0) direction = -direction;
  Eigen::VectorXd along = way.transpose() * direction;
  along.array() -= along.minCoeff();
  return {std::move(along), true};
}

std::vector<double> listed(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

}  // namespace

ClipTravel clip_travel(const Sequence& sequence, std::size_t clip) {
  const auto& clips = sequence.boundaries.front().clips;
  std::vector<Eigen::Matrix3Xd> places;
  places.reserve(clips.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < clips.size(); ++k) {
    places.push_back(middles(sequence, k));
    centre += places.back().col(0) / static_cast<double>(clips.size());
  }
  if (places.size() == 2) {
    const Eigen::Matrix3Xd way = since_first(places[clip]) - since_first(places[1 - clip]);
    return {listed(way.transpose() * direction_of(way)), "travel between the clips"};
  }
  std::vector<Way> ways;
  ways.reserve(places.size());
  for (const Eigen::Matrix3Xd& place : places) ways.push_back(way_of(place, centre));
  const auto most = std::max_element(
      ways.begin(), ways.end(), [](const Way& a, const Way& b) { return a.range() < b.range(); });
  const Way& own = ways[clip];
  if (own.range() < kStays * most->range())
    return {listed(most->along),
            "travel of clip " + clips[static_cast<std::size_t>(most - ways.begin())].id};
  ClipTravel travel{listed(own.along), "travel of the clip"};
  bool waits = false;
  for (std::size_t f = 0; own.is_pulled && f < travel.along_m.size(); ++f) {
    const auto at = static_cast<Eigen::Index>(f);
    if (own.along[at] > kWaits * own.range()) continue;
    double others = 0.0;
    for (const Way& other : ways)
      if (other.is_pulled && other.along[at] > kIsPulled * other.range())
        others = std::max(others, other.along[at]);
    if (others == 0.0) continue;
    travel.along_m[f] = -others;
    waits = true;
  }
  if (waits) travel.words += "; below zero: of others while it waits";
  return travel;
}

}  // namespace tenter::jobs
