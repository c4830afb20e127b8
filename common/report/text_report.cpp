// SPDX-License-Identifier: Apache-2.0
#include "common/report/text_report.h"

#include <algorithm>
#include <sstream>

#include "common/report/summary.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

constexpr const char* kIndent = "                ";  // under the words of a verdict

std::string padded(const std::string& text, std::size_t width) {
  const std::size_t used = columns(text);
  return used >= width ? text : text + std::string(width - used, ' ');
}

std::string right(const std::string& text, std::size_t width) {
  const std::size_t used = columns(text);
  return used >= width ? text : std::string(width - used, ' ') + text;
}

std::string wrapped(const std::string& text, const std::string& indent, int width) {
  std::istringstream words(text);
  std::string word, line, out;
  const std::size_t room =
      static_cast<std::size_t>(std::max(30, width)) - std::min<std::size_t>(indent.size(), 29);
  while (words >> word) {
    if (!line.empty() && columns(line) + 1 + columns(word) > room) {
      out += indent + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return line.empty() ? out : out + indent + line + "\n";
}

std::string coloured(const std::string& text, const char* code, bool on) {
  return on ? "\x1b[" + std::string(code) + "m" + text + "\x1b[0m" : text;
}

const char* colour_of(const std::string& verdict) {
  if (verdict == "NAMED") return "1;34";
  if (verdict == "NOTHING_FOUND" || verdict == "OK") return "32";
  if (verdict == "AMBIGUOUS" || verdict == "WARNING") return "33";
  if (verdict == "SENSOR") return "35";
  if (verdict == "UNEXPLAINED" || verdict == "NUMERICAL" || verdict == "ERROR") return "31";
  return "2";
}

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

std::string printable(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const unsigned char byte = static_cast<unsigned char>(text[i]);
    // C1 controls (U+0080 to U+009F) are two bytes in UTF-8 and some terminals obey them
    if (byte == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0) {
      ++i;
      continue;
    }
    if (byte == '\n' || byte == '\t')
      out += ' ';
    else if (byte >= 0x20 && byte != 0x7f)
      out += text[i];
  }
  return out;
}

std::size_t columns(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

Expected<std::string> render_text(const std::string& result_json, const TextStyle& style) {
  const Expected<Json> parsed = parse_result(result_json);
  if (!parsed) return tl::unexpected(parsed.error());
  const Json& result = *parsed;

  std::string first = wrapped(printable(headline(result)), "", style.width);
  if (!first.empty()) first.pop_back();
  std::string out = coloured(first, "1", style.colour) + "\n" +
                    coloured(printable(subject(result)), "2", style.colour) + "\n\n";
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
  out += capture_lines(result);

  std::string notes;
  for (const char* level : {"ERROR", "WARNING"})
    for (const Json& entry : list(result, "checklist"))
      if (text(entry, "level") == level) {
        const std::string why = printable(text(entry, "why"));
        notes += "  " + coloured(padded(level, 13), colour_of(level), style.colour) + " " +
                 printable(text(entry, "what")) + "\n" + wrapped(why, kIndent, style.width);
      }
  if (!notes.empty()) out += "\n" + notes;
  return out;
}

}  // namespace tenter::report
