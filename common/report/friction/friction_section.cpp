// SPDX-License-Identifier: Apache-2.0
#include "common/report/friction/friction_section.h"

#include <vector>

#include "common/report/html_parts.h"
#include "common/report/html_text.h"
#include "common/report/text_parts.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

constexpr const char* kDash = "\u2013";

const Json& parts_of(const Json& result) {
  return list(member(result, "friction_test"), "parts");
}

std::string protocol_of(const Json& result) {
  return text(member(result, "friction_test"), "protocol");
}

/// "Warp, positive sense".
std::string name_of(const Json& part) {
  std::string name = text(part, "direction");
  if (!name.empty()) name[0] = static_cast<char>(name[0] - 'a' + 'A');
  const std::string sense = text(part, "sense");
  return sense.empty() ? name : name + ", " + sense + " sense";
}

std::string with_unit(const Json& number_of_test) {
  const std::string unit = text(number_of_test, "unit");
  return significant(number(number_of_test, "value")) + (unit == "1" ? "" : " " + unit);
}

std::string interval_of(const Json& number_of_test) {
  const Json& ends = list(number_of_test, "interval");
  if (ends.size() != 2) return kDash;
  const auto lo = number(ends[0]);
  const auto hi = number(ends[1]);
  if (lo && hi) return significant(lo) + " to " + significant(hi);
  if (lo) return "above " + significant(lo);
  return hi ? "below " + significant(hi) : kDash;
}

/// What stands beside the numbers of a part, a sentence each.
std::vector<std::string> notes_of(const Json& part) {
  std::vector<std::string> notes;
  const auto count = [&](const char* key) { return number(part, key); };
  if (const auto noise = count("noise"))
    notes.push_back("Noise of one reading " + significant(noise) +
                    (text(part, "noise_unit") == "1" ? "" : " " + text(part, "noise_unit")) +
                    (flag(part, "noise_is_from_fit") ? ", taken from what the model misses" : "") +
                    "; chi-squared per row " + significant(count("chi2_per_row")) + ".");
  if (count("spirals"))
    notes.push_back(significant(count("spirals")) + " spirals, " +
                    significant(count("cantilevers")) + " cantilevers; " +
                    significant(count("samples")) + " samples, " + significant(count("left_out")) +
                    " left out where gravity and elasticity oppose.");
  const Json& alone = member(part, "cantilever");
  if (alone.is_object() && count("spirals").value_or(0.0) > 0.0)
    notes.push_back("Cantilevers alone, as if without friction: k1 " +
                    significant(number(alone, "k1")) + ", k2 " + significant(number(alone, "k2")) +
                    ".");
  if (count("lost_share"))
    notes.push_back("Of the work of loading " + percent(count("lost_share")) +
                    " is lost, of the model's " + percent(count("lost_share_of_model")) +
                    "; the model misses " + percent(count("missed_share")) + " of the load.");
  std::string rate = text(member(part, "rate"), "words");
  if (!rate.empty()) {
    if (rate[0] >= 'a' && rate[0] <= 'z') rate[0] = static_cast<char>(rate[0] - 'a' + 'A');
    notes.push_back(rate);
  }
  if (count("snapped").value_or(0.0) > 0.0)
    notes.push_back(significant(count("snapped")) +
                    " steps snap: the stress falls on the way to the next place of rest.");
  if (count("gains_below").value_or(0.0) > 0.0)
    notes.push_back("Below a strain of " + significant(count("gains_below")) +
                    " a step may gain work.");
  return notes;
}

}  // namespace

std::string measured_words(const Json& result) {
  const std::string protocol = protocol_of(result);
  if (protocol == "spiral") return "all samples of the strain 3 kappa";
  if (protocol == "cantilever") return "all samples of the torque";
  return "all stress channels";
}

std::string friction_headline(const Json& result) {
  std::string words;
  for (const Json& part : parts_of(result)) {
    std::string told;
    std::size_t count = 0;
    for (const Json& n : list(part, "numbers")) {
      if (!flag(n, "told")) continue;
      ++count;
      const std::string name = text(n, "name");
      if (name == "a" || name == "b" || name == "tau")
        told += (told.empty() ? "" : ", ") + name + " = " + with_unit(n);
    }
    words += (words.empty() ? "" : " ") + name_of(part) + ": " + std::to_string(count) + " of " +
             std::to_string(list(part, "numbers").size()) + " numbers are told; " +
             (told.empty() ? "none of friction" : "friction " + told) + ".";
  }
  return words;
}

std::string friction_section(const Json& result) {
  std::string tables;
  for (const Json& part : parts_of(result)) {
    std::string rows;
    for (const Json& n : list(part, "numbers")) {
      const bool is_told = flag(n, "told");
      rows += "<tr>" + cell("<code>" + escape_html(text(n, "name")) + "</code>") +
              number_cell(is_told ? significant(number(n, "value")) : kDash) +
              cell(text(n, "unit") == "1" ? "" : escape_html(text(n, "unit"))) +
              number_cell(interval_of(n)) +
              cell(is_told ? badge("good", "told") : badge("warn", "not told")) +
              cell(escape_html(text(n, "words"))) + "</tr>\n";
    }
    if (rows.empty()) continue;
    tables += "<h3>" + escape_html(name_of(part)) +
              "</h3>\n<div class=\"panel\"><table>\n<thead><tr><th>Number</th><th class=\"n\">Value"
              "</th><th>Unit</th><th class=\"n\">95 % interval</th><th></th><th>What is known</th>"
              "</tr></thead>\n<tbody>\n" +
              rows + "</tbody>\n</table></div>\n";
    for (const std::string& note : notes_of(part))
      tables += "<p class=\"soft\">" + escape_html(note) + "</p>\n";
  }
  if (tables.empty()) return "";
  return "<section id=\"friction\">\n<h2>Internal friction (" + escape_html(protocol_of(result)) +
         ")</h2>\n<p class=\"soft\">Stress (k1 + k2 |eps|) eps + friction of Dahl, sigma_max = a + "
         "b "
         "|eps|, reached over the strain tau.</p>\n" +
         tables + "</section>\n";
}

std::string friction_text(const Json& result, const TextStyle& style) {
  std::string out;
  for (const Json& part : parts_of(result)) {
    out += "\n  " + printable(name_of(part)) + " (" + printable(protocol_of(result)) + ")\n";
    for (const Json& n : list(part, "numbers")) {
      const std::string name = "    " + padded(printable(text(n, "name")), 4);
      if (flag(n, "told"))
        out += name + right(significant(number(n, "value")), 11) + " " +
               padded(text(n, "unit") == "1" ? "" : printable(text(n, "unit")), 6) + "  " +
               interval_of(n) + "\n";
      else
        out += name + "  " +
               coloured(printable(text(n, "words")), colour_of("WARNING"), style.colour) + "\n";
    }
    for (const std::string& note : notes_of(part))
      out += wrapped(printable(note), "    ", style.width);
  }
  return out;
}

}  // namespace tenter::report
