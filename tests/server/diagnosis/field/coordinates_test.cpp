// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/coordinates.h"

#include <gtest/gtest.h>

#include "server/diagnosis/screening/normal.h"

namespace tenter::diagnosis {
namespace {

/// Products of columns are those of the rows, however many columns and batches, and where some are
/// zero or hang on others, to the rounding of a QR: that of lengths, not of their squares.
TEST(Coordinates, HaveTheProductsOfTheRows) {
  for (const Eigen::Index columns : {1, 7, 8, 9, 16, 37}) {
    constexpr Eigen::Index kRows = 300;
    Normal normal(static_cast<unsigned long long>(columns));
    estimation::RowMatrix all(kRows, columns);
    for (Eigen::Index k = 0; k < all.size(); ++k) all.data()[k] = normal();
    if (columns > 8) {
      all.col(3).setZero();
      all.col(8) = 1e-9 * all.col(8) + all.col(0) - 2.0 * all.col(5);
    }
    if (columns > 24) all.block(0, 16, 200, 8).setZero();  // what comes late
    Coordinates coordinates(columns);
    for (const Eigen::Index first : {0, 5, 120})
      coordinates.add(all.middleRows(first, (first == 0 ? 5 : first == 5 ? 120 : kRows) - first));
    const Eigen::MatrixXd r = coordinates.matrix();
    const Eigen::MatrixXd expected = all.transpose() * all;
    EXPECT_LT((r.transpose() * r - expected).norm(), 1e-13 * expected.norm()) << columns;
    EXPECT_EQ(r.triangularView<Eigen::StrictlyLower>().toDenseMatrix().norm(), 0.0);
    if (columns <= 8) continue;
    const Eigen::VectorXd new_part = all.col(8) - all.col(0) + 2.0 * all.col(5);
    const Eigen::VectorXd kept = r.col(8) - r.col(0) + 2.0 * r.col(5);
    EXPECT_NEAR(kept.norm(), new_part.norm(), 1e-5 * new_part.norm()) << columns;
  }
}

}  // namespace
}  // namespace tenter::diagnosis
