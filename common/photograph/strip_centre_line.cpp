// SPDX-License-Identifier: Apache-2.0
#include "common/photograph/strip_centre_line.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <string>

namespace tenter::photograph {
namespace {

using Point = std::array<double, 2>;

constexpr double kFar = std::numeric_limits<double>::infinity();

Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1]};
}
double length(const Point& a) {
  return std::hypot(a[0], a[1]);
}
std::string words(const Point& pixel) {
  return "pixel (" + std::to_string(std::lround(pixel[0])) + ", " +
         std::to_string(std::lround(pixel[1])) + ")";
}

/// The level that parts two heaps of grey levels best (Otsu): largest variance between them.
int otsu(const GrayImage& image, const std::array<int, 4>& box) {
  std::array<double, 256> count{};
  for (int y = box[1]; y <= box[3]; ++y)
    for (int x = box[0]; x <= box[2]; ++x) count[image.at(x, y)] += 1.0;
  double all = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < count.size(); ++i) {
    all += count[i];
    sum += static_cast<double>(i) * count[i];
  }
  double below = 0.0, sum_below = 0.0, best = -1.0;
  double first = 0.0, last = 0.0;  // of the levels that are equally good
  for (std::size_t i = 0; i + 1 < count.size(); ++i) {
    below += count[i];
    sum_below += static_cast<double>(i) * count[i];
    if (below == 0.0 || below == all) continue;
    const double apart = sum_below / below - (sum - sum_below) / (all - below);
    const double between = below * (all - below) * apart * apart;
    if (between > best * (1.0 + 1e-12)) {
      best = between;
      first = static_cast<double>(i);
    }
    if (between >= best * (1.0 - 1e-12)) last = static_cast<double>(i);
  }
  return static_cast<int>(std::lround(0.5 * (first + last) + 0.5));
}

/// The dark piece at the clamp, with the way from there to each of its pixels.
class DarkPiece {
 public:
  DarkPiece(const GrayImage& image, const std::array<int, 4>& box, int threshold)
      : image_(image), box_(box), threshold_(threshold) {}

  bool is_dark(int x, int y) const {
    return x >= box_[0] && x <= box_[2] && y >= box_[1] && y <= box_[3] &&
           image_.at(x, y) < threshold_;
  }

  /// The dark pixel nearest to the clamp, within `reach` of it.
  std::optional<std::array<int, 2>> nearest(const Point& clamp, int reach) const {
    std::optional<std::array<int, 2>> best;
    double least = kFar;
    const int cx = static_cast<int>(std::lround(clamp[0]));
    const int cy = static_cast<int>(std::lround(clamp[1]));
    for (int y = cy - reach; y <= cy + reach; ++y)
      for (int x = cx - reach; x <= cx + reach; ++x) {
        const double away = std::hypot(x - clamp[0], y - clamp[1]);
        if (away < least && is_dark(x, y)) {
          least = away;
          best = {x, y};
        }
      }
    return best;
  }

  /// Ways by Dijkstra's algorithm; pixels in the order in which they were reached.
  void measure(const std::array<int, 2>& start) {
    const auto width = static_cast<std::size_t>(image_.width);
    way_.assign(width * static_cast<std::size_t>(image_.height), kFar);
    const auto index = [&](int x, int y) {
      return static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
    };
    using Entry = std::pair<double, std::size_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> waiting;
    way_[index(start[0], start[1])] = 0.0;
    waiting.push({0.0, index(start[0], start[1])});
    while (!waiting.empty()) {
      const auto [way, at] = waiting.top();
      waiting.pop();
      if (way > way_[at]) continue;
      const int x = static_cast<int>(at % width);
      const int y = static_cast<int>(at / width);
      pixels.push_back({static_cast<double>(x), static_cast<double>(y)});
      ways.push_back(way);
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          if (!is_dark(x + dx, y + dy)) continue;
          const double next = way + std::hypot(dx, dy);
          if (next >= way_[index(x + dx, y + dy)]) continue;
          way_[index(x + dx, y + dy)] = next;
          waiting.push({next, index(x + dx, y + dy)});
        }
    }
  }

  std::vector<Point> pixels;  ///< of the piece
  std::vector<double> ways;   ///< of each, rising

 private:
  const GrayImage& image_;
  std::array<int, 4> box_;
  int threshold_;
  std::vector<double> way_;
};

