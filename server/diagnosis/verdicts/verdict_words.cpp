// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/verdict_words.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

namespace tenter::diagnosis {

std::string in_percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, share < 0.0995 ? "%.1f %%" : "%.0f %%", 100.0 * share);
  return text;
}

namespace {

std::string list_words(const std::vector<std::string>& ids) {
  std::string words;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (i > 0) words += i + 1 == ids.size() ? " or " : ", ";
    words += find_effect(ids[i]) ? find_effect(ids[i])->words : ids[i];
  }
  return words;
}

/// Friction and viscosity.
bool is_rate_question(const std::string& effect) {
  return effect == "internal_friction" || effect == "strain_dependent_friction" ||
         effect == "viscosity";
}

}  // namespace

double evidence_against(const Reference& other, const Reference& chosen, double telling_rows) {
  const double rows = std::max(other.fit.effective_rows, chosen.fit.effective_rows);
  const int more = free_count(other.model) - free_count(chosen.model);
  const double per_parameter = std::log(telling_rows > 0.0 ? telling_rows : rows);
  return rows * std::log(std::max(other.fit.chi2, 1e-12) / std::max(chosen.fit.chi2, 1e-12)) +
         more * per_parameter;
}

bool says_nothing_against(const std::string& rival, const std::string& effect) {
  const Effect* other = find_effect(rival);
  return (rival == "strain_dependent_friction" && effect == "internal_friction") ||
         (other != nullptr && other->special_form_of == effect);
}

bool is_case_of(const std::string& effect, const std::string& rival) {
  return effect == "anisotropy" && rival == "nonlinear_stiffness";
}

Question question_of(const std::string& effect, const std::vector<std::string>& alternatives) {
  return is_rate_question(effect) && std::ranges::any_of(alternatives, is_rate_question)
             ? Question::of_rate
             : Question::any;
}

std::vector<std::string> to_be_split(const std::string& effect,
                                     const std::vector<std::string>& alternatives) {
  if (question_of(effect, alternatives) == Question::any) return alternatives;
  std::vector<std::string> others;
  for (const std::string& other : alternatives)
    if (!is_rate_question(other) || (other == "viscosity") != (effect == "viscosity"))
      others.push_back(other);
  return others.empty() ? alternatives : others;
}

void add_untold(const Effect& effect, const Excitation& excitation,
                std::vector<std::string>& alternatives) {
  if (is_rate_question(effect.id) && !excitation.splits_rate()) {
    const std::string other = effect.id == "viscosity" ? "internal_friction" : "viscosity";
    if (std::find(alternatives.begin(), alternatives.end(), other) == alternatives.end())
      alternatives.push_back(other);
  }
  if (effect.needs_rate && !excitation.has_rate && alternatives.empty())
    alternatives.push_back(effect.mistaken_for.front());
}

void put_in_words(const Effect& effect, const std::vector<const Trial*>& trials,
                  const SizeInterval& size, const std::string& of_what, const std::string& here,
                  int blocks, Verdict& verdict) {
  const Trial& first = *trials.front();
  verdict.effect = effect.id;
  verdict.p_value = first.p_value;
  verdict.size = size.size;
  verdict.size_lo = size.lo;
  verdict.size_hi = size.hi;
  std::string words = effect.words;
  words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
  if (!verdict.alternatives.empty()) {
    verdict.kind = VerdictKind::ambiguous;
    words += "; " + here + " cannot tell it from " + list_words(verdict.alternatives);
  } else {
    verdict.kind = effect.kind == effects::Kind::sensor ? VerdictKind::sensor : VerdictKind::named;
  }
  words += ". It accounts for " + in_percent(size.size) + " of the " + of_what;
  std::string variants;
  for (const Trial* trial : trials)
    variants += (variants.empty() ? " (" : "; ") + trial->variant.words;
  words += variants + ")";
  if (first.held_out_before > 0.0)
    words += " and takes " + in_percent(1.0 - first.held_out_after / first.held_out_before) +
             " off the squared error on left-out " + first.folds;
  words += ".";
  const bool few_blocks = blocks < 8;
  if (few_blocks) words += " Too few repeats for more than a weak word.";
  verdict.words = words;
  verdict.evidence = {{"screen_ratio", first.ratio},
                      {"f_test_p", first.p_value},
                      {"blocks", static_cast<double>(blocks)},
                      {"few_repeats", few_blocks ? 1.0 : 0.0}};
}

Verdict nothing_found(double noise_floor) {
  Verdict verdict;
  verdict.words = "Nothing found: what the model misses is no larger than the noise, " +
                  in_percent(noise_floor) + " of the force.";
  return verdict;
}

Verdict unexplained(const Findings& findings, double error) {
  Verdict verdict;
  verdict.kind = VerdictKind::unexplained;
  verdict.size =
      std::sqrt(std::max(0.0, error * error - findings.noise_floor * findings.noise_floor));
  verdict.size_lo = verdict.size_hi = verdict.size;
  verdict.words =
      in_percent(findings.unexplained_share) +
      " of what the baseline missed beyond the noise is explained by no effect of the catalogue; " +
      in_percent(verdict.size) + " of the force.";
  verdict.evidence = {{"lack_of_fit", findings.last_screen.lack_of_fit},
                      {"unexplained_share", findings.unexplained_share}};
  return verdict;
}

void add_not_excited(Findings& findings, const std::set<std::string>& found,
                     bool (*is_asked)(const Effect&)) {
  for (const ScreenRow& row : findings.first_screen.table) {
    if (found.contains(row.effect->id) || !row.status.starts_with("not excited")) continue;
    if (!is_asked(*row.effect)) continue;
    Verdict verdict;
    verdict.kind = VerdictKind::not_excited;
    verdict.effect = row.effect->id;
    verdict.words =
        "These captures cannot show " + row.effect->words + " (" + row.status.substr(13) + ").";
    verdict.next_protocol = row.effect->split_by;
    findings.verdicts.push_back(std::move(verdict));
  }
}

const char* verdict_name(VerdictKind kind) {
  switch (kind) {
    case VerdictKind::nothing_found:
      return "NOTHING_FOUND";
    case VerdictKind::named:
      return "NAMED";
    case VerdictKind::ambiguous:
      return "AMBIGUOUS";
    case VerdictKind::sensor:
      return "SENSOR";
    case VerdictKind::not_excited:
      return "NOT_EXCITED";
    case VerdictKind::unexplained:
      return "UNEXPLAINED";
    case VerdictKind::numerical:
      return "NUMERICAL";
  }
  return "";
}

}  // namespace tenter::diagnosis
