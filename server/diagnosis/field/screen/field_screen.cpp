// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/field_screen.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <optional>

#include "server/diagnosis/field/data/structure.h"
#include "server/diagnosis/field/screen/added_columns.h"
#include "server/diagnosis/field/screen/coordinates.h"
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

/// In coordinates: all columns of the fit, those that are added, then the residuals.
Eigen::MatrixXd reduced(const FieldFit& fit, const estimation::RowMatrix& added) {
  constexpr Eigen::Index kBatch = 256;
  const Eigen::Index own = fit.at.fit.jacobian.cols();
  const Eigen::Index rows = fit.at.fit.residuals.size();
  Coordinates coordinates(own + added.cols() + 1);
  estimation::RowMatrix batch;
  for (Eigen::Index first = 0; first < rows; first += kBatch) {
    const Eigen::Index count = std::min(kBatch, rows - first);
    batch.resize(count, own + added.cols() + 1);
    batch.leftCols(own) = fit.at.fit.jacobian.middleRows(first, count);
    batch.middleCols(own, added.cols()) = added.middleRows(first, count);
    batch.rightCols(1) = fit.at.fit.residuals.segment(first, count);
    coordinates.add(batch);
  }
  return coordinates.matrix();
}

/// The same in the gathered order; zero where no entry asks for a column.
Eigen::MatrixXd in_order(const Eigen::MatrixXd& all, const Gathering& gathering,
                         const Added& added) {
  const Eigen::Index terms = gathering.base_term_count();
  const Eigen::Index corrections = gathering.base_correction_count();
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(all.rows(), gathering.count());
  columns.leftCols(terms) = all.leftCols(terms);
  const Eigen::Index after = terms + gathering.added_term_count();
  columns.middleCols(after, corrections) = all.middleCols(terms, corrections);
  Eigen::Index from = terms + corrections;
  for (const int p : added.wanted_of_terms) columns.col(terms + p) = all.col(from++);
  for (const int p : added.wanted_of_corrections)
    columns.col(after + corrections + p) = all.col(from++);
  return columns;
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
    const Added added{gathering.added_terms(), fields_of(gathering), gathering.added_corrections(),
                      gathering.asked_of_terms(), gathering.asked_of_corrections()};
    const auto rows = added_columns(fit, data, added, threads);
    if (!rows) {
      error = rows.error();
      return false;
    }
    const Eigen::MatrixXd all = reduced(fit, *rows);
    columns = in_order(all, gathering, added);
    ground.own = range_basis(all(Eigen::indexing::all, free_columns(fit.at.fit)));
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
