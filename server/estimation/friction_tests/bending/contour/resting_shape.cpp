// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/contour/resting_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tenter::estimation {
namespace {

/// Two points of Gauss in a cell, as shares of it: gravity's work.
constexpr std::array<double, 2> kGauss = {0.21132486540518713, 0.78867513459481287};
/// Simpson's three: places.
constexpr std::array<double, 3> kSimpson = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};

constexpr double kFarthest = 0.3;  // rad in one step

}  // namespace

RestingShape::RestingShape(double length_m, double weight_N_m2, Eigen::VectorXd strain,
                           std::vector<HeldRun> held)
    : length_(length_m),
      cell_(length_m / static_cast<double>(strain.size())),
      weight_(weight_N_m2),
      cells_(static_cast<int>(strain.size())),
      strain_(std::move(strain)),
      held_(std::move(held)) {
  is_held_.assign(static_cast<std::size_t>(cells_), false);
  for (const HeldRun& run : held_) {
    for (int i = run.first; i < run.last; ++i) is_held_[static_cast<std::size_t>(i)] = true;
    placement_count_ += run.turns;
  }
  unknown_.assign(static_cast<std::size_t>(cells_) + 1, -1);
  for (int i = 0; i < cells_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    unknown_[k + 1] = is_held_[k] ? unknown_[k] : count_++;
  }
  turned_.setZero(cells_ + 1);
}

void RestingShape::turn() {
  for (int i = 0; i <= cells_; ++i) {
    const int u = unknown_[static_cast<std::size_t>(i)];
    directions_[i] = (u < 0 ? placement_[2] : unknowns_[u]) + turned_[i];
  }
}

// The work's slopes and second derivatives by directions at the borders, then by the unknowns.
void RestingShape::assemble(double held_back) {
  force_.setZero(cells_ + 1);
  diagonal_.setZero(cells_ + 1);
  beside_.setZero(cells_ + 1);
  for (int i = 0; i < cells_; ++i) {
    const double a = directions_[i];
    const double b = directions_[i + 1];
    for (const double share : kGauss) {
      const double arm = 0.5 * weight_ * cell_ * (length_ - (i + share) * cell_);
      const double angle = (1.0 - share) * a + share * b;
      const double c = arm * std::cos(angle);
      const double s = arm * std::sin(angle);
      force_[i] += (1.0 - share) * c;
      force_[i + 1] += share * c;
      diagonal_[i] -= (1.0 - share) * (1.0 - share) * s;
      diagonal_[i + 1] -= share * share * s;
      beside_[i] -= share * (1.0 - share) * s;
    }
    if (is_held_[static_cast<std::size_t>(i)]) continue;
    const double torque = torque_at(i);
    const double stiffness = 3.0 / cell_ * (tangent_[i] + held_back);
    force_[i] -= torque;
    force_[i + 1] += torque;
    diagonal_[i] += stiffness;
    diagonal_[i + 1] += stiffness;
    beside_[i] -= stiffness;
  }
  reduced_.setZero(count_);
  matrix_diagonal_.setZero(count_);
  matrix_beside_.setZero(count_);
  for (int i = 0; i <= cells_; ++i) {
    const int u = unknown_[static_cast<std::size_t>(i)];
    if (u >= 0) {
      reduced_[u] += force_[i];
      matrix_diagonal_[u] += diagonal_[i];
    }
    if (i == cells_) break;
    const int next = unknown_[static_cast<std::size_t>(i) + 1];
    if (next < 0) continue;
    if (next == u)
      matrix_diagonal_[u] += 2.0 * beside_[i];
    else if (u >= 0)
      matrix_beside_[u] = beside_[i];
  }
}

bool RestingShape::factorise() {
  pivot_.resize(count_);
  lower_.setZero(count_);
  for (int i = 0; i < count_; ++i) {
    pivot_[i] = matrix_diagonal_[i];
    if (i > 0) pivot_[i] -= lower_[i - 1] * matrix_beside_[i - 1];
    if (!(pivot_[i] > 1e-12 * std::abs(matrix_diagonal_[i]))) return false;
    lower_[i] = matrix_beside_[i] / pivot_[i];
  }
  return true;
}

