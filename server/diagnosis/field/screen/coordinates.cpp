// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/coordinates.h"

#include <Eigen/QR>

namespace tenter::diagnosis {

void Coordinates::add(const Eigen::MatrixXd& rows) {
  Eigen::MatrixXd stack(r_.rows() + rows.rows(), r_.cols());
  stack << r_, rows;
  const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(stack);
  r_ = qr.matrixQR().topRows(r_.rows()).triangularView<Eigen::Upper>();
}

}  // namespace tenter::diagnosis
