// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/convexity.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>

#include "common/model/catalogue.h"
#include "server/mechanics/solid_strain.h"
#include "server/mechanics/strain_measure.h"

namespace tenter::mechanics {
namespace {

void take(const Eigen::MatrixXd& hessian, int sample, Convexity& result, bool& is_worst) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(hessian, Eigen::EigenvaluesOnly);
  const Eigen::VectorXd& values = eigen.eigenvalues();
  is_worst = values[0] < result.smallest;
  result.largest = std::max(result.largest, values.cwiseAbs().maxCoeff());
  if (!is_worst) return;
  result.smallest = values[0];
  result.sample = sample;
}

/// Gradient and Hessian of the energy by z.
struct ByZ {
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};

struct Term {
  std::shared_ptr<const Law> law;
  const double* parameters;
  StrainMeasure membrane;
  SolidStrain solid;
};

template <int N, class Value, class Measure>
void add_term(const Term& term, const Measure& measure, const Eigen::Matrix<double, N, 1>& z,
              const Eigen::Matrix<double, N, 1>* by_z, const Eigen::Matrix<double, N, N>* by_zz,
              Value& strain, ByZ& sum) {
  measure.evaluate(z, strain);
  LawOutput law{};
  LawInput in;
  in.strain = strain.value;
  in.parameters = term.parameters;
  term.law->evaluate(in, law);
  Eigen::Matrix<double, N, N> hessian = Eigen::Matrix<double, N, N>::Zero();
  for (int i = 0; i < measure.count(); ++i) {
    sum.gradient += law.stress[i] * by_z[i];
    hessian += law.stress[i] * by_zz[i];
    for (int j = 0; j < measure.count(); ++j)
      hessian += law.tangent[i][j] * by_z[i] * by_z[j].transpose();
  }
  add_near_pairs(strain.near, strain.near_count, strain.value, law.stress, law.tangent, hessian);
  sum.hessian += hessian;
}

/// The entries (a, b) of C that make up z.
using Entry = std::pair<int, int>;
constexpr Entry kMembraneEntries[] = {{0, 0}, {1, 1}, {0, 1}};
constexpr Entry kSolidEntries[] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};

// C_ab = sum_r F_ra F_rb: dC_ab/dF_rc = delta_ca F_rb + delta_cb F_ra, and the second derivative by
// F_rc and F_rd is delta_ca delta_db + delta_cb delta_da, the same for each row r.
Eigen::MatrixXd hessian_by_f(const ByZ& by_z, const Eigen::MatrixXd& f, const Entry* entries) {
  const Eigen::Index rows = f.rows();
  const Eigen::Index columns = f.cols();
  const Eigen::Index n = by_z.gradient.size();
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(n, rows * columns);
  Eigen::MatrixXd geometric = Eigen::MatrixXd::Zero(columns, columns);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto [a, b] = entries[k];
    for (Eigen::Index r = 0; r < rows; ++r) {
      g(k, a * rows + r) += f(r, b);
      g(k, b * rows + r) += f(r, a);
    }
    geometric(a, b) += by_z.gradient[k];
    geometric(b, a) += by_z.gradient[k];
  }
  Eigen::MatrixXd hessian = g.transpose() * by_z.hessian * g;
  for (Eigen::Index c = 0; c < columns; ++c)
    for (Eigen::Index d = 0; d < columns; ++d)
      for (Eigen::Index r = 0; r < rows; ++r)
        hessian(c * rows + r, d * rows + r) += geometric(c, d);
  return hessian;
}