void RestingShape::solve(Eigen::VectorXd& x) const {
  for (int i = 1; i < count_; ++i) x[i] -= lower_[i - 1] * x[i - 1];
  for (int i = count_; i-- > 0;) {
    x[i] /= pivot_[i];
    if (i + 1 < count_) x[i] -= lower_[i] * x[i + 1];
  }
}

/// Of the straight line that stands for the law of a cell.
double RestingShape::torque_at(int cell) const {
  const double strain = 3.0 * (directions_[cell + 1] - directions_[cell]) / cell_;
  return torque_[cell] + tangent_[cell] * (strain - strain_at_[cell]);
}

// The point of the law from which a line at the last line's strain and torque is met by one of a
// slope between the law's steepest and its flattest: near a snap neither strain nor torque alone
// would say where. The largest torque by which the last line was off.
double RestingShape::meet(OneWay& way) {
  const double softness = way.softness();
  double off = 0.0;
  snapped_ = 0;
  for (int i = 0; i < cells_; ++i) {
    if (is_held_[static_cast<std::size_t>(i)]) continue;
    const double strain = 3.0 * (directions_[i + 1] - directions_[i]) / cell_;
    const double torque = torque_at(i);
    const OneWay::Value value = way.meeting(strain + softness * torque, softness, strain_at_[i]);
    off = std::max(off, std::abs(value.torque - torque));
    torque_[i] = value.torque;
    tangent_[i] = value.tangent;
    law_at_[i] = value.law_at;
    snapped_ += value.is_past ? 1 : 0;
  }
  return off;
}

/// The law itself at the strains as they are.
void RestingShape::touch(OneWay& way) {
  snapped_ = 0;
  for (int i = 0; i < cells_; ++i) {
    if (is_held_[static_cast<std::size_t>(i)]) continue;
    strain_at_[i] = 3.0 * (directions_[i + 1] - directions_[i]) / cell_;
    const OneWay::Value value = way.at(strain_at_[i]);
    torque_[i] = value.torque;
    tangent_[i] = value.tangent;
    law_at_[i] = value.law_at;
    snapped_ += value.is_past ? 1 : 0;
  }
}

bool RestingShape::is_small(double torque) const {
  constexpr double kSmall = 1e-11;  // of the strip's weight on its length
  return torque <= kSmall * 0.5 * weight_ * length_ * length_;
}

// Newton's steps with a line for the law of each cell, whose strain and torque need not agree with
// the law on the way (a semi-smooth Newton method for the law's proximal map): a strip in which
// some cells rest on a snap and others where the law is steep gets there in few steps, or goes to
// and fro for ever.
bool RestingShape::leap(OneWay& way) {
  constexpr int kMaxSteps = 50;
  Eigen::VectorXd step;
  for (int i = 0; i < kMaxSteps; ++i) {
    const double off = meet(way);
    assemble(0.0);
    if (!reduced_.allFinite() || !factorise()) return false;
    step = -reduced_;
    solve(step);
    if (step.cwiseAbs().maxCoeff() > kFarthest) return false;
    unknowns_ += step;
    turn();
    if (is_small(off) && is_small(reduced_.cwiseAbs().maxCoeff())) return true;
  }
  return false;
}

// The same down the work, every cell held back by a viscosity that goes as the steps succeed.
bool RestingShape::creep(OneWay& way, int steps, double& held_back) {
  const double least = 1e-8 / way.softness();
  Eigen::VectorXd step, before;
  for (int i = 0; i < steps; ++i) {
    assemble(0.0);
    if (!reduced_.allFinite()) return false;
    if (is_small(reduced_.cwiseAbs().maxCoeff())) return factorise();
    assemble(held_back);
    step = -reduced_;
    if (!factorise()) {
      held_back = std::max(least, 4.0 * held_back);
      continue;
    }
    solve(step);
    const double slope = -step.dot(reduced_);
    before = unknowns_;
    unknowns_ += step;
    turn();
    touch(way);
    assemble(0.0);
    if (step.cwiseAbs().maxCoeff() <= kFarthest && step.dot(reduced_) <= 0.5 * slope) {
      held_back = held_back > least ? held_back / 3.0 : 0.0;
      continue;
    }
    unknowns_ = before;
    turn();
    touch(way);
    held_back = std::max(least, 4.0 * held_back);
  }
  return false;
}

