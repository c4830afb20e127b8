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
// Householder's, batch by batch: cost 2 rows columns^2; deterministic. One thread.
#pragma once

#include <Eigen/Core>

namespace tenter::diagnosis {

class Coordinates {
 public:
  explicit Coordinates(Eigen::Index columns) : r_(Eigen::MatrixXd::Zero(columns, columns)) {}

  void add(const Eigen::MatrixXd& rows);
  /// columns x columns: a column each of the rows'.
  const Eigen::MatrixXd& matrix() const { return r_; }

 private:
  Eigen::MatrixXd r_;
};

}  // namespace tenter::diagnosis
