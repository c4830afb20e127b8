// SPDX-License-Identifier: GPL-3.0-or-later
// Below R stands a batch B, both of which reflections turn into another R. For eight columns from
// k on (G. H. Golub, C. F. Van Loan, Matrix Computations, 5.1 and 5.2; R. Schreiber, C. Van Loan,
// SIAM J. Sci. Stat. Comput. 10, 1989),
//
//   H_c = I - tau_c v_c v_c'        v_c: one at row k + c of R, V(:, c) in the batch, else zero
//   H_7 ... H_0 = I - V T' V'       T(c, c) = tau_c,  T(:c, c) = -tau_c T(:c, :c) V(:, :c)' V(:, c)
//
// Rows of R above and below those eight have no part in it.
#include "server/diagnosis/field/screen/coordinates.h"

#include <algorithm>
#include <cmath>

#include "server/mechanics/elements/lanes.h"

namespace tenter::diagnosis {

using mechanics::Lanes;
using mechanics::load;
using mechanics::store;

namespace {

constexpr int kPanel = mechanics::kLanes;

/// Eight reflections: V, row by row, and T.
struct Panel {
  double* v = nullptr;
  double t[kPanel][kPanel] = {};
};

/// Eight columns of the batch, from `b` on, and their rows of R, from `r` on; `stride` of both.
/// Columns from `count` on are padding.
TENTER_KERNEL void reflect_panel(double* b, double* r, Eigen::Index rows, Eigen::Index stride,
                                 int count, Panel& panel) {
  for (Eigen::Index i = 0; i < rows; ++i) store(Lanes{}, panel.v + i * kPanel);
  for (int c = 0; c < kPanel; ++c)
    for (int k = 0; k < kPanel; ++k) panel.t[c][k] = 0.0;
  for (int c = 0; c < count; ++c) {
    double below = 0.0;
    for (Eigen::Index i = 0; i < rows; ++i) below += b[i * stride + c] * b[i * stride + c];
    if (below == 0.0) continue;
    double* own = r + c * stride;
    const double top = own[c];
    const double length = std::copysign(std::sqrt(top * top + below), -top);
    const double tau = (length - top) / length;
    const double scale = 1.0 / (top - length);
    Lanes products = load(own), along{};  // of the panel's columns and of V's with this one
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double v = b[i * stride + c] * scale;
      along += v * load(panel.v + i * kPanel);
      products += v * load(b + i * stride);
      panel.v[i * kPanel + c] = v;
    }
    products *= tau;
    for (int k = 0; k < kPanel; ++k)
      if (k <= c) products[k] = 0.0;  // done already
    store(load(own) - products, own);
    own[c] = length;
    for (Eigen::Index i = 0; i < rows; ++i)
      store(load(b + i * stride) - panel.v[i * kPanel + c] * products, b + i * stride);
    panel.t[c][c] = tau;
    for (int k = 0; k < c; ++k) {
      double sum = 0.0;
      for (int l = k; l < c; ++l) sum += panel.t[k][l] * along[l];
      panel.t[k][c] = -tau * sum;
    }
  }
}

/// Two times eight columns further on.
TENTER_KERNEL void reflect_others(const Panel& panel, double* b, double* r, Eigen::Index rows,
                                  Eigen::Index stride, bool has_second) {
  const Eigen::Index second = has_second ? kPanel : 0;
  Lanes w[kPanel][2];
  for (int c = 0; c < kPanel; ++c) {
    w[c][0] = load(r + c * stride);
    w[c][1] = load(r + c * stride + second);
  }
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Lanes x = load(b + i * stride), y = load(b + i * stride + second);
    const double* v = panel.v + i * kPanel;
    for (int c = 0; c < kPanel; ++c) {
      w[c][0] += v[c] * x;
      w[c][1] += v[c] * y;
    }
  }
  for (int c = kPanel - 1; c >= 0; --c) {
    Lanes x{}, y{};
    for (int k = 0; k <= c; ++k) {
      x += panel.t[k][c] * w[k][0];
      y += panel.t[k][c] * w[k][1];
    }
    w[c][0] = x;
    w[c][1] = y;
    if (has_second) store(load(r + c * stride + second) - y, r + c * stride + second);
    store(load(r + c * stride) - x, r + c * stride);
  }
  for (Eigen::Index i = 0; i < rows; ++i) {
    Lanes x = load(b + i * stride), y = load(b + i * stride + second);
    const double* v = panel.v + i * kPanel;
    for (int c = 0; c < kPanel; ++c) {
      x -= v[c] * w[c][0];
      y -= v[c] * w[c][1];
    }
    if (has_second) store(y, b + i * stride + second);
    store(x, b + i * stride);
  }
}

}  // namespace

Coordinates::Coordinates(Eigen::Index columns)
    : columns_(columns),
      stride_((columns + kPanel - 1) / kPanel * kPanel),
      r_(static_cast<std::size_t>(stride_ * stride_), 0.0),
      is_zero_(static_cast<std::size_t>(stride_ / kPanel), true) {}

/// Whether eight columns are zero in the batch.
bool Coordinates::is_zero(Eigen::Index count, Eigen::Index first) const {
  for (Eigen::Index i = 0; i < count; ++i)
    for (int c = 0; c < kPanel; ++c)
      if (rows_[static_cast<std::size_t>(i * stride_ + first + c)] != 0.0) return false;
  return true;
}

void Coordinates::add(const estimation::RowMatrix& rows) {
  const Eigen::Index count = rows.rows();
  rows_.assign(static_cast<std::size_t>(count * stride_), 0.0);
  reflectors_.resize(static_cast<std::size_t>(count * kPanel));
  for (Eigen::Index i = 0; i < count; ++i)
    std::copy_n(rows.row(i).data(), columns_, rows_.data() + i * stride_);
  std::vector<Eigen::Index> panels;  // that are zero neither here nor in R
  for (Eigen::Index k = 0; k < stride_; k += kPanel) {
    const auto p = static_cast<std::size_t>(k / kPanel);
    is_zero_[p] = is_zero_[p] && is_zero(count, k);
    if (!is_zero_[p]) panels.push_back(k);
  }
  Panel panel;
  panel.v = reflectors_.data();
  for (std::size_t p = 0; p < panels.size(); ++p) {
    const Eigen::Index k = panels[p];
    double* own = r_.data() + k * stride_;
    const auto wide = static_cast<int>(std::min<Eigen::Index>(kPanel, columns_ - k));
    reflect_panel(rows_.data() + k, own + k, count, stride_, wide, panel);
    for (std::size_t q = p + 1; q < panels.size(); ++q) {
      const Eigen::Index j = panels[q];
      const bool has_second = q + 1 < panels.size() && panels[q + 1] == j + kPanel;
      reflect_others(panel, rows_.data() + j, own + j, count, stride_, has_second);
      if (has_second) ++q;
    }
  }
}

Eigen::MatrixXd Coordinates::matrix() const {
  const Eigen::Map<const estimation::RowMatrix, 0, Eigen::OuterStride<>> all(
      r_.data(), columns_, columns_, Eigen::OuterStride<>(stride_));
  return all.triangularView<Eigen::Upper>();
}

}  // namespace tenter::diagnosis