/// Centroids of pieces of `step` pixels of way; bad_input where a piece is far wider than is usual.
Expected<std::vector<Point>> first_line(const DarkPiece& piece, double step, double width) {
  std::vector<Point> line;
  std::size_t from = 0;
  for (double edge = step; from < piece.ways.size(); edge += step) {
    std::size_t to = from;
    Point sum = {0.0, 0.0};
    while (to < piece.ways.size() && piece.ways[to] < edge) {
      sum = {sum[0] + piece.pixels[to][0], sum[1] + piece.pixels[to][1]};
      ++to;
    }
    if (to == from) continue;
    const auto count = static_cast<double>(to - from);
    const Point middle = {sum[0] / count, sum[1] / count};
    for (std::size_t i = from; i < to; ++i)
      if (length(minus(piece.pixels[i], middle)) > 2.5 * width + step)
        return bad_input("the strip touches itself or something dark near " + words(middle) +
                         ": a piece of it is far wider than the rest");
    line.push_back(middle);
    from = to;
  }
  return line;
}

/// Where the grey level crosses the threshold, from a dark place on in a direction; negative: not
/// within reach.
double edge_from(const GrayImage& image, const Point& at, const Point& direction, double threshold,
                 double reach) {
  constexpr double kStep = 0.25;
  double before = image.level_at(at[0], at[1]);
  if (before >= threshold) return -1.0;
  for (double way = kStep; way <= reach; way += kStep) {
    const double level = image.level_at(at[0] + way * direction[0], at[1] + way * direction[1]);
    if (level >= threshold) return way - kStep * (level - threshold) / (level - before);
    before = level;
  }
  return -1.0;
}

Point tangent_at(const std::vector<Point>& line, std::size_t i) {
  const std::size_t lo = i == 0 ? 0 : i - 1;
  const std::size_t hi = std::min(i + 1, line.size() - 1);
  const Point way = minus(line[hi], line[lo]);
  const double size = std::max(length(way), 1e-12);
  return {way[0] / size, way[1] / size};
}

/// Every point moved to the middle of the edges across the line; those without two edges go. Widths
/// are collected.
std::vector<Point> between_edges(const GrayImage& image, const std::vector<Point>& line,
                                 double threshold, double reach, std::vector<double>& widths) {
  std::vector<Point> moved;
  widths.clear();
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Point along = tangent_at(line, i);
    const Point across = {-along[1], along[0]};
    const double left = edge_from(image, line[i], across, threshold, reach);
    const double right = edge_from(image, line[i], {along[1], -along[0]}, threshold, reach);
    if (left < 0.0 || right < 0.0) continue;
    const double off = 0.5 * (left - right);
    moved.push_back({line[i][0] + off * across[0], line[i][1] + off * across[1]});
    widths.push_back(left + right);
  }
  return moved;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Which way the line goes on beyond its end, on the mean over a way `ahead`, when it goes on
/// turning as it does over its last points.
Point beyond(const std::vector<Point>& line, bool at_front, double ahead) {
  const auto at = [&](std::size_t i) { return at_front ? line[i] : line[line.size() - 1 - i]; };
  // far enough apart that a tenth of a pixel does not turn it
  const std::size_t apart = std::min<std::size_t>(4, (line.size() - 1) / 2);
  const Point last = minus(at(0), at(apart));
  const Point before = minus(at(apart), at(2 * apart));
  const double angle = std::atan2(last[1], last[0]);
  const double turn = std::remainder(angle - std::atan2(before[1], before[0]), 2.0 * M_PI);
  const double rate = turn / (0.5 * (length(last) + length(before)));
  const double mean = angle + 0.5 * rate * (length(last) + ahead);
  return {std::cos(mean), std::sin(mean)};
}

