// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/profile_curve.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace tenter::estimation {
namespace {

constexpr int kCells = 240;  // of the grid: a tight coil turns a few degrees in one

/// Places along the strip and directions of chords, from points far enough apart that noise does
/// not lengthen the way.
struct Chords {
  std::vector<double> arcs;        ///< of each point
  std::vector<double> places;      ///< of the chords' middles
  std::vector<double> directions;  ///< unwound
};

Chords chords_of(const std::vector<ContourPoint>& points, double length_m) {
  const std::size_t stride = std::max<std::size_t>(1, points.size() / 50);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < points.size(); i += stride) kept.push_back(i);
  if (kept.back() != points.size() - 1) kept.back() = points.size() - 1;
  Chords chords;
  std::vector<double> at = {0.0};
  for (std::size_t i = 1; i < kept.size(); ++i) {
    const double dx = points[kept[i]].x_m - points[kept[i - 1]].x_m;
    const double dy = points[kept[i]].y_m - points[kept[i - 1]].y_m;
    at.push_back(at.back() + std::hypot(dx, dy));
    double direction = std::atan2(dy, dx);
    if (!chords.directions.empty())
      direction += 2.0 * M_PI * std::round((chords.directions.back() - direction) / (2.0 * M_PI));
    chords.directions.push_back(direction);
  }
  const double scale = at.back() > 0.0 ? length_m / at.back() : 0.0;
  for (std::size_t i = 1; i < at.size(); ++i)
    chords.places.push_back(0.5 * scale * (at[i] + at[i - 1]));
  chords.arcs.resize(points.size());
  for (std::size_t i = 1; i < kept.size(); ++i)
    for (std::size_t k = kept[i - 1]; k <= kept[i]; ++k) {
      const double share = static_cast<double>(k - kept[i - 1]) /
                           static_cast<double>(std::max<std::size_t>(1, kept[i] - kept[i - 1]));
      chords.arcs[k] = scale * ((1.0 - share) * at[i - 1] + share * at[i]);
    }
  return chords;
}

}  // namespace

ProfileCurve::Basis ProfileCurve::basis(double arc_m) const {
  const double x = std::clamp(arc_m / length_, 0.0, 1.0) * intervals_;
  Basis b;
  b.first = std::min(static_cast<int>(x), intervals_ - 1);
  const double t = x - b.first;
  const double u = 1.0 - t;
  b.value[0] = u * u * u / 6.0;
  b.value[1] = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0;
  b.value[2] = (-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0) / 6.0;
  b.value[3] = t * t * t / 6.0;
  const double by_x = intervals_ / length_;
  b.slope[0] = -0.5 * u * u * by_x;
  b.slope[1] = (1.5 * t * t - 2.0 * t) * by_x;
  b.slope[2] = (-1.5 * t * t + t + 0.5) * by_x;
  b.slope[3] = 0.5 * t * t * by_x;
  return b;
}

double ProfileCurve::direction(double arc_m) const {
  const Basis b = basis(arc_m);
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) sum += b.value[k] * coefficients_[b.first + k];
  return sum;
}

double ProfileCurve::curvature(double arc_m) const {
  const Basis b = basis(arc_m);
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) sum += b.slope[k] * coefficients_[b.first + k];
  return sum;
}

ContourPoint ProfileCurve::position(double arc_m) const {
  const double cell = length_ / kCells;
  const int i = std::clamp(static_cast<int>(arc_m / cell), 0, kCells - 1);
  const double start = i * cell;
  const double h = arc_m - start;
  const double a = direction(start), m = direction(start + 0.5 * h), b = direction(arc_m);
  const ContourPoint& from = grid_[static_cast<std::size_t>(i)];
  return {from.x_m + h * (std::cos(a) + 4.0 * std::cos(m) + std::cos(b)) / 6.0,
          from.y_m + h * (std::sin(a) + 4.0 * std::sin(m) + std::sin(b)) / 6.0};
}

// Simpson's rule on every cell, for places and their derivatives alike.
void ProfileCurve::lay_grid() {
  const Eigen::Index count = coefficients_.size();
  const double h = length_ / kCells;
  grid_.assign(kCells + 1, origin_);
  grid_x_by_c_.setZero(kCells + 1, count);
  grid_y_by_c_.setZero(kCells + 1, count);
  for (int i = 0; i < kCells; ++i) {
    const auto k = static_cast<std::size_t>(i);
    grid_[k + 1] = grid_[k];
    grid_x_by_c_.row(i + 1) = grid_x_by_c_.row(i);
    grid_y_by_c_.row(i + 1) = grid_y_by_c_.row(i);
    const double shares[3] = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};
    for (int q = 0; q < 3; ++q) {
      const Basis b = basis((i + 0.5 * q) * h);
      double angle = 0.0;
      for (int j = 0; j < 4; ++j) angle += b.value[j] * coefficients_[b.first + j];
      const double c = shares[q] * h * std::cos(angle);
      const double s = shares[q] * h * std::sin(angle);
      grid_[k + 1].x_m += c;
      grid_[k + 1].y_m += s;
      for (int j = 0; j < 4; ++j) {
        grid_x_by_c_(i + 1, b.first + j) -= s * b.value[j];
        grid_y_by_c_(i + 1, b.first + j) += c * b.value[j];
      }
    }
  }
}

