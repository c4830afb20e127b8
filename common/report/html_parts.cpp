// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_parts.h"

#include <algorithm>
#include <cstdio>

#include "common/report/html_text.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

std::string navigation(const std::string& body, std::span<const PageSection> sections) {
  std::string links;
  for (const auto& [anchor, words] : sections)
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

}  // namespace

std::string badge(const std::string& css, const std::string& words) {
  return "<span class=\"badge " + css + "\">" + escape_html(words) + "</span>";
}

std::string meter(std::optional<double> value, double full, const char* css,
                  std::optional<double> lo, std::optional<double> hi, std::optional<double> limit) {
  if (!value || !(full > 0.0)) return "";
  constexpr double kWidth = 150.0;
  const auto at = [full](double v) { return kWidth * std::clamp(v / full, 0.0, 1.0); };
  char shapes[400];
  std::snprintf(shapes, sizeof shapes,
                "<rect class=\"track\" width=\"%g\" height=\"9\" rx=\"2\"/><rect class=\"%s\" "
                "width=\"%.1f\" height=\"9\" rx=\"2\"/>",
                kWidth, css, at(*value));
  std::string svg = shapes;
  if (lo && hi) {
    std::snprintf(shapes, sizeof shapes,
                  "<path class=\"whisker\" d=\"M%.1f 4.5H%.1fM%.1f 1.5v6M%.1f 1.5v6\"/>", at(*lo),
                  at(*hi), at(*lo), at(*hi));
    svg += shapes;
  }
  if (limit) {
    std::snprintf(shapes, sizeof shapes, "<path class=\"limit\" d=\"M%.1f 0v9\"/>", at(*limit));
    svg += shapes;
  }
  return "<svg class=\"meter\" width=\"150\" height=\"9\" viewBox=\"0 0 150 9\" "
         "aria-hidden=\"true\">" +
         svg + "</svg>";
}

std::string cell(const std::string& html) {
  return "<td>" + html + "</td>";
}
std::string number_cell(const std::string& html) {
  return "<td class=\"n\">" + html + "</td>";
}

std::string panel(const std::string& anchor, const std::string& title, const std::string& note,
                  const std::string& head, const std::string& rows) {
  if (rows.empty()) return "";
  return "<section id=\"" + anchor + "\">\n<h2>" + title + "</h2>\n" +
         (note.empty() ? "" : "<p class=\"soft\">" + note + "</p>\n") +
         "<div class=\"panel\"><table>\n<thead><tr>" + head + "</tr></thead>\n<tbody>\n" + rows +
         "</tbody>\n</table></div>\n</section>\n";
}

std::string card(const std::string& name, const std::string& value, const std::string& note) {
  return "<div class=\"card\"><div class=\"name\">" + name + "</div><div class=\"value\">" + value +
         "</div><div class=\"note\">" + note + "</div></div>\n";
}

std::string page_header(const Json& result, const std::string& over, const std::string& title,
                        std::span<const PageSection> sections, const std::string& details) {
  return "<header>\n<div class=\"over\">" + escape_html(over) + "</div>\n<h1>" +
         unbroken(escape_html(title)) + "</h1>\n" + synthetic_note(result) +
         navigation(details, sections) + "</header>\n";
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

}  // namespace tenter::report
