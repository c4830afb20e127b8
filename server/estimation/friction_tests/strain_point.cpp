// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/strain_point.h"

#include <algorithm>
#include <cmath>

#include "server/mechanics/strain_measure.h"

namespace tenter::estimation {

using mechanics::LawInput;
using mechanics::LawOutput;
using mechanics::PathStatus;

namespace {

constexpr double kLeastStretchStrain = -0.45;  // a cloth at a third of its length is not hanging

bool is_stretch(const std::string& measure) {
  return measure == "green_u" || measure == "green_v";
}

bool is_bend(const std::string& measure) {
  return measure == "bend_u" || measure == "bend_v";
}

}  // namespace

Expected<StrainPoint> StrainPoint::make(const model::Model& model) {
  if (model.terms.empty()) return bad_input("the model has no terms");
  const std::string& measure = model.terms.front().strain.name;
  if (!is_stretch(measure) && !is_bend(measure))
    return bad_input("term \"" + model.terms.front().id + "\": \"" + measure +
                     "\" is none of green_u, green_v, bend_u, bend_v, which these tests strain");
  StrainPoint point;
  point.is_bending_ = is_bend(measure);
  for (const model::Term& description : model.terms) {
    if (description.strain.name != measure)
      return bad_input("term \"" + description.id + "\" acts on \"" + description.strain.name +
                       "\" beside terms on \"" + measure + "\": such a test strains one only");
    auto law = mechanics::make_law(description.law, 1);
    if (!law) return bad_input("term \"" + description.id + "\": " + law.error().message);
    point.terms_.push_back({*law, point.parameter_count_, point.state_count_});
    point.parameter_count_ += (*law)->parameter_count();
    point.state_count_ += (*law)->state_count();
  }
  return point;
}

StrainPoint::Weight StrainPoint::weight(double strain) const {
  if (is_bending_) return {1.0, 0.0};
  const double stretch = std::sqrt(1.0 + 2.0 * std::max(strain, kLeastStretchStrain));
  return {stretch, 1.0 / stretch};
}

void StrainPoint::begin(Walk& walk) const {
  walk.strain = walk.load = walk.tangent = 0.0;
  walk.snapped = 0;
  walk.strain_by_p.setZero(parameter_count_);
  walk.load_by_p.setZero(parameter_count_);
  walk.state.assign(static_cast<std::size_t>(state_count_), 0.0);
  walk.state_by_p.setZero(state_count_, parameter_count_);
  walk.next_state_by_p.setZero(state_count_, parameter_count_);
  walk.laws.resize(terms_.size());
}

void StrainPoint::look(double strain, const Eigen::VectorXd& parameters, bool by_p, Walk& walk,
                       double& load, double& tangent) const {
  double stress = 0.0;
  double stiffness = 0.0;
  if (by_p) walk.load_by_p.setZero();
  const Weight w = weight(strain);
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Term& term = terms_[t];
    LawOutput& out = walk.laws[t];
    term.law->clear(out);
    LawInput in;
    in.strain = &strain;
    in.parameters = parameters.data() + term.first_parameter;
    in.state = walk.state.data() + term.first_state;
    in.wants_energy = false;
    term.law->evaluate(in, out);
    stress += out.stress[0];
    stiffness += out.tangent[0][0];
    if (!by_p) continue;
    for (int k = 0; k < term.law->parameter_count(); ++k)
      walk.load_by_p[term.first_parameter + k] += w.value * out.stress_by_parameter[0][k];
    for (int s = 0; s < term.law->state_count(); ++s)
      walk.load_by_p +=
          (w.value * out.stress_by_state[0][s]) * walk.state_by_p.row(term.first_state + s);
  }
  load = w.value * stress;
  tangent = w.value * stiffness + w.slope * stress;
}

