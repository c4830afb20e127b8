// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/answer.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "common/model/presets.h"
#include "server/diagnosis/diagnose.h"
#include "server/diagnosis/verdicts.h"
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

void take_over(const diagnosis::Diagnosis& found, Answer& answer) {
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

Answer ask(const Question& question) {
  Answer answer;
  const auto start = std::chrono::steady_clock::now();
  auto twin = twin::make_twin(question.twin);
  if (!twin) {
    answer.trouble = twin.error().message;
    return answer;
  }
  answer.achieved_size = twin->achieved_size;
  auto baseline = model::preset(twin->baseline_preset);
  if (!baseline) {
    answer.trouble = baseline.error().message;
    return answer;
  }
  diagnosis::Request request;
  request.model = *baseline;
  for (std::size_t i = 0; i < twin->captures.size(); ++i)
    request.captures.emplace_back("twin" + std::to_string(i), std::move(twin->captures[i]));
  const auto found = diagnosis::diagnose(request, diagnosis::Control());
  if (found) {
    take_over(*found, answer);
  } else {
    answer.trouble = found.error().message;
  }
  answer.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return answer;
}

}  // namespace tenter::exam
