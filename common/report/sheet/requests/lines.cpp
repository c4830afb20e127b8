// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "common/report/sheet/document.h"
#include "common/report/sheet/requests/requests.h"
#include "common/report/text_parts.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

namespace {

std::string line(const char* name, const std::string& words) {
  return "  " + padded(name, 13) + " " + words + "\n";
}

std::string samples_line(const Json& samples) {
  const std::string message = text(samples, "message");
  if (!message.empty()) return line("samples", printable(message));
  const auto kept = list(samples, "released").size();
  std::string words = std::to_string(kept) + " of " +
                      std::to_string(list(samples, "steps").size()) + " tried were kept";
  if (kept > 0)
    words += "; held-out cost " + significant(number(samples, "held_out_before")) + " -> " +
             significant(number(samples, "held_out"));
  return line("samples", words);
}

}  // namespace

std::string request_lines(const Json& result) {
  std::string out;
  if (const Json& grid = member(result, "grid_error"); grid.is_object()) {
    double force = 0.0, position = 0.0;
    for (const Json& capture : list(grid, "captures")) {
      force = std::max(force, number(member(capture, "force"), "rms").value_or(0.0));
      position = std::max(position, number(member(capture, "position"), "rms").value_or(0.0));
    }
    out += line("grid error", "taken off: up to " + quantity(force, "N") + " and " +
                                  quantity(position, "m") + " of a capture (rms)" +
                                  (flag(grid, "settled") ? "" : ", still changing"));
  }
  if (const Json& starts = member(result, "starts"); starts.is_object())
    out +=
        line("starts", significant(number(starts, "in_best_basin")) + " of " +
                           std::to_string(list(starts, "outcomes").size()) + " in the best basin" +
                           (flag(starts, "is_better") ? ", which the stages had missed" : ""));
  if (const Json& convex = member(result, "convexity"); convex.is_object())
    out += line("convex", std::string(flag(convex, "is_convex") ? "yes" : "no") + "; cost " +
                              significant(number(convex, "cost_before")) + " -> " +
                              significant(number(convex, "cost_after")));
  if (const Json& samples = member(result, "samples"); samples.is_object())
    out += samples_line(samples);
  if (const Json& limit = member(result, "limit"); limit.is_object())
    out += line("limit", printable(text(limit, "message")));
  return out;
}

}  // namespace tenter::report::sheet