/// Directions by linear least squares, pulled a little towards a straight continuation where there
/// are more coefficients than chords say anything of.
void ProfileCurve::start(const std::vector<ContourPoint>& points, const std::vector<double>& arcs,
                         const std::vector<double>& directions) {
  const int count = intervals_ + 3;
  const auto rows = static_cast<Eigen::Index>(arcs.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows + count - 2, count);
  Eigen::VectorXd wanted = Eigen::VectorXd::Zero(rows + count - 2);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Basis b = basis(arcs[static_cast<std::size_t>(i)]);
    for (int k = 0; k < 4; ++k) a(i, b.first + k) = b.value[k];
    wanted[i] = directions[static_cast<std::size_t>(i)];
  }
  constexpr double kPull = 1e-3;
  for (int k = 0; k + 2 < count; ++k) {
    a(rows + k, k) = a(rows + k, k + 2) = kPull;
    a(rows + k, k + 1) = -2.0 * kPull;
  }
  coefficients_ = a.colPivHouseholderQr().solve(wanted);
  origin_ = points.front();
  lay_grid();
}

// Gauss-Newton on the distances across the curve; after each step every point slides along it to
// where it lies beside the curve. The two ends do not slide, and count along the curve as well:
// else a strip in the shape of a circle could be turned in itself.
bool ProfileCurve::improve(const std::vector<ContourPoint>& points, std::vector<double>& arcs) {
  const Eigen::Index count = coefficients_.size();
  const auto rows = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd jacobian(rows + 2, count + 2);
  Eigen::VectorXd distance(rows + 2);
  arcs.front() = 0.0;
  arcs.back() = length_;
  const double cell = length_ / kCells;
  const auto measure = [&](int slides) {
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto k = static_cast<std::size_t>(i);
      ContourPoint at;
      double c = 0.0, s = 0.0;
      for (int slide = 0; slide < slides; ++slide) {
        at = position(arcs[k]);
        const double angle = direction(arcs[k]);
        c = std::cos(angle);
        s = std::sin(angle);
        if (i == 0 || i == rows - 1) break;
        const double along = (points[k].x_m - at.x_m) * c + (points[k].y_m - at.y_m) * s;
        const double next = std::clamp(arcs[k] + along, 0.0, length_);
        if (std::abs(next - arcs[k]) < 1e-9 * length_) break;
        arcs[k] = next;
        at = position(arcs[k]);
      }
      distance[i] = -s * (points[k].x_m - at.x_m) + c * (points[k].y_m - at.y_m);
      const int g = std::clamp(static_cast<int>(arcs[k] / cell), 0, kCells - 1);
      const double share = arcs[k] / cell - g;
      jacobian.row(i).head(count) =
          s * ((1.0 - share) * grid_x_by_c_.row(g) + share * grid_x_by_c_.row(g + 1)) -
          c * ((1.0 - share) * grid_y_by_c_.row(g) + share * grid_y_by_c_.row(g + 1));
      jacobian(i, count) = s;
      jacobian(i, count + 1) = -c;
      if (i > 0 && i < rows - 1) continue;
      const Eigen::Index end = i == 0 ? rows : rows + 1;
      distance[end] = c * (points[k].x_m - at.x_m) + s * (points[k].y_m - at.y_m);
      const Eigen::Index at_end = i == 0 ? 0 : kCells;
      jacobian.row(end).head(count) = -c * grid_x_by_c_.row(at_end) - s * grid_y_by_c_.row(at_end);
      jacobian(end, count) = -c;
      jacobian(end, count + 1) = -s;
    }
    return distance.squaredNorm();
  };
  double before = measure(3);
  constexpr int kSteps = 15;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::VectorXd change = jacobian.householderQr().solve(-distance);
    if (!change.allFinite()) return false;
    const Eigen::VectorXd coefficients = coefficients_;
    const ContourPoint origin = origin_;
    const std::vector<double> places = arcs;
    double share = 1.0;
    double now = before;
    for (int halving = 0; halving < 8; ++halving, share *= 0.5) {
      coefficients_ = coefficients + share * change.head(count);
      origin_ = {origin.x_m + share * change[count], origin.y_m + share * change[count + 1]};
      lay_grid();
      now = measure(1);
      if (now < before) break;
      arcs = places;
    }
    if (!(now < before)) {
      coefficients_ = coefficients;
      origin_ = origin;
      lay_grid();
      before = measure(1);
      break;
    }
    const bool is_still = before - now <= 1e-5 * before;
    before = now;
    if (is_still) break;
  }
  if (!std::isfinite(before)) return false;
  const double freedom = static_cast<double>(rows - count);
  rms_ = std::sqrt(before / static_cast<double>(rows + 2));
  noise_ = std::sqrt(before / std::max(1.0, freedom));
  const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
  const Eigen::MatrixXd inverse =
      normal.ldlt().solve(Eigen::MatrixXd::Identity(count + 2, count + 2));
  covariance_ = noise_ * noise_ * inverse.topLeftCorner(count, count);
  return covariance_.allFinite();
}

