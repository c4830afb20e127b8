// SPDX-License-Identifier: GPL-3.0-or-later
// Where a symmetric matrix has entries: the lower triangle, diagonal included, in compressed
// columns. The pattern is built once per mesh and set of free nodes; after that a matrix is one
// array of entry_count() values, and assembly adds into it through slots looked up once:
//
//   const SymmetricPattern pattern = element_pattern(free_count, element_dofs);
//   slots.push_back(pattern.slot(row, col));       // once
//   values[slots[i]] += stiffness;                 // every assembly
//
// Plain data: reading is safe from any thread.
#pragma once

#include <vector>

namespace tenter::mechanics {

/// Lower triangle of a symmetric matrix in compressed columns, rows increasing in each column. The
/// diagonal is always present and comes first in its column.
struct SymmetricPattern {
  int size = 0;
  std::vector<int> column_start;  ///< size + 1 offsets into row
  std::vector<int> row;           ///< row >= column

  int entry_count() const { return static_cast<int>(row.size()); }

  /// Position in the value array of entry (row, col), in either order; -1 where the pattern has
  /// none or an index is outside (a fixed degree of freedom may be numbered -1). O(log column).
  int slot(int entry_row, int entry_col) const;

  bool operator==(const SymmetricPattern&) const = default;
};

/// Pattern of a sum of dense element matrices: element_dofs[e] lists the rows that element e
/// couples. Negative indices are left out; indices from `size` on are a programmer's mistake.
SymmetricPattern element_pattern(int size, const std::vector<std::vector<int>>& element_dofs);

/// Pattern of 3 x 3 blocks: unknown 3 i + c is coordinate c of node i, and neighbours[i] lists the
/// nodes that node i is coupled to (in one direction is enough, itself is implied, repeats and
/// negative numbers are ignored).
SymmetricPattern block_pattern(int nodes, const std::vector<std::vector<int>>& neighbours);

/// Of the matrix with these values: its scale.
double mean_diagonal(const SymmetricPattern& pattern, const std::vector<double>& values);

/// y = A x for the matrix with these values: residual checks and products in O(entries).
void multiply(const SymmetricPattern& pattern, const double* values, const double* x, double* y);

}  // namespace tenter::mechanics
