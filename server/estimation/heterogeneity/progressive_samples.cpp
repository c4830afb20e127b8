// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/heterogeneity/progressive_samples.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace tenter::estimation {
namespace {

/// Squares of rows as the cost counts them.
Eigen::VectorXd squares(const ResidualFunction& function, const Eigen::VectorXd& residuals) {
  const Eigen::VectorXd weights = function.weights();
  Eigen::VectorXd result = residuals.cwiseAbs2();
  if (weights.size() > 0) result.array() *= weights.array();
  return result;
}

class Search {
 public:
  Search(const model::Model& base, model::Model expanded, const MaterialSamples& samples,
         ResidualFunction& training, ResidualFunction& held_out, const SampleOptions& options)
      : base_(base),
        expanded_(std::move(expanded)),
        samples_(samples),
        training_(training),
        held_out_(held_out),
        options_(options) {}

  Expected<SampledFit> run() {
    auto at = fit_with({}, expanded_);
    if (!at) return tl::unexpected(at.error());
    SampledFit result;
    result.homogeneous_training = at->training.sum();
    const Unseen homogeneous = at->held_out;
    std::vector<int> refused;
    while (static_cast<int>(result.released.size()) < options_.most &&
           static_cast<int>(refused.size()) < options_.tries) {
      SampleStep step = most_wanted(*at, result.released, refused);
      if (step.sample < 0) break;
      std::vector<int> more = result.released;
      more.push_back(step.sample);
      auto next = fit_with(more, at->model);
      step.kept = next && judge(*at, *next, step);
      result.steps.push_back(step);
      if (!step.kept) {
        refused.push_back(step.sample);
        continue;
      }
      refused.clear();
      result.released = std::move(more);
      at = std::move(next);
    }
    result.training = at->training.sum();
    const Eigen::VectorXd counts = both_meaningful(homogeneous, at->held_out);
    result.homogeneous_held_out = counts.dot(homogeneous.squares);
    result.held_out = counts.dot(at->held_out.squares);
    result.model = at->model;
    result.fit = at->fit;
    return result;
  }

 private:
  /// Rows of the held-out data.
  struct Unseen {
    Eigen::VectorXd squares;
    std::vector<bool> is_meaningful;
  };
  struct Fitted {
    model::Model model;
    FitResult fit;
    RowMatrix by_free;          ///< rows x free numbers, whitened and weighted
    RowMatrix by_all;           ///< rows x all parameters
    Eigen::VectorXd residuals;  ///< the same
    Eigen::VectorXd training;   ///< squares of rows
    Unseen held_out;
  };

  Expected<Fitted> fit_with(const std::vector<int>& released, const model::Model& start) {
    const auto ties = background_ties(start, base_, samples_, released);
    if (!ties) return tl::unexpected(ties.error());
    Fitted result;
    result.model = start;
    result.fit = fit_tied(training_, *ties, options_.fit);
    if (!result.fit.usable) return bad_input(result.fit.message);
    store(result.fit, result.model);
    result.residuals = result.fit.residuals;
    result.training = squares(training_, result.residuals);
    result.by_all = result.fit.jacobian;
    if (const Eigen::VectorXd roots = training_.weights().cwiseSqrt(); roots.size() > 0) {
      result.residuals.array() *= roots.array();
      result.by_all.array().colwise() *= roots.array();
    }
    result.by_free = result.by_all * ties->map;
    for (std::size_t q = 0; q < ties->free.size(); ++q)
      if (ties->free[q].fixed) result.by_free.col(static_cast<Eigen::Index>(q)).setZero();
    Eigen::VectorXd unseen;
    if (held_out_.evaluate(result.fit.parameters, unseen, nullptr) != mechanics::PathStatus::ok)
      return bad_input("the fitted model has no equilibrium on the held-out data");
    result.held_out.squares = squares(held_out_, unseen);
    result.held_out.is_meaningful =
        options_.meaningful ? options_.meaningful(held_out_)
                            : std::vector<bool>(static_cast<std::size_t>(unseen.size()), true);
    return result;
  }

