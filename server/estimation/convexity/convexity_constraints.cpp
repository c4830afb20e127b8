// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/convexity/convexity_constraints.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "common/model/catalogue.h"
#include "server/estimation/prediction.h"
#include "server/mechanics/law.h"
#include "server/mechanics/strain_measure.h"

namespace tenter::estimation {
namespace {

using mechanics::LawInput;
using mechanics::LawOutput;
using mechanics::StrainMeasure;
using mechanics::StrainValue;

bool is_linear_in_parameters(const std::string& law) {
  return law != "ogden" && law != "exponential_fibre";
}

bool is_everywhere(const model::Support& support) {
  return support.name == "everywhere";
}
bool acts_at(const model::Support& support, const model::Support& place) {
  return is_everywhere(support) || (support.field == place.field && support.sample == place.sample);
}

}  // namespace

struct ConvexityConstraints::Builder {
  struct Term {
    const model::Term* description = nullptr;
    const model::StrainRow* strain = nullptr;
    const model::LawRow* row = nullptr;
    std::shared_ptr<const mechanics::Law> law;  ///< null: has a memory
    std::optional<StrainMeasure> measure;       ///< of membranes
    int first = 0;
    double lo = 0.0, hi = 0.0;
  };

  const ConvexityOptions& options;
  Eigen::VectorXd values;
  std::vector<Term> terms;
  ConvexityConstraints& result;

  Expected<void> read(const model::Model& model) {
    int first = 0;
    for (const model::Term& description : model.terms) {
      Term term;
      term.description = &description;
      term.first = first;
      first += static_cast<int>(description.law.parameters.size());
      term.strain = model::find_strain(description.strain.name);
      term.row = model::find_law(description.law.name);
      if (term.strain == nullptr || term.row == nullptr)
        return bad_input("term \"" + description.id + "\": is not in the catalogue");
      if (!term.row->path_dependent) {
        auto law = mechanics::make_law(description.law, term.strain->strains);
        if (!law) return bad_input("term \"" + description.id + "\": " + law.error().message);
        term.law = *law;
      }
      if (term.strain->domain == model::Domain::membrane)
        if (auto measure = StrainMeasure::make(description.strain)) term.measure = *measure;
      set_range(model, term);
      terms.push_back(std::move(term));
    }
    return {};
  }

  void set_range(const model::Model& model, Term& term) const {
    const model::Law& law = term.description->law;
    const double per_curvature = term.strain->domain == model::Domain::hinge ? 1e3 : 1.0;
    term.lo = per_curvature * options.lo;
    term.hi = per_curvature * options.hi;
    if (term.row->spline)
      std::tie(term.lo, term.hi) = model::spline_range(law, term.strain->domain);
    for (const model::StrainRange& range : model.strain_ranges)
      if (range.term == term.description->id && range.hi > range.lo) {
        const bool has_points = term.row->spline && law.range_hi > law.range_lo;
        term.lo = has_points ? std::min(term.lo, range.lo) : range.lo;
        term.hi = has_points ? std::max(term.hi, range.hi) : range.hi;
      }
  }

  /// A little to either side of each.
  static std::vector<double> knots_of(const Term& term) {
    const model::Law& law = term.description->law;
    std::vector<double> ends;
    const auto [lo, hi] = model::spline_range(law, term.strain->domain);
    if (model::may_have_knots(law)) {
      ends = model::spline_knots(law, term.strain->domain);
    } else {
      const int intervals = term.law->parameter_count() - 1;
      for (int i = 0; i <= intervals; ++i) ends.push_back(lo + i * ((hi - lo) / intervals));
    }
    const double near = 1e-9 * (hi - lo) / static_cast<double>(ends.size() - 1);
    std::vector<double> knots;
    knots.reserve(2 * ends.size());
    for (const double end : ends)
      for (const double side : {-near, near}) knots.push_back(end + side);
    return knots;
  }

  std::vector<double> samples_of(const Term& term) const {
    std::vector<double> at;
    at.reserve(static_cast<std::size_t>(options.samples));
    for (int i = 0; i < options.samples; ++i)
      at.push_back(term.lo + (term.hi - term.lo) * i / std::max(options.samples - 1, 1));
    if (term.row->spline && !term.row->grid && term.law->parameter_count() > 1)
      for (const double knot : knots_of(term)) at.push_back(knot);
    return at;
  }

