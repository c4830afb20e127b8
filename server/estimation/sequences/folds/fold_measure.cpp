// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/folds/fold_measure.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

namespace tenter::estimation {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSmoothDegree = 4;
constexpr int kSmoothTerms = 15;  // of that degree in two variables
constexpr int kFewestPoints = 40;

/// The material's bounding square, mapped to -1 to 1.
struct Square {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double side_m = 0.0;
  Eigen::Vector2d scaled(const Eigen::Vector2d& material_m) const {
    return 2.0 * (material_m - middle) / side_m;
  }
};

Square square_of(const SheetPoints& points, const std::vector<Eigen::Index>& seen) {
  Eigen::Vector2d low = points.material_m.col(seen.front()), high = low;
  for (const Eigen::Index k : seen) {
    low = low.cwiseMin(points.material_m.col(k));
    high = high.cwiseMax(points.material_m.col(k));
  }
  return {0.5 * (low + high), (high - low).maxCoeff()};
}

/// Powers of (s, t) up to the fourth together, and their derivatives.
struct Powers {
  Eigen::Matrix<double, kSmoothTerms, 1> value, by_s, by_t;
};
Powers powers_at(const Eigen::Vector2d& at) {
  Powers powers;
  int term = 0;
  const auto power = [](double x, int n) { return n == 0 ? 1.0 : std::pow(x, n); };
  for (int i = 0; i <= kSmoothDegree; ++i)
    for (int j = 0; i + j <= kSmoothDegree; ++j, ++term) {
      powers.value[term] = power(at.x(), i) * power(at.y(), j);
      powers.by_s[term] = i > 0 ? i * power(at.x(), i - 1) * power(at.y(), j) : 0.0;
      powers.by_t[term] = j > 0 ? j * power(at.x(), i) * power(at.y(), j - 1) : 0.0;
    }
  return powers;
}

/// w of every point that was seen; false where they do not determine a smooth surface.
bool find_relief(const SheetPoints& points, const std::vector<Eigen::Index>& seen,
                 const Square& square, Eigen::VectorXd& relief) {
  const auto count = static_cast<Eigen::Index>(seen.size());
  Eigen::MatrixXd design(count, kSmoothTerms), wanted(count, 3);
  for (Eigen::Index r = 0; r < count; ++r) {
    const Eigen::Index k = seen[static_cast<std::size_t>(r)];
    design.row(r) = powers_at(square.scaled(points.material_m.col(k))).value.transpose();
    wanted.row(r) = points.position_m.col(k).transpose();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(design);
  if (qr.rank() < kSmoothTerms) return false;
  const Eigen::MatrixXd smooth = qr.solve(wanted);
  relief.setZero(points.material_m.cols());
  for (Eigen::Index r = 0; r < count; ++r) {
    const Eigen::Index k = seen[static_cast<std::size_t>(r)];
    const Powers powers = powers_at(square.scaled(points.material_m.col(k)));
    const Eigen::Vector3d along_s = smooth.transpose() * powers.by_s;
    const Eigen::Vector3d along_t = smooth.transpose() * powers.by_t;
    const Eigen::Vector3d normal = along_s.cross(along_t).normalized();
    const Eigen::Vector3d off = (wanted.row(r) - design.row(r) * smooth).transpose();
    relief[k] = normal.dot(off);
  }
  return relief.allFinite();
}

struct Wave {
  Eigen::Vector2d k_1_m = Eigen::Vector2d::Zero();
  double power = 0.0;
};

/// P over half of the plane of wave vectors, half a cycle a side apart, from one and a half cycles
/// a side (the smooth part has what is longer) to what the points can tell. `noise`: what was taken
/// off.
std::vector<Wave> spectrum(const SheetPoints& points, const std::vector<Eigen::Index>& seen,
                           const Square& square, const Eigen::VectorXd& relief, double sigma_m,
                           double& noise) {
  constexpr double kPointsACycle = 2.5, kMostCycles = 16.0, kLongest = 1.5, kStep = 0.5;
  const double most =
      std::min(kMostCycles, std::sqrt(static_cast<double>(seen.size())) / kPointsACycle);
  const int steps = static_cast<int>(most / kStep);
  std::vector<double> weighted;
  std::vector<Eigen::Vector2d> place;
  noise = 0.0;
  for (const Eigen::Index k : seen) {
    const Eigen::Vector2d at = square.scaled(points.material_m.col(k));
    const double window = 0.25 * (1.0 + std::cos(kPi * at.x())) * (1.0 + std::cos(kPi * at.y()));
    weighted.push_back(window * relief[k]);
    place.emplace_back(at);
    noise += sigma_m * sigma_m * window * window;
  }
  std::vector<Wave> waves;
  const double unit = 2.0 * kPi / square.side_m;  // one cycle a side
  std::vector<std::complex<double>> row(weighted.size()), turn(weighted.size());
  for (std::size_t j = 0; j < turn.size(); ++j)
    turn[j] = std::polar(1.0, -kPi * kStep * place[j].x());
  for (int b = 0; b <= steps; ++b) {
    for (std::size_t j = 0; j < row.size(); ++j)
      row[j] =
          weighted[j] * std::polar(1.0, -kPi * kStep * (b * place[j].y() - steps * place[j].x()));
    for (int a = -steps; a <= steps; ++a) {
      std::complex<double> sum = 0.0;
      for (std::size_t j = 0; j < row.size(); ++j) {
        sum += row[j];
        row[j] *= turn[j];
      }
      if (b == 0 && a <= 0) continue;  // the other half of the plane
      const double cycles = kStep * std::hypot(a, b);
      if (cycles < kLongest || cycles > most) continue;
      waves.push_back({unit * kStep * Eigen::Vector2d(a, b), std::norm(sum) - noise});
    }
  }
  return waves;
}

}  // namespace

Expected<FoldMeasure> measure_folds(const SheetPoints& points, double sigma_m) {
  if (points.material_m.cols() != points.position_m.cols())
    return bad_input("folds: " + std::to_string(points.position_m.cols()) + " positions of " +
                     std::to_string(points.material_m.cols()) + " points");
  if (!(sigma_m >= 0.0) || !std::isfinite(sigma_m))
    return bad_input("folds: a standard deviation below zero or no number");
  std::vector<Eigen::Index> seen;
  for (Eigen::Index k = 0; k < points.material_m.cols(); ++k)
    if (points.position_m.col(k).allFinite() && points.material_m.col(k).allFinite())
      seen.push_back(k);
  if (seen.size() < kFewestPoints)
    return bad_input("folds: " + std::to_string(seen.size()) + " points, at least " +
                     std::to_string(kFewestPoints) + " are needed");
  FoldMeasure result;
  const Square square = square_of(points, seen);
  if (!(square.side_m > 0.0) || !find_relief(points, seen, square, result.relief_m))
    return bad_input("folds: the points lie on lines, not over a sheet");

  double noise = 0.0;
  const auto waves = spectrum(points, seen, square, result.relief_m, sigma_m, noise);
  const auto peak = std::max_element(
      waves.begin(), waves.end(), [](const Wave& a, const Wave& b) { return a.power < b.power; });
  // the largest of 2,000 powers of noise alone is eight times its mean; and rounding is no fold
  constexpr double kAboveNoise = 25.0, kSmallest = 1e-6;
  const double variance = std::max(
      0.0, result.relief_m.squaredNorm() / static_cast<double>(seen.size()) - sigma_m * sigma_m);
  const double height_m = std::sqrt(2.0 * variance);
  if (peak == waves.end() || !(peak->power > kAboveNoise * noise) ||
      height_m < kSmallest * square.side_m)
    return result;
  result.is_folded = true;
  result.height_m = height_m;
  double near_peak = 0.0, sum_k = 0.0, sum = 0.0;
  std::complex<double> turned = 0.0;
  for (const Wave& wave : waves) {
    if (!(wave.power > 0.0)) continue;
    const double angle = std::atan2(wave.k_1_m.y(), wave.k_1_m.x());
    // leakage of the window and noise have no direction of their own
    if (wave.power > 0.1 * peak->power) {
      turned += wave.power * std::polar(1.0, 2.0 * angle);
      sum += wave.power;
    }
    if (wave.power < 0.5 * peak->power) continue;
    near_peak += wave.power;
    sum_k += wave.power * wave.k_1_m.norm();
  }
  result.wavelength_m = 2.0 * kPi * near_peak / sum_k;
  result.alignment = std::abs(turned) / sum;
  result.direction_rad = 0.5 * std::arg(turned);
  if (result.direction_rad < 0.0) result.direction_rad += kPi;
  result.steepness = 2.0 * kPi * result.height_m / result.wavelength_m;
  return result;
}

}  // namespace tenter::estimation
