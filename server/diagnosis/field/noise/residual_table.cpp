// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/noise/residual_table.h"

#include <algorithm>

#include "common/base/not_a_number.h"

namespace tenter::diagnosis {

ResidualTable residual_table(const estimation::Sequence& sequence, int index, int channels,
                             const std::vector<estimation::Row>& rows,
                             const Eigen::VectorXd& residuals) {
  ResidualTable table(static_cast<std::size_t>(channels),
                      std::vector<double>(sequence.frames.size(), kNaN));
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows[r].curve == index && rows[r].channel < channels)
      table[static_cast<std::size_t>(rows[r].channel)][static_cast<std::size_t>(rows[r].frame)] =
          residuals[static_cast<Eigen::Index>(r)];
  return table;
}

std::vector<std::vector<std::size_t>> nearest_points(const estimation::Sequence& sequence,
                                                     std::size_t most) {
  const std::size_t count = sequence.points.size();
  std::vector<std::vector<std::size_t>> nearest(count);
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (std::size_t i = 0; i < count; ++i) {
    by_distance.clear();
    for (std::size_t j = 0; j < count; ++j)
      if (j != i)
        by_distance.emplace_back(
            (sequence.points[i].material_m - sequence.points[j].material_m).squaredNorm(), j);
    const std::size_t few = std::min(most, by_distance.size());
    std::partial_sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(few),
                      by_distance.end());
    for (std::size_t k = 0; k < few; ++k) nearest[i].push_back(by_distance[k].second);
  }
  return nearest;
}

}  // namespace tenter::diagnosis