  /// The law's answer with one of its parameters at 1 and the others at 0, or at their values.
  static void evaluate(const Term& term, int unit, const Eigen::VectorXd& values,
                       const double* strain, LawOutput& out) {
    static constexpr double kNoState[mechanics::kMaxLawState] = {};
    double p[mechanics::kMaxLawParameters] = {};
    if (unit >= 0)
      p[unit] = 1.0;
    else
      for (int j = 0; j < term.law->parameter_count(); ++j) p[j] = values[term.first + j];
    term.law->clear(out);
    LawInput in;
    in.strain = strain;
    in.parameters = p;
    in.state = kNoState;
    term.law->evaluate(in, out);
  }

  void add_rows(int t) {
    const Term& term = terms[static_cast<std::size_t>(t)];
    LawOutput out{};
    for (const double eps : samples_of(term)) {
      Row row;
      row.term = t;
      row.strain = eps;
      row.by_p = Eigen::VectorXd::Zero(values.size());
      const double strain[mechanics::kMaxStrains] = {eps, 0.0, 0.0};
      for (int j = 0; j < term.law->parameter_count(); ++j) {
        evaluate(term, j, values, strain, out);
        row.by_p[term.first + j] = out.tangent[0][0];
      }
      result.rows_.push_back(std::move(row));
    }
  }

  /// The tensor c = (C_uu, C_vv, C_uv) nearest to rest with these two strains; false where there is
  /// none that a sheet can have.
  static bool find_tensor(const StrainMeasure& measure, const Eigen::Vector2d& wanted,
                          Eigen::Vector3d& c, StrainValue& value) {
    c << 1.0, 1.0, 0.0;
    for (int iteration = 0; iteration < 60; ++iteration) {
      measure.evaluate(c, value);
      const Eigen::Vector2d miss(wanted[0] - value.value[0], wanted[1] - value.value[1]);
      if (miss.norm() < 1e-13) return c[0] * c[1] - c[2] * c[2] > 1e-3;
      Eigen::Matrix<double, 2, 3> a;
      a << value.by_c[0].transpose(), value.by_c[1].transpose();
      c += a.transpose() * (a * a.transpose()).inverse() * miss;
      if (!c.allFinite()) return false;
    }
    return false;
  }

  // H_eps = T' H_c T - sum_i (g . t_i) T' B_i T, with T = A'(A A')^-1 the columns t_i, A = deps/dc,
  // B_i = d2eps_i/dc2: along the curve c(eps) that keeps to the strains, T' A' = 1.
  static Eigen::Vector3d in_strains(const StrainValue& domain, const Eigen::Vector3d& g,
                                    const Eigen::Matrix3d& h) {
    Eigen::Matrix<double, 2, 3> a;
    a << domain.by_c[0].transpose(), domain.by_c[1].transpose();
    const Eigen::Matrix<double, 3, 2> t = a.transpose() * (a * a.transpose()).inverse();
    Eigen::Matrix2d s = t.transpose() * h * t;
    for (int i = 0; i < 2; ++i) s -= g.dot(t.col(i)) * (t.transpose() * domain.by_cc[i] * t);
    return {s(0, 0), 0.5 * (s(0, 1) + s(1, 0)), s(1, 1)};
  }

  static void add_by_c(const StrainValue& strain, int count, const LawOutput& law,
                       Eigen::Vector3d& g, Eigen::Matrix3d& h) {
    for (int i = 0; i < count; ++i) {
      g += law.stress[i] * strain.by_c[i];
      h += law.stress[i] * strain.by_cc[i];
      for (int j = 0; j < count; ++j)
        h += law.tangent[i][j] * strain.by_c[i] * strain.by_c[j].transpose();
    }
    mechanics::add_near_pairs(strain.near, strain.near_count, strain.value, law.stress, law.tangent,
                              h);
  }

  /// Where the full energy of an addend is looked at: weights of samples sum to one, so an energy
  /// that is convex at each sample, with what acts everywhere, is convex between them.
  std::vector<model::Support> places_of(const Term& term) const {
    if (!is_everywhere(term.description->support)) return {term.description->support};
    std::vector<model::Support> places;
    for (const Term& other : terms) {
      const model::Support& support = other.description->support;
      if (!other.measure || is_everywhere(support)) continue;
      if (std::none_of(places.begin(), places.end(),
                       [&](const model::Support& place) { return acts_at(support, place); }))
        places.push_back(support);
    }
    if (places.empty()) places.emplace_back();
    return places;
  }