// A snap goes along the strip cell by cell, and creeping follows it a few steps a cell; leaps take
// the rest of the way at once, but only from near enough.
bool RestingShape::creep_and_leap(OneWay& way) {
  constexpr int kRounds = 12;
  constexpr int kCreepingSteps = 20;
  double held_back = 1.0 / way.softness();
  for (int round = 0; round < kRounds; ++round) {
    if (creep(way, kCreepingSteps, held_back)) return true;
    if (!unknowns_.allFinite()) return false;
    const Eigen::VectorXd crept = unknowns_;
    if (leap(way)) return true;
    unknowns_ = crept;
    turn();
    touch(way);
  }
  return false;
}

bool RestingShape::rest(OneWay& way, const Eigen::VectorXd& placement,
                        const Eigen::VectorXd& guess) {
  placement_ = placement;
  Eigen::Index column = 3;
  for (const HeldRun& run : held_) {
    int turn = 0;
    for (int k = run.first; k < run.last; ++k) {
      turned_[k + 1] = turned_[k] + strain_[k] / 3.0 * cell_;
      if (turn < run.turns && k == run.turn_at(turn)) {
        turned_[k + 1] += placement_[column++];
        ++turn;
      }
    }
  }
  directions_.resize(cells_ + 1);
  unknowns_.resize(count_);
  strain_at_.setZero(cells_);
  torque_.setZero(cells_);
  tangent_.setZero(cells_);
  law_at_.setZero(cells_);
  const auto begin = [&] {
    for (int i = cells_; i >= 0; --i)
      if (const int u = unknown_[static_cast<std::size_t>(i)]; u >= 0)
        unknowns_[u] = guess[i] - turned_[i];
    turn();
    touch(way);
  };
  begin();
  bool is_at_rest = count_ == 0 || leap(way);
  if (!is_at_rest) {
    begin();
    is_at_rest = creep_and_leap(way);
  }
  if (is_at_rest) lay_out();
  return is_at_rest;
}

