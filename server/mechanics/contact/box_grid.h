// SPDX-License-Identifier: GPL-3.0-or-later
// Which of many boxes overlap with a given one: boxes sorted into cells of a grid as wide as the
// widest of them, so that nobody looks farther than one cell back.
//
//   grid.fill(boxes);
//   grid.near(low, high, [&](int box) { ... });          // every box that overlaps, in fixed order
//
// fill: O(boxes), near: what is in at most 27 cells where the box asked for is no wider. Nothing
// allocates once its lists have grown. One thread at a time; near is callable from any thread.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace tenter::mechanics {

/// Of a node among coordinates of 3 numbers a node.
inline Eigen::Vector3d place_of(const Eigen::VectorXd& x, int node) {
  return x.segment<3>(3 * static_cast<Eigen::Index>(node));
}

struct Box {
  Eigen::Vector3d low, high;

  void hold(const Eigen::Vector3d& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
};

class BoxGrid {
 public:
  void fill(const std::vector<Box>& boxes);

  /// work(k) for every boxes[k] that overlaps with the one from `low` to `high`.
  template <class Work>
  void near(const Eigen::Vector3d& low, const Eigen::Vector3d& high, Work work) const {
    if (order_.empty()) return;
    const Eigen::Array3i first = cell_of(low.array() - widest_m_);
    const Eigen::Array3i last = cell_of(high.array());
    for (int i = first[0]; i <= last[0]; ++i)
      for (int j = first[1]; j <= last[1]; ++j) {
        // cells along the third direction follow each other
        const auto row = static_cast<std::size_t>((i * cells_[1] + j) * cells_[2]);
        const int end = start_[row + static_cast<std::size_t>(last[2]) + 1];
        for (int k = start_[row + static_cast<std::size_t>(first[2])]; k < end; ++k) {
          const Placed& placed = order_[static_cast<std::size_t>(k)];
          if ((placed.box.high.array() >= low.array()).all() &&
              (placed.box.low.array() <= high.array()).all())
            work(placed.number);
        }
      }
  }

 private:
  struct Placed {
    Box box;
    int number = 0;
  };
  /// The nearest cell of the grid to a point.
  Eigen::Array3i cell_of(const Eigen::Array3d& point) const {
    const Eigen::Array3d place = ((point - origin_m_) * per_cell_).floor();
    return place.max(0.0).min((cells_ - 1).cast<double>()).cast<int>();
  }

  Eigen::Array3d origin_m_ = Eigen::Array3d::Zero();
  Eigen::Array3i cells_ = Eigen::Array3i::Zero();
  double widest_m_ = 0.0, per_cell_ = 0.0;
  std::vector<int> start_;  ///< of each cell in order_, and the end
  std::vector<int> cell_;   ///< of each box: that of its low corner
  std::vector<Placed> order_;
};

}  // namespace tenter::mechanics
