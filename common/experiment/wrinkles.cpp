// SPDX-License-Identifier: Apache-2.0
#include "common/experiment/wrinkles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace tenter::experiment {

namespace {

using Vector = std::array<double, 3>;

constexpr double kNothing = -36.0;  // e^this is beside one as its rounding

Vector at(std::span<const double> x, std::size_t node) {
  return {x[3 * node], x[3 * node + 1], x[3 * node + 2]};
}

Vector minus(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

bool all_finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

Expected<void> check_lists(std::span<const int> triangles, std::span<const double> smooth_m,
                           std::span<const double> position_m, double width_m) {
  if (triangles.empty() || triangles.size() % 3 != 0)
    return bad_input("wrinkles: there are no triangles");
  if (smooth_m.size() != position_m.size() || smooth_m.size() % 3 != 0)
    return bad_input("wrinkles: states of " + std::to_string(smooth_m.size()) + " and " +
                     std::to_string(position_m.size()) + " numbers");
  for (const int node : triangles)
    if (node < 0 || static_cast<std::size_t>(node) >= smooth_m.size() / 3)
      return bad_input("wrinkles: a triangle names node " + std::to_string(node) + " of " +
                       std::to_string(smooth_m.size() / 3));
  if (!all_finite(smooth_m) || !all_finite(position_m))
    return bad_input("wrinkles: a position is no number");
  if (!(width_m > 0.0) || !std::isfinite(width_m))
    return bad_input("wrinkles: a width of " + std::to_string(width_m) + " m");
  return {};
}

/// Less what is left of it when smoothed; the lists are those of the nodes.
std::vector<double> without_shape(const std::vector<double>& height,
                                  const std::vector<double>& area, std::span<const double> x,
                                  double width_m) {
  std::vector<double> wrinkle(height.size());
  const double per_square = -0.5 / (width_m * width_m);
  for (std::size_t i = 0; i < height.size(); ++i) {
    const Vector here = at(x, i);
    double sum = 0.0, weights = 0.0;
    for (std::size_t j = 0; j < height.size(); ++j) {
      const Vector way = minus(at(x, j), here);
      const double exponent = per_square * dot(way, way);
      if (exponent < kNothing) continue;
      const double weight = area[j] * std::exp(exponent);
      sum += weight * height[j];
      weights += weight;
    }
    wrinkle[i] = height[i] - sum / weights;
  }
  return wrinkle;
}

double product(const Wrinkles& a, const Wrinkles& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.height_m.size(); ++i)
    sum += a.area_m2[i] * a.height_m[i] * b.height_m[i];
  return sum;
}

}  // namespace

Expected<Wrinkles> wrinkles_of(std::span<const int> triangles, std::span<const double> smooth_m,
                               std::span<const double> position_m, double width_m) {
  if (auto ok = check_lists(triangles, smooth_m, position_m, width_m); !ok)
    return tl::unexpected(ok.error());
  const std::size_t count = smooth_m.size() / 3;
  Wrinkles result{{}, std::vector<double>(count, 0.0)};
  std::vector<Vector> normal(count, Vector{});
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    std::array<std::size_t, 3> corner;
    for (std::size_t c = 0; c < 3; ++c) corner[c] = static_cast<std::size_t>(triangles[t + c]);
    const Vector from = at(smooth_m, corner[0]);
    const Vector doubled =
        cross(minus(at(smooth_m, corner[1]), from), minus(at(smooth_m, corner[2]), from));
    for (const std::size_t node : corner) {
      for (std::size_t k = 0; k < 3; ++k) normal[node][k] += doubled[k];
      result.area_m2[node] += std::sqrt(dot(doubled, doubled)) / 6.0;
    }
  }
  std::vector<double> height(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double length = std::sqrt(dot(normal[i], normal[i]));
    if (!(length > 0.0))
      return bad_input("wrinkles: the smooth state has no normal at node " + std::to_string(i));
    height[i] = dot(minus(at(position_m, i), at(smooth_m, i)), normal[i]) / length;
  }
  result.height_m = without_shape(height, result.area_m2, smooth_m, width_m);
  return result;
}

double height_m(const Wrinkles& wrinkles) {
  double area = 0.0;
  for (const double a : wrinkles.area_m2) area += a;
  return area > 0.0 ? std::sqrt(product(wrinkles, wrinkles) / area) : 0.0;
}

Expected<double> likeness(const Wrinkles& a, const Wrinkles& b) {
  if (a.height_m.size() != b.height_m.size() || a.area_m2 != b.area_m2)
    return bad_input("likeness: wrinkles of different sheets");
  const double squares = product(a, a) * product(b, b);
  if (!(squares > 0.0)) return bad_input("likeness: a state without wrinkles");
  return product(a, b) / std::sqrt(squares);
}

}  // namespace tenter::experiment
