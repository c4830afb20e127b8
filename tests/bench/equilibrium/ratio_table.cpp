// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/equilibrium/ratio_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace tenter::mechanics::bench {

namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? std::nan("") : values[values.size() / 2];
}

double counter(const std::map<std::string, double>& counters, const char* name) {
  const auto found = counters.find(name);
  return found == counters.end() ? std::nan("") : found->second;
}

/// "-" where there is none.
std::string number(const char* format, double value) {
  if (std::isnan(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

bool RatioTable::ReportContext(const Context& context) {
  std::printf("%d cores, %.0f MHz, load %.2f; medians of the process's CPU time\n",
              context.cpu_info.num_cpus, context.cpu_info.cycles_per_second / 1e6,
              context.cpu_info.load_avg.empty() ? -1.0 : context.cpu_info.load_avg[0]);
  return true;
}

RatioTable::Row& RatioTable::row(const std::string& case_name, const std::string& way) {
  auto found = std::find_if(cases_.begin(), cases_.end(),
                            [&](const auto& entry) { return entry.first == case_name; });
  if (found == cases_.end()) found = cases_.insert(cases_.end(), {case_name, {}});
  std::vector<Row>& rows = found->second;
  const auto same =
      std::find_if(rows.begin(), rows.end(), [&](const Row& entry) { return entry.name == way; });
  return same != rows.end() ? *same : rows.emplace_back(Row{way, 0, {}, {}});
}

void RatioTable::ReportRuns(const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    if (run.error_occurred) {
      failures_.push_back(run.benchmark_name() + ": " + run.error_message);
      continue;
    }
    if (run.run_type != Run::RT_Iteration) continue;
    const std::string name = run.run_name.function_name;
    const std::size_t slash = name.find('/');
    Row& entry = row(name.substr(0, slash), name.substr(slash + 1));
    entry.place = run.family_index;
    entry.milliseconds.push_back(run.GetAdjustedCPUTime());
    for (const auto& [key, value] : run.counters) entry.counters[key] = value.value;
  }
}

void RatioTable::Finalize() {
  std::printf("%-24s %-28s %10s %7s %6s %9s %9s %8s %7s %9s\n", "case", "way", "ms", "floors",
              "steps", "a step", "Mflop", "GF/s", "MB", "check");
  for (auto& [name, rows] : cases_)  // turns end in any order
    std::sort(rows.begin(), rows.end(),
              [](const Row& a, const Row& b) { return a.place < b.place; });
  std::sort(cases_.begin(), cases_.end(), [](const auto& a, const auto& b) {
    return a.second.front().place < b.second.front().place;
  });
  for (const auto& [name, rows] : cases_) {
    double floor = std::numeric_limits<double>::infinity();
    for (const Row& entry : rows)
      if (entry.name.starts_with("floor")) floor = std::min(floor, median(entry.milliseconds));
    for (const Row& entry : rows) {
      const double time = median(entry.milliseconds), mflop = counter(entry.counters, "Mflop");
      const double steps = counter(entry.counters, "iterations");
      std::printf("%-24s %-28s %10.3f %7.2f %6s %9s %9s %8s %7s %9s\n", name.c_str(),
                  entry.name.c_str(), time, time / floor, number("%.0f", steps).c_str(),
                  number("%.2f", time / floor / steps).c_str(), number("%.1f", mflop).c_str(),
                  number("%.1f", mflop / time).c_str(),
                  number("%.1f", counter(entry.counters, "MB")).c_str(),
                  number("%.1e", counter(entry.counters, "check")).c_str());
    }
  }
  for (const std::string& failure : failures_) std::printf("FAILED %s\n", failure.c_str());
}

}  // namespace tenter::mechanics::bench
