// SPDX-License-Identifier: Apache-2.0
#include "common/report/sheet/sheet_report.h"

#include <algorithm>

#include "common/report/html_figures.h"
#include "common/report/html_page.h"
#include "common/report/html_parts.h"
#include "common/report/html_tables.h"
#include "common/report/sheet/curves.h"
#include "common/report/sheet/document.h"
#include "common/report/sheet/mesh_svg.h"
#include "common/report/sheet/requests/requests.h"
#include "common/report/sheet/tables.h"
#include "common/report/text_parts.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

namespace {

constexpr PageSection kSections[] = {{"captures", "Captures"},     {"curves", "Curves"},
                                     {"loops", "Loops"},           {"residuals", "Residuals"},
                                     {"figures", "Figures"},       {"sheets", "The sheet"},
                                     {"stages", "Stages"},         {"grid-error", "Grid error"},
                                     {"starts", "Starts"},         {"convexity", "Convexity"},
                                     {"samples", "Samples"},       {"limit", "Limit"},
                                     {"parameters", "Parameters"}, {"correlations", "Correlations"},
                                     {"model", "Model"},           {"checklist", "Checklist"}};

/// "force  12.1 mN -> 3.2 mN  1.1 sigma" cells of a line.
std::string error_words(const Json& errors, const char* unit) {
  std::string words = change(errors, unit, " -> ");
  if (number(errors, "after_sigmas")) words += "  (" + sigmas(number(errors, "after_sigmas")) + ")";
  return words;
}

std::string total_line(const Json& result, const char* key, const std::string& name) {
  const Json& of = member(result, key);
  if (!of.is_object()) return "";
  return "  " + padded(name, 13) + " force " + error_words(member(of, "force"), "N") +
         "   position " + error_words(member(of, "position"), "m") + "\n";
}

std::string capture_lines(const Json& result) {
  const Json& captures = list(result, "captures");
  if (captures.empty()) return "";
  const auto title_of = [](const Json& capture) {
    return printable(text(capture, "title")) + (flag(capture, "synthetic") ? " [SYNTHETIC]" : "") +
           (flag(capture, "held_out") ? " [HELD OUT]" : "");
  };
  std::size_t width = 8;
  for (const Json& capture : captures) width = std::max(width, columns(title_of(capture)));
  width = std::min<std::size_t>(width, 44);
  std::string out = "\n  " + padded("capture", width) + "  " + padded("role", 12) +
                    right("frames", 7) + right("force", 24) + right("position", 26) + "\n";
  for (const bool held_out : {false, true})
    for (const Json& capture : captures) {
      if (flag(capture, "held_out") != held_out) continue;
      out += "  " + padded(title_of(capture), width) + "  " +
             padded(effect_words(printable(text(capture, "role"))), 12) +
             right(significant(number(capture, "frames")), 7) +
             right(change(member(capture, "force"), "N", " -> "), 24) +
             right(change(member(capture, "position"), "m", " -> "), 26) + "\n";
      const std::size_t dropped = list(capture, "dropped").size();
      if (dropped > 0)
        out +=
            "  " + std::string(width, ' ') + "  " + std::to_string(dropped) + " frames dropped\n";
    }
  return out;
}

std::string stage_lines(const Json& result) {
  const Json& stages = list(result, "stages");
  if (stages.empty()) return "";
  std::size_t width = 8;
  for (const Json& stage : stages) width = std::max(width, columns(printable(text(stage, "name"))));
  width = std::min<std::size_t>(width, 44);
  std::string out =
      "\n  " + padded("stage", width) + right("iterations", 12) + right("cost", 26) + "\n";
  for (const Json& stage : stages)
    out += "  " + padded(effect_words(printable(text(stage, "name"))), width) +
           right(significant(number(stage, "iterations")), 12) +
           right(significant(number(stage, "cost_before")) + " -> " +
                     significant(number(stage, "cost_after")),
                 26) +
           (flag(stage, "done") ? "" : "  not done") + "\n";
  return out;
}

/// Where the fit was asked for profile likelihoods.
std::string profile_lines(const Json& result) {
  std::string out;
  for (const Json& entry : list(result, "parameters")) {
    const Json& profile = member(entry, "profile");
    if (!profile.is_object()) continue;
    out += "  " + padded(printable(text(entry, "name")), 32) +
           right(significant(number(entry, "value")), 12) + "  " +
           padded(verdict_words(printable(text(profile, "word"))), 11) + "  " +
           profile_range(profile) + "\n";
  }
  if (out.empty()) return "";
  return "\n  " + padded("parameter", 32) + right("value", 12) + "  profile likelihood, 95 %\n" +
         out;
}

}  // namespace

std::string render_page(const Json& result) {
  const std::string details =
      capture_table(result) + curve_section(result) +
      figure_sections(result, {"starting model", "fitted model", true}) + mesh_section(result) +
      stage_table(result) + grid_error_section(result) + start_section(result) +
      convexity_section(result) + sample_section(result) + limit_section(result) +
      parameter_table(result) + correlation_table(result) + model_table(result) +
      checklist_table(result);
  std::string body = page_header(result, subject(result), headline(result), kSections, details);
  body += error_cards(result) + details;
  body += "<footer>" + fit_note(result) +
          "<p>Errors are root mean squares of measured minus model, over clip forces and over "
          "the coordinates of points. All units are SI; membrane stress is force per "
          "width.</p></footer>\n";
  return html_page(headline(result), body);
}

std::string render_words(const Json& result, const TextStyle& style) {
  std::string out = title_text(headline(result), subject(result), style);
  out += total_line(result, "fitted", "error");
  out += total_line(result, "held_out", "held out");
  out += request_lines(result);
  return out + capture_lines(result) + stage_lines(result) + profile_lines(result) +
         checklist_text(result, style);
}

}  // namespace tenter::report::sheet
