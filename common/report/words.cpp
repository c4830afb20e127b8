// SPDX-License-Identifier: Apache-2.0
#include "common/report/words.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tenter::report {

namespace {

constexpr const char* kNone = "\u2013";

std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// One decimal above 1 %, two below.
std::string percent_number(double share) {
  const double value = 100.0 * share;
  const double size = std::abs(value);
  if (size >= 99.5 || size == 0.0) return formatted("%.0f", value);
  if (size >= 1.0) return formatted("%.1f", value);
  if (size >= 0.01) return formatted("%.2f", value);
  return formatted("%.1g", value);
}

}  // namespace

std::string effect_words(std::string_view id) {
  if (id == "poisson_coupling") return "Poisson coupling";
  if (id == "first_cycle_softening") return "first-cycle softening";
  if (id == "cross_modal_stiffening") return "cross-modal stiffening";
  if (id == "strain_dependent_friction") return "strain-dependent friction";
  if (id == "force_camera_delay") return "force-camera delay";
  std::string words(id);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string verdict_words(std::string_view verdict) {
  std::string words(verdict);
  for (char& c : words) {
    if (c == '_') c = ' ';
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return words;
}

std::string percent(std::optional<double> share) {
  return share ? percent_number(*share) + "\u202f%" : kNone;
}

std::string percent_interval(std::optional<double> lo, std::optional<double> hi) {
  if (!lo || !hi || percent_number(*lo) == percent_number(*hi)) return "";
  return percent_number(*lo) + " to " + percent_number(*hi) + "\u202f%";
}

std::string p_value(std::optional<double> p) {
  if (!p) return "";
  if (*p < 0.001) return "p < 0.001";
  return "p = " + formatted(*p < 0.1 ? "%.3f" : "%.2f", *p);
}

std::string significant(std::optional<double> value) {
  return value ? formatted("%.4g", *value) : kNone;
}

std::string joined(const std::vector<std::string>& items, std::string_view last) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += i + 1 == items.size() ? " " + std::string(last) + " " : ", ";
    text += items[i];
  }
  return text;
}

}  // namespace tenter::report
