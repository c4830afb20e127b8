// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/score.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace tenter::diagnosis {
namespace {

using estimation::DataSet;
using estimation::Row;

bool is_stress(const DataSet& data, const Row& row) {
  return data.curves[static_cast<std::size_t>(row.curve)]
      .channels[static_cast<std::size_t>(row.channel)]
      .is_stress;
}

double measured(const DataSet& data, const Row& row) {
  return data.curves[static_cast<std::size_t>(row.curve)]
      .channels[static_cast<std::size_t>(row.channel)]
      .measured[static_cast<std::size_t>(row.frame)];
}

/// What the channel shows at rest: a stretch of one, no stress, no shear.
double rest_value(const DataSet& data, const Row& row) {
  const auto& channel = data.curves[static_cast<std::size_t>(row.curve)]
                            .channels[static_cast<std::size_t>(row.channel)];
  return channel.is_stress || channel.component == 2 ? 0.0 : 1.0;
}

/// Rows that a score is taken over.
std::vector<std::size_t> scored_rows(const DataSet& data, const std::vector<Row>& rows, int curve) {
  std::vector<std::size_t> stress;
  std::vector<std::size_t> all;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (curve >= 0 && rows[r].curve != curve) continue;
    all.push_back(r);
    if (is_stress(data, rows[r])) stress.push_back(r);
  }
  return stress.empty() ? all : stress;
}

}  // namespace

Score score_of(const DataSet& data, const std::vector<Row>& rows, const Eigen::VectorXd& residuals,
               int curve) {
  const auto used = scored_rows(data, rows, curve);
  double error = 0.0;
  double power = 0.0;
  double sum = 0.0;
  double n = 0.0;
  for (const std::size_t r : used) {
    if (!std::isfinite(residuals[static_cast<Eigen::Index>(r)]))
      continue;  // no fold left this row out
    n += 1.0;
    const double e = residuals[static_cast<Eigen::Index>(r)] * data.sigma_of(rows[r]);
    const double m = measured(data, rows[r]);
    error += e * e;
    power += m * m;
    sum += m;
  }
  const double spread = power - sum * sum / std::max(1.0, n);
  Score score;
  score.error = power > 0.0 ? std::sqrt(error / power) : 0.0;
  score.r2 = spread > 0.0 ? 1.0 - error / spread : 0.0;
  return score;
}

double noise_floor_of(const DataSet& data, const std::vector<Row>& rows,
                      const estimation::Noise& noise, int curve) {
  double error = 0.0;
  double power = 0.0;
  for (const std::size_t r : scored_rows(data, rows, curve)) {
    const auto& channel = noise.channels[static_cast<std::size_t>(rows[r].curve)]
                                        [static_cast<std::size_t>(rows[r].channel)];
    const double sigma = channel.floor_sigma;
    const double m = measured(data, rows[r]);
    error += sigma * sigma;
    power += m * m;
  }
  return power > 0.0 ? std::sqrt(error / power) : 0.0;
}

namespace {

SizeInterval size_over(const DataSet& data, const std::vector<Row>& rows,
                       const std::vector<std::size_t>& used, const Eigen::VectorXd& without,
                       const Eigen::VectorXd& with, unsigned long long seed) {
  const int blocks = data.block_count();
  std::vector<double> gain(static_cast<std::size_t>(blocks), 0.0);
  std::vector<double> power(static_cast<std::size_t>(blocks), 0.0);
  for (const std::size_t r : used) {
    const auto k = static_cast<Eigen::Index>(r);
    const double sigma = data.sigma_of(rows[r]);
    const auto b = static_cast<std::size_t>(rows[r].block);
    const double m = measured(data, rows[r]) - rest_value(data, rows[r]);
    gain[b] += (without[k] * without[k] - with[k] * with[k]) * sigma * sigma;
    power[b] += m * m;
  }
  const auto share = [](double g, double p) { return p > 0.0 && g > 0.0 ? std::sqrt(g / p) : 0.0; };
  double total_gain = 0.0;
  double total_power = 0.0;
  for (std::size_t b = 0; b < gain.size(); ++b) {
    total_gain += gain[b];
    total_power += power[b];
  }
  SizeInterval result;
  result.size = share(total_gain, total_power);
  std::mt19937_64 engine(seed);
  constexpr int kResamples = 400;
  std::vector<double> sizes;
  for (int k = 0; k < kResamples; ++k) {
    double g = 0.0;
    double p = 0.0;
    for (int b = 0; b < blocks; ++b) {
      const auto pick =
          static_cast<std::size_t>(engine() % static_cast<unsigned long long>(blocks));
      g += gain[pick];
      p += power[pick];
    }
    sizes.push_back(share(g, p));
  }
  std::sort(sizes.begin(), sizes.end());
  result.lo = std::min(result.size, sizes[kResamples / 40]);
  result.hi = std::max(result.size, sizes[kResamples - 1 - kResamples / 40]);
  return result;
}

}  // namespace

SizeInterval size_between(const DataSet& data, const std::vector<Row>& rows,
                          const Eigen::VectorXd& without, const Eigen::VectorXd& with,
                          unsigned long long seed) {
  constexpr double kNothing = 2e-3;
  SizeInterval of_force = size_over(data, rows, scored_rows(data, rows, -1), without, with, seed);
  if (of_force.size >= kNothing) return of_force;
  std::vector<std::size_t> stretches;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (!is_stress(data, rows[r])) stretches.push_back(r);
  if (stretches.empty()) return of_force;
  SizeInterval of_stretch = size_over(data, rows, stretches, without, with, seed);
  of_stretch.of_force = false;
  return of_stretch.size > of_force.size ? of_stretch : of_force;
}

}  // namespace tenter::diagnosis
