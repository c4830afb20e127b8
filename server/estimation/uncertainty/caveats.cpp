// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/uncertainty/caveats.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/model/catalogue.h"
#include "server/mechanics/friction/dahl_work.h"

namespace tenter::estimation {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

void add(std::vector<Caveat>& list, CaveatKind kind, const std::string& subject,
         const std::string& sentence) {
  list.push_back({kind, subject, sentence});
}

void add_state(std::vector<Caveat>& list, const std::string& name, const model::Parameter& p,
               double value, ParameterState state) {
  const std::string amount = number(value) + " " + p.unit;
  switch (state) {
    case ParameterState::free:
      return;
    case ParameterState::fixed:
      return add(list, CaveatKind::frozen, name,
                 name + " was held at " + amount + ": an assumption, not a finding");
    case ParameterState::at_bound:
      return add(list, CaveatKind::at_bound, name,
                 name + " ended at its bound, " + amount + ": it has no interval");
    case ParameterState::zero_gradient:
      return add(list, CaveatKind::zero_gradient, name,
                 "nothing in the data moves with " + name + ": it stayed at " + amount);
    case ParameterState::flat:
      return add(
          list, CaveatKind::flat, name,
          "the data do not determine " + name + " by itself; " + amount + " is one of many values");
  }
}

void add_profile(std::vector<Caveat>& list, const std::string& name, const Profile& profile) {
  if (profile.determined == Determined::flat)
    add(list, CaveatKind::flat, name,
        "the profile of " + name + " is flat: no value that was tried can be excluded");
  if (profile.determined == Determined::one_sided)
    add(list, CaveatKind::one_sided, name,
        profile.lo ? name + " is at least " + number(*profile.lo) + "; nothing bounds it above"
                   : name + " is at most " + number(*profile.hi) + "; nothing bounds it below");
  if (profile.determined != Determined::multimodal) return;
  const auto least = std::min_element(
      profile.points.begin(), profile.points.end(),
      [](const ProfilePoint& a, const ProfilePoint& b) { return a.rise < b.rise; });
  add(list, CaveatKind::multimodal, name,
      profile.found_better ? "the fit is not the best there is: " + name + " = " +
                                 number(least->value) + " fits better"
                           : "values of " + name + " far from the fit's fit as well");
}

void add_correlations(std::vector<Caveat>& list, const std::vector<std::string>& names,
                      const RowMatrix& correlation, double limit) {
  for (Eigen::Index i = 0; i < correlation.rows(); ++i)
    for (Eigen::Index k = i + 1; k < correlation.cols(); ++k)
      if (std::abs(correlation(i, k)) > limit) {
        const std::string& a = names[static_cast<std::size_t>(i)];
        const std::string& b = names[static_cast<std::size_t>(k)];
        add(list, CaveatKind::correlated, a,
            a + " and " + b + " are correlated by " + number(correlation(i, k)) +
                ": the data tell a combination of them");
      }
}

void add_ranges(std::vector<Caveat>& list, const model::Model& model) {
  for (const model::Term& term : model.terms) {
    const model::LawRow* row = model::find_law(term.law.name);
    if (row == nullptr || !row->spline || !(term.law.range_hi > term.law.range_lo)) continue;
    for (const model::StrainRange& range : model.strain_ranges) {
      const double slack = 1e-6 * (term.law.range_hi - term.law.range_lo);
      if (range.term != term.id ||
          (term.law.range_lo >= range.lo - slack && term.law.range_hi <= range.hi + slack))
        continue;
      add(list, CaveatKind::beyond_data, term.id,
          "the curve of " + term.id + " spans " + number(term.law.range_lo) + " to " +
              number(term.law.range_hi) + ", but strains were seen from " + number(range.lo) +
              " to " + number(range.hi) + " only");
    }
  }
}

/// Dissipation of Dahl's law (mechanics/friction/dahl_work.h) at any strain.
void add_frictions(std::vector<Caveat>& list, const model::Model& model,
                   const Eigen::VectorXd& values) {
  constexpr double kAnyStrain = 1e9;
  Eigen::Index first = 0;
  for (const model::Term& term : model.terms) {
    const Eigen::Index own = first;
    first += static_cast<Eigen::Index>(term.law.parameters.size());
    if (term.law.name != "dahl" || first > values.size()) continue;
    const mechanics::DissipationCheck check =
        mechanics::check_dissipation(values.data() + own, kAnyStrain);
    if (check.holds) continue;
    add(list, CaveatKind::gains_work, term.id,
        "a step of \"" + term.id + "\" may give back more work than it took at strains from " +
            number(check.fails_from) + " to " + number(check.fails_to) +
            ": tau times the slope of sigma_max is up to " + number(check.worst) +
            " times 2 sigma_max there");
  }
}

}  // namespace

std::string_view words_of(CaveatKind kind) {
  static constexpr std::string_view kWords[] = {
      "not_converged", "frozen",     "zero_gradient", "at_bound",    "flat",
      "one_sided",     "multimodal", "correlated",    "beyond_data", "dropped_frames",
      "rows_left_out", "wrong_form", "gains_work"};
  return kWords[static_cast<std::size_t>(kind)];
}

std::vector<Caveat> caveats(const model::Model& model, const FitResult& found,
                            const FitOptions& options, const std::vector<Profile>& profiles,
                            const std::vector<DroppedFrames>& dropped,
                            const CaveatOptions& caveat_options) {
  std::vector<Caveat> list;
  if (!found.converged)
    add(list, CaveatKind::not_converged, model.name, "the fit did not converge: " + found.message);
  const std::vector<std::string> names = parameter_names(model);
  const auto parameters = parameters_of(model);
  for (std::size_t i = 0; i < found.states.size(); ++i)
    add_state(list, names[i], *parameters[i], found.parameters[static_cast<Eigen::Index>(i)],
              found.states[i]);
  for (const Profile& profile : profiles)
    add_profile(list, names[static_cast<std::size_t>(profile.parameter)], profile);
  add_correlations(list, names, found.correlation, caveat_options.correlation);
  add_ranges(list, model);
  for (const DroppedFrames& frames : dropped)
    if (!frames.frames.empty()) {
      constexpr std::size_t kNamed = 12;
      std::string which;
      for (std::size_t i = 0; i < std::min(kNamed, frames.frames.size()); ++i)
        which += (i == 0 ? "" : ", ") + std::to_string(frames.frames[i]);
      if (frames.frames.size() > kNamed)
        which += " and " + std::to_string(frames.frames.size() - kNamed) + " more";
      add(list, CaveatKind::dropped_frames, frames.name,
          std::to_string(frames.frames.size()) + " frames of " + frames.name + " took no part (" +
              frames.why + "): " + which);
    }
  const Eigen::Index left_out =
      options.weights.size() > 0 ? (options.weights.array() == 0.0).count() : 0;
  if (left_out > 0)
    add(list, CaveatKind::rows_left_out, model.name,
        std::to_string(left_out) + " of " + std::to_string(found.residuals.size()) +
            " measured values were left out");
  const double used = static_cast<double>(found.residuals.size() - left_out);
  const double per_row = found.chi2 / std::max(1.0, used);
  if (per_row > caveat_options.wrong_form)
    add(list, CaveatKind::wrong_form, model.name,
        "residuals are " + number(std::sqrt(per_row)) +
            " times the noise: the model's form is wrong, and intervals are widened for it");
  add_frictions(list, model, found.parameters);
  std::stable_sort(list.begin(), list.end(),
                   [](const Caveat& a, const Caveat& b) { return a.kind < b.kind; });
  return list;
}

}  // namespace tenter::estimation
