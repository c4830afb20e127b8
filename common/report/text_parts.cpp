// SPDX-License-Identifier: Apache-2.0
#include "common/report/text_parts.h"

#include "common/report/words.h"

#include <algorithm>
#include <sstream>

namespace tenter::report {

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

std::string title_text(const std::string& headline, const std::string& subject,
                       const TextStyle& style) {
  std::string first = wrapped(printable(headline), "", style.width);
  if (!first.empty()) first.pop_back();
  return coloured(first, "1", style.colour) + "\n" +
         coloured(printable(subject), "2", style.colour) + "\n\n";
}

std::string profile_range(const Json& profile) {
  const std::optional<double> lo = number(profile, "lo");
  const std::optional<double> hi = number(profile, "hi");
  if (lo && hi) return significant(lo) + " to " + significant(hi);
  if (lo) return "above " + significant(lo);
  return hi ? "below " + significant(hi) : "no end found";
}

std::string checklist_text(const Json& result, const TextStyle& style) {
  std::string notes;
  for (const char* level : {"ERROR", "WARNING"})
    for (const Json& entry : list(result, "checklist"))
      if (text(entry, "level") == level) {
        const std::string why = printable(text(entry, "why"));
        notes += "  " + coloured(padded(level, 13), colour_of(level), style.colour) + " " +
                 printable(text(entry, "what")) + "\n" + wrapped(why, kIndent, style.width);
      }
  return notes.empty() ? "" : "\n" + notes;
}

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

}  // namespace tenter::report
