// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_report.h"

#include "common/report/html_figures.h"
#include "common/report/html_page.h"
#include "common/report/html_tables.h"
#include "common/report/html_text.h"
#include "common/report/summary.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

std::string navigation(const std::string& body) {
  static constexpr const char* kSections[][2] = {
      {"captures", "Captures"},   {"loops", "Loops"},   {"transverse", "Transverse"},
      {"residuals", "Residuals"}, {"model", "Model"},   {"parameters", "Parameters"},
      {"path", "How it grew"},    {"screen", "Screen"}, {"checklist", "Checklist"},
      {"figures", "More figures"}};
  std::string links;
  for (const auto& [anchor, words] : kSections)
    if (body.find("<section id=\"" + std::string(anchor) + "\"") != std::string::npos)
      links += "<a href=\"#" + std::string(anchor) + "\">" + words + "</a>\n";
  return links.empty() ? "" : "<nav>" + links + "</nav>\n";
}

/// Headlines break between words, not within "first-cycle".
std::string unbroken(std::string html) {
  for (std::size_t at = html.find('-'); at != std::string::npos; at = html.find('-', at + 1))
    html.replace(at, 1, "\u2011");
  return html;
}

std::string synthetic_note(const Json& result) {
  std::size_t synthetic = 0;
  for (const Json& capture : list(result, "captures"))
    synthetic += flag(capture, "synthetic") ? 1 : 0;
  if (synthetic == 0) return "";
  const std::size_t all = list(result, "captures").size();
  const std::string which = synthetic == all ? (all == 1 ? "The capture is" : "All captures are")
                            : synthetic == 1 ? "One of the captures is"
                                             : std::to_string(synthetic) + " of the captures are";
  return "<p><span class=\"badge synthetic\">SYNTHETIC</span> " + which +
         " made by a generator, not measured.</p>\n";
}

std::string fit_note(const Json& result) {
  const Json& fit = member(result, "fit");
  if (!fit.is_object()) return "";
  std::string words = "Final fit: ";
  words += text(fit, "status").empty() ? "done" : effect_words(text(fit, "status"));
  if (const std::optional<double> n = number(fit, "iterations"))
    words += ", " + significant(n) + " iterations";
  if (const std::optional<double> cost = number(fit, "cost"))
    words += ", cost " + significant(cost);
  if (!text(fit, "message").empty()) words += ". " + text(fit, "message");
  return "<p>" + escape_html(words) + "</p>\n";
}

}  // namespace

Expected<std::string> render_html(const std::string& result_json) {
  const Expected<Json> parsed = parse_result(result_json);
  if (!parsed) return tl::unexpected(parsed.error());
  const Json& result = *parsed;

  const std::string details = capture_table(result) + figure_sections(result) +
                              model_table(result) + parameter_table(result) + path_table(result) +
                              screen_table(result) + checklist_table(result);
  std::string body = "<header>\n<div class=\"over\">" + escape_html(subject(result)) +
                     "</div>\n<h1>" + unbroken(escape_html(headline(result))) + "</h1>\n" +
                     synthetic_note(result) + navigation(details) + "</header>\n";
  body += summary_cards(result) + verdict_table(result) + details;
  body += "<footer>" + fit_note(result) +
          "<p>Errors are rms(measured \u2212 model) / rms(measured) over all stress channels. "
          "All units are SI; membrane stress is force per width.</p></footer>\n";
  return html_page(headline(result), body);
}

}  // namespace tenter::report
