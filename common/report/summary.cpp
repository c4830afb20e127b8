// SPDX-License-Identifier: Apache-2.0
#include "common/report/summary.h"

#include <algorithm>

#include "common/report/experiment/scene_page.h"
#include "common/report/friction/friction_section.h"
#include "common/report/sheet/sheet_report.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

std::vector<std::string> effects_with(const Json& result, const char* verdict) {
  std::vector<std::string> effects;
  for (const Json& entry : list(result, "verdicts"))
    if (text(entry, "verdict") == verdict) effects.push_back(effect_words(text(entry, "effect")));
  return effects;
}

/// All that could be meant by the first ambiguous verdict.
std::vector<std::string> ambiguity_group(const Json& result) {
  std::vector<std::string> group;
  for (const Json& entry : list(result, "verdicts")) {
    if (text(entry, "verdict") != "AMBIGUOUS") continue;
    if (!text(entry, "effect").empty()) group.push_back(effect_words(text(entry, "effect")));
    for (const Json& other : list(entry, "alternatives")) {
      const std::string words = effect_words(text(other));
      bool known = false;
      for (const std::string& g : group) known = known || g == words;
      if (!known && !words.empty()) group.push_back(words);
    }
    break;
  }
  return group;
}

bool has(const Json& result, const char* verdict) {
  for (const Json& entry : list(result, "verdicts"))
    if (text(entry, "verdict") == verdict) return true;
  return false;
}

}  // namespace

std::string headline(const Json& result) {
  const std::string kind = text(result, "kind");
  if (std::string friction = friction_headline(result); !friction.empty()) return friction;
  if (kind != "diagnose") {
    const std::string what = kind == "simulate" ? "The simulation misses " : "The fit misses ";
    const std::optional<double> error = number(result, "error_after");
    if (!error)
      return kind == "simulate" ? "Simulated; nothing was measured to compare with." : "Fitted.";
    return what + percent(error) + " of the measured force.";
  }
  const std::vector<std::string> named = effects_with(result, "NAMED");
  std::vector<std::string> sensors = effects_with(result, "SENSOR");
  const std::vector<std::string> group = ambiguity_group(result);
  std::string words;
  if (!named.empty())
    words = (named.size() == 1 ? "Cause found: " : "Causes found: ") + joined(named) + ".";
  const bool outliers = std::erase(sensors, effect_words("outliers")) > 0;
  if (!sensors.empty())
    words += (words.empty() ? "" : " ") +
             std::string(sensors.size() == 1 ? "Sensor fault: " : "Sensor faults: ") +
             joined(sensors) + ".";
  if (outliers) words += (words.empty() ? "" : " ") + std::string("Some readings are outliers.");
  if (!group.empty())
    words += (words.empty() ? "" : " ") + std::string("Not to be told apart here: ") +
             joined(group) + ".";
  if (!words.empty()) return words;
  if (has(result, "NUMERICAL")) return "The misfit is numerical, not the material's.";
  if (has(result, "NOTHING_FOUND")) return "Nothing found: the model fits to within the noise.";
  if (has(result, "UNEXPLAINED")) return "Something is wrong that no known cause explains.";
  if (has(result, "NOT_EXCITED")) return "These captures do not excite the causes asked for.";
  return "No finding.";
}

namespace {

/// "; goes on from job 12 (AMBIGUOUS internal friction or viscosity)".
std::string continued(const Json& result) {
  const Json& before = member(result, "continues");
  if (text(before, "job").empty()) return "";
  std::vector<std::string> said;
  for (const Json& entry : list(before, "said")) {
    std::vector<std::string> group;
    if (!text(entry, "effect").empty()) group.push_back(effect_words(text(entry, "effect")));
    for (const Json& other : list(entry, "alternatives"))
      group.push_back(effect_words(text(other)));
    std::string verdict = text(entry, "verdict");
    std::replace(verdict.begin(), verdict.end(), '_', ' ');
    said.push_back(verdict + (group.empty() ? "" : " " + joined(group, "or")));
  }
  return "; goes on from job " + text(before, "job") +
         (said.empty() ? "" : " (" + joined(said) + ")");
}

}  // namespace

std::string subject(const Json& result) {
  const std::string kind = text(result, "kind");
  const std::size_t count = list(result, "captures").size();
  std::string words = kind == "diagnose" ? "Diagnosis" : kind == "simulate" ? "Simulation" : "Fit";
  words += " of " + std::to_string(count) + (count == 1 ? " capture" : " captures");
  std::string model = text(member(result, "baseline_model"), "name");
  if (model.empty()) model = text(member(result, "model"), "name");
  if (!model.empty()) words += " with " + model;
  return words + continued(result);
}

bool extends_baseline(const Json& result) {
  const Json& before = member(result, "baseline_model");
  const Json& after = member(result, "model");
  if (!before.is_object() || !after.is_object()) return true;
  return list(before, "terms") != list(after, "terms") ||
         list(before, "corrections") != list(after, "corrections");
}

Expected<Json> parse_document(const std::string& result_json) {
  Json result = Json::parse(result_json, nullptr, false);
  if (result.is_discarded()) return bad_input("the result document is not JSON");
  if (text(result, "schema") != "tenter.result" && text(result, "schema") != sheet::kSchema &&
      text(result, "schema") != kSceneSchema)
    return bad_input(
        "the document is not a result: its schema is not 'tenter.result', 'tenter.sheet_fit' or "
        "'tenter.simulation'");
  if (number(result, "version") != 1.0)
    return bad_input("the result document has a version that this program does not read");
  return result;
}

Expected<Json> parse_result(const std::string& result_json) {
  Expected<Json> result = parse_document(result_json);
  if (result && text(*result, "schema") == kSceneSchema)
    return bad_input(
        "the result is a simulated scene, which is shown as a page only: give it a file "
        "(-o FILE.html); its frames are for ParaView (tenter simulate --scene ... -o DIR)");
  return result;
}

}  // namespace tenter::report