// The laws' outputs are those of the last look; the strain's own derivative moves the states too.
void StrainPoint::settle(double strain, Walk& walk) const {
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Term& term = terms_[t];
    const LawOutput& out = walk.laws[t];
    for (int s = 0; s < term.law->state_count(); ++s) {
      auto row = walk.next_state_by_p.row(term.first_state + s);
      row = out.state_by_strain[s][0] * walk.strain_by_p.transpose();
      for (int k = 0; k < term.law->parameter_count(); ++k)
        row[term.first_parameter + k] += out.state_by_parameter[s][k];
      for (int r = 0; r < term.law->state_count(); ++r)
        row += out.state_by_state[s][r] * walk.state_by_p.row(term.first_state + r);
    }
    std::copy_n(out.state, term.law->state_count(), walk.state.begin() + term.first_state);
  }
  walk.state_by_p.swap(walk.next_state_by_p);
  walk.strain = strain;
}

void StrainPoint::to_strain(double strain, const Eigen::VectorXd& parameters, Walk& walk) const {
  look(strain, parameters, true, walk, walk.load, walk.tangent);
  walk.strain_by_p.setZero();
  settle(strain, walk);
}

// Newton from the start of the step, on the side that the load asks for. Pre-sliding bends the
// curve so that Newton stays short of the place of rest; where it does not, or the stress falls,
// a bracket takes over.
bool StrainPoint::find_rest(double load, const Eigen::VectorXd& parameters, Walk& walk,
                            double& strain) const {
  double reached = 0.0;
  double tangent = 0.0;
  look(walk.strain, parameters, false, walk, reached, tangent);
  strain = walk.strain;
  if (reached == load) return true;
  const double side = load > reached ? 1.0 : -1.0;
  const double end = is_bending_ ? side * 1e6 : (side > 0.0 ? 1e3 : kLeastStretchStrain);
  double inside = walk.strain;  // short of the place of rest
  double outside = end;
  bool is_bracketed = false;
  bool fell = false;
  // the tangent of a law with memory jumps where the direction turns: look a little ahead
  double step = 1e-9 * std::max(1.0, std::abs(walk.strain)) * (is_bending_ ? 1e3 : 1.0);
  double at = inside + side * step;
  constexpr int kMaxSteps = 200;
  for (int i = 0; i < kMaxSteps; ++i) {
    look(at, parameters, false, walk, reached, tangent);
    if (!std::isfinite(reached)) return false;
    const double missing = side * (load - reached);
    if (missing == 0.0) break;
    if (missing > 0.0) {
      inside = at;
    } else {
      outside = at;
      is_bracketed = true;
    }
    const double newton = at + (load - reached) / tangent;
    double next;
    if (tangent > 0.0 && side * (newton - inside) > 0.0 && side * (outside - newton) > 0.0) {
      next = newton;
    } else if (is_bracketed) {
      next = 0.5 * (inside + outside);
    } else {
      fell = fell || tangent <= 0.0;
      step *= 2.0;
      next = inside + side * step;
      if (side * (end - next) <= 0.0) return false;
    }
    step = std::max(std::abs(next - at), step);
    // a Newton step that small leaves nothing behind; halving a bracket ends by itself
    const bool is_found = std::abs(next - at) <= 1e-11 * std::abs(next);
    at = next;
    if (is_found) break;
  }
  strain = at;
  if (fell) ++walk.snapped;
  return true;
}

PathStatus StrainPoint::to_load(double load, const Eigen::VectorXd& parameters, Walk& walk) const {
  double strain = 0.0;
  if (!find_rest(load, parameters, walk, strain)) return PathStatus::no_equilibrium;
  look(strain, parameters, true, walk, walk.load, walk.tangent);
  if (!std::isfinite(walk.load) || !(walk.tangent > 0.0)) return PathStatus::no_equilibrium;
  walk.strain_by_p = -walk.load_by_p / walk.tangent;
  walk.load_by_p.setZero();
  settle(strain, walk);
  return PathStatus::ok;
}

}  // namespace tenter::estimation
