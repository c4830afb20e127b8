// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/sheets/sheet_ruler.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

namespace tenter::twin {
namespace {

/// The plain cloth with one of the baseline's stiffnesses a little larger.
std::vector<SheetTruth> moved(const SheetTruth& plain, SheetBaseline baseline) {
  constexpr double kStep = 1e-2;
  const auto with = [&](double u, double v, double shear, double coupling) {
    SheetTruth truth = plain;
    const double step = kStep * plain.fabric.curves[0].stiffness(0.0);
    truth.fabric.curves[0].k[0] += step * u;
    truth.fabric.curves[1].k[0] += step * v;
    truth.fabric.curves[2].k[0] += step * shear;
    truth.fabric.hidden.coupling_N_m += step * coupling;
    return truth;
  };
  SheetTruth stiffer = plain;  // in bending, all of it
  for (std::size_t m = 3; m < stiffer.fabric.curves.size(); ++m)
    stiffer.fabric.curves[m].k[0] *= 1.0 + 10.0 * kStep;
  if (baseline == SheetBaseline::isotropic)  // lambda, mu
    return {with(1, 1, 0, 1), with(2, 2, 1, 0), stiffer};
  return {with(1, 0, 0, 0), with(0, 1, 0, 0), with(0, 0, 1, 0), stiffer};
}

}  // namespace

std::size_t SheetRuler::fitted() const {
  const auto& plans = suite_->plans;
  return static_cast<std::size_t>(
      std::find_if(plans.begin(), plans.end(), [](const SheetPlan& p) { return p.held_out; }) -
      plans.begin());
}

Eigen::VectorXd SheetRuler::rows_of(const SheetReadings& readings) const {
  std::vector<double> rows, forces;
  for (std::size_t p = 0; p < fitted(); ++p)
    for (std::size_t f = 0; f < readings.plans[p].size(); ++f) {
      const SheetReadings::Frame& frame = readings.plans[p][f];
      for (Eigen::Index k = 0; k < frame.points_m.cols(); ++k)
        if (!(*hidden_)[p][f][static_cast<std::size_t>(k)])
          for (int c = 0; c < 3; ++c) rows.push_back(frame.points_m(c, k) / noise_.points_m);
      for (const double force_N : frame.forces_N) forces.push_back(force_N / noise_.forces_N);
    }
  rows.insert(rows.end(), forces.begin(), forces.end());
  return Eigen::Map<const Eigen::VectorXd>(rows.data(), static_cast<Eigen::Index>(rows.size()));
}

Expected<SheetRuler> SheetRuler::make(const SheetSuite& suite, const SheetTruth& plain,
                                      SheetBaseline baseline, const SheetNoise& noise,
                                      const Hidden3& hidden) {
  SheetRuler ruler(suite, noise, hidden);
  auto done = perform(suite, plain.fabric, plain.faults, ruler.fitted());
  if (!done) return tl::unexpected(done.error());
  ruler.plain_done_ = std::move(*done);
  ruler.plain_readings_ = read(suite, ruler.plain_done_, hidden, plain.faults);
  ruler.plain_rows_ = ruler.rows_of(ruler.plain_readings_);
  Eigen::Index forces = 0;
  for (const auto& frames : ruler.plain_readings_.plans)
    for (const auto& frame : frames) forces += frame.forces_N.size();
  ruler.points_ = ruler.plain_rows_.size() - forces;
  const std::vector<SheetTruth> others = moved(plain, baseline);
  Eigen::MatrixXd by_stiffness(ruler.plain_rows_.size(), static_cast<Eigen::Index>(others.size()));
  for (std::size_t i = 0; i < others.size(); ++i) {
    const auto other = perform(suite, others[i].fabric, others[i].faults, ruler.fitted());
    if (!other) return tl::unexpected(other.error());
    by_stiffness.col(static_cast<Eigen::Index>(i)) =
        ruler.rows_of(read(suite, *other, hidden, others[i].faults)) - ruler.plain_rows_;
  }
  ruler.span_ = Eigen::HouseholderQR<Eigen::MatrixXd>(by_stiffness).householderQ() *
                Eigen::MatrixXd::Identity(by_stiffness.rows(), by_stiffness.cols());
  return ruler;
}

std::optional<SheetSize> SheetRuler::size_of(const SheetTruth& truth) const {
  SheetReadings readings;
  if (truth.is_fabric_plain && truth.faults.spares_the_sheet()) {
    readings = read(*suite_, plain_done_, *hidden_, truth.faults);
  } else {
    const auto done = perform(*suite_, truth.fabric, truth.faults, fitted());
    if (!done) return std::nullopt;
    readings = read(*suite_, *done, *hidden_, truth.faults);
  }
  const Eigen::VectorXd rows = rows_of(readings);
  Eigen::VectorXd added = rows - plain_rows_;
  added -= span_ * (span_.transpose() * added);
  const auto rms = [](const Eigen::VectorXd& x) {
    return x.size() > 0 ? std::sqrt(x.squaredNorm() / static_cast<double>(x.size())) : 0.0;
  };
  const Eigen::Index forces = rows.size() - points_;
  SheetSize result;
  result.size = std::max(rms(added.head(points_)), rms(added.tail(forces)));
  result.share_of_force = rms(added.tail(forces)) / std::max(1e-12, rms(rows.tail(forces)));
  return result;
}

}  // namespace tenter::twin
