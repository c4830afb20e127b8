// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/neighbours.h"

#include <cmath>

namespace tenter::diagnosis {

double neighbours_alike(const std::vector<estimation::Row>& rows,
                        const Eigen::VectorXd& residuals) {
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    const estimation::Row& a = rows[r - 1];
    const estimation::Row& b = rows[r];
    if (a.curve != b.curve || a.channel != b.channel || a.block != b.block) continue;
    const auto k = static_cast<Eigen::Index>(r);
    const double product = residuals[k - 1] * residuals[k];
    sum += product;
    squares += product * product;
  }
  return squares > 0.0 ? sum / std::sqrt(squares) : 0.0;
}

}  // namespace tenter::diagnosis