/// The line from beside the clamp to the edge of the free end: pieces near both ends, whose
/// centroids and edges are those of corners, make way for ones that go on as the line does.
std::vector<Point> with_ends(const GrayImage& image, std::vector<Point> line, const Point& clamp,
                             double threshold, double width) {
  while (line.size() > 8 && length(minus(line.front(), clamp)) < 0.8 * width)
    line.erase(line.begin());
  const Point start = beyond(line, true, length(minus(line.front(), clamp)));
  const Point to_clamp = minus(clamp, line.front());
  const double back = to_clamp[0] * start[0] + to_clamp[1] * start[1];
  line.insert(line.begin(), {line.front()[0] + back * start[0], line.front()[1] + back * start[1]});
  const auto end_way = [&](const Point& along) {
    return edge_from(image, line.back(), along, threshold, 6.0 * width);
  };
  while (line.size() > 8 && end_way(beyond(line, false, width)) < 0.8 * width) line.pop_back();
  const Point along = beyond(line, false, width);
  const double way = end_way(along);
  if (way > 0.0) line.push_back({line.back()[0] + way * along[0], line.back()[1] + way * along[1]});
  return line;
}

Expected<std::array<int, 4>> box_of(const GrayImage& image, const StripView& view) {
  const std::array<int, 4> whole = {0, 0, image.width - 1, image.height - 1};
  if (!view.region) return whole;
  const std::array<int, 4>& box = *view.region;
  if (box[0] < 0 || box[1] < 0 || box[2] > whole[2] || box[3] > whole[3] || box[0] >= box[2] ||
      box[1] >= box[3])
    return bad_input("the region is not within the picture of " + std::to_string(image.width) +
                     " x " + std::to_string(image.height) + " pixels");
  return box;
}

}  // namespace

Expected<StripCentreLine> strip_centre_line(const GrayImage& image, const StripView& view) {
  if (!(view.metres_per_pixel > 0.0) || !std::isfinite(view.metres_per_pixel))
    return bad_input("the scale of the picture must be above zero");
  const auto box = box_of(image, view);
  if (!box) return tl::unexpected(box.error());
  const Point clamp = {view.clamp_x, view.clamp_y};
  if (!(clamp[0] >= (*box)[0] && clamp[0] <= (*box)[2] && clamp[1] >= (*box)[1] &&
        clamp[1] <= (*box)[3]))
    return bad_input("the clamp is outside of the picture");
  StripCentreLine result;
  result.threshold = view.threshold.value_or(otsu(image, *box));
  DarkPiece piece(image, *box, result.threshold);
  constexpr int kReach = 20;
  const auto start = piece.nearest(clamp, kReach);
  if (!start)
    return bad_input("nothing darker than level " + std::to_string(result.threshold) + " within " +
                     std::to_string(kReach) + " pixels of the clamp at " + words(clamp));
  piece.measure(*start);
  const double way = piece.ways.back();
  const double width = static_cast<double>(piece.pixels.size()) / std::max(1.0, way);
  if (width < 3.0)
    return bad_input("the strip is thinner than 3 pixels: a closer picture is needed");
  if (way < 15.0 * width)
    return bad_input("what is dark at the clamp is no strip: it is " +
                     std::to_string(std::lround(way)) + " pixels long and " +
                     std::to_string(std::lround(width)) + " wide");
  const auto coarse = first_line(piece, std::max(2.0, 0.5 * width), width);
  if (!coarse) return tl::unexpected(coarse.error());
  std::vector<double> widths;
  std::vector<Point> line = *coarse;
  for (int round = 0; round < 2; ++round)
    line = between_edges(image, line, result.threshold, 2.0 * width, widths);
  if (line.size() < 12)
    return bad_input("the strip has no clear edges: is it darker than all around it?");
  line = with_ends(image, std::move(line), clamp, result.threshold, median(widths));
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Point at = {view.metres_per_pixel * (line[i][0] - clamp[0]),
                      view.metres_per_pixel * (clamp[1] - line[i][1])};
    if (i > 0) result.length_m += length(minus(at, result.points_m.back()));
    result.points_m.push_back(at);
  }
  result.width_m = view.metres_per_pixel * median(widths);
  return result;
}

}  // namespace tenter::photograph
