// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_report.h"

#include "common/report/experiment/scene_page.h"
#include "common/report/friction/friction_section.h"
#include "common/report/html_figures.h"
#include "common/report/html_page.h"
#include "common/report/html_parts.h"
#include "common/report/html_tables.h"
#include "common/report/html_text.h"
#include "common/report/sheet/mesh_svg.h"
#include "common/report/sheet/sheet_report.h"
#include "common/report/summary.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

constexpr PageSection kSections[] = {
    {"friction", "Friction"},   {"test", "Readings"},         {"captures", "Captures"},
    {"loops", "Loops"},         {"transverse", "Transverse"}, {"residuals", "Residuals"},
    {"sheets", "The sheet"},    {"model", "Model"},           {"parameters", "Parameters"},
    {"path", "How it grew"},    {"screen", "Screen"},         {"checklist", "Checklist"},
    {"figures", "More figures"}};

}  // namespace

Expected<std::string> render_html(const std::string& result_json) {
  const Expected<Json> parsed = parse_document(result_json);
  if (!parsed) return tl::unexpected(parsed.error());
  const Json& result = *parsed;
  if (text(result, "schema") == sheet::kSchema) return sheet::render_page(result);
  if (text(result, "schema") == kSceneSchema) return scene_page(result);

  const std::string details =
      friction_section(result) + capture_table(result) +
      figure_sections(result, {"baseline model", "extended model", extends_baseline(result)}) +
      sheet::mesh_section(result) + model_table(result) + parameter_table(result) +
      path_table(result) + screen_table(result) + checklist_table(result);
  std::string body = page_header(result, subject(result), headline(result), kSections, details);
  body += summary_cards(result) + verdict_table(result) + details;
  body += "<footer>" + fit_note(result) +
          "<p>Errors are rms(measured \u2212 model) / rms(measured) over " +
          measured_words(result) +
          ". "
          "All units are SI; membrane stress is force per width.</p></footer>\n";
  return html_page(headline(result), body);
}

}  // namespace tenter::report