  void add_matrices(int t) {
    for (const model::Support& place : places_of(terms[static_cast<std::size_t>(t)]))
      add_matrices_at(t, place);
  }

  /// Along each of two strains: even samples, and both sides of the knots at which tangents jump.
  std::vector<double> samples_of_two(const Term& term) const {
    std::vector<double> at;
    const int n = options.samples_of_two;
    at.reserve(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) at.push_back(term.lo + (term.hi - term.lo) * i / (n - 1));
    for (const Term& other : terms)
      if (other.measure && other.row->name == "hermite_energy")
        for (const double knot : knots_of(other))
          if (knot > term.lo && knot < term.hi) at.push_back(knot);
    std::sort(at.begin(), at.end());
    at.erase(std::unique(at.begin(), at.end()), at.end());
    return at;
  }

  void add_matrices_at(int t, const model::Support& place) {
    const Term& term = terms[static_cast<std::size_t>(t)];
    const std::vector<double> along = samples_of_two(term);
    StrainValue domain, strain;
    LawOutput out{};
    for (std::size_t s = 0; s < along.size() * along.size(); ++s) {
      const Eigen::Vector2d wanted(along[s % along.size()], along[s / along.size()]);
      Eigen::Vector3d c;
      if (!find_tensor(*term.measure, wanted, c, domain)) continue;
      Matrix matrix;
      matrix.term = t;
      matrix.strain = {wanted[0], wanted[1]};
      matrix.by_p = Eigen::Matrix3Xd::Zero(3, values.size());
      for (const Term& other : terms) {
        if (!other.law || !other.measure || !acts_at(other.description->support, place)) continue;
        other.measure->evaluate(c, strain);
        const bool is_linear = is_linear_in_parameters(other.row->name.data());
        for (int j = is_linear ? 0 : -1; j < (is_linear ? other.law->parameter_count() : 0); ++j) {
          evaluate(other, j, values, strain.value, out);
          Eigen::Vector3d g = Eigen::Vector3d::Zero();
          Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
          add_by_c(strain, other.measure->count(), out, g, h);
          const Eigen::Vector3d two = in_strains(domain, g, h);
          if (j < 0)
            matrix.constant += two;
          else
            matrix.by_p.col(other.first + j) += two;
        }
      }
      result.matrices_.push_back(std::move(matrix));
    }
  }

  void add_bounds(const std::vector<const model::Parameter*>& parameters) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      if (parameters[i]->fixed) continue;
      const auto k = static_cast<Eigen::Index>(i);
      Row row;
      row.by_p = Eigen::VectorXd::Zero(values.size());
      if (parameters[i]->lower) {
        row.by_p[k] = 1.0;
        row.least = *parameters[i]->lower;
        result.rows_.push_back(row);
      }
      if (parameters[i]->upper) {
        row.by_p[k] = -1.0;
        row.least = -*parameters[i]->upper;
        result.rows_.push_back(row);
      }
    }
  }
};

Expected<ConvexityConstraints> ConvexityConstraints::make(const model::Model& model,
                                                          const ConvexityOptions& options) {
  if (options.samples < 2 || options.samples_of_two < 2)
    return bad_input("convexity is looked at on at least two samples of a strain");
  ConvexityConstraints result;
  const auto parameters = parameters_of(model);
  result.is_fixed_.reserve(parameters.size());
  for (const model::Parameter* p : parameters) result.is_fixed_.push_back(p->fixed);
  result.term_count_ = static_cast<int>(model.terms.size());
  for (int t = 0; t < result.term_count_; ++t)
    result.term_of_.insert(result.term_of_.end(),
                           model.terms[static_cast<std::size_t>(t)].law.parameters.size(), t);
  result.term_of_.resize(parameters.size(), -1);
  Builder builder{options, parameter_values(model), {}, result};
  if (auto read = builder.read(model); !read) return tl::unexpected(read.error());
  for (int t = 0; t < result.term_count_; ++t) {
    const Builder::Term& term = builder.terms[static_cast<std::size_t>(t)];
    if (!term.law || !is_linear_in_parameters(term.row->name.data())) continue;
    const bool couples = term.row->strains == 2;
    if (!couples)
      builder.add_rows(t);
    else if (term.measure)
      builder.add_matrices(t);
  }
  builder.add_bounds(parameters);
  return result;
}

}  // namespace tenter::estimation
