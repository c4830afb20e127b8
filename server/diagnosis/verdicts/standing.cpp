// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/standing.h"

#include <cstdio>

namespace tenter::diagnosis {

std::string standing(const Screen& screen, const std::vector<std::string>& added, double error) {
  constexpr int kShown = 5;
  std::string words;
  int shown = 0;
  int above = 0;
  int below = 0;
  char text[32];
  for (const ScreenRow& row : screen.table) {
    if (row.status != "screened") continue;
    if (row.ratio <= 1.0) {
      ++below;
      continue;
    }
    ++above;
    if (shown == kShown) continue;
    ++shown;
    std::snprintf(text, sizeof text, " %.3g", row.ratio);
    words += (words.empty() ? "" : ", ") + row.effect->id + text;
  }
  if (above > shown) words += ", " + std::to_string(above - shown) + " more above the threshold";
  words += (words.empty() ? "" : ", ") + std::to_string(below) +
           (shown > 0 ? " others below 1 x threshold" : " effects, none above the threshold");
  std::snprintf(text, sizeof text, "%.2g %%", 100.0 * error);
  words += "; so far: ";
  for (std::size_t i = 0; i < added.size(); ++i) words += (i > 0 ? ", " : "") + added[i];
  return words + (added.empty() ? "none" : "") + ", error " + text;
}

}  // namespace tenter::diagnosis
