// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/added_columns.h"

#include "server/diagnosis/field/screen/column_walk.h"
#include "server/estimation/parallel.h"

namespace tenter::diagnosis {
namespace {

/// Of the rows of a fit, [sequence][frame][channel]; -1: none.
std::vector<std::vector<std::vector<int>>> rows_of(const FieldFit& fit, const FieldData& data) {
  std::vector<std::vector<std::vector<int>>> row_of;
  for (const estimation::Sequence& sequence : data.sequences) {
    const auto channels = static_cast<std::size_t>(estimation::Observations(sequence).count());
    row_of.emplace_back(sequence.frames.size(), std::vector<int>(channels, -1));
  }
  for (std::size_t r = 0; r < fit.rows.size(); ++r)
    row_of[static_cast<std::size_t>(fit.rows[r].curve)][static_cast<std::size_t>(fit.rows[r].frame)]
          [static_cast<std::size_t>(fit.rows[r].channel)] = static_cast<int>(r);
  return row_of;
}

/// The fitted model with the corrections that are added.
model::Model corrected(const model::Model& fitted, const Added& added) {
  model::Model model = fitted;
  for (std::size_t k = 0; k < added.corrections.size(); ++k) {
    model.corrections.push_back(added.corrections[k]);
    model.corrections.back().id = "added_" + std::to_string(k);  // ids of variants may be alike
  }
  return model;
}

}  // namespace

Expected<estimation::RowMatrix> added_columns(const FieldFit& fit, const FieldData& data,
                                              const Added& added, int threads) {
  estimation::RowMatrix result =
      estimation::RowMatrix::Zero(static_cast<Eigen::Index>(fit.rows.size()), added.count());
  if (added.count() == 0) return result;
  const std::vector<TermGroup> groups = grouped(added);
  const model::Model with_corrections = corrected(fit.at.model, added);
  const auto own = estimation::SequenceSensors::make(fit.at.model, data.sequences);
  if (!own) return tl::unexpected(own.error());
  const auto all = estimation::SequenceSensors::make(with_corrections, data.sequences);
  if (!all) return tl::unexpected(all.error());
  const ColumnTask task{
      fit, data, added, groups, *own, *all, estimation::parameter_values(with_corrections)};
  const auto row_of = rows_of(fit, data);
  std::vector<Expected<void>> done(data.sequences.size());
  estimation::in_parallel(threads, static_cast<int>(done.size()), [&](int, int s) {
    const auto k = static_cast<std::size_t>(s);
    done[k] = ColumnWalk(task, k).run(row_of[k], result);
  });
  for (const auto& one : done)
    if (!one) return tl::unexpected(one.error());
  return result;
}

}  // namespace tenter::diagnosis
