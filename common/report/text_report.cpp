// SPDX-License-Identifier: Apache-2.0
#include "common/report/text_report.h"

#include <algorithm>

#include "common/report/friction/friction_section.h"
#include "common/report/sheet/sheet_report.h"
#include "common/report/summary.h"
#include "common/report/text_parts.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

std::string verdict_text(const Json& entry, const TextStyle& style) {
  std::string verdict = printable(text(entry, "verdict"));
  const char* colour = colour_of(verdict);
  std::replace(verdict.begin(), verdict.end(), '_', ' ');
  const std::string effect = printable(text(entry, "effect"));
  std::string line = effect.empty() ? "" : effect_words(effect);
  const auto add = [&line](const std::string& more) {
    if (!more.empty()) line += (line.empty() ? "" : "  ") + more;
  };
  if (number(entry, "size")) {
    const Json& interval = list(entry, "interval");
    add(percent(number(entry, "size")) + " of the force");
    if (interval.size() == 2 && number(interval[0]) && number(interval[1]))
      line += " (" + percent_interval(number(interval[0]), number(interval[1])) + ")";
  }
  add(p_value(number(entry, "p_value")));
  std::string out = "  " + coloured(padded(verdict, 13), colour, style.colour) + " " + line + "\n";
  out += wrapped(printable(text(entry, "words")), kIndent, style.width);
  std::vector<std::string> others;
  for (const Json& other : list(entry, "alternatives"))
    others.push_back(effect_words(printable(text(other))));
  if (!others.empty())
    out += wrapped("Could also be " + joined(others, "or") + ".", kIndent, style.width);
  const Json& next = member(entry, "next_protocol");
  if (next.is_object())
    out += wrapped("Next capture: " + effect_words(printable(text(next, "name"))) + ". " +
                       printable(text(next, "words")),
                   kIndent, style.width);
  return out;
}

/// All that the captures could not have shown, together.
std::string not_excited_text(const Json& result, const TextStyle& style) {
  std::vector<std::string> effects, nexts;
  for (const Json& entry : list(result, "verdicts")) {
    if (text(entry, "verdict") != "NOT_EXCITED") continue;
    effects.push_back(effect_words(printable(text(entry, "effect"))));
    const std::string next = effect_words(printable(text(member(entry, "next_protocol"), "name")));
    if (!next.empty() && std::find(nexts.begin(), nexts.end(), next) == nexts.end())
      nexts.push_back(next);
  }
  if (effects.empty()) return "";
  std::string words = "These captures cannot show " + joined(effects, "or") + ".";
  if (!nexts.empty()) words += " Captures that would: " + joined(nexts, "and") + ".";
  std::string out = wrapped(words, kIndent, style.width);
  out.replace(
      0, std::string(kIndent).size(),
      "  " + coloured(padded("NOT EXCITED", 13), colour_of("NOT_EXCITED"), style.colour) + " ");
  return out;
}

std::string change_line(const Json& result, const std::string& name, const char* before,
                        const char* after, const std::string& note) {
  const std::optional<double> first = number(result, before);
  const std::optional<double> last = number(result, after);
  if (!first && !last) return "";
  std::string value = percent(first ? first : last);
  if (first && last && first != last) value += " -> " + percent(last);
  return "  " + padded(name, 13) + " " + value + (note.empty() ? "" : "   " + note) + "\n";
}

std::string capture_lines(const Json& result) {
  const Json& captures = list(result, "captures");
  if (captures.empty()) return "";
  std::size_t width = 8;
  const auto title_of = [](const Json& capture) {
    return printable(text(capture, "title")) + (flag(capture, "synthetic") ? " [SYNTHETIC]" : "");
  };
  for (const Json& capture : captures) width = std::max(width, columns(title_of(capture)));
  width = std::min<std::size_t>(width, 60);
  const auto change = [](const Json& capture, const char* before, const char* after) {
    const std::optional<double> first = number(capture, before);
    const std::optional<double> last = number(capture, after);
    if (first && last && first != last) return percent(first) + " -> " + percent(last);
    return percent(first ? first : last);
  };
  std::string out = "\n  " + padded("capture", width) + right("noise", 9) + right("error", 20) +
                    right("held out", 20) + "\n";
  for (const Json& capture : captures)
    out += "  " + padded(title_of(capture), width) +
           right(percent(number(capture, "noise_floor")), 9) +
           right(change(capture, "error_before", "error_after"), 20) +
           right(change(capture, "held_out_before", "held_out_after"), 20) + "\n";
  return out;
}

}  // namespace

Expected<std::string> render_text(const std::string& result_json, const TextStyle& style) {
  const Expected<Json> parsed = parse_result(result_json);
  if (!parsed) return tl::unexpected(parsed.error());
  const Json& result = *parsed;
  if (text(result, "schema") == sheet::kSchema) return sheet::render_words(result, style);

  std::string out = title_text(headline(result), subject(result), style);
  for (const Json& entry : list(result, "verdicts"))
    if (text(entry, "verdict") != "NOT_EXCITED") out += verdict_text(entry, style);
  out += not_excited_text(result, style);
  if (!list(result, "verdicts").empty()) out += "\n";

  const std::optional<double> floor = number(result, "noise_floor");
  out += change_line(result, "error", "error_before", "error_after",
                     floor ? "noise floor " + percent(floor) : "");
  const std::string kind = printable(text(result, "held_out_kind"));
  out += change_line(result, "held out", "held_out_before", "held_out_after",
                     kind.empty() ? "" : "left out in turn: " + kind);
  if (number(result, "unexplained_share"))
    out += "  " + padded("unexplained", 13) + " " + percent(number(result, "unexplained_share")) +
           " of what the baseline missed\n";
  out += friction_text(result, style);
  out += capture_lines(result);

  out += checklist_text(result, style);
  return out;
}

}  // namespace tenter::report
