// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/material_point.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/model/catalogue.h"

namespace tenter::mechanics {
namespace {

/// At most three unknowns, on the stack.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;

}  // namespace

Expected<MaterialPoint> MaterialPoint::make(const model::Model& model) {
  if (!model.limits.empty())
    return bad_input("limit \"" + model.limits.front().id +
                     "\": a material point does not enforce energy limits");
  MaterialPoint point;
  for (const model::Term& description : model.terms) {
    const std::string name = "term \"" + description.id + "\": ";
    const model::StrainRow* row = model::find_strain(description.strain.name);
    if (row != nullptr && row->domain == model::Domain::solid)
      return bad_input(name + "\"" + description.strain.name +
                       "\" is a strain of solids; a material point is a piece of membrane");
    if (description.support.name != "everywhere")
      return bad_input(name +
                       "acts around one place of the material only; a material point stands "
                       "for all of it");
    if (row != nullptr && !row->at_point) {
      point.parameter_count_ += static_cast<int>(description.law.parameters.size());
      continue;
    }
    Expected<StrainMeasure> measure = StrainMeasure::make(description.strain);
    if (!measure) return bad_input(name + measure.error().message);
    auto law = make_law(description.law, measure->count());
    if (!law) return bad_input(name + law.error().message);
    Term term;
    term.measure = *measure;
    term.law = *law;
    term.first_parameter = point.parameter_count_;
    term.first_state = point.state_count_;
    point.parameter_count_ += term.law->parameter_count();
    point.state_count_ += term.law->state_count();
    point.terms_.push_back(std::move(term));
  }
  return point;
}

void MaterialPoint::begin_run(FrameStart start, Workspace& scratch) const {
  for (const Term& term : terms_) {
    for (int i = 0; i < term.law->state_count(); ++i) {
      if (start == FrameStart::rested && term.law->state_kind(i) == StateKind::memory) continue;
      scratch.state[static_cast<std::size_t>(term.first_state + i)] = 0.0;
      if (scratch.state_by_p.size() > 0) scratch.state_by_p.row(term.first_state + i).setZero();
    }
  }
}

// Psi(eps(c(q))):  P = sum sigma_i deps_i/dq,  dP/dq = sum deps_i' S_ij deps_j + sigma_i
// d2eps_i/dq2 with deps/dq = by_c c_q and d2eps/dq2 = c_q' by_cc c_q + sum_k by_c[k] c_k,qq.
MaterialPoint::Balance MaterialPoint::evaluate(const HomogeneousStrain& kinematics,
                                               const Eigen::Vector3d& q,
                                               const Eigen::VectorXd& parameters, double duration_s,
                                               Workspace& scratch) const {
  Balance balance;
  balance.stress.setZero();
  balance.tangent.setZero();
  const Eigen::Vector3d c = kinematics.c(q);
  const Eigen::Matrix3d c_by_q = kinematics.c_by_q(q);
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Term& term = terms_[t];
    StrainValue& strain = scratch.strains[t];
    term.measure.evaluate(c, strain);
    LawOutput& law = scratch.laws[t];
    term.law->clear(law);
    LawInput in;
    in.strain = strain.value;
    in.parameters = parameters.data() + term.first_parameter;
    in.state = scratch.state.data() + term.first_state;
    in.duration_s = duration_s;
    in.wants_energy = false;
    term.law->evaluate(in, law);

    auto& by_q = scratch.strain_by_q[t];
    const int count = term.measure.count();
    for (int i = 0; i < count; ++i) by_q.row(i) = strain.by_c[i].transpose() * c_by_q;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d push = law.stress[i] * by_q.row(i).transpose();
      balance.stress += push;
      balance.scale += push.cwiseAbs().sum();
      Eigen::Matrix3d curvature = c_by_q.transpose() * strain.by_cc[i] * c_by_q;
      for (int k = 0; k < 3; ++k) curvature += strain.by_c[i][k] * kinematics.c_by_qq(k);
      balance.tangent += law.stress[i] * curvature;
      for (int j = 0; j < count; ++j)
        balance.tangent += law.tangent[i][j] * by_q.row(i).transpose() * by_q.row(j);
    }
    if (strain.near_count > 0) {
      Eigen::Matrix3d by_cc = Eigen::Matrix3d::Zero();
      add_near_pairs(strain.near, strain.near_count, strain.value, law.stress, law.tangent, by_cc);
      balance.tangent += c_by_q.transpose() * by_cc * c_by_q;
    }
  }
  return balance;
}

