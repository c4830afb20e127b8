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
// what was read of a held run is uncertain in every interval of the smooth curve: where it may not
// turn, what it is wrong by is taken for the law's
constexpr int kTurns = 2;        // in each of these intervals
constexpr int kFewestTurns = 3;  // direction and place of what hangs below
constexpr double kFlat = 1e-9;   // a direction of the placement that nothing tells

bool is_kept(const ProfileSamples& profile, double arc_m) {
  return std::any_of(profile.samples.begin(), profile.samples.end(), [&](const TorqueSample& s) {
    return std::abs(arc_m - s.arc_m) <= 0.5 * profile.width_m;
  });
}

/// Not more than four standard deviations of chi-squared above its mean.
bool is_noise(double misfit, int rows) {
  return misfit <= rows + 4.0 * std::sqrt(2.0 * rows);
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
  for (HeldRun& run : held) {
    const int count = run.last - run.first;
    run.turns = std::min(std::max(kFewestTurns, kTurns * profile.intervals * count / cells), count);
  }
  return {length, profile.weight_N_m2, std::move(strain), std::move(held)};
}

}  // namespace

int ContourErrors::Strip::row_count() const {
  constexpr int kEnds = 2;
  return points.empty() ? 0 : static_cast<int>(points.size()) + kEnds;
}

ContourErrors::ContourErrors(StrainPoint point,
                             std::shared_ptr<const std::vector<ProfileSamples>> profiles)
    : point_(std::move(point)), profiles_(std::move(profiles)) {
  for (const ProfileSamples& profile : *profiles_) {
    reach_ = std::max(reach_, profile.anchor);
    for (const TorqueSample& sample : profile.samples)
      reach_ = std::max(reach_, std::abs(sample.strain));
    Strip strip{shape_of(profile), {}, {}, {}, {}, 0.0, row_count()};
    if (!profile.samples.empty()) strip.points = profile.points;
    strip.read.arcs = Eigen::Map<const Eigen::VectorXd>(
        profile.curve.arcs().data(), static_cast<Eigen::Index>(strip.points.size()));
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
    const bool is_end = j == 0 || j == count - 1;
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

// Marquardt's steps from where it stands, in units of the columns' largest lengths: where a snap
// holds what is next to the clamp upright, the clamp's direction moves the points by its square
// only.
bool ContourErrors::find_placement(Strip& strip, const ProfileSamples& profile,
                                   const Eigen::VectorXd& parameters) {
  Eigen::VectorXd distances, next;
  RowMatrix by, next_by;
  Eigen::VectorXd arcs = strip.at.arcs;
  if (!look(strip, profile, parameters, strip.at.placement, arcs, distances, &by)) return false;
  const Eigen::Index columns = strip.shape.placement_count();
  const auto stand = [&] {
    strip.at.arcs = arcs;
    strip.at.directions = strip.shape.directions();
  };
  stand();
  constexpr int kSteps = 40;
  constexpr double kWorth = 1e-5;  // of the sum of squares, in units of the noise's
  constexpr double kHeaviest = 1e8;
  double damping = 1e-3;
  double growth = 2.0;
  Eigen::VectorXd units = Eigen::VectorXd::Zero(columns);
  for (int step = 0; step < kSteps && damping < kHeaviest; ++step) {
    const Eigen::MatrixXd moves = by.rightCols(columns);
    units = units.cwiseMax(moves.colwise().norm().transpose());
    Eigen::MatrixXd damped(moves.rows() + columns, columns);
    damped << moves, Eigen::MatrixXd((std::sqrt(damping) * units).asDiagonal());
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(damped.rows());
    wanted.head(moves.rows()) = -distances;
    const Eigen::VectorXd change =
        Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(damped).solve(wanted);
    const double promised = distances.squaredNorm() - (distances + moves * change).squaredNorm();
    if (!(promised > kWorth)) break;
    arcs = strip.at.arcs;
    const bool is_nearer =
        look(strip, profile, parameters, strip.at.placement + change, arcs, next, &next_by) &&
        next.squaredNorm() < distances.squaredNorm();
    if (!is_nearer) {
      damping *= growth;
      growth *= 2.0;
      continue;
    }
    const double kept = (distances.squaredNorm() - next.squaredNorm()) / promised;
    damping *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * kept - 1.0, 3.0));
    growth = 2.0;
    strip.at.placement += change;
    stand();
    distances.swap(next);
    by.swap(next_by);
  }
  strip.misfit = distances.squaredNorm();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(by.rightCols(columns));
  qr.setThreshold(kFlat);
  strip.placed = qr.householderQ() * Eigen::MatrixXd::Identity(by.rows(), qr.rank());
  return true;
}

PathStatus ContourErrors::set_reference(const Eigen::VectorXd& parameters) {
  for (std::size_t i = 0; i < strips_.size(); ++i) {
    Strip& strip = strips_[i];
    const ProfileSamples& profile = (*profiles_)[i];
    if (strip.row_count() == 0) continue;
    const bool is_found = find_placement(strip, profile, parameters);
    if (is_found && is_noise(strip.misfit, strip.row_count())) continue;
    // a strip may rest in more than one way, and where it stood last is no place to begin from
    const Strip::Stand last = strip.at;
    const Eigen::MatrixXd placed = strip.placed;
    const double misfit = strip.misfit;
    strip.at = strip.read;
    if (find_placement(strip, profile, parameters) && (!is_found || strip.misfit < misfit))
      continue;
    if (!is_found) return PathStatus::no_equilibrium;
    strip.at = last;
    strip.placed = placed;
    strip.misfit = misfit;
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
