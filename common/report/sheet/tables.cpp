// SPDX-License-Identifier: Apache-2.0
#include "common/report/sheet/tables.h"

#include <cstdio>

#include "common/report/html_parts.h"
#include "common/report/html_text.h"
#include "common/report/sheet/document.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

namespace {

std::string whole(const Json& value) {
  const std::optional<double> count = number(value);
  if (!count) return significant(count);
  char words[40];
  std::snprintf(words, sizeof words, "%.0f", *count);
  return words;
}

/// Before and after, and below them the same in standard deviations of a reading.
std::string error_cell(const Json& errors, const char* unit) {
  if (!errors.is_object()) return number_cell(significant({}));
  std::string html = change(errors, unit, kArrow);
  const std::optional<double> before = number(errors, "before_sigmas");
  const std::optional<double> after = number(errors, "after_sigmas");
  if (before && after)
    html += "<div class=\"soft over\">" + sigmas(before) + kArrow + sigmas(after) + "</div>";
  return number_cell(html);
}

std::string noise_cell(const Json& capture) {
  std::string html;
  for (const auto& [key, unit] : {std::pair{"force", "N"}, std::pair{"position", "m"}}) {
    const std::optional<double> sigma = number(member(capture, key), "sigma");
    if (sigma) html += (html.empty() ? "" : "<br>") + quantity(sigma, unit);
  }
  return number_cell(html.empty() ? significant({}) : html);
}

/// What a capture did not give to the fit: dropped frames by reason, then the notes.
std::string left_out(const Json& capture) {
  std::string html;
  const Json& dropped = list(capture, "dropped");
  if (!dropped.empty()) {
    std::string rows;
    for (const Json& frame : dropped)
      rows += "<li>frame " + whole(member(frame, "frame")) + ": " +
              escape_html(text(frame, "reason")) + "</li>";
    html += "<details><summary>" + std::to_string(dropped.size()) +
            (dropped.size() == 1 ? " frame" : " frames") + " dropped</summary><ul>" + rows +
            "</ul></details>";
  }
  std::string notes;
  for (const Json& note : list(capture, "notes"))
    notes += "<li>" + escape_html(text(note)) + "</li>";
  if (!notes.empty()) html += "<details><summary>Notes</summary><ul>" + notes + "</ul></details>";
  return html;
}

std::string capture_row(const Json& capture) {
  std::string title = escape_html(text(capture, "title"));
  if (flag(capture, "synthetic")) title += " " + badge("synthetic", "SYNTHETIC");
  if (flag(capture, "held_out")) title += " " + badge("named", "HELD OUT");
  std::string origin;
  for (const char* key : {"specimen", "material"})
    if (!text(capture, key).empty())
      origin += (origin.empty() ? "" : ", ") + escape_html(text(capture, key));
  const std::string licence = text(capture, "licence");
  origin += (origin.empty() ? "" : "; ") +
            (licence.empty() ? "licence not stated" : "licence " + escape_html(licence));
  title += "<div class=\"soft over\">" + origin + "; <code>" +
           escape_html(text(capture, "id").substr(0, 12)) + "</code></div>" + left_out(capture);
  return "<tr>" + cell(title) + cell(escape_html(effect_words(text(capture, "role")))) +
         number_cell(whole(member(capture, "frames"))) +
         number_cell(whole(member(capture, "rows"))) +
         number_cell(significant(number(capture, "weight"))) + noise_cell(capture) +
         error_cell(member(capture, "force"), "N") + error_cell(member(capture, "position"), "m") +
         "</tr>\n";
}

std::string error_card(const std::string& name, const Json& errors, const char* unit,
                       const std::string& otherwise) {
  if (!number(errors, "rms_after")) return card(name, significant({}), otherwise);
  std::string value = quantity(number(errors, "rms_after"), unit);
  const std::optional<double> before = number(errors, "rms_before");
  if (before && before != number(errors, "rms_after"))
    value = "<span class=\"from\">" + quantity(before, unit) + kArrow + "</span>" + value;
  std::string note = "noise " + quantity(number(errors, "sigma"), unit);
  if (number(errors, "after_sigmas")) note += "; " + sigmas(number(errors, "after_sigmas"));
  return card(name, value, note);
}

std::string name_list(const Json& names) {
  std::vector<std::string> codes;
  for (const Json& name : names) codes.push_back("<code>" + escape_html(text(name)) + "</code>");
  return joined(codes);
}

std::string stage_row(const Json& stage, int number_of) {
  std::string what = "<span class=\"cause\">" + escape_html(effect_words(text(stage, "name"))) +
                     "</span><div class=\"soft over\">" + name_list(list(stage, "terms")) +
                     "</div>";
  if (flag(stage, "guessed"))
    what +=
        "<div class=\"soft over\">started from what the forces say at the measured places</div>";
  const std::string message = text(stage, "message");
  if (!message.empty()) what += "<div class=\"soft over\">" + escape_html(message) + "</div>";
  std::string limits;
  for (const auto& [key, words] :
       {std::pair{"at_bound", "at a bound: "}, std::pair{"flat", "not determined: "},
        std::pair{"zero_gradient", "without effect: "}})
    if (!list(stage, key).empty())
      limits += std::string("<div>") + words + name_list(list(stage, key)) + "</div>";
  for (const Json& frame : list(stage, "dropped"))
    limits += "<div>" + escape_html(text(frame, "capture")) + ", frame " +
              whole(member(frame, "frame")) + " dropped: " + escape_html(text(frame, "reason")) +
              "</div>";
  const bool done = flag(stage, "done");
  return "<tr>" + number_cell(std::to_string(number_of)) + cell(what) +
         number_cell(significant(number(stage, "cost_before")) + kArrow +
                     significant(number(stage, "cost_after"))) +
         number_cell(whole(member(stage, "iterations"))) +
         cell(badge(done ? "good" : "warn", done ? "done" : "not done")) +
         number_cell(whole(member(stage, "control_points"))) + cell(limits) + "</tr>\n";
}

}  // namespace

