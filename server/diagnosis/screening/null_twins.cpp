// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/screening/null_twins.h"

#include <algorithm>

#include "server/diagnosis/screening/normal.h"

namespace tenter::diagnosis {
Eigen::MatrixXd null_twins(const std::vector<estimation::Row>& rows, const estimation::Noise& noise,
                           int count, unsigned long long seed) {
  Normal normal(seed);
  Eigen::MatrixXd twins(static_cast<Eigen::Index>(rows.size()), count);
  for (int twin = 0; twin < count; ++twin) {
    std::size_t first = 0;
    while (first < rows.size()) {
      std::size_t last = first;
      while (last < rows.size() && rows[last].block == rows[first].block &&
             rows[last].channel == rows[first].channel && rows[last].curve == rows[first].curve)
        ++last;
      const auto length = static_cast<double>(last - first);
      if (noise.sequences.empty()) {
        for (std::size_t r = first; r < last; ++r)
          twins(static_cast<Eigen::Index>(r), twin) = normal();
      } else {
        const auto pick = static_cast<std::size_t>(normal.uniform() *
                                                   static_cast<double>(noise.sequences.size()));
        const std::vector<double>& s = noise.sequences[pick];
        const double sign = normal.uniform() < 0.5 ? -1.0 : 1.0;
        for (std::size_t r = first; r < last; ++r) {
          const double x =
              (static_cast<double>(r - first) + 0.5) / length * static_cast<double>(s.size());
          const auto k = std::min(static_cast<std::size_t>(x), s.size() - 1);
          // the sequence has the repeats' variance in full where neighbours on its grid are single
          // readings
          twins(static_cast<Eigen::Index>(r), twin) = sign * s[k];
        }
      }
      first = last;
    }
  }
  return twins;
}

}  // namespace tenter::diagnosis
