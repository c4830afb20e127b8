// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/score.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

double measured_from_rest(const DataSet& data, const Row& row) {
  const auto& channel = data.curves[static_cast<std::size_t>(row.curve)]
                            .channels[static_cast<std::size_t>(row.channel)];
  const double rest = channel.is_stress || channel.component == 2 ? 0.0 : 1.0;
  return measured(data, row) - rest;
}

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

std::vector<std::size_t> stretch_rows(const DataSet& data, const std::vector<Row>& rows) {
  std::vector<std::size_t> stretches;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (!is_stress(data, rows[r])) stretches.push_back(r);
  return stretches;
}

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

}  // namespace tenter::diagnosis
