// SPDX-License-Identifier: Apache-2.0
#include "common/report/sheet/document.h"

#include <cmath>
#include <cstdio>
#include <string_view>

#include "common/report/words.h"

namespace tenter::report::sheet {

namespace {

/// "forces by 12 mN (4.0 sigma)"
std::string missed(const Json& errors, const char* what, const char* unit) {
  if (!number(errors, "rms_after")) return "";
  std::string words = std::string(what) + " by " + quantity(number(errors, "rms_after"), unit);
  if (number(errors, "after_sigmas")) words += " (" + sigmas(number(errors, "after_sigmas")) + ")";
  return words;
}

}  // namespace

std::string headline(const Json& result) {
  const Json& of = member(result, "fitted");
  std::vector<std::string> parts;
  for (const std::string& part : {missed(member(of, "force"), "forces", "N"),
                                  missed(member(of, "position"), "positions", "m")})
    if (!part.empty()) parts.push_back(part);
  if (parts.empty()) return "Fitted.";
  return "The fit misses " + joined(parts) + ".";
}

std::string subject(const Json& result) {
  std::size_t held_out = 0;
  for (const Json& capture : list(result, "captures")) held_out += flag(capture, "held_out");
  const std::size_t fitted = list(result, "captures").size() - held_out;
  std::string words = "Fit of " + std::to_string(fitted) + (fitted == 1 ? " capture" : " captures");
  const std::string model = text(member(result, "starting_model"), "name");
  if (!model.empty()) words += " of a sheet with " + model;
  if (held_out > 0) words += "; " + std::to_string(held_out) + " held out";
  return words;
}

std::string quantity(std::optional<double> value, const char* unit) {
  if (!value) return significant(value);
  struct Step {
    double from;  // the least that is said in this unit
    double size;
    const char* prefix;
  };
  static constexpr Step kForces[] = {
      {0.1, 1.0, ""}, {1e-4, 1e-3, "m"}, {1e-7, 1e-6, "\u00b5"}, {0.0, 1e-9, "n"}};
  static constexpr Step kLengths[] = {
      {1.0, 1.0, ""}, {1e-6, 1e-3, "m"}, {1e-9, 1e-6, "\u00b5"}, {0.0, 1e-9, "n"}};
  const Step* step = std::string_view(unit) == "m" ? kLengths : kForces;
  while (std::abs(*value) < step->from) ++step;
  char words[48];
  std::snprintf(words, sizeof words, "%.3g\u202f%s%s", *value / step->size, step->prefix, unit);
  return words;
}

std::string sigmas(std::optional<double> value) {
  if (!value) return significant(value);
  char words[48];
  std::snprintf(words, sizeof words, *value < 99.5 ? "%.2g\u202f\u03c3" : "%.0f\u202f\u03c3",
                *value);
  return words;
}

std::string change(const Json& errors, const char* unit, const std::string& arrow) {
  const std::optional<double> before = number(errors, "rms_before");
  const std::optional<double> after = number(errors, "rms_after");
  if (before && after && *before != *after)
    return quantity(before, unit) + arrow + quantity(after, unit);
  return quantity(after ? after : before, unit);
}

}  // namespace tenter::report::sheet
