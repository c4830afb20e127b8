// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/friction_document.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/jobs/results/json_number.h"

namespace tenter::jobs {
namespace {

using estimation::FrictionEstimate;
using estimation::FrictionNumber;
using nlohmann::json;

json end_or_null(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

std::string short_number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

}  // namespace

std::string direction_of(const std::string& measure) {
  return measure.ends_with("_u") ? "weft" : "warp";
}

json part_json(const FrictionEstimate& found, const std::string& measure,
               const std::string& noise_unit) {
  json numbers = json::array();
  for (const FrictionNumber& n : found.numbers)
    numbers.push_back({{"name", n.name},
                       {"unit", n.unit},
                       {"told", n.is_told},
                       {"value", n.is_told ? json(n.value) : json(nullptr)},
                       {"interval", json::array({end_or_null(n.lo), end_or_null(n.hi)})},
                       {"words", n.words}});
  json stages = json::array();
  for (std::size_t i = 0; i < found.start.stages.size(); ++i) {
    const estimation::FrictionValues& v = found.start.stages[i];
    stages.push_back({{"k1", v.k1},
                      {"k2", v.k2},
                      {"a", v.a},
                      {"b", v.b},
                      {"tau", v.tau},
                      {"rms_load", number(found.start.rms_load[i])}});
  }
  const auto rows = static_cast<double>(std::max<Eigen::Index>(1, found.fit.residuals.size()));
  return {{"direction", direction_of(measure)},
          {"sense", nullptr},
          {"noise", number(found.noise)},
          {"noise_unit", noise_unit},
          {"gains_below", found.gains_below},
          {"snapped", found.snapped},
          {"chi2_per_row", number(found.fit.chi2 / rows)},
          {"numbers", numbers},
          {"stages", stages}};
}

std::vector<diagnosis::Check> checks_of(const FrictionEstimate& found, const std::string& name) {
  const std::string before = name.empty() ? "" : name + ": ";
  std::vector<diagnosis::Check> checks;
  for (const FrictionNumber& n : found.numbers)
    if (!n.is_told) checks.push_back({"WARNING", before + n.name, n.words});
  if (found.gains_below > 0.0)
    checks.push_back({"WARNING", before + "friction gains work",
                      "below a strain of " + short_number(found.gains_below) +
                          " a step may gain work: b tau is above 2 sigma_max there"});
  return checks;
}

void withhold(const FrictionEstimate& found, json& parameters) {
  for (const FrictionNumber& n : found.numbers) {
    if (n.is_told) continue;
    for (json& parameter : parameters) {
      const std::string& name = parameter["name"].get_ref<const std::string&>();
      if (name.ends_with("." + n.name)) parameter["value"] = parameter["std_error"] = nullptr;
    }
  }
}

}  // namespace tenter::jobs
