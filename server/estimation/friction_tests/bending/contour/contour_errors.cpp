// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/contour/contour_errors.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

namespace tenter::estimation {

using mechanics::PathStatus;

namespace {

constexpr int kFewestCells = 240;
constexpr double kFlat = 1e-9;  // a direction of the placement that nothing tells

bool is_kept(const ProfileSamples& profile, double arc_m) {
  return std::any_of(profile.samples.begin(), profile.samples.end(), [&](const TorqueSample& s) {
    return std::abs(arc_m - s.arc_m) <= 0.5 * profile.width_m;
  });
}

RestingShape shape_of(const ProfileSamples& profile) {
  const double length = profile.curve.length_m();
  const int pieces = static_cast<int>(std::lround(length / profile.width_m));
  const int cells = pieces * ((kFewestCells + pieces - 1) / pieces);
  Eigen::VectorXd strain(cells);
  std::vector<HeldRun> held;
  for (int i = 0; i < cells; ++i) {
    const double middle = (i + 0.5) * length / cells;
    strain[i] = 3.0 * profile.curve.curvature(middle);
    if (is_kept(profile, middle)) continue;
    if (held.empty() || held.back().last != i) held.push_back({i, i});
    held.back().last = i + 1;
  }
  return {length, profile.weight_N_m2, std::move(strain), std::move(held)};
}

}  // namespace

int ContourErrors::Strip::row_count() const {
  return static_cast<int>(points.size()) + (has_start ? 1 : 0) + (has_end ? 1 : 0);
}

ContourErrors::ContourErrors(StrainPoint point,
                             std::shared_ptr<const std::vector<ProfileSamples>> profiles)
    : point_(std::move(point)), profiles_(std::move(profiles)) {
  for (const ProfileSamples& profile : *profiles_) {
    reach_ = std::max(reach_, profile.anchor);
    for (const TorqueSample& sample : profile.samples)
      reach_ = std::max(reach_, std::abs(sample.strain));
    Strip strip{shape_of(profile), {}, false, false, {}, {}, {}, row_count()};
    std::vector<double> arcs;
    const std::size_t last = profile.points.size() - 1;
    for (std::size_t j = 0; j <= last; ++j) {
      const double arc = profile.curve.arcs()[j];
      if (!is_kept(profile, arc)) continue;
      strip.points.push_back(profile.points[j]);
      arcs.push_back(arc);
      strip.has_start = strip.has_start || j == 0;
      strip.has_end = strip.has_end || j == last;
    }
    strip.read.arcs =
        Eigen::Map<const Eigen::VectorXd>(arcs.data(), static_cast<Eigen::Index>(arcs.size()));
    strip.read.placement.setZero(strip.shape.placement_count());
    const ContourPoint clamp = profile.curve.position(0.0);
    strip.read.placement.head<3>() << clamp.x_m, clamp.y_m, profile.curve.direction(0.0);
    const int cells = strip.shape.cells();
    strip.read.directions.resize(cells + 1);
    for (int i = 0; i <= cells; ++i)
      strip.read.directions[i] = profile.curve.direction(i * profile.curve.length_m() / cells);
    for (int r = 0; r < strip.row_count(); ++r) rows_.push_back({0, 0, row_count(), profile.group});
    strip.at = strip.read;
    strip.placed.resize(strip.row_count(), 0);
    strips_.push_back(std::move(strip));
  }
  reach_ *= 1.5;
}

bool ContourErrors::look(Strip& strip, const ProfileSamples& profile,
                         const Eigen::VectorXd& parameters, const Eigen::VectorXd& placement,
                         Eigen::VectorXd& arcs, Eigen::VectorXd& distances, RowMatrix* by) {
  OneWay way(point_, profile.anchor, reach_, parameters);
  RestingShape& shape = strip.shape;
  if (!shape.rest(way, placement, strip.at.directions)) return false;
  if (by != nullptr) {
    shape.differentiate(way, parameter_count());
    by->resize(strip.row_count(), parameter_count() + shape.placement_count());
  }
  const double length = profile.curve.length_m();
  const double cell = length / shape.cells();
  const auto count = static_cast<Eigen::Index>(strip.points.size());
  distances.resize(strip.row_count());
  Eigen::Matrix<double, 3, Eigen::Dynamic> moves;
  Eigen::Index end_row = count;
  for (Eigen::Index j = 0; j < count; ++j) {
    const ContourPoint& point = strip.points[static_cast<std::size_t>(j)];
    const bool is_end = (j == 0 && strip.has_start) || (j == count - 1 && strip.has_end);
    RestingShape::Place at;
    double c = 0.0, s = 0.0, along = 0.0, across = 0.0;
    constexpr int kSlides = 12;
    for (int slide = 0; slide < kSlides; ++slide) {
      at = shape.place(arcs[j]);
      c = std::cos(at.direction);
      s = std::sin(at.direction);
      along = c * (point.x_m - at.x) + s * (point.y_m - at.y);
      across = -s * (point.x_m - at.x) + c * (point.y_m - at.y);
      if (is_end) break;
      const int i = std::clamp(static_cast<int>(arcs[j] / cell), 0, shape.cells() - 1);
      const double turn = (shape.directions()[i + 1] - shape.directions()[i]) / cell;
      const double reach = 0.02 * length;  // in one slide
      const double step = std::clamp(along / std::max(0.3, 1.0 - turn * across), -reach, reach);
      const double next = std::clamp(arcs[j] + step, 0.0, length);
      if (std::abs(next - arcs[j]) <= 1e-13 * length) break;
      arcs[j] = next;
    }
    distances[j] = across / profile.noise_m;
    if (by != nullptr) {
      shape.place_by(arcs[j], moves);
      by->row(j) = (s * moves.row(0) - c * moves.row(1) - along * moves.row(2)) / profile.noise_m;
    }
    if (!is_end) continue;
    distances[end_row] = along / profile.noise_m;
    if (by != nullptr)
      by->row(end_row) =
          (-c * moves.row(0) - s * moves.row(1) + across * moves.row(2)) / profile.noise_m;
    ++end_row;
  }
  return distances.allFinite();
}

// Gauss-Newton from where it stands, a step at a time as long as the points come nearer.
bool ContourErrors::find_placement(Strip& strip, const ProfileSamples& profile,
                                   const Eigen::VectorXd& parameters) {
  Eigen::VectorXd distances;
  RowMatrix by;
  Eigen::VectorXd arcs = strip.at.arcs;
  if (!look(strip, profile, parameters, strip.at.placement, arcs, distances, &by)) return false;
  constexpr int kSteps = 15;
  constexpr int kHalvings = 6;
  for (int step = 0; step < kSteps; ++step) {
    strip.at.arcs = arcs;
    strip.at.directions = strip.shape.directions();
    const auto solver = Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(
        by.rightCols(strip.shape.placement_count()));
    const Eigen::VectorXd change = solver.solve(-distances);
    const double before = distances.squaredNorm();
    double share = 1.0;
    bool is_nearer = false;
    for (int halving = 0; halving < kHalvings && !is_nearer; ++halving, share *= 0.5) {
      arcs = strip.at.arcs;
      const Eigen::VectorXd placement = strip.at.placement + share * change;
      is_nearer = look(strip, profile, parameters, placement, arcs, distances, &by) &&
                  distances.squaredNorm() < before;
      if (is_nearer) strip.at.placement = placement;
    }
    if (!is_nearer || before - distances.squaredNorm() <= 1e-6 * before) break;
  }
  arcs = strip.at.arcs;
  if (!look(strip, profile, parameters, strip.at.placement, arcs, distances, &by)) return false;
  strip.at.arcs = arcs;
  strip.at.directions = strip.shape.directions();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(by.rightCols(strip.shape.placement_count()));
  qr.setThreshold(kFlat);
  strip.placed = qr.householderQ() * Eigen::MatrixXd::Identity(by.rows(), qr.rank());
  return true;
}

PathStatus ContourErrors::set_reference(const Eigen::VectorXd& parameters) {
  for (std::size_t i = 0; i < strips_.size(); ++i) {
    Strip& strip = strips_[i];
    if (strip.row_count() == 0 || find_placement(strip, (*profiles_)[i], parameters)) continue;
    strip.at = strip.read;  // where it stood last is no place to begin from
    if (!find_placement(strip, (*profiles_)[i], parameters)) return PathStatus::no_equilibrium;
  }
  return PathStatus::ok;
}

PathStatus ContourErrors::evaluate(const Eigen::VectorXd& parameters, Eigen::VectorXd& residuals,
                                   RowMatrix* jacobian) {
  residuals.resize(row_count());
  if (jacobian != nullptr) jacobian->resize(row_count(), parameter_count());
  predicted_.clear();
  snapped_ = 0;
  Eigen::VectorXd distances, arcs;
  RowMatrix by;
  for (std::size_t i = 0; i < strips_.size(); ++i) {
    Strip& strip = strips_[i];
    const ProfileSamples& profile = (*profiles_)[i];
    if (strip.row_count() == 0) continue;
    arcs = strip.at.arcs;
    if (!look(strip, profile, parameters, strip.at.placement, arcs, distances,
              jacobian != nullptr ? &by : nullptr))
      return PathStatus::no_equilibrium;
    residuals.segment(strip.first_row, strip.row_count()) =
        distances - strip.placed * (strip.placed.transpose() * distances);
    if (jacobian != nullptr) {
      const auto moves = by.leftCols(parameter_count());
      jacobian->middleRows(strip.first_row, strip.row_count()) =
          moves - strip.placed * (strip.placed.transpose() * moves);
    }
    for (const TorqueSample& sample : profile.samples)
      predicted_.push_back(3.0 / profile.width_m *
                           (strip.shape.place(sample.arc_m + 0.5 * profile.width_m).direction -
                            strip.shape.place(sample.arc_m - 0.5 * profile.width_m).direction));
    snapped_ += strip.shape.snapped() > 0 ? 1 : 0;
  }
  return residuals.allFinite() ? PathStatus::ok : PathStatus::not_finite;
}

}  // namespace tenter::estimation