  SampleStep most_wanted(const Fitted& at, const std::vector<int>& released,
                         const std::vector<int>& refused) const {
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> free(at.by_free);
    const Eigen::Index rank = free.rank();
    const Eigen::MatrixXd q =
        free.householderQ() * Eigen::MatrixXd::Identity(at.by_free.rows(), rank);
    const auto without = [&](const Eigen::MatrixXd& columns) -> Eigen::MatrixXd {
      return columns - q * (q.transpose() * columns);
    };
    const Eigen::VectorXd r = without(at.residuals);
    SampleStep best;
    for (int k = 0; k < samples_.field.sample_count(); ++k) {
      if (std::find(released.begin(), released.end(), k) != released.end()) continue;
      if (std::find(refused.begin(), refused.end(), k) != refused.end()) continue;
      const std::vector<int> own = parameters_of_sample(at.model, k);
      if (own.empty()) continue;
      const Eigen::MatrixXd columns = without(at.by_all(Eigen::indexing::all, own));
      const double gain = (columns * columns.colPivHouseholderQr().solve(r)).squaredNorm();
      if (gain > best.gain) {
        best.sample = k;
        best.gain = gain;
      }
    }
    return best;
  }

  /// One for rows that are meaningful in both, else zero.
  static Eigen::VectorXd both_meaningful(const Unseen& a, const Unseen& b) {
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(a.squares.size());
    for (Eigen::Index i = 0; i < counts.size(); ++i) {
      const auto row = static_cast<std::size_t>(i);
      counts[i] = a.is_meaningful[row] && b.is_meaningful[row] ? 1.0 : 0.0;
    }
    return counts;
  }

  // the fall of each row is one draw of what a sample is worth on data not seen
  bool judge(const Fitted& before, const Fitted& after, SampleStep& step) const {
    step.training = after.training.sum();
    const Eigen::VectorXd counts = both_meaningful(before.held_out, after.held_out);
    step.rows_left_out = static_cast<int>(counts.size() - static_cast<Eigen::Index>(counts.sum()));
    step.held_out_before = counts.dot(before.held_out.squares);
    step.held_out = counts.dot(after.held_out.squares);
    const Eigen::VectorXd fall =
        counts.cwiseProduct(before.held_out.squares - after.held_out.squares);
    const double scatter = fall.norm();
    step.sigmas = scatter > 0.0 ? fall.sum() / scatter : 0.0;
    return fall.sum() > options_.least_fall * step.held_out_before &&
           step.sigmas > options_.least_sigmas;
  }

  const model::Model& base_;
  model::Model expanded_;
  const MaterialSamples& samples_;
  ResidualFunction& training_;
  ResidualFunction& held_out_;
  const SampleOptions& options_;
};

/// The base with the numbers that all samples share.
model::Model homogeneous(const model::Model& base, const model::Model& expanded) {
  model::Model result = base;
  for (model::Term& term : result.terms)
    for (const model::Term& other : expanded.terms)
      if (other.id == term.id || other.id == term.id + "_1") {
        term.law.parameters = other.law.parameters;
        break;
      }
  return result;
}

}  // namespace

Expected<SampledFit> add_samples(const model::Model& base, const MaterialSamples& samples,
                                 const MakeFor& training, const MakeFor& held_out,
                                 const SampleOptions& options) {
  auto expanded = with_samples(base, samples);
  if (!expanded) return tl::unexpected(expanded.error());
  auto seen = training(*expanded);
  if (!seen) return tl::unexpected(seen.error());
  auto unseen = held_out(*expanded);
  if (!unseen) return tl::unexpected(unseen.error());
  auto result = Search(base, *expanded, samples, **seen, **unseen, options).run();
  if (!result || !result->released.empty()) return result;
  result->model = homogeneous(base, result->model);
  // the same fit, told over the base's parameters
  auto plain = training(result->model);
  if (!plain) return tl::unexpected(plain.error());
  result->fit = fit(**plain, result->model, options.fit);
  store(result->fit, result->model);
  return result;
}

}  // namespace tenter::estimation
