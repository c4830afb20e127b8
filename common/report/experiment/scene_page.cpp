// SPDX-License-Identifier: Apache-2.0
#include "common/report/experiment/scene_page.h"

#include "common/report/experiment/found.h"
#include "common/report/html_page.h"
#include "common/report/html_parts.h"
#include "common/report/html_text.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

constexpr PageSection kSections[] = {{"figure", "Figure"},
                                     {"numbers", "Numbers"},
                                     {"reactions", "Forces at clips"},
                                     {"energies", "Energies"},
                                     {"parameters", "Parameters"}};

std::string count_words(const Json& result, const char* key) {
  return significant(number(result, key));
}

/// "1152 triangles, 48 bars" of the document's {"triangle": 1152, "bar": 48}.
std::string element_words(const Json& elements) {
  std::vector<std::string> words;
  if (elements.is_object())
    for (const auto& [kind, count] : elements.items())
      words.push_back(significant(number(count)) + " " + effect_words(kind) + "s");
  return joined(words);
}

std::string cards(const Json& result) {
  const Json& frames = list(result, "frames");
  double steps = 0.0, iterations = 0.0;
  for (const Json& frame : frames) {
    steps += number(frame, "steps").value_or(0.0);
    iterations += number(frame, "iterations").value_or(0.0);
  }
  const Json last = frames.empty() ? Json() : frames.back();
  const std::optional<double> time = number(last, "time_s");
  return "<div class=\"cards\">" +
         card("Frames",
              std::to_string(frames.size()) + " of " + count_words(result, "frames_asked"),
              significant(steps) + " steps, " + significant(iterations) + " iterations" +
                  (time ? ", " + significant(time) + " s" : "")) +
         card("Mesh", count_words(result, "nodes") + " nodes",
              escape_html(element_words(member(result, "elements")))) +
         card("Net force", significant(number(last, "net_force_N")) + " N",
              time ? "at the last frame" : "left at the last frame, where all is at rest") +
         "</div>\n";
}

std::string figure_section(const Found& found) {
  return "<section id=\"figure\">\n<h2>Figure</h2>\n<div class=\"panel\">" + drawn(found) +
         "</div>\n</section>\n";
}

std::string number_section(const Found& found) {
  if (found.heads.empty()) return "";
  std::string head = "<th>Run</th>";
  for (const std::string& words : found.heads)
    head += "<th class=\"n\">" + escape_html(words) + "</th>";
  std::string rows;
  for (const RunFound& run : found.runs) {
    const std::string ended =
        run.reason.empty()
            ? ""
            : "<div class=\"soft over\">ended early: " + escape_html(run.reason) + "</div>";
    rows += "<tr>" + cell(escape_html(run.name) + ended);
    for (const std::string& value : run.numbers) rows += number_cell(escape_html(value));
    rows += "</tr>\n";
  }
  return panel("numbers", "Numbers", "Of every run of the experiment.", head, rows);
}

std::string reaction_section(const Json& last) {
  std::string rows;
  const Json& reactions = member(last, "reactions");
  if (reactions.is_object())
    for (const auto& [clip, wrench] : reactions.items()) {
      rows += "<tr>" + cell(escape_html(clip));
      for (const char* key : {"force_N", "torque_N_m"})
        for (std::size_t c = 0; c < 3; ++c) {
          const Json& values = list(wrench, key);
          rows += number_cell(significant(c < values.size() ? number(values[c]) : std::nullopt));
        }
      rows += "</tr>\n";
    }
  std::string head = "<th>Clip</th>";
  for (const char* words : {"F<sub>x</sub> (N)", "F<sub>y</sub> (N)", "F<sub>z</sub> (N)",
                            "T<sub>x</sub> (N m)", "T<sub>y</sub> (N m)", "T<sub>z</sub> (N m)"})
    head += std::string("<th class=\"n\">") + words + "</th>";
  return panel("reactions", "Forces at clips",
               "What the scene itself does to its clips at the last frame, with the torque about "
               "each clip's middle.",
               head, rows);
}

std::string energy_section(const Json& last) {
  std::string rows;
  const Json& energies = member(last, "energies_J");
  if (energies.is_object())
    for (const auto& [term, energy] : energies.items())
      rows += "<tr>" + cell("<code>" + escape_html(term) + "</code>") +
              number_cell(significant(number(energy))) + cell("J") + "</tr>\n";
  return panel("energies", "Energies", "Held by each of the model's terms at the last frame.",
               "<th>Term</th><th class=\"n\">Energy</th><th>Unit</th>", rows);
}

std::string parameter_section(const Json& result) {
  std::string rows;
  for (const Json& entry : list(result, "parameters")) {
    const std::string unit = text(entry, "unit");
    rows += "<tr>" + cell("<code>" + escape_html(text(entry, "name")) + "</code>") +
            number_cell(significant(number(entry, "value"))) +
            cell(unit == "1" ? "" : escape_html(unit)) + "</tr>\n";
  }
  return panel("parameters", "Parameters",
               "Of " + escape_html(text(result, "model")) + ", as it was simulated.",
               "<th>Parameter</th><th class=\"n\">Value</th><th>Unit</th>", rows);
}

}  // namespace

std::string scene_page(const Json& result) {
  const Expected<Found> found = found_of(result);
  const Json& frames = list(result, "frames");
  const Json last = frames.empty() ? Json() : frames.back();
  const std::string details = (found ? figure_section(*found) + number_section(*found) : "") +
                              reaction_section(last) + energy_section(last) +
                              parameter_section(result);
  const std::string title = text(result, "scene") + " with " + text(result, "model");
  std::string body = page_header(result, "Simulation of a scene", title, kSections, details);
  if (const std::string words = text(result, "words"); !words.empty())
    body += "<p>" + escape_html(words) + "</p>\n";
  if (!flag(result, "completed"))
    body +=
        "<p>" + badge("bad", "ENDED EARLY") + " " + escape_html(text(result, "reason")) + "</p>\n";
  body += cards(result) + details;
  body +=
      "<footer><p>All units are SI; membrane stress is force per width. Frames are for ParaView "
      "(tenter simulate --scene ... -o DIR).</p></footer>\n";
  return html_page(title, body);
}

}  // namespace tenter::report
