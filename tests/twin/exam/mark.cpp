// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/mark.h"

#include <algorithm>

namespace tenter::exam {
namespace {

constexpr std::size_t kLargestGroup = 3;

bool is_friction(const std::string& id) {
  return id == "internal_friction" || id == "strain_dependent_friction";
}

bool group_counts_as(const std::vector<std::string>& group, const std::string& truth) {
  return std::any_of(group.begin(), group.end(),
                     [&](const std::string& id) { return counts_as(id, truth); });
}

bool splits_no_rate(const std::vector<std::string>& group) {
  return std::any_of(group.begin(), group.end(), is_friction) &&
         std::find(group.begin(), group.end(), "viscosity") != group.end();
}

Grade grade_of_effect(const Mark& mark, bool overclaimed) {
  const bool wrong = !mark.wrong_names.empty() || !mark.wrong_groups.empty();
  if (!mark.holding.empty()) return wrong ? Grade::partly : Grade::right;
  if (wrong) return Grade::wrong;
  return overclaimed ? Grade::overclaimed : Grade::missed;
}

Grade grade_of_null(const Mark& mark) {
  return mark.wrong_names.empty() && mark.wrong_groups.empty() ? Grade::right : Grade::wrong;
}

Grade grade_of_foreign(const Mark& mark) {
  if (!mark.wrong_names.empty()) return Grade::wrong;
  return mark.unexplained ? Grade::right : Grade::missed;
}

}  // namespace

const char* grade_name(Grade grade) {
  switch (grade) {
    case Grade::right:
      return "right";
    case Grade::partly:
      return "partly";
    case Grade::overclaimed:
      return "overclaimed";
    case Grade::missed:
      return "missed";
    case Grade::wrong:
      return "wrong";
    case Grade::no_answer:
      return "no answer";
  }
  return "";
}

bool counts_as(const std::string& named, const std::string& truth) {
  return named == truth || (is_friction(named) && is_friction(truth));
}

Mark mark(const Question& question, const Answer& answer) {
  Mark result;
  if (!answer.trouble.empty()) return result;
  bool overclaimed = false;
  for (const Said& said : answer.said) {
    if (said.verdict == "UNEXPLAINED") result.unexplained = true;
    const bool certain = said.verdict == "NAMED" || said.verdict == "SENSOR";
    const std::vector<std::string> group = said.group();
    if (!certain && (said.verdict != "AMBIGUOUS" || group.size() > kLargestGroup)) continue;
    const bool true_one =
        question.kind == Kind::effect &&
        (certain ? counts_as(said.effect, question.truth) : group_counts_as(group, question.truth));
    if (!true_one) {
      (certain ? result.wrong_names : result.wrong_groups).push_back(said.effect);
    } else if (question.rate_hidden && (certain || !splits_no_rate(group))) {
      overclaimed = true;
    } else {
      result.holding.push_back(said.line());
      result.certain = result.certain || certain;
    }
  }
  switch (question.kind) {
    case Kind::effect:
      result.grade = grade_of_effect(result, overclaimed);
      break;
    case Kind::null:
      result.grade = grade_of_null(result);
      break;
    case Kind::foreign:
      result.grade = grade_of_foreign(result);
      break;
  }
  return result;
}

}  // namespace tenter::exam
