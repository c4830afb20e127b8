// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/screen.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "server/diagnosis/null_twins.h"

namespace tenter::diagnosis {
namespace {

using estimation::RowMatrix;

/// Where the columns of one candidate stand in the Jacobian of the model that holds them all.
struct Columns {
  const Effect* effect = nullptr;
  const Variant* variant = nullptr;
  Setting setting;
  std::vector<int> columns;
  std::vector<std::string> addresses;  ///< "term.parameter" of each column in the extended model
  std::vector<bool> one_sided;
  std::vector<double> off;  ///< value of each parameter when the effect is off
};

/// Gathers the terms of all candidates into one model, each distinct term once.
class Gathering {
 public:
  explicit Gathering(const model::Model& base) : model_(base) {
    const auto names = estimation::parameter_names(base);
    for (std::size_t i = 0; i < names.size(); ++i) base_index_[names[i]] = static_cast<int>(i);
    term_parameters_ = 0;
    for (const model::Term& t : base.terms)
      term_parameters_ += static_cast<int>(t.law.parameters.size());
  }

  void add(const Effect& effect, const Variant& variant, const Setting& setting) {
    Columns entry;
    entry.effect = &effect;
    entry.variant = &variant;
    entry.setting = setting;
    for (const model::Term& term : variant.append) add_term(term, setting, entry);
    for (const auto& [id, law] : variant.replace) {
      for (const model::Term& existing : model_.terms) {
        if (existing.id != id) continue;
        model::Term term = existing;
        term.law = law;
        const std::size_t first = entry.columns.size();
        // linear in its parameters: at zero it has the same columns as in the place of the law that
        // it replaces
        for (model::Parameter& p : term.law.parameters) p.value = 0.0;
        add_term(term, setting, entry);
        for (std::size_t k = first; k < entry.off.size(); ++k)
          entry.off[k] = law.parameters[k - first].value;
        break;
      }
    }
    for (const std::string& address : variant.unfix) {
      entry.columns.push_back(-1 - base_index_.at(address));
      entry.addresses.push_back(address);
      entry.one_sided.push_back(true);
      entry.off.push_back(0.0);
    }
    for (model::SensorCorrection correction : variant.corrections) {
      const std::string id = correction.id;
      apply(setting, id, correction.parameters);
      for (std::size_t k = 0; k < correction.parameters.size(); ++k) {
        const model::Parameter& p = correction.parameters[k];
        const std::string address = id + "." + p.name;
        if (p.fixed || is_set(setting, address)) continue;
        entry.columns.push_back(correction_parameters_ + static_cast<int>(k) + kCorrectionBase);
        entry.addresses.push_back(address);
        entry.one_sided.push_back(p.lower && *p.lower == p.value);
        entry.off.push_back(p.value);
      }
      correction_parameters_ += static_cast<int>(correction.parameters.size());
      added_corrections_.push_back(std::move(correction));
    }
    entries_.push_back(std::move(entry));
  }

  const std::vector<Columns>& entries() const { return entries_; }

  model::Model model() const {
    model::Model all = model_;
    for (const model::Term& t : added_terms_) all.terms.push_back(t);
    for (const model::SensorCorrection& c : added_corrections_) all.corrections.push_back(c);
    return all;
  }

  /// Column of the gathered model's Jacobian for an entry of Columns::columns.
  int place(int code) const {
    const int base_corrections = static_cast<int>(base_index_.size()) - term_parameters_;
    if (code < 0) {
      const int base = -1 - code;
      return base < term_parameters_ ? base : base + added_term_parameters_;
    }
    if (code >= kCorrectionBase)
      return term_parameters_ + added_term_parameters_ + base_corrections + code - kCorrectionBase;
    return term_parameters_ + code;
  }

 private:
  static constexpr int kCorrectionBase = 1 << 20;

  static bool is_set(const Setting& setting, const std::string& address) {
    return std::any_of(setting.begin(), setting.end(),
                       [&](const auto& s) { return s.first == address; });
  }

  static void apply(const Setting& setting, const std::string& id,
                    std::vector<model::Parameter>& parameters) {
    for (const auto& [address, value] : setting)
      for (model::Parameter& p : parameters)
        if (address == id + "." + p.name) p.value = value;
  }

