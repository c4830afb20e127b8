// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/answer.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "common/model/presets.h"
#include "server/diagnosis/diagnose.h"
#include "server/diagnosis/field/diagnose_sheet.h"
#include "server/diagnosis/verdicts/verdict_words.h"
#include "tests/twin/exam/field/next_sheet.h"
#include "tests/twin/exam/field/sheet_question.h"
#include "tests/twin/exam/next_capture.h"
#include "tests/twin/generator.h"

namespace tenter::exam {
namespace {

std::string formatted(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string path_line(const diagnosis::PathStep& step) {
  std::string line = step.action;
  if (!step.effect.empty()) line += " " + step.effect;
  if (!step.why.empty()) line += " (" + step.why + ")";
  line += formatted(" chi2 %.4g", step.chi2) + formatted(" error %.4f", step.error);
  if (step.p_value) line += formatted(" p %.2g", *step.p_value);
  if (step.held_out) line += formatted(" held-out ratio %.3f", *step.held_out);
  return line;
}

Said said_in(const diagnosis::Verdict& verdict) {
  return {diagnosis::verdict_name(verdict.kind),
          verdict.effect,
          verdict.alternatives,
          verdict.size,
          verdict.size_lo,
          verdict.size_hi};
}

/// Of curves or of sheets.
template <class Found>
void take_over(const Found& found, Answer& answer) {
  for (const diagnosis::Verdict& verdict : found.verdicts) answer.said.push_back(said_in(verdict));
  for (const diagnosis::PathStep& step : found.path) answer.path.push_back(path_line(step));
  answer.noise_floor = found.noise_floor;
  answer.error_before = found.before.error;
  answer.error_after = found.after.error;
  if (found.held_out_before) answer.held_out_before = found.held_out_before->error;
  if (found.held_out_after) answer.held_out_after = found.held_out_after->error;
  answer.unexplained_share = found.unexplained_share;
}

}  // namespace

std::vector<std::string> Said::group() const {
  std::vector<std::string> ids = {effect};
  for (const std::string& other : alternatives)
    if (std::find(ids.begin(), ids.end(), other) == ids.end()) ids.push_back(other);
  return ids;
}

std::string Said::line() const {
  std::string words = verdict;
  if (!effect.empty()) {
    const std::vector<std::string> ids = group();
    words += " " + ids.front();
    for (std::size_t i = 1; i < ids.size(); ++i) words += "|" + ids[i];
  }
  if (size > 0.0) words += formatted(" %.2f %%", 100.0 * size);
  return words;
}

std::string Answer::line() const {
  std::string words;
  for (const Said& one : said) {
    if (one.verdict == "NOT_EXCITED") continue;
    words += (words.empty() ? "" : "; ") + one.line();
  }
  if (!trouble.empty()) words += (words.empty() ? "" : "; ") + ("FAILED: " + trouble);
  return words.empty() ? "no verdict" : words;
}

namespace {

Expected<diagnosis::Diagnosis> diagnose_twin(twin::Twin twin,
                                             const diagnosis::Options& options = {}) {
  diagnosis::Request request;
  request.options = options;
  auto baseline = model::preset(twin.baseline_preset);
  if (!baseline) return tl::unexpected(baseline.error());
  request.model = *baseline;
  for (std::size_t i = 0; i < twin.captures.size(); ++i)
    request.captures.emplace_back("twin" + std::to_string(i), std::move(twin.captures[i]));
  return diagnosis::diagnose(request, diagnosis::Control());
}

/// The same captures with a catalogue that knows only what hides: what the true model would have
/// foretold, left out in the same way.
template <class Found, class Diagnose>
void compare(const Question& question, const Found& found, const Diagnose& diagnose,
             Answer& answer) {
  if (!found.held_out_after) return;
  diagnosis::Options options;
  options.effects = question.truths;
  options.leave_out = found.held_out_kind;
  if (question.truths.empty()) options.max_effects = 0;
  const auto truth = diagnose(options);
  if (truth && truth->held_out_after && truth->held_out_kind == found.held_out_kind)
    answer.held_out_truth = truth->held_out_after->error;
}

/// The design of the first AMBIGUOUS verdict, noted in the answer.
const diagnosis::Design* proposed_by(const diagnosis::Findings& found, Answer& answer) {
  const auto ambiguous = std::ranges::find(found.verdicts, diagnosis::VerdictKind::ambiguous,
                                           &diagnosis::Verdict::kind);
  if (ambiguous == found.verdicts.end()) return nullptr;
  answer.was_ambiguous = true;
  if (!ambiguous->design) return nullptr;
  answer.proposed = ambiguous->design->plan.name + ", mounted as " + ambiguous->design->mounted_as;
  return &*ambiguous->design;
}

template <class Found>
void take_over_next(const Found& again, Answer& answer) {
  for (const diagnosis::Verdict& verdict : again.verdicts)
    answer.said_next.push_back(said_in(verdict));
}

/// Does what the first AMBIGUOUS verdict proposes, and asks again.
void resolve(const Question& question, const diagnosis::Diagnosis& found, Answer& answer) {
  const diagnosis::Design* design = proposed_by(found, answer);
  const auto suite = twin::plan_suite(question.twin.suite, twin::Random(question.twin.seed));
  if (design == nullptr || !suite) return;
  const auto plan = planned(*design, *suite);
  if (!plan) return;
  twin::TwinCase twin_case = question.twin;
  twin_case.more = {*plan};
  auto twin = twin::make_twin(twin_case);
  if (!twin) return;
  // what was recorded without time cannot speak of rates
  const bool has_time = std::any_of(twin->captures.begin(), twin->captures.end(),
                                    [](const auto& c) { return !c.time_s.empty(); });
  if (has_time) std::erase_if(twin->captures, [](const auto& c) { return c.time_s.empty(); });
  const auto again = diagnose_twin(std::move(*twin));
  if (again) take_over_next(*again, answer);
}

void take_over_hidden(const std::vector<twin::Hidden>& all, Answer& answer) {
  for (const twin::Hidden& hidden : all)
    answer.achieved_size = &hidden == &all.front()
                               ? hidden.achieved_size
                               : std::min(answer.achieved_size, hidden.achieved_size);
  if (all.size() == 1) answer.true_share = all.front().share_of_force;
}

Answer ask_curves(const Question& question) {
  Answer answer;
  auto twin = twin::make_twin(question.twin);
  if (!twin) {
    answer.trouble = twin.error().message;
    return answer;
  }
  take_over_hidden(twin->hidden, answer);
  const auto found = diagnose_twin(*twin);
  if (found) {
    take_over(*found, answer);
    if (question.compare)
      compare(
          question, *found,
          [&](const diagnosis::Options& options) { return diagnose_twin(*twin, options); }, answer);
    if (question.resolve) resolve(question, *found, answer);
  } else {
    answer.trouble = found.error().message;
  }
  return answer;
}

Expected<diagnosis::SheetDiagnosis> diagnose_sheets(const twin::SheetTwins& twins,
                                                    const diagnosis::Options& options = {}) {
  diagnosis::SheetRequest request = request_of(twins);
  request.options = options;
  return diagnosis::diagnose_sheets(request, diagnosis::Control());
}

/// The same of sheets.
void resolve(const Question& question, const twin::SheetTwins& twins,
             const diagnosis::SheetDiagnosis& found, Answer& answer) {
  const diagnosis::Design* design = proposed_by(found, answer);
  if (design == nullptr) return;
  const auto plan = planned(*design, twins.suite);
  if (!plan) return;
  const auto more = twin::make_sheets(question.twin, {*plan});
  if (!more) return;
  const auto again = diagnose_sheets(*more);
  if (again) take_over_next(*again, answer);
}

Answer ask_sheets(const Question& question) {
  Answer answer;
  const auto twins = twin::make_sheets(question.twin);
  if (!twins) {
    answer.trouble = twins.error().message;
    return answer;
  }
  take_over_hidden(twins->hidden, answer);
  const auto found = diagnose_sheets(*twins);
  if (found) {
    take_over(*found, answer);
    if (question.compare)
      compare(
          question, *found,
          [&](const diagnosis::Options& options) { return diagnose_sheets(*twins, options); },
          answer);
    if (question.resolve) resolve(question, *twins, *found, answer);
  } else {
    answer.trouble = found.error().message;
  }
  return answer;
}

}  // namespace

Answer ask(const Question& question) {
  const auto start = std::chrono::steady_clock::now();
  Answer answer =
      twin::is_sheet_suite(question.twin.suite) ? ask_sheets(question) : ask_curves(question);
  answer.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return answer;
}

}  // namespace tenter::exam