// Newton on the free components' stress, with the tangent shifted where it is not positive
// definite, and a line search on the norm of the stress. Two unknowns at most.
bool MaterialPoint::solve_free(const HomogeneousStrain& kinematics,
                               const std::array<bool, 3>& is_free,
                               const Eigen::VectorXd& parameters, double duration_s,
                               Workspace& scratch, Eigen::Vector3d& q, Balance& balance) const {
  int free[3];
  int count = 0;
  for (int i = 0; i < 3; ++i)
    if (is_free[static_cast<std::size_t>(i)]) free[count++] = i;
  constexpr int kMaxIterations = 60;
  constexpr double kTolerance = 1e-12;  // of the sum of the magnitudes that balance
  constexpr double kSmallestStretch = 0.02;

  const auto residual_norm = [&](const Balance& b) {
    double sum = 0.0;
    for (int i = 0; i < count; ++i) sum += b.stress[free[i]] * b.stress[free[i]];
    return std::sqrt(sum);
  };
  balance = evaluate(kinematics, q, parameters, duration_s, scratch);
  double norm = residual_norm(balance);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    if (!std::isfinite(norm)) return false;
    if (norm <= kTolerance * (balance.scale + 1e-9)) return true;
    SmallMatrix k = SmallMatrix::Zero(count, count);
    SmallVector r = SmallVector::Zero(count);
    for (int i = 0; i < count; ++i) {
      r[i] = balance.stress[free[i]];
      for (int j = 0; j < count; ++j) k(i, j) = balance.tangent(free[i], free[j]);
    }
    const double stiffness = k.cwiseAbs().maxCoeff();
    const double smallest =
        count == 1 ? k(0, 0)
                   : Eigen::SelfAdjointEigenSolver<SmallMatrix>(k, Eigen::EigenvaluesOnly)
                         .eigenvalues()[0];
    if (smallest < 1e-6 * stiffness)
      k.diagonal().array() += 1e-3 * stiffness - std::min(smallest, 0.0);
    if (!(stiffness > 0.0)) return false;
    const SmallVector step = -k.partialPivLu().solve(r);
    double length = 1.0;
    for (int i = 0; i < count; ++i)  // at most a quarter of the stretch in one go
      length = std::min(
          length, 0.25 * std::max(std::abs(q[free[i]]), 0.2) / std::max(std::abs(step[i]), 1e-300));
    bool improved = false;
    const Eigen::Vector3d start = q;
    for (int halving = 0; halving < 40 && !improved; ++halving, length *= 0.5) {
      q = start;
      for (int i = 0; i < count; ++i) q[free[i]] += length * step[i];
      for (int i = 0; i < count; ++i)
        if (free[i] < 2) q[free[i]] = std::max(q[free[i]], kSmallestStretch);
      const Balance trial = evaluate(kinematics, q, parameters, duration_s, scratch);
      const double trial_norm = residual_norm(trial);
      if (trial_norm < norm) {
        balance = trial;
        norm = trial_norm;
        improved = true;
      }
    }
    if (!improved) {
      q = start;
      balance = evaluate(kinematics, q, parameters, duration_s, scratch);
      // rounding keeps it from falling further: good where what is left is small beside what
      // balances
      return norm <= 1e-8 * (balance.scale + 1e-9);
    }
  }
  return norm <= 1e-8 * (balance.scale + 1e-9);
}

// With g = stress_p + stress_state dstate/dp at fixed strain, the free components obey K_ff dq_f/dp
// = -(eps_q' g)_f and dP/dp = K_.f dq_f/dp + eps_q' g.
void MaterialPoint::differentiate(const std::array<bool, 3>& is_free, const Balance& balance,
                                  Eigen::Index frame, Workspace& scratch,
                                  PathResponse& response) const {
  auto stress_by_p = response.stress_by_p.middleRows(3 * frame, 3);
  auto q_by_p = response.q_by_p.middleRows(3 * frame, 3);
  stress_by_p.setZero();
  q_by_p.setZero();
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Term& term = terms_[t];
    const LawOutput& law = scratch.laws[t];
    const auto& by_q = scratch.strain_by_q[t];
    for (int i = 0; i < term.measure.count(); ++i) {
      for (int k = 0; k < term.law->parameter_count(); ++k)
        for (int a = 0; a < 3; ++a)
          stress_by_p(a, term.first_parameter + k) += by_q(i, a) * law.stress_by_parameter[i][k];
      for (int s = 0; s < term.law->state_count(); ++s) {
        if (law.stress_by_state[i][s] == 0.0) continue;
        for (int a = 0; a < 3; ++a)
          stress_by_p.row(a) +=
              by_q(i, a) * law.stress_by_state[i][s] * scratch.state_by_p.row(term.first_state + s);
      }
    }
  }
  int free[3];
  int count = 0;
  for (int i = 0; i < 3; ++i)
    if (is_free[static_cast<std::size_t>(i)]) free[count++] = i;
  if (count > 0) {
    SmallMatrix k = SmallMatrix::Zero(count, count);
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < count; ++j) k(i, j) = balance.tangent(free[i], free[j]);
    const SmallMatrix inverse = k.inverse();
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < count; ++j)
        q_by_p.row(free[i]) -= inverse(i, j) * stress_by_p.row(free[j]);
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < count; ++i)
        stress_by_p.row(a) += balance.tangent(a, free[i]) * q_by_p.row(free[i]);
    for (int i = 0; i < count; ++i) stress_by_p.row(free[i]).setZero();
  }
  // states at the end of the step
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Term& term = terms_[t];
    const LawOutput& law = scratch.laws[t];
    for (int s = 0; s < term.law->state_count(); ++s) {
      auto row = scratch.next_state_by_p.row(term.first_state + s);
      row.setZero();
      for (int k = 0; k < term.law->parameter_count(); ++k)
        row[term.first_parameter + k] = law.state_by_parameter[s][k];
      for (int r = 0; r < term.law->state_count(); ++r)
        if (law.state_by_state[s][r] != 0.0)
          row += law.state_by_state[s][r] * scratch.state_by_p.row(term.first_state + r);
      if (count == 0) continue;
      for (int i = 0; i < term.measure.count(); ++i)
        for (int f = 0; f < count; ++f)
          row +=
              law.state_by_strain[s][i] * scratch.strain_by_q[t](i, free[f]) * q_by_p.row(free[f]);
    }
  }
  scratch.state_by_p.swap(scratch.next_state_by_p);
}