  void add_term(model::Term term, const Setting& setting, Columns& entry) {
    const std::string id = term.id;
    apply(setting, id, term.law.parameters);
    std::string key =
        term.strain.name + "@" + std::to_string(term.strain.angle_rad) + "/" + term.law.name;
    for (const model::Parameter& p : term.law.parameters) key += "," + std::to_string(p.value);
    auto [found, is_new] = known_.emplace(key, added_term_parameters_);
    if (is_new) {
      added_term_parameters_ += static_cast<int>(term.law.parameters.size());
      added_terms_.push_back(term);
    }
    for (std::size_t k = 0; k < term.law.parameters.size(); ++k) {
      const model::Parameter& p = term.law.parameters[k];
      const std::string address = id + "." + p.name;
      if (p.fixed || is_set(setting, address)) continue;
      entry.columns.push_back(found->second + static_cast<int>(k));
      entry.addresses.push_back(address);
      entry.one_sided.push_back(p.lower && *p.lower == 0.0);
      entry.off.push_back(p.value);
    }
  }

  model::Model model_;
  std::map<std::string, int> base_index_;
  std::map<std::string, int> known_;
  std::vector<model::Term> added_terms_;
  std::vector<model::SensorCorrection> added_corrections_;
  std::vector<Columns> entries_;
  int term_parameters_ = 0;
  int added_term_parameters_ = 0;
  int correction_parameters_ = 0;
};

/// Orthonormal basis of the columns of J that carry anything.
Eigen::MatrixXd range_basis(const Eigen::MatrixXd& j) {
  if (j.cols() == 0) return Eigen::MatrixXd(j.rows(), 0);
  Eigen::MatrixXd scaled = j;
  for (Eigen::Index c = 0; c < j.cols(); ++c) {
    const double norm = j.col(c).norm();
    if (norm > 0.0) scaled.col(c) /= norm;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-9);
  return qr.householderQ() * Eigen::MatrixXd::Identity(j.rows(), qr.rank());
}

double percentile(std::vector<double> values, double share) {
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

/// The space that a candidate adds to the model's own, and what it makes of the residuals.
struct Projected {
  Eigen::MatrixXd basis;       ///< rows x df, orthonormal, orthogonal to J
  Eigen::VectorXd amplitudes;  ///< least-squares values of the candidate's columns
  bool positive =
      false;  ///< one column whose amplitude must not be negative; the basis points to more of it
};

Projected project(const Columns& entry, const Gathering& gathering, const RowMatrix& jacobian,
                  const Eigen::MatrixXd& own, const Eigen::VectorXd& residuals) {
  constexpr double kHidden = 1e-4;  // share of a column that must be new for it to count
  const auto count = static_cast<Eigen::Index>(entry.columns.size());
  Eigen::MatrixXd z(jacobian.rows(), count);
  Eigen::VectorXd norms(count);
  for (Eigen::Index c = 0; c < count; ++c) {
    z.col(c) = jacobian.col(gathering.place(entry.columns[static_cast<std::size_t>(c)]));
    norms[c] = z.col(c).norm();
    if (norms[c] > 0.0) z.col(c) /= norms[c];
  }
  z -= own * (own.transpose() * z);
  Projected result;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(z);
  qr.setThreshold(1e-6);
  Eigen::Index rank = 0;
  for (Eigen::Index k = 0; k < std::min(z.rows(), count); ++k)
    if (std::abs(qr.matrixR()(k, k)) > kHidden) ++rank;
  result.basis = qr.householderQ() * Eigen::MatrixXd::Identity(z.rows(), rank);
  result.amplitudes = Eigen::VectorXd::Zero(count);
  if (rank > 0) {
    const Eigen::VectorXd y = -(result.basis.transpose() * residuals);
    const Eigen::VectorXd x =
        qr.matrixR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>().solve(y);
    for (Eigen::Index k = 0; k < rank; ++k) {
      const Eigen::Index c = qr.colsPermutation().indices()[k];
      result.amplitudes[c] = x[k] / norms[c];
    }
    if (count == 1 && entry.one_sided[0]) {
      result.positive = true;
      if (result.basis.col(0).dot(z.col(0)) < 0.0) result.basis.col(0) *= -1.0;
    }
  }
  return result;
}

double statistic(const Eigen::VectorXd& components, bool positive) {
  if (positive)
    return components[0] < 0.0 ? components.squaredNorm() : 0.0;  // less residual, not more
  return components.squaredNorm();
}

/// What all candidates of one screen share.
struct Ground {
  const model::Model* fitted = nullptr;
  DataPointer data;
  Eigen::MatrixXd own;    ///< orthonormal basis of the model's own columns
  Eigen::MatrixXd twins;  ///< null twins, without what the model absorbs
  Eigen::VectorXd left;   ///< residuals, likewise
};

/// Grids can be long, and a candidate is one point of them.
Variant without_grids(const Variant& variant) {
  Variant copy;
  copy.words = variant.words;
  copy.append = variant.append;
  copy.replace = variant.replace;
  copy.unfix = variant.unfix;
  copy.corrections = variant.corrections;
  copy.searched = variant.searched;
  return copy;
}

/// Points of the finer grid between the neighbours of the coarse point that was liked best.
std::vector<Setting> around(const Variant& variant, const Setting& best) {
  std::vector<Setting> near;
  for (const Setting& setting : variant.finer) {
    bool inside = true;
    for (const auto& [address, value] : best) {
      double lower = -1e300;
      double upper = 1e300;
      for (const Setting& coarse : variant.grid)
        for (const auto& [other, at] : coarse) {
          if (other != address) continue;
          if (at < value) lower = std::max(lower, at);
          if (at > value) upper = std::min(upper, at);
        }
      for (const auto& [other, at] : setting)
        if (other == address && (at < lower || at > upper)) inside = false;
    }
    if (inside) near.push_back(setting);
  }
  return near;
}

/// Projects every entry and adds it to the candidates; `largest`, where given, collects each twin's
/// largest u.
bool add_candidates(const Gathering& gathering, const Ground& ground, std::vector<double>* largest,
                    std::vector<Candidate>& candidates) {
  const model::Model all = gathering.model();
  auto evaluator = estimation::Evaluator::make(all, ground.data);
  if (!evaluator) return false;
  Eigen::VectorXd residuals;
  RowMatrix jacobian;
  if (evaluator->evaluate(estimation::parameter_values(all), residuals, &jacobian) !=
      mechanics::PathStatus::ok)
    return false;
  const auto count = static_cast<std::size_t>(ground.twins.cols());
  for (const Columns& entry : gathering.entries()) {
    const Projected p = project(entry, gathering, jacobian, ground.own, ground.left);
    if (p.basis.cols() == 0) continue;
    const Eigen::VectorXd components = p.basis.transpose() * ground.left;
    const Eigen::MatrixXd twin_components = p.basis.transpose() * ground.twins;
    std::vector<double> null(count);
    for (std::size_t k = 0; k < count; ++k)
      null[k] = statistic(twin_components.col(static_cast<Eigen::Index>(k)), p.positive);
    const double scale = std::max(percentile(null, 0.95), 1e-9);
    if (largest)
      for (std::size_t k = 0; k < count; ++k)
        (*largest)[k] = std::max((*largest)[k], null[k] / scale);
    Candidate candidate;
    candidate.effect = entry.effect;
    candidate.variant = without_grids(*entry.variant);
    candidate.source = entry.variant;
    candidate.point = entry.setting;
    candidate.setting = entry.setting;
    candidate.gain = statistic(components, p.positive);
    candidate.df = static_cast<int>(p.basis.cols());
    candidate.ratio = candidate.gain / scale;
    candidate.direction = p.basis * components;
    for (std::size_t c = 0; c < entry.addresses.size(); ++c) {
      double amplitude = entry.off[c] + p.amplitudes[static_cast<Eigen::Index>(c)];
      if (entry.one_sided[c]) amplitude = std::max(amplitude, 0.0);
      candidate.setting.emplace_back(entry.addresses[c], amplitude);
    }
    candidates.push_back(std::move(candidate));
  }
  return true;
}

/// The model's own space and the null twins.
Ground make_ground(const model::Model& fitted, const estimation::FitResult& fit,
                   const DataPointer& data, const estimation::Noise& noise,
                   const ScreenOptions& options, Screen& result) {
  Ground ground;
  ground.fitted = &fitted;
  ground.data = data;
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < fit.states.size(); ++i)
    if (fit.states[i] == estimation::ParameterState::free ||
        fit.states[i] == estimation::ParameterState::flat)
      free.push_back(static_cast<Eigen::Index>(i));
  Eigen::MatrixXd own_columns(fit.residuals.size(), static_cast<Eigen::Index>(free.size()));
  for (std::size_t c = 0; c < free.size(); ++c)
    own_columns.col(static_cast<Eigen::Index>(c)) = fit.jacobian.col(free[c]);
  ground.own = range_basis(own_columns);
  ground.twins = null_twins(data->rows(), noise, options.null_twins, options.seed);
  ground.twins -= ground.own * (ground.own.transpose() * ground.twins);
  ground.left = fit.residuals - ground.own * (ground.own.transpose() * fit.residuals);
  std::vector<double> twin_chi2;
  for (Eigen::Index k = 0; k < ground.twins.cols(); ++k)
    twin_chi2.push_back(ground.twins.col(k).squaredNorm());
  for (const double c : twin_chi2)
    result.expected_chi2 += c / static_cast<double>(twin_chi2.size());
  result.lack_of_fit = ground.left.squaredNorm() / percentile(twin_chi2, 0.95);
  return ground;
}

}  // namespace

Screen screen(const model::Model& fitted, const estimation::FitResult& fit, const DataPointer& data,
              const estimation::Noise& noise, const Excitation& excitation,
              const ScreenOptions& options) {
  Screen result;
  const Ground ground = make_ground(fitted, fit, data, noise, options, result);
  Gathering gathering(fitted);
  std::vector<std::vector<Variant>> variants;  // kept alive: the entries point into it
  variants.reserve(catalogue().size());
  std::map<const Effect*, ScreenRow> table;
  for (const Effect& effect : catalogue()) {
    ScreenRow row;
    row.effect = &effect;
    variants.emplace_back();
    if (const auto why = effect.not_excited(fitted, excitation)) {
      row.status = "not excited: " + *why;
    } else {
      variants.back() = effect.variants(fitted, excitation);
      row.status = variants.back().empty() ? "in the model" : "hides in the model's own parameters";
    }
    for (const Variant& variant : variants.back()) {
      if (variant.grid.empty()) gathering.add(effect, variant, {});
      for (const Setting& setting : variant.grid) gathering.add(effect, variant, setting);
    }
    table[&effect] = row;
  }
  std::vector<double> largest(static_cast<std::size_t>(options.null_twins), 0.0);
  if (!add_candidates(gathering, ground, &largest, result.candidates)) return result;
  const auto by_ratio = [](const Candidate& a, const Candidate& b) { return a.ratio > b.ratio; };
  std::stable_sort(result.candidates.begin(), result.candidates.end(), by_ratio);

  // a finer look at the two likeliest variants of each effect that has one
  Gathering fine(fitted);
  std::map<const Effect*, std::set<std::string>> looked_at;
  for (const Candidate& c : result.candidates) {
    if (c.source->finer.empty() || looked_at[c.effect].size() >= 2) continue;
    if (!looked_at[c.effect].insert(c.variant.words).second) continue;
    for (const Setting& setting : around(*c.source, c.point))
      fine.add(*c.effect, *c.source, setting);
  }
  if (!fine.entries().empty()) add_candidates(fine, ground, &largest, result.candidates);

  const double threshold = percentile(largest, 0.95);
  for (Candidate& c : result.candidates) {
    c.ratio /= threshold;
    c.source = nullptr;
    ScreenRow& row = table[c.effect];
    if (row.status == "screened" && row.gain / std::max(1, row.df) >= c.gain / c.df) continue;
    row.status = "screened";
    row.gain = c.gain;
    row.df = c.df;
    row.ratio = c.ratio;
    row.grid = c.setting;
  }
  std::stable_sort(result.candidates.begin(), result.candidates.end(), by_ratio);
  for (const Effect& effect : catalogue()) result.table.push_back(table[&effect]);
  std::stable_sort(result.table.begin(), result.table.end(),
                   [](const ScreenRow& a, const ScreenRow& b) { return a.ratio > b.ratio; });
  return result;
}

}  // namespace tenter::diagnosis
