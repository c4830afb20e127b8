// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/contact/box_grid.h"

#include <cmath>

namespace tenter::mechanics {

void BoxGrid::fill(const std::vector<Box>& boxes) {
  constexpr double kCellsPerBox = 4.0;  // at most
  order_.resize(boxes.size());
  cell_.resize(boxes.size());
  if (boxes.empty()) return;
  Eigen::Array3d low = boxes[0].low, high = boxes[0].low;
  widest_m_ = 0.0;
  for (const Box& box : boxes) {
    low = low.min(box.low.array());
    high = high.max(box.low.array());
    widest_m_ = std::max(widest_m_, (box.high - box.low).maxCoeff());
  }
  origin_m_ = low;
  const double most = kCellsPerBox * static_cast<double>(boxes.size());
  const double longest_m = (high - low).maxCoeff();
  double side_m = std::max(widest_m_, longest_m / most);
  if (!(side_m > 0.0)) side_m = 1.0;  // all of them are one point
  const auto count = [&] { return ((high - low) / side_m).floor() + 1.0; };
  while (count().prod() > most + 8.0) side_m *= 1.25;
  cells_ = count().cast<int>();
  per_cell_ = 1.0 / side_m;

  // counting sort: the order within a cell is that of the boxes
  start_.assign(static_cast<std::size_t>(cells_.prod()) + 1, 0);
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const Eigen::Array3i c = cell_of(boxes[k].low.array());
    cell_[k] = (c[0] * cells_[1] + c[1]) * cells_[2] + c[2];
    ++start_[static_cast<std::size_t>(cell_[k]) + 1];
  }
  for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
  for (std::size_t k = boxes.size(); k-- > 0;) {
    // filled from behind: start_[cell + 1] goes down to the cell's start
    const auto place = static_cast<std::size_t>(--start_[static_cast<std::size_t>(cell_[k]) + 1]);
    order_[place] = {boxes[k], static_cast<int>(k)};
  }
  start_.erase(start_.begin());
  start_.push_back(static_cast<int>(boxes.size()));
}

}  // namespace tenter::mechanics
