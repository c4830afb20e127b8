// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/knit/knit_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tests/bench/number_table.h"

namespace tenter::bench {
namespace {

using estimation::Sequence;
using estimation::SequenceFrame;
using mechanics::Grid;
using mechanics::Pose;

constexpr int kNodesU = 13, kNodesV = 11;
constexpr std::size_t kReadings = 7;  // on either side of a distance
// denser where the force is steep
constexpr std::array<double, 12> kDistances_m = {0.070, 0.082, 0.094, 0.106, 0.118, 0.128,
                                                 0.138, 0.146, 0.154, 0.160, 0.166, 0.1715};
// columns as they are asked for
constexpr std::size_t kRun = 0, kForce = 1, kFirstPin = 2, kBottomClamp = 12, kTopClamp = 14;
constexpr std::size_t kColumns = 16;

using Row = std::array<double, kColumns>;
using Pulls = std::map<int, std::vector<Row>>;

/// What was read at one clamp distance; places from the middle of the clamps (m).
struct Reading {
  double force_N = 0.0;
  std::array<Eigen::Vector2d, kPins> pin_m;
};

double distance_m(const Row& row) {
  return 1e-3 * (row[kBottomClamp + 1] - row[kTopClamp + 1]);
}

Eigen::Vector2d pin_m(const Row& row, int pin) {
  const std::size_t c = kFirstPin + 2 * static_cast<std::size_t>(pin);
  const Eigen::Vector2d middle(0.5 * (row[kBottomClamp] + row[kTopClamp]),
                               0.5 * (row[kBottomClamp + 1] + row[kTopClamp + 1]));
  return 1e-3 * (Eigen::Vector2d(row[c], row[c + 1]) - middle);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The readings nearest to a distance on either side of it.
struct Near {
  std::vector<Row> below, above;
};

Near near(const std::vector<Row>& rows, double distance) {
  Near near;
  for (const Row& row : rows) (distance_m(row) < distance ? near.below : near.above).push_back(row);
  std::ranges::stable_sort(near.below, std::ranges::greater{}, distance_m);
  std::ranges::stable_sort(near.above, {}, distance_m);
  near.below.resize(std::min(kReadings, near.below.size()));
  near.above.resize(std::min(kReadings, near.above.size()));
  return near;
}

/// On the line through the medians of either side.
template <class Value>
double value_at(const Near& near, double distance, const Value& value) {
  const auto middle = [](const std::vector<Row>& rows, const auto& of) {
    std::vector<double> values;
    values.reserve(rows.size());
    for (const Row& row : rows) values.push_back(of(row));
    return median(std::move(values));
  };
  const double below = middle(near.below, distance_m);
  const double share = (distance - below) / (middle(near.above, distance_m) - below);
  const double at_below = middle(near.below, value);
  return at_below + share * (middle(near.above, value) - at_below);
}

Reading read_at(const std::vector<Row>& rows, double distance) {
  const Near readings = near(rows, distance);
  Reading reading;
  reading.force_N = value_at(readings, distance, [](const Row& row) { return row[kForce]; });
  for (int pin = 0; pin < kPins; ++pin)
    for (int axis = 0; axis < 2; ++axis)
      reading.pin_m[static_cast<std::size_t>(pin)][axis] =
          value_at(readings, distance, [&](const Row& row) { return pin_m(row, pin)[axis]; });
  return reading;
}

Expected<Pulls> read_pulls(const std::string& path) {
  std::vector<std::string> columns = {"run", "force_N"};
  for (const char* point : {"right_pin", "left_pin", "bottom_pin", "top_pin", "centre_pin",
                            "bottom_clamp", "top_clamp"})
    for (const char* axis : {"_x_mm", "_y_mm"}) columns.push_back(point + std::string(axis));
  const auto rows = read_numbers(path, columns);
  if (!rows) return tl::unexpected(rows.error());
  Pulls pulls;
  for (const std::vector<double>& cells : *rows) {
    Row row{};
    std::ranges::copy(cells, row.begin());
    pulls[static_cast<int>(row[kRun])].push_back(row);
  }
  return pulls;
}

/// Standard deviation from pull to pull of the fitted ones, root mean square over values.
template <class Value>
double repeatability(const std::vector<std::vector<Reading>>& readings,
                     const std::vector<int>& fitted, const Value& value) {
  double squares = 0.0;
  for (std::size_t f = 0; f < kDistances_m.size(); ++f) {
    double sum = 0.0, square = 0.0;
    const auto n = static_cast<double>(fitted.size());
    for (const int pull : fitted) {
      const double v = value(readings[static_cast<std::size_t>(pull)][f]);
      sum += v;
      square += v * v;
    }
    squares += (square - sum * sum / n) / (n - 1.0);
  }
  return std::sqrt(squares / static_cast<double>(kDistances_m.size()));
}

/// The sheet at rest, and its clips along both clamps.
Expected<void> lay_out(double width_m, double length_m, Sequence& s) {
  const Grid grid{kNodesU, kNodesV, width_m, length_m};
  auto cloth = cloth_of_grid(grid, mechanics::Diagonals::both);
  if (!cloth) return tl::unexpected(cloth.error());
  s.cloth = *cloth;
  const auto& mesh = s.cloth.mesh;
  s.start.x.setZero(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n)
    s.start.x.segment<2>(3 * static_cast<Eigen::Index>(n)) = mesh.material_m.col(n);
  std::vector<int> top, bottom;
  for (int i = 0; i < kNodesU; ++i) {
    top.push_back(grid.node(i, 0));
    bottom.push_back(grid.node(i, kNodesV - 1));
  }
  s.boundaries.resize(1);
  s.boundaries[0].clips = {clip_on("top", top, s.start.x, Pose{}),
                           clip_on("bottom", bottom, s.start.x, Pose{})};
  s.start.clips = {Pose{}, Pose{}};
  s.loads.node_mass_kg = Eigen::VectorXd::Zero(mesh.node_count());
  return {};
}

/// Where a solve begins: stretched evenly, and narrower in the middle.
mechanics::State stretched(const Sequence& s, const std::vector<Pose>& clips, double width_m,
                           double stretch) {
  mechanics::State state = s.start;
  state.clips = clips;
  const double narrowing = 0.19 * (stretch - 1.0);
  for (Eigen::Index n = 0; n < state.x.size(); n += 3) {
    const double t = state.x[n + 1] / s.cloth.mesh.material_m.row(1).maxCoeff();
    state.x[n] -= (state.x[n] - 0.5 * width_m) * narrowing * 4.0 * t * (1.0 - t);
    state.x[n + 1] *= stretch;
  }
  return state;
}

}  // namespace

Expected<KnitData> read_knit(const std::string& path, double width_m,
                             const std::vector<int>& fitted) {
  const auto pulls = read_pulls(path);
  if (!pulls) return tl::unexpected(pulls.error());
  KnitData data;
  data.pulls = static_cast<int>(pulls->size());
  data.distances_m.assign(kDistances_m.begin(), kDistances_m.end());
  std::vector<std::vector<Reading>> readings;
  std::vector<double> first_m;
  for (const auto& [number, rows] : *pulls) {
    const auto [least, most] = std::ranges::minmax(rows, {}, distance_m);
    if (distance_m(least) >= kDistances_m.front() || distance_m(most) < kDistances_m.back())
      return bad_input(path + ": pull " + std::to_string(number) + " does not reach all distances");
    first_m.push_back(distance_m(rows.front()));
    std::vector<Reading>& own = readings.emplace_back();
    for (const double distance : kDistances_m) own.push_back(read_at(rows, distance));
  }
  std::array<Eigen::Vector2d, kPins> taut_m;
  taut_m.fill(Eigen::Vector2d::Zero());
  for (const int pull : fitted) {
    if (pull < 0 || pull >= data.pulls) return bad_input(path + ": has fewer pulls");
    const auto p = static_cast<std::size_t>(pull);
    data.rest_length_m += first_m[p] / static_cast<double>(fitted.size());
    for (std::size_t pin = 0; pin < kPins; ++pin)
      taut_m[pin] += readings[p][kTautFrame].pin_m[pin] / static_cast<double>(fitted.size());
  }

  Sequence& s = data.sequence;
  s.name = "knit";
  if (auto ok = lay_out(width_m, data.rest_length_m, s); !ok) return tl::unexpected(ok.error());
  // the side pins stand as far from either edge: the dots are not in the middle of the clamps
  const Eigen::Vector2d origin(0.5 * width_m - 0.5 * (taut_m[0].x() + taut_m[1].x()), 0.0);
  double pin_variance = 0.0;
  for (std::size_t pin = 0; pin < kPins; ++pin)
    for (int axis = 0; axis < 2; ++axis)
      pin_variance += std::pow(repeatability(readings, fitted,
                                             [&](const Reading& r) { return r.pin_m[pin][axis]; }),
                               2) /
                      (2.0 * kPins);
  const double force_sigma =
      repeatability(readings, fitted, [](const Reading& r) { return r.force_N; });
  for (int pull = 0; pull < data.pulls; ++pull) {
    for (const Eigen::Vector2d& taut : taut_m) {
      Eigen::Vector2d place = taut + origin;
      place.y() = data.rest_length_m * (0.5 + taut.y() / kDistances_m[kTautFrame]);
      s.points.push_back({place, std::sqrt(pin_variance)});
    }
    s.forces.push_back({1, Eigen::Vector3d::UnitY(), force_sigma, false});
  }
  for (std::size_t f = 0; f < kDistances_m.size(); ++f) {
    SequenceFrame frame;
    Pose bottom;
    bottom.position_m.y() = kDistances_m[f] - data.rest_length_m;
    frame.clips = {Pose{}, bottom};
    frame.start = stretched(s, frame.clips, width_m, kDistances_m[f] / data.rest_length_m);
    frame.points_m.resize(3, kPins * data.pulls);
    frame.forces_N.resize(data.pulls);
    for (int pull = 0; pull < data.pulls; ++pull) {
      const Reading& reading = readings[static_cast<std::size_t>(pull)][f];
      frame.forces_N[pull] = reading.force_N;
      for (int pin = 0; pin < kPins; ++pin)
        frame.points_m.col(kPins * pull + pin)
            << reading.pin_m[static_cast<std::size_t>(pin)] +
                   Eigen::Vector2d(origin.x(), 0.5 * kDistances_m[f]),
            std::numeric_limits<double>::quiet_NaN();
    }
    frame.block = static_cast<int>(f);
    s.frames.push_back(std::move(frame));
  }
  return data;
}

}  // namespace tenter::bench
