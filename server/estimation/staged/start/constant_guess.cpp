// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/start/constant_guess.h"

#include <algorithm>

#include "server/estimation/staged/splines/spline_refinement.h"

namespace tenter::estimation {

double started(double guess, double before, const model::Parameter& p) {
  constexpr double kLeast = 0.1;
  const bool is_stiffness = p.lower && *p.lower >= 0.0 && before > 0.0;
  return is_stiffness ? std::max(guess, kLeast * before) : guess;
}

void begin_with_one_point(model::Model& model, const std::vector<std::string>& terms) {
  for (model::Term& term : model.terms) {
    const bool has_range = term.law.range_hi > term.law.range_lo;
    const bool is_named = std::find(terms.begin(), terms.end(), term.id) != terms.end();
    if (is_spline(term.law) && (is_named || !has_range)) term.law = as_constant(term.law);
  }
}

Expected<StageRecord> guess_all(model::Model& model, const StageTask& task,
                                const StageOptions& options) {
  StageRecord record;
  record.name = task.name;
  begin_with_one_point(model, task.terms);
  auto ties = tie_terms(model, task.ties);
  if (!ties) return tl::unexpected(ties.error());
  std::vector<GapSequence> measured;
  measured.reserve(task.sequences.size());
  for (const RoleSequence& s : task.sequences) measured.push_back({&s.sequence, GapRows::all});
  const auto gap = equation_gap(model, *ties, measured, options.gap);
  if (!gap) {
    if (gap.error().kind != ErrorKind::refused) return tl::unexpected(gap.error());
    record.message = gap.error().message;
    return record;
  }
  record.done = record.guessed = true;
  record.message = std::to_string(gap->frames) + " frames, " + std::to_string(gap->rounds) +
                   " rounds, " + std::to_string(gap->frames_left_out) + " frames left out";
  const Eigen::VectorXd all = ties->all(gap->q);
  const auto parameters = parameters_of(model);
  const std::vector<std::string> names = parameter_names(model);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    parameters[k]->value =
        started(all[static_cast<Eigen::Index>(k)], parameters[k]->value, *parameters[k]);
    for (Eigen::Index q = 0; q < ties->map.cols(); ++q)
      if (ties->map(static_cast<Eigen::Index>(k), q) != 0.0 &&
          gap->is_at_bound[static_cast<std::size_t>(q)])
        record.not_free.push_back({names[k], ParameterState::at_bound});
  }
  return record;
}

}  // namespace tenter::estimation