std::string error_cards(const Json& result) {
  const Json& fitted = member(result, "fitted");
  const Json& held_out = member(result, "held_out");
  std::string html = "<div class=\"cards\">\n";
  html += error_card("Force error", member(fitted, "force"), "N", "no force was compared");
  html += error_card("Position error", member(fitted, "position"), "m", "no position was compared");
  html +=
      error_card("Force error, held out", member(held_out, "force"), "N", "nothing was left out");
  html += error_card("Position error, held out", member(held_out, "position"), "m",
                     "nothing was left out");
  return html + "</div>\n";
}

std::string capture_table(const Json& result) {
  std::string rows;
  // what the fit never saw stands together at the end
  for (const bool held_out : {false, true})
    for (const Json& capture : list(result, "captures"))
      if (flag(capture, "held_out") == held_out) rows += capture_row(capture);
  return panel("captures", "Captures",
               "Root mean square of measured minus model, from the starting model to the fitted "
               "one, and below it in standard deviations of a reading.",
               "<th>Capture</th><th>Role</th><th class=\"n\">Frames</th><th class=\"n\">Rows</th>"
               "<th class=\"n\">Weight</th><th class=\"n\">Noise</th><th class=\"n\">Force</th>"
               "<th class=\"n\">Position</th>",
               rows);
}

std::string stage_table(const Json& result) {
  std::string rows;
  int index = 0;
  for (const Json& stage : list(result, "stages")) rows += stage_row(stage, ++index);
  return panel("stages", "Stages", "What was fitted, in this order, and what each stage left.",
               "<th class=\"n\">Stage</th><th>What was fitted</th><th class=\"n\">Cost</th><th "
               "class=\"n\">Iterations</th><th></th><th class=\"n\">Control points</th><th>At the "
               "limits</th>",
               rows);
}

std::string correlation_table(const Json& result) {
  std::string rows;
  for (const Json& pair : list(result, "correlations"))
    rows += "<tr>" + cell("<code>" + escape_html(text(pair, "a")) + "</code>") +
            cell("<code>" + escape_html(text(pair, "b")) + "</code>") +
            number_cell(significant(number(pair, "value"))) + "</tr>\n";
  return panel("correlations", "Correlations",
               "Pairs above 0.9: the captures hardly tell one from the other.",
               "<th>Parameter</th><th>Parameter</th><th class=\"n\">Correlation</th>", rows);
}

}  // namespace tenter::report::sheet