// K d theta = - d force: parameters act through the torque of cells, the placement through the
// directions that it gives.
void RestingShape::differentiate(OneWay& way, int parameters) {
  parameters_ = parameters;
  const int columns = parameters + placement_count();
  Eigen::MatrixXd pushed = Eigen::MatrixXd::Zero(cells_ + 1, columns);  // of borders
  directions_by_.setZero(cells_ + 1, columns);
  double last_at = 0.0;
  bool has_last = false;
  Eigen::VectorXd by_p;
  for (int i = 0; i < cells_; ++i) {
    if (is_held_[static_cast<std::size_t>(i)]) continue;
    if (!has_last || law_at_[i] != last_at) by_p = way.torque_by_p(law_at_[i]);
    has_last = true;
    last_at = law_at_[i];
    pushed.row(i).head(parameters) -= by_p.transpose();
    pushed.row(i + 1).head(parameters) += by_p.transpose();
  }
  // directions from a border on that are tied to one unknown, or to the clamp
  const auto given = [&](int column, int from) {
    const int tied = unknown_[static_cast<std::size_t>(from)];
    for (int i = from; i <= cells_ && unknown_[static_cast<std::size_t>(i)] == tied; ++i)
      directions_by_(i, column) = 1.0;
    const Eigen::VectorXd moved = directions_by_.col(column);
    for (int i = 0; i <= cells_; ++i) {
      pushed(i, column) += diagonal_[i] * moved[i];
      if (i > 0) pushed(i, column) += beside_[i - 1] * moved[i - 1];
      if (i < cells_) pushed(i, column) += beside_[i] * moved[i + 1];
    }
  };
  given(parameters + 2, 0);
  int turning = parameters + 3;
  for (const HeldRun& run : held_)
    for (int turn = 0; turn < run.turns; ++turn) given(turning++, run.turn_at(turn) + 1);
  Eigen::VectorXd right(count_);
  for (int column = 0; column < columns; ++column) {
    right.setZero();
    for (int i = 0; i <= cells_; ++i)
      if (const int u = unknown_[static_cast<std::size_t>(i)]; u >= 0)
        right[u] -= pushed(i, column);
    solve(right);
    for (int i = 0; i <= cells_; ++i)
      if (const int u = unknown_[static_cast<std::size_t>(i)]; u >= 0)
        directions_by_(i, column) += right[u];
  }
  x_by_.setZero(cells_ + 1, columns);
  y_by_.setZero(cells_ + 1, columns);
  for (int i = 0; i < cells_; ++i) {
    x_by_.row(i + 1) = x_by_.row(i);
    y_by_.row(i + 1) = y_by_.row(i);
    for (std::size_t q = 0; q < kSimpson.size(); ++q) {
      const double share = 0.5 * static_cast<double>(q);
      const double angle = (1.0 - share) * directions_[i] + share * directions_[i + 1];
      const double c = kSimpson[q] * cell_ * std::cos(angle);
      const double s = kSimpson[q] * cell_ * std::sin(angle);
      x_by_.row(i + 1) -=
          s * ((1.0 - share) * directions_by_.row(i) + share * directions_by_.row(i + 1));
      y_by_.row(i + 1) +=
          c * ((1.0 - share) * directions_by_.row(i) + share * directions_by_.row(i + 1));
    }
  }
  x_by_.col(parameters).array() += 1.0;
  y_by_.col(parameters + 1).array() += 1.0;
}

void RestingShape::lay_out() {
  x_.resize(cells_ + 1);
  y_.resize(cells_ + 1);
  x_[0] = placement_[0];
  y_[0] = placement_[1];
  for (int i = 0; i < cells_; ++i) {
    const Place at = within(i, cell_);
    x_[i + 1] = at.x;
    y_[i + 1] = at.y;
  }
}

RestingShape::Place RestingShape::within(int cell, double way) const {
  const double a = directions_[cell];
  const double turn = (directions_[cell + 1] - a) * way / cell_;
  Place at{x_[cell], y_[cell], a + turn};
  for (std::size_t q = 0; q < kSimpson.size(); ++q) {
    const double angle = a + 0.5 * static_cast<double>(q) * turn;
    at.x += kSimpson[q] * way * std::cos(angle);
    at.y += kSimpson[q] * way * std::sin(angle);
  }
  return at;
}

int RestingShape::cell_of(double arc_m) const {
  return std::clamp(static_cast<int>(arc_m / cell_), 0, cells_ - 1);
}

RestingShape::Place RestingShape::place(double arc_m) const {
  const int i = cell_of(arc_m);
  return within(i, arc_m - i * cell_);
}

void RestingShape::place_by(double arc_m, Eigen::Matrix<double, 3, Eigen::Dynamic>& by) const {
  const int i = cell_of(arc_m);
  const double way = arc_m - i * cell_;
  const double along = way / cell_;
  by.resize(3, directions_by_.cols());
  by.row(0) = x_by_.row(i);
  by.row(1) = y_by_.row(i);
  for (std::size_t q = 0; q < kSimpson.size(); ++q) {
    const double share = 0.5 * static_cast<double>(q) * along;
    const double angle = (1.0 - share) * directions_[i] + share * directions_[i + 1];
    by.row(2) = (1.0 - share) * directions_by_.row(i) + share * directions_by_.row(i + 1);
    by.row(0) -= kSimpson[q] * way * std::sin(angle) * by.row(2);
    by.row(1) += kSimpson[q] * way * std::cos(angle) * by.row(2);
  }
}

}  // namespace tenter::estimation
