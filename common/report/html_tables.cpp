// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_tables.h"

#include <algorithm>
#include <cstdio>

#include "common/report/html_parts.h"
#include "common/report/html_text.h"
#include "common/report/summary.h"
#include "common/report/text_parts.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

std::string verdict_badge(const std::string& verdict) {
  std::string css = "plain";
  if (verdict == "NAMED") css = "named";
  if (verdict == "NOTHING_FOUND") css = "good";
  if (verdict == "AMBIGUOUS") css = "warn";
  if (verdict == "SENSOR") css = "sensor";
  if (verdict == "UNEXPLAINED" || verdict == "NUMERICAL") css = "bad";
  std::string words = verdict;
  std::replace(words.begin(), words.end(), '_', ' ');
  return badge(css, words);
}

std::string before_after(const Json& object, const char* before, const char* after) {
  const std::optional<double> first = number(object, before);
  const std::optional<double> last = number(object, after);
  if (!first && !last) return percent({});
  if (!first || first == last) return percent(last);
  return percent(first) + kArrow + percent(last);
}

/// A value that may be any JSON, as short text.
std::string plain(const Json& value) {
  if (value.is_string()) return escape_html(text(value));
  if (value.is_number()) return significant(number(value));
  if (value.is_null()) return percent({});
  return escape_html(value.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string next_protocol_html(const Json& next) {
  if (!next.is_object()) return "";
  return "<div class=\"next\"><strong>Next capture: " +
         escape_html(effect_words(text(next, "name"))) + ".</strong> " +
         escape_html(text(next, "words")) + "</div>";
}

std::string phases_html(const Json& next) {
  std::string html;
  for (const Json& phase : list(next, "phases")) {
    std::string words = text(phase, "words");
    if (words.empty()) words = text(phase, "kind");
    html += "<li>" + escape_html(words) + "</li>";
  }
  return html.empty() ? "" : "<ol>" + html + "</ol>";
}

std::string definitions(const Json& object) {
  if (!object.is_object() || object.empty()) return "";
  std::string html = "<dl>";
  for (const auto& [key, value] : object.items())
    html += "<dt>" + escape_html(effect_words(key)) + "</dt><dd>" + plain(value) + "</dd>";
  return html + "</dl>";
}

std::string change_card(const Json& result, const std::string& name, const char* before,
                        const char* after, const char* r2_before, const char* r2_after,
                        const std::string& otherwise, const std::string& more) {
  const std::optional<double> first = number(result, before);
  const std::optional<double> last = number(result, after);
  if (!first && !last) return card(name, percent({}), otherwise);
  std::string value;
  if (first && last && first != last)
    value = "<span class=\"from\">" + percent(first) + kArrow + "</span>" + percent(last);
  else
    value = percent(first ? first : last);
  std::string note;
  const std::optional<double> r2_first = number(result, r2_before);
  const std::optional<double> r2_last = number(result, r2_after);
  if (r2_first && r2_last && r2_first != r2_last)
    note = "R\u00b2 " + significant(*r2_first) + kArrow + significant(*r2_last);
  else if (r2_last)
    note = "R\u00b2 " + significant(*r2_last);
  const std::string joint = note.empty() || more.empty() ? "" : "; ";
  return card(name, value, note + joint + more);
}

/// The two ends of an interval, or none.
std::pair<std::optional<double>, std::optional<double>> ends(const Json& interval) {
  if (interval.size() != 2) return {};
  return {number(interval[0]), number(interval[1])};
}

/// The finding of a verdict: cause, words, what else it could be, what to capture next.
std::string finding_html(const Json& entry) {
  const std::string effect = text(entry, "effect");
  std::string html;
  if (!effect.empty())
    html = "<div><span class=\"cause\">" + escape_html(effect_words(effect)) + "</span> <code>" +
           escape_html(effect) + "</code></div>";
  std::vector<std::string> others;
  for (const Json& other : list(entry, "alternatives"))
    others.push_back(escape_html(effect_words(text(other))));
  std::string words = escape_html(text(entry, "words"));
  if (!others.empty())
    words += " <span class=\"soft\">Could also be " + joined(others, "or") + ".</span>";
  if (!words.empty()) html += "<p>" + words + "</p>";
  return html + next_protocol_html(member(entry, "next_protocol"));
}

std::string verdict_row(const Json& entry, double full) {
  const auto [lo, hi] = ends(list(entry, "interval"));
  std::string what = finding_html(entry);
  const std::string phases = phases_html(member(entry, "next_protocol"));
  const std::string evidence = definitions(member(entry, "evidence"));
  if (!phases.empty() || !evidence.empty())
    what += "<details><summary>" + std::string(phases.empty() ? "Evidence" : "Steps and evidence") +
            "</summary>" + phases + evidence + "</details>";
  const std::string range = percent_interval(lo, hi);
  return "<tr>" + cell(verdict_badge(text(entry, "verdict"))) + cell(what) +
         cell("<span class=\"cause\">" + percent(number(entry, "size")) + "</span>" +
              (range.empty() ? "" : " <span class=\"soft\">" + range + "</span>") +
              meter(number(entry, "size"), full, "full", lo, hi)) +
         number_cell(escape_html(p_value(number(entry, "p_value")))) + "</tr>\n";
}

/// All that the captures could not have shown, in one row that opens.
std::string not_excited_row(const Json& result) {
  std::vector<std::string> names;
  std::string findings;
  for (const Json& entry : list(result, "verdicts")) {
    if (text(entry, "verdict") != "NOT_EXCITED") continue;
    names.push_back("<span class=\"cause\">" + escape_html(effect_words(text(entry, "effect"))) +
                    "</span>");
    findings +=
        "<li>" + finding_html(entry) + phases_html(member(entry, "next_protocol")) + "</li>";
  }
  if (names.empty()) return "";
  return "<tr>" + cell(verdict_badge("NOT_EXCITED")) +
         "<td colspan=\"3\"><p>These captures cannot show " + joined(names, "or") +
         ".</p><details><summary>Why, and the captures that would</summary>" +
         "<ul class=\"findings\">" + findings + "</ul></details></td></tr>\n";
}

/// "bounded: 43.1 to 46.8".
std::string profile_cell(const Json& profile) {
  const std::string word = text(profile, "word");
  if (word.empty()) return cell("");
  return cell(badge(word == "bounded" ? "good" : "warn", verdict_words(word)) +
              "<div class=\"soft\">" + profile_range(profile) + "</div>");
}

}  // namespace

std::string summary_cards(const Json& result) {
  std::string sources;
  for (const Json& capture : list(result, "captures")) {
    const std::string source = text(capture, "noise_source");
    if (!source.empty() && sources.find(source) == std::string::npos)
      sources += (sources.empty() ? "from " : ", ") + source;
  }
  const bool diagnosis = text(result, "kind") == "diagnose";
  const std::string kind = text(result, "held_out_kind");
  std::string html = "<div class=\"cards\">\n";
  html += change_card(
      result,
      diagnosis && extends_baseline(result) ? "Error, baseline \u2192 extended model" : "Error",
      "error_before", "error_after", "r2_before", "r2_after", "not computed", "");
  html += change_card(result, "Error on what the fit never saw", "held_out_before",
                      "held_out_after", "held_out_r2_before", "held_out_r2_after",
                      "nothing was left out", kind.empty() ? "" : "left out: " + escape_html(kind));
  html += card("Noise floor", percent(number(result, "noise_floor")), escape_html(sources));
  if (diagnosis)
    html += card("Unexplained", percent(number(result, "unexplained_share")),
                 "of what the baseline missed");
  return html + "</div>\n";
}

std::string verdict_table(const Json& result) {
  double largest = 0.0;
  for (const Json& entry : list(result, "verdicts")) {
    const auto [lo, hi] = ends(list(entry, "interval"));
    largest = std::max({largest, number(entry, "size").value_or(0.0), hi.value_or(0.0)});
  }
  const double full = largest > 0.5 ? 1.0 : largest > 0.2 ? 0.5 : largest > 0.05 ? 0.2 : 0.05;

  std::string rows;
  for (const Json& entry : list(result, "verdicts"))
    if (text(entry, "verdict") != "NOT_EXCITED") rows += verdict_row(entry, full);
  rows += not_excited_row(result);
  if (rows.empty()) return "";
  return "<section id=\"verdicts\">\n<div class=\"panel\"><table>\n<thead><tr><th>Verdict</th><th>"
         "Finding</th><th class=\"size\">Share of the force</th><th class=\"n\">Chance</th></tr>"
         "</thead>\n<tbody>\n" +
         rows + "</tbody>\n</table></div>\n</section>\n";
}

std::string capture_table(const Json& result) {
  std::string rows;
  for (const Json& capture : list(result, "captures")) {
    std::string title = escape_html(text(capture, "title"));
    if (flag(capture, "synthetic")) title += " " + badge("synthetic", "SYNTHETIC");
    std::string origin;
    for (const char* key : {"specimen", "material"})
      if (!text(capture, key).empty())
        origin += (origin.empty() ? "" : ", ") + escape_html(text(capture, key));
    const std::string licence = text(capture, "licence");
    origin += (origin.empty() ? "" : "; ") +
              (licence.empty() ? "licence not stated" : "licence " + escape_html(licence));
    title += "<div class=\"soft over\">" + origin + "; <code>" +
             escape_html(text(capture, "id").substr(0, 12)) + "</code></div>";
    const std::string source = text(capture, "source");
    if (!source.empty())
      title +=
          "<details class=\"over\"><summary>Source</summary>" + escape_html(source) + "</details>";
    std::string noise = percent(number(capture, "noise_floor"));
    if (!text(capture, "noise_source").empty())
      noise += "<div class=\"soft over\">" + escape_html(text(capture, "noise_source")) + "</div>";
    rows += "<tr>" + cell(title) + number_cell(plain(member(capture, "frames"))) +
            number_cell(plain(member(capture, "blocks"))) + number_cell(noise) +
            number_cell(before_after(capture, "error_before", "error_after")) +
            number_cell(before_after(capture, "held_out_before", "held_out_after")) + "</tr>\n";
  }
  return panel(
      "captures", "Captures", "",
      "<th>Capture</th><th class=\"n\">Frames</th><th class=\"n\">Blocks</th><th "
      "class=\"n\">Noise floor</th><th class=\"n\">Error</th><th class=\"n\">Held out</th>",
      rows);
}

std::string parameter_table(const Json& result) {
  // a column of its own where the fit was asked for profile likelihoods
  const Json& entries = list(result, "parameters");
  const bool has_profiles = std::any_of(entries.begin(), entries.end(), [](const Json& entry) {
    return member(entry, "profile").is_object();
  });
  std::string rows;
  for (const Json& entry : entries) {
    const std::string state = text(entry, "state");
    const Json& interval = list(entry, "interval");
    std::string range = percent({});
    if (interval.size() == 2)
      range = significant(number(interval[0])) + " to " + significant(number(interval[1]));
    const std::optional<double> value = number(entry, "value");
    const std::optional<double> error = number(entry, "std_error");
    std::string relative = percent({});
    if (value && error && *value != 0.0) relative = percent(std::abs(*error / *value));
    const std::string css = state == "free"                     ? "good"
                            : state == "fixed" || state.empty() ? "plain"
                                                                : "warn";
    const std::string held =
        flag(entry, "held") ? "<div class=\"soft over\">held: the captures do not tell it</div>"
                            : "";
    const std::string unit = text(entry, "unit");
    rows += "<tr>" + cell("<code>" + escape_html(text(entry, "name")) + "</code>") +
            number_cell(significant(value)) + cell(unit == "1" ? "" : escape_html(unit)) +
            number_cell(range) + number_cell(relative) +
            cell((state.empty() ? "" : badge(css, verdict_words(state))) + held) +
            (has_profiles ? profile_cell(member(entry, "profile")) : "") + "</tr>\n";
  }
  return panel("parameters", "Parameters", "Of the final model, with 95 % intervals.",
               "<th>Parameter</th><th class=\"n\">Value</th><th>Unit</th><th class=\"n\">Interval"
               "</th><th class=\"n\">Standard error</th><th>State</th>" +
                   std::string(has_profiles ? "<th>Profile likelihood</th>" : ""),
               rows);
}

std::string path_table(const Json& result) {
  double largest = 0.0;
  for (const Json& step : list(result, "path"))
    largest = std::max(
        {largest, number(step, "error").value_or(0.0), number(step, "held_out").value_or(0.0)});
  const std::optional<double> floor = number(result, "noise_floor");
  std::string rows;
  int index = 0;
  for (const Json& step : list(result, "path")) {
    const std::string action = text(step, "action");
    const std::string effect = text(step, "effect");
    const std::string css = action == "add"      ? "good"
                            : action == "reject" ? "warn"
                            : action == "drop"   ? "bad"
                                                 : "plain";
    std::string what = badge(css, action);
    if (!effect.empty())
      what += " <span class=\"cause\">" + escape_html(effect_words(effect)) + "</span>";
    if (!text(step, "why").empty())
      what += "<div class=\"soft\">" + escape_html(text(step, "why")) + "</div>";
    const char* bar = action == "start" ? "old" : "full";
    rows += "<tr>" + number_cell(std::to_string(++index)) + cell(what) +
            cell(percent(number(step, "error")) +
                 meter(number(step, "error"), largest, bar, {}, {}, floor)) +
            cell(percent(number(step, "held_out")) +
                 meter(number(step, "held_out"), largest, bar, {}, {}, floor)) +
            number_cell(plain(member(step, "parameters"))) +
            number_cell(significant(number(step, "bic"))) +
            number_cell(escape_html(p_value(number(step, "p_value")))) + "</tr>\n";
  }
  return panel("path", "How the model grew",
               "One effect at a time, in this order. The mark in the bars is the noise floor.",
               "<th class=\"n\">Step</th><th>What was tried</th><th>Error</th><th>Held out</th><th "
               "class=\"n\">Parameters</th><th class=\"n\">BIC</th><th class=\"n\">Chance</th>",
               rows);
}

std::string screen_table(const Json& result) {
  double largest = 1.0;
  for (const Json& entry : list(result, "screen"))
    largest = std::max(largest, number(entry, "ratio").value_or(0.0));
  std::string rows;
  for (const Json& entry : list(result, "screen")) {
    const std::string effect = text(entry, "effect");
    const std::optional<double> ratio = number(entry, "ratio");
    rows +=
        "<tr>" + cell("<span class=\"cause\">" + escape_html(effect_words(effect)) + "</span>") +
        cell(ratio ? significant(ratio) +
                         meter(ratio, largest, *ratio >= 1.0 ? "full" : "old", {}, {}, 1.0)
                   : percent({})) +
        number_cell(significant(number(entry, "gain"))) + number_cell(plain(member(entry, "df"))) +
        cell("<span class=\"soft\">" + escape_html(text(entry, "status")) + "</span>") + "</tr>\n";
  }
  return panel(
      "screen", "Every cause, screened",
      "Expected gain of each effect without a refit. The ratio is the statistic over the "
      "largest that noise alone reaches in 95 % of null twins (the mark in the bars, at 1).",
      "<th>Effect</th><th>Ratio to the threshold</th><th class=\"n\">Expected fall of "
      "\u03c7\u00b2</th><th class=\"n\">Degrees of freedom</th><th>Status</th>",
      rows);
}

std::string checklist_table(const Json& result) {
  std::string rows;
  for (const char* level : {"ERROR", "WARNING", "OK"})
    for (const Json& entry : list(result, "checklist")) {
      if (text(entry, "level") != level) continue;
      const std::string css = level[0] == 'O' ? "good" : level[0] == 'W' ? "warn" : "bad";
      rows += "<tr>" + cell(badge(css, level)) +
              cell("<span class=\"cause\">" + escape_html(text(entry, "what")) + "</span>") +
              "<td class=\"wide\"><span class=\"soft\">" + escape_html(text(entry, "why")) +
              "</span></td></tr>\n";
    }
  return panel("checklist", "Checklist", "", "<th>Level</th><th>What</th><th>Why</th>", rows);
}

std::string model_table(const Json& result) {
  const Json& model = member(result, "model");
  std::string rows;
  for (const Json& term : list(model, "terms")) {
    const Json& strain = member(term, "strain");
    std::string measure = "<code>" + escape_html(text(strain, "name")) + "</code>";
    if (const std::optional<double> angle = number(strain, "angle_rad")) {
      char degrees[40];
      std::snprintf(degrees, sizeof degrees, " at %.4g\u00b0",
                    *angle * 180.0 / 3.14159265358979323846);
      measure += degrees;
    }
    const std::string effect = text(term, "effect");
    rows += "<tr>" + cell("<code>" + escape_html(text(term, "id")) + "</code>") + cell(measure) +
            cell("<code>" + escape_html(text(member(term, "law"), "name")) + "</code>") +
            cell(effect.empty()
                     ? "<span class=\"soft\">baseline</span>"
                     : "<span class=\"cause\">" + escape_html(effect_words(effect)) + "</span>") +
            "</tr>\n";
  }
  for (const Json& correction : list(model, "corrections"))
    rows += "<tr>" + cell("<code>" + escape_html(text(correction, "id")) + "</code>") +
            cell("<span class=\"soft\">sensor</span>") +
            cell("<code>" + escape_html(text(correction, "type")) + "</code>") +
            cell("<span class=\"cause\">" + escape_html(effect_words(text(correction, "effect"))) +
                 "</span>") +
            "</tr>\n";
  return panel("model", "Model", escape_html(text(model, "description")),
               "<th>Term</th><th>Strain measure</th><th>Law</th><th>Because of</th>", rows);
}

}  // namespace tenter::report
