// SPDX-License-Identifier: GPL-3.0-or-later
// A symmetric matrix over all nodes of a mesh, fixed ones included, in blocks of 3 x 3: what the
// elements add their stiffness into. Boundary conditions come afterwards (Reduction), so the same
// assembled matrix gives the matrix of equilibrium and the reactions' derivatives.
//
// Lower triangle of blocks: block (i, j) with i >= j, column-major, 9 numbers (N/m). Built once per
// mesh; adding goes through slots that were looked up once.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace tenter::mechanics {

class NodeMatrix {
 public:
  NodeMatrix() = default;
  /// Couples the nodes of every pair in `pairs` (any order, repeats allowed) and each with itself.
  NodeMatrix(int nodes, std::vector<std::pair<int, int>> pairs);

  int node_count() const { return static_cast<int>(column_start_.size()) - 1; }
  int block_count() const { return static_cast<int>(row_.size()); }
  /// Block of (i, j), i >= j; the pair must have been given.
  int slot(int i, int j) const;

  const std::vector<int>& column_start() const { return column_start_; }
  const std::vector<int>& row() const { return row_; }

  void set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }
  double* block(int slot) { return values_.data() + 9 * static_cast<std::ptrdiff_t>(slot); }
  const double* block(int slot) const {
    return values_.data() + 9 * static_cast<std::ptrdiff_t>(slot);
  }

  bool is_finite() const;

  /// y += A x over all nodes (3 numbers a node).
  void multiply_add(const double* x, double* y) const;
  /// The same for `count` columns of x and y, and only for the rows of y of nodes that are wanted.
  void multiply_add(const double* x, double* y, int count, const std::vector<bool>& wanted) const;

 private:
  std::vector<int> column_start_ = {0};
  std::vector<int> row_;
  std::vector<double> values_;
};

/// Where the blocks of one kind of element go. Pairs of local corners (a, b), a >= b, in the order
/// (0,0), (1,0), (1,1), (2,0), ...; a slot s >= 0 adds the block as it is, s < 0 adds its transpose
/// at -1 - s.
template <class Nodes>
std::vector<int> block_slots(const NodeMatrix& matrix, const std::vector<Nodes>& elements) {
  std::vector<int> slots;
  for (const Nodes& nodes : elements) {
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      for (std::size_t b = 0; b <= a; ++b)
        slots.push_back(nodes[a] >= nodes[b] ? matrix.slot(nodes[a], nodes[b])
                                             : -1 - matrix.slot(nodes[b], nodes[a]));
    }
  }
  return slots;
}

}  // namespace tenter::mechanics