Expected<std::vector<Term>> terms_of(const model::Model& model, Body body,
                                     const std::vector<double>& parameters, int only) {
  std::vector<Term> terms;
  std::size_t first = 0;
  for (std::size_t t = 0; t < model.terms.size(); ++t) {
    const model::Term& description = model.terms[t];
    const std::size_t begin = first;
    first += description.law.parameters.size();
    if (first > parameters.size())
      return bad_input("the model has more than " + std::to_string(parameters.size()) +
                       " parameters");
    if (only >= 0 && static_cast<int>(t) != only) continue;
    const std::string name = "term \"" + description.id + "\": ";
    const model::StrainRow* strain = model::find_strain(description.strain.name);
    const model::LawRow* law = model::find_law(description.law.name);
    if (strain == nullptr || law == nullptr) return bad_input(name + "is not in the catalogue");
    if (law->path_dependent) continue;
    const bool is_solid = strain->domain == model::Domain::solid;
    if (!is_solid && !strain->at_point) continue;
    if (is_solid != (body == Body::solid))
      return bad_input(name + "\"" + description.strain.name + "\" does not live on this body");
    Term term;
    if (is_solid) {
      auto measure = SolidStrain::make(description.strain);
      if (!measure) return bad_input(name + measure.error().message);
      term.solid = *measure;
    } else {
      auto measure = StrainMeasure::make(description.strain);
      if (!measure) return bad_input(name + measure.error().message);
      term.membrane = *measure;
    }
    auto made = make_law(description.law, strain->strains);
    if (!made) return bad_input(name + made.error().message);
    term.law = *made;
    term.parameters = parameters.data() + begin;
    terms.push_back(std::move(term));
  }
  return terms;
}

}  // namespace

Convexity law_convexity(const Law& law, const double* parameters, double lo, double hi,
                        int samples) {
  Convexity result;
  const int strains = law.strain_count();
  const double no_state[kMaxLawState] = {};
  int count = 1;
  for (int i = 0; i < strains; ++i) count *= samples;
  LawOutput out{};
  Eigen::MatrixXd hessian(strains, strains);
  for (int s = 0; s < count; ++s) {
    double strain[kMaxStrains] = {};
    for (int i = 0, rest = s; i < strains; ++i, rest /= samples)
      strain[i] = lo + (hi - lo) * (rest % samples) / std::max(samples - 1, 1);
    law.clear(out);
    law.evaluate({strain, parameters, no_state, 0.0}, out);
    for (int i = 0; i < strains; ++i)
      for (int j = 0; j < strains; ++j) hessian(i, j) = out.tangent[i][j];
    bool is_worst = false;
    take(hessian, s, result, is_worst);
    if (is_worst) std::copy_n(strain, kMaxStrains, result.strain);
  }
  return result;
}

Expected<Convexity> model_convexity(const model::Model& model, Body body,
                                    const std::vector<double>& parameters,
                                    const std::vector<Eigen::MatrixXd>& deformations, int term,
                                    bool in_plane) {
  const auto terms = terms_of(model, body, parameters, term);
  if (!terms) return tl::unexpected(terms.error());
  const int dimensions = body == Body::solid ? 3 : 2;
  const int n = body == Body::solid ? 6 : 3;
  const Entry* entries = body == Body::solid ? kSolidEntries : kMembraneEntries;
  Convexity result;
  StrainValue membrane;
  SolidStrainValue solid;
  for (std::size_t s = 0; s < deformations.size(); ++s) {
    Eigen::MatrixXd f = deformations[s];
    if (f.rows() != dimensions || f.cols() != dimensions || !f.allFinite())
      return bad_input("deformation " + std::to_string(s) + " is not a finite " +
                       std::to_string(dimensions) + " x " + std::to_string(dimensions) + " matrix");
    ByZ sum{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
    const Eigen::MatrixXd c = f.transpose() * f;
    Eigen::VectorXd z(n);
    for (int k = 0; k < n; ++k) z[k] = c(entries[k].first, entries[k].second);
    for (const Term& t : *terms) {
      if (body == Body::solid)
        add_term<6>(t, t.solid, Vector6d(z), solid.by_z, solid.by_zz, solid, sum);
      else
        add_term<3>(t, t.membrane, Eigen::Vector3d(z), membrane.by_c, membrane.by_cc, membrane,
                    sum);
    }
    if (body == Body::membrane && !in_plane) {  // a third row of zeros: out of the plane
      f.conservativeResize(3, 2);
      f.row(2).setZero();
    }
    bool is_worst = false;
    take(hessian_by_f(sum, f, entries), static_cast<int>(s), result, is_worst);
  }
  return result;
}

}  // namespace tenter::mechanics