void MaterialPoint::advance_state(Workspace& scratch) const {
  for (std::size_t t = 0; t < terms_.size(); ++t)
    std::copy_n(scratch.laws[t].state, terms_[t].law->state_count(),
                scratch.state.begin() + terms_[t].first_state);
}

Eigen::Matrix3d MaterialPoint::elastic_hessian(const HomogeneousStrain& kinematics,
                                               const Eigen::Vector3d& q,
                                               const Eigen::VectorXd& parameters) const {
  Workspace scratch;
  scratch.state.assign(static_cast<std::size_t>(state_count_), 0.0);
  scratch.laws.resize(terms_.size());
  scratch.strains.resize(terms_.size());
  scratch.strain_by_q.resize(terms_.size());
  return evaluate(kinematics, q, parameters, 0.0, scratch).tangent;
}

PathStatus MaterialPoint::follow(const StrainPath& path, const Eigen::VectorXd& parameters,
                                 bool sensitivities, Workspace& scratch,
                                 PathResponse& response) const {
  const auto frames = static_cast<Eigen::Index>(path.q.size());
  scratch.state.assign(static_cast<std::size_t>(state_count_), 0.0);
  scratch.laws.resize(terms_.size());
  scratch.strains.resize(terms_.size());
  scratch.strain_by_q.resize(terms_.size());
  response.stress.resize(path.q.size());
  response.q.resize(path.q.size());
  scratch.state_by_p.resize(sensitivities ? state_count_ : 0, parameter_count_);
  if (sensitivities) {
    scratch.state_by_p.setZero();
    scratch.next_state_by_p.resize(state_count_, parameter_count_);
    response.stress_by_p.resize(3 * frames, parameter_count_);
    response.q_by_p.resize(3 * frames, parameter_count_);
  }
  const HomogeneousStrain kinematics(path.axis_angle_rad);
  const bool any_free = path.is_free[0] || path.is_free[1] || path.is_free[2];
  for (Eigen::Index frame = 0; frame < frames; ++frame) {
    const auto f = static_cast<std::size_t>(frame);
    const bool run_starts = frame == 0 || path.start[f] != FrameStart::next;
    if (frame > 0 && run_starts) begin_run(path.start[f], scratch);
    Eigen::Vector3d q = path.q[f];
    if (any_free && !run_starts)  // the solution of the frame before is the better guess
      for (int i = 0; i < 3; ++i)
        if (path.is_free[static_cast<std::size_t>(i)]) q[i] = response.q[f - 1][i];
    Balance balance;
    if (any_free) {
      if (!solve_free(kinematics, path.is_free, parameters, path.duration_s[f], scratch, q,
                      balance)) {
        q = path.q[f];  // once more from the path's own guess
        if (!solve_free(kinematics, path.is_free, parameters, path.duration_s[f], scratch, q,
                        balance))
          return PathStatus::no_equilibrium;
      }
    } else {
      balance = evaluate(kinematics, q, parameters, path.duration_s[f], scratch);
    }
    if (!balance.stress.allFinite()) return PathStatus::not_finite;
    response.q[f] = q;
    response.stress[f] = balance.stress;
    for (int i = 0; i < 3; ++i)
      if (path.is_free[static_cast<std::size_t>(i)]) response.stress[f][i] = 0.0;
    if (sensitivities) differentiate(path.is_free, balance, frame, scratch, response);
    advance_state(scratch);
  }
  return PathStatus::ok;
}

}  // namespace tenter::mechanics
