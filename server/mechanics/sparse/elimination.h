// SPDX-License-Identifier: GPL-3.0-or-later
// In what order to eliminate, and what L looks like then: the symbolic phase of the supernodal
// factorisation.
//
// Unknowns with the same neighbours (the three coordinates of a node) are taken as one from the
// start, so that everything works on a graph of a third of the size. That graph is ordered twice,
// by approximate minimum degree and by nested dissection (AMD and METIS, through the LGPL parts of
// CHOLMOD), and the order with fewer flops is kept. Columns of L with the same rows below are one
// supernode; small supernodes are merged with their parents where a model of what a supernode costs
// says that the zeros stored thereby are cheaper than the overhead they save; wide ones are cut.
#pragma once

#include <vector>

#include "server/mechanics/sparse/symmetric_pattern.h"

namespace tenter::mechanics {

/// Supernode s has columns [column_start[s], column_start[s + 1]) in the new numbering, and the
/// rows rows[row_start[s]] .. rows[row_start[s + 1] - 1], increasing, its own columns first.
struct SupernodalStructure {
  std::vector<int> order;  ///< order[new] = old
  std::vector<int> column_start;
  std::vector<int> row_start;
  std::vector<int> rows;
  double flops = 0.0;  ///< sum of squared column counts of L without stored zeros

  int count() const { return static_cast<int>(column_start.size()) - 1; }
  int width(int s) const { return column_start[s + 1] - column_start[s]; }
  int height(int s) const { return row_start[s + 1] - row_start[s]; }
};

/// Costs O(entries of L / block size squared) and the orderings. Deterministic. Orderings of
/// several threads wait for each other, because METIS draws from the C library's only generator.
SupernodalStructure supernodal_structure(const SymmetricPattern& pattern);

}  // namespace tenter::mechanics
