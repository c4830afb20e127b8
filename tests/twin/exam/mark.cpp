// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/mark.h"

#include <algorithm>

namespace tenter::exam {
namespace {

constexpr std::size_t kLargestGroup = 3;

bool is_friction(const std::string& id) {
  return id == "internal_friction" || id == "strain_dependent_friction";
}

/// Those of the truths that a statement's group holds.
std::vector<std::string> held_by(const std::vector<std::string>& group,
                                 const std::vector<std::string>& truths) {
  std::vector<std::string> held;
  for (const std::string& truth : truths)
    if (std::any_of(group.begin(), group.end(),
                    [&](const std::string& id) { return counts_as(id, truth); }))
      held.push_back(truth);
  return held;
}

bool splits_no_rate(const std::vector<std::string>& group) {
  return std::any_of(group.begin(), group.end(), is_friction) &&
         std::find(group.begin(), group.end(), "viscosity") != group.end();
}

Grade grade_of_effects(const Mark& mark, std::size_t hidden, bool overclaimed) {
  const bool wrong = !mark.wrong_names.empty() || !mark.wrong_groups.empty();
  if (!mark.holding.empty())
    return wrong || mark.held.size() < hidden ? Grade::partly : Grade::right;
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

namespace {

/// With the rate no longer hidden: what hides is named and nothing else is.
bool is_resolved(const Question& question, const Answer& answer) {
  if (answer.said_next.empty()) return false;
  Question open = question;
  open.rate_hidden = false;
  Answer next;
  next.said = answer.said_next;
  const Mark again = mark(open, next);
  return again.grade == Grade::right && again.certain;
}

}  // namespace

Mark mark(const Question& question, const Answer& answer) {
  Mark result;
  result.resolved = is_resolved(question, answer);
  if (!answer.trouble.empty()) return result;
  bool overclaimed = false;
  for (const Said& said : answer.said) {
    if (said.verdict == "UNEXPLAINED") result.unexplained = true;
    const bool certain = said.verdict == "NAMED" || said.verdict == "SENSOR";
    const std::vector<std::string> group = said.group();
    if (!certain && (said.verdict != "AMBIGUOUS" || group.size() > kLargestGroup)) continue;
    const bool may_hold = question.kind == Kind::effect || question.kind == Kind::pair;
    const std::vector<std::string> held =
        may_hold ? held_by(certain ? std::vector{said.effect} : group, question.truths)
                 : std::vector<std::string>();
    if (held.empty()) {
      (certain ? result.wrong_names : result.wrong_groups).push_back(said.effect);
    } else if (question.rate_hidden && is_rate_question(held.front()) &&
               (certain || !splits_no_rate(group))) {
      overclaimed = true;
    } else {
      result.holding.push_back(said.line());
      for (const std::string& truth : held)
        if (std::find(result.held.begin(), result.held.end(), truth) == result.held.end())
          result.held.push_back(truth);
      result.certain = result.certain || certain;
    }
  }
  switch (question.kind) {
    case Kind::effect:
    case Kind::pair:
      result.grade = grade_of_effects(result, question.truths.size(), overclaimed);
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
