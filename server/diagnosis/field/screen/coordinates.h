// SPDX-License-Identifier: GPL-3.0-or-later
// Thousands of rows in as many numbers as there are columns: coordinates in an orthonormal basis of
// what the columns span.
//
//   A = Q R     all inner products of columns of A are those of columns of R
//
// White noise of one sigma a row has components in the span that are white with one sigma each:
// null twins are drawn there, and a screen of 75,000 rows costs that of 200. Q is never formed.
//
//   Coordinates reduced(columns);
//   for (each batch of rows) reduced.add(batch);
//   const Eigen::MatrixXd r = reduced.matrix();
//
// Householder's, batch by batch, eight columns at a time: cost 2 rows columns^2, batches of some
// hundred rows are best, and columns that have been zero so far cost nothing (those of instruments
// that only read forces, say). Deterministic on one machine (elements/lanes.h). One thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/residual_function.h"

namespace tenter::diagnosis {

class Coordinates {
 public:
  explicit Coordinates(Eigen::Index columns);

  void add(const estimation::RowMatrix& rows);
  /// columns x columns: a column each of the rows'.
  Eigen::MatrixXd matrix() const;

 private:
  bool is_zero(Eigen::Index count, Eigen::Index first) const;

  Eigen::Index columns_, stride_;  ///< of rows that are padded to whole lanes
  std::vector<double> r_;          ///< upper triangle, row by row
  std::vector<bool> is_zero_;      ///< [eight columns] so far
  std::vector<double> rows_,
      reflectors_;  ///< scratch: the batch, and what takes eight columns off it
};

}  // namespace tenter::diagnosis
