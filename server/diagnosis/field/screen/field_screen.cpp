// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/field_screen.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <optional>

#include "server/diagnosis/field/data/structure.h"
#include "server/diagnosis/field/screen/coordinates.h"
#include "server/diagnosis/field/screen/term_columns.h"
#include "server/diagnosis/screening/catalogue_screen.h"
#include "server/diagnosis/screening/normal.h"

namespace tenter::diagnosis {
namespace {

using estimation::ParameterState;

std::vector<Eigen::Index> free_columns(const estimation::FitResult& fit) {
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < fit.states.size(); ++i)
    if (fit.states[i] == ParameterState::free || fit.states[i] == ParameterState::flat)
      free.push_back(static_cast<Eigen::Index>(i));
  return free;
}

/// Fields of the material that variants bring along, each once.
std::vector<model::Field> fields_of(const Gathering& gathering) {
  std::vector<model::Field> fields = gathering.base().fields;
  for (const Columns& entry : gathering.entries())
    for (const model::Field& field : entry.variant->fields) {
      const bool is_there = std::any_of(fields.begin(), fields.end(),
                                        [&](const model::Field& f) { return f.id == field.id; });
      if (!is_there) fields.push_back(field);
    }
  return fields;
}

/// What noise alone exceeds with this chance: chi2, or where sigma itself is an estimate, F.
double noise_exceeds(double rows, const FieldData& data, std::size_t kind, double chance) {
  using boost::math::complement;
  const double known_of = kind < data.sigma_known_of.size() ? data.sigma_known_of[kind] : 0.0;
  if (!(known_of > 0.0))
    return boost::math::quantile(
        complement(boost::math::chi_squared_distribution<double>(rows), chance));
  return rows * boost::math::quantile(
                    complement(boost::math::fisher_f_distribution<double>(rows, known_of), chance));
}

/// Largest chi2 of a kind over its share of false alarms.
double lack_of_fit(const FieldFit& fit, const FieldData& data) {
  const std::vector<int> places = kind_places(data.sequences, fit.rows);
  std::vector<double> chi2;
  std::vector<double> rows;
  for (std::size_t r = 0; r < places.size(); ++r) {
    const auto p = static_cast<std::size_t>(places[r]);
    if (chi2.size() <= p) {
      chi2.resize(p + 1, 0.0);
      rows.resize(p + 1, 0.0);
    }
    const double x = fit.at.fit.residuals[static_cast<Eigen::Index>(r)];
    chi2[p] += x * x;
    rows[p] += 1.0;
  }
  double worst = 0.0;
  for (std::size_t p = 0; p < chi2.size(); ++p) {
    if (rows[p] < 1.0) continue;
    const double alarm = 0.05 / static_cast<double>(chi2.size());
    worst = std::max(worst, chi2[p] / noise_exceeds(rows[p], data, p, alarm));
  }
  return worst;
}

/// All columns in the gathered order, then the residuals: batch by batch.
Eigen::MatrixXd reduced(const FieldFit& fit, const Gathering& gathering,
                        const Eigen::MatrixXd& added, const Eigen::MatrixXd& corrected) {
  constexpr Eigen::Index kBatch = 1024;
  const Eigen::Index terms = gathering.base_term_count();
  const Eigen::Index corrections = gathering.base_correction_count();
  const Eigen::Index rows = fit.at.fit.residuals.size();
  const Eigen::MatrixXd& jacobian = fit.at.fit.jacobian;
  const Eigen::Index columns = terms + added.cols() + corrections + corrected.cols() + 1;
  Coordinates coordinates(columns);
  Eigen::MatrixXd batch;
  for (Eigen::Index first = 0; first < rows; first += kBatch) {
    const Eigen::Index count = std::min(kBatch, rows - first);
    batch.resize(count, columns);
    batch.leftCols(terms) = jacobian.block(first, 0, count, terms);
    batch.middleCols(terms, added.cols()) = added.middleRows(first, count);
    batch.middleCols(terms + added.cols(), corrections) =
        jacobian.block(first, terms, count, corrections);
    batch.middleCols(terms + added.cols() + corrections, corrected.cols()) =
        corrected.middleRows(first, count);
    batch.rightCols(1) = fit.at.fit.residuals.segment(first, count);
    coordinates.add(batch);
  }
  return coordinates.matrix();
}

}  // namespace

double expected_chi2(const FieldFit& fit) {
  return std::max(1.0, static_cast<double>(fit.rows.size()) -
                           static_cast<double>(free_columns(fit.at.fit).size()));
}

Expected<Screen> screen_field(const FieldFit& fit, const FieldData& data,
                              const Excitation& excitation, const ScreenOptions& options,
                              int threads) {
  Screen result;
  result.expected_chi2 = expected_chi2(fit);
  result.lack_of_fit = lack_of_fit(fit, data);
  std::optional<Error> error;
  unsigned long long draw = options.seed;
  const auto source = [&](const Gathering& gathering, Ground& ground, Eigen::MatrixXd& columns) {
    const auto added =
        term_columns(fit, data, gathering.added_terms(), fields_of(gathering), threads);
    if (!added) {
      error = added.error();
      return false;
    }
    const auto corrected = correction_columns(fit, data, gathering.added_corrections(), threads);
    if (!corrected) {
      error = corrected.error();
      return false;
    }
    const Eigen::MatrixXd all = reduced(fit, gathering, *added, *corrected);
    columns = all.leftCols(all.cols() - 1);
    std::vector<Eigen::Index> free = free_columns(fit.at.fit);
    for (Eigen::Index& c : free)
      if (c >= gathering.base_term_count()) c += gathering.added_term_count();
    ground.own = range_basis(columns(Eigen::indexing::all, free));
    ground.left = all.rightCols(1);
    Normal normal(draw++);
    ground.twins.resize(all.rows(), options.null_twins);
    for (Eigen::Index k = 0; k < ground.twins.size(); ++k) ground.twins.data()[k] = normal();
    settle(ground);
    return true;
  };
  screen_catalogue(fit.at.model, excitation, source, options, result);
  if (error) return tl::unexpected(*error);
  return result;
}

}  // namespace tenter::diagnosis
