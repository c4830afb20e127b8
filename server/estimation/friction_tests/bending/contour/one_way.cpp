// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/contour/one_way.h"

#include <cmath>
#include <limits>

namespace tenter::estimation {

OneWay::OneWay(const StrainPoint& point, double anchor, double reach,
               const Eigen::VectorXd& parameters)
    : point_(point), parameters_(parameters), anchor_(anchor) {
  point_.begin(walk_);
  if (anchor != 0.0) point_.to_strain(anchor, parameters_, walk_);
  const double typical = anchor != 0.0 ? anchor : 0.3 * reach;
  double torque = 0.0;
  double tangent = 0.0;
  look(typical, torque, tangent);
  softness_ = std::abs(typical / torque);
  find_snaps(-1.0, -reach);
  find_snaps(1.0, reach);
}

void OneWay::look(double strain, double& torque, double& tangent) {
  point_.look(strain, parameters_, false, walk_, torque, tangent);
}

// Steps that widen: pre-sliding is over within a few tau, and bends most at the anchor.
void OneWay::find_snaps(double side, double end) {
  constexpr int kSteps = 150;
  constexpr int kHalvings = 50;
  std::vector<Snap>& snaps = side < 0.0 ? down_ : up_;
  const double way = side * (end - anchor_);
  if (!(way > 0.0)) return;
  double torque = 0.0;
  double tangent = 0.0;
  double before = anchor_;
  bool is_falling = false;
  for (int i = 1; i <= kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    const double strain = anchor_ + side * way * share * (0.1 + 0.9 * share);
    look(strain, torque, tangent);
    if (!is_falling && tangent < 0.0) {
      double rises = before;
      double falls = strain;
      for (int k = 0; k < kHalvings; ++k) {
        const double middle = 0.5 * (rises + falls);
        look(middle, torque, tangent);
        (tangent < 0.0 ? falls : rises) = middle;
      }
      look(rises, torque, tangent);
      snaps.push_back({rises, end, torque});
      is_falling = true;
      look(strain, torque, tangent);
    }
    if (is_falling && side * (torque - snaps.back().torque) > 0.0) {
      double held = before;
      double past = strain;
      for (int k = 0; k < kHalvings; ++k) {
        const double middle = 0.5 * (held + past);
        look(middle, torque, tangent);
        (side * (torque - snaps.back().torque) > 0.0 ? past : held) = middle;
      }
      snaps.back().to = held;
      is_falling = false;
    }
    before = strain;
  }
}

OneWay::Value OneWay::at(double strain) {
  const double side = strain < anchor_ ? -1.0 : 1.0;
  Value value;
  for (const Snap& snap : side < 0.0 ? down_ : up_) {
    if (side * (strain - snap.from) <= 0.0) break;
    value.is_past = true;
    if (side * (snap.to - strain) <= 0.0) continue;
    value.torque = snap.torque;
    value.law_at = snap.from;
    return value;
  }
  value.law_at = strain;
  look(strain, value.torque, value.tangent);
  return value;
}

// Newton within a bracket: the sum rises everywhere, and at least as fast as the strain.
OneWay::Value OneWay::meeting(double sum, double softness, double& strain) {
  constexpr int kMaxSteps = 80;
  double below = -std::numeric_limits<double>::infinity();
  double above = -below;
  Value value;
  for (int i = 0; i < kMaxSteps; ++i) {
    value = at(strain);
    const double missing = sum - strain - softness * value.torque;
    if (std::abs(missing) <= 1e-14 * (std::abs(sum) + std::abs(strain))) break;
    (missing > 0.0 ? below : above) = strain;
    double next = strain + missing / (1.0 + softness * value.tangent);
    if (!(next > below && next < above)) next = 0.5 * (below + above);
    if (next == strain) break;
    strain = next;
  }
  return value;
}

const Eigen::VectorXd& OneWay::torque_by_p(double law_at) {
  double torque = 0.0;
  double tangent = 0.0;
  point_.look(law_at, parameters_, true, walk_, torque, tangent);
  return walk_.load_by_p;
}

}  // namespace tenter::estimation