Expected<ProfileCurve> ProfileCurve::fitted(const std::vector<ContourPoint>& points,
                                            const ContourOptions& options) {
  constexpr std::size_t kFewest = 12;
  if (points.size() < kFewest)
    return bad_input("a profile needs at least " + std::to_string(kFewest) + " points, " +
                     std::to_string(points.size()) + " are given");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!std::isfinite(points[i].x_m) || !std::isfinite(points[i].y_m))
      return bad_input("point " + std::to_string(i + 1) + " of the profile is not a number");
  if (!std::isfinite(options.length_m) || options.length_m <= 0.0)
    return bad_input("the length of the strip is not above zero");
  const Chords chords = chords_of(points, options.length_m);
  if (!(chords.arcs.back() > 0.0)) return bad_input("all points of the profile coincide");

  const auto with = [&](int intervals, ProfileCurve& curve) {
    curve.length_ = options.length_m;
    curve.intervals_ = intervals;
    curve.start(points, chords.places, chords.directions);
    std::vector<double> arcs = chords.arcs;
    const bool is_followed = curve.improve(points, arcs);
    curve.arcs_ = std::move(arcs);
    return is_followed;
  };
  ProfileCurve best;
  int chosen = options.intervals;
  if (chosen <= 0) {
    double best_score = std::numeric_limits<double>::infinity();
    const int most = std::min(options.most_intervals, static_cast<int>(points.size()) / 6);
    for (int intervals = 2; intervals <= std::max(2, most); intervals += intervals < 4 ? 1 : 2) {
      ProfileCurve curve;
      if (!with(intervals, curve)) continue;
      const auto rows = static_cast<double>(points.size());
      const double unknowns = intervals + 5.0;
      const double score = rows * std::log(curve.rms_ * curve.rms_ + 1e-30) + 2.0 * unknowns +
                           2.0 * unknowns * (unknowns + 1.0) / std::max(1.0, rows - unknowns - 1);
      if (score >= best_score) continue;
      best_score = score;
      chosen = 2 * intervals;
      best = std::move(curve);
    }
  }
  ProfileCurve finer;
  if (chosen > 0 && with(chosen, finer)) return finer;
  if (best.intervals_ == 0) return bad_input("no smooth curve follows the points of the profile");
  return best;
}

// integral_s^L of (L - t) f(theta(t)) on the grid's cells, the first one cut at s
Eigen::VectorXd ProfileCurve::torque_and_slopes(double arc_m, double weight_N_m2) const {
  Eigen::VectorXd by_c = Eigen::VectorXd::Zero(coefficients_.size() + 1);  // the torque comes last
  const double cell = length_ / kCells;
  double from = arc_m;
  while (from < length_ * (1.0 - 1e-12)) {
    const double to = std::min(length_, (std::floor(from / cell + 1e-9) + 1.0) * cell);
    const double shares[3] = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};
    for (int q = 0; q < 3; ++q) {
      const double t = from + 0.5 * q * (to - from);
      const Basis b = basis(t);
      double angle = 0.0;
      for (int j = 0; j < 4; ++j) angle += b.value[j] * coefficients_[b.first + j];
      const double lever = weight_N_m2 * shares[q] * (to - from) * (length_ - t);
      by_c[coefficients_.size()] -= lever * std::cos(angle);
      for (int j = 0; j < 4; ++j) by_c[b.first + j] += lever * std::sin(angle) * b.value[j];
    }
    from = to;
  }
  return by_c;
}

double ProfileCurve::torque(double arc_m, double weight_N_m2) const {
  return torque_and_slopes(arc_m, weight_N_m2)[coefficients_.size()];
}

Eigen::VectorXd ProfileCurve::torque_by_coefficients(double arc_m, double weight_N_m2) const {
  return torque_and_slopes(arc_m, weight_N_m2).head(coefficients_.size());
}

Eigen::VectorXd ProfileCurve::direction_by_coefficients(double arc_m) const {
  Eigen::VectorXd by_c = Eigen::VectorXd::Zero(coefficients_.size());
  const Basis b = basis(arc_m);
  for (int k = 0; k < 4; ++k) by_c[b.first + k] = b.value[k];
  return by_c;
}

}  // namespace tenter::estimation
