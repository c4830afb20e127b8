// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/results/parameters_json.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "server/jobs/results/json_number.h"

namespace tenter::jobs {
namespace {

using nlohmann::json;

template <class T>
json maybe(const std::optional<T>& value) {
  return value ? json(*value) : json(nullptr);
}

const char* state_word(estimation::ParameterState state) {
  switch (state) {
    case estimation::ParameterState::free:
      return "free";
    case estimation::ParameterState::fixed:
      return "fixed";
    case estimation::ParameterState::at_bound:
      return "at_bound";
    case estimation::ParameterState::zero_gradient:
      return "zero_gradient";
    case estimation::ParameterState::flat:
      return "flat";
  }
  return "";
}

}  // namespace

json model_parameters_json(const model::Model& model,
                           const std::vector<estimation::ParameterState>& states) {
  json list = json::array();
  const auto names = estimation::parameter_names(model);
  const auto all = estimation::parameters_of(model);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const model::Parameter& p = *all[i];
    list.push_back({{"name", names[i]},
                    {"value", number(p.value)},
                    {"unit", p.unit},
                    {"std_error", maybe(p.std_error)},
                    {"interval",
                     p.interval_lo ? json::array({*p.interval_lo, *p.interval_hi}) : json(nullptr)},
                    {"state", state_word(states[i])}});
  }
  return list;
}

}  // namespace tenter::jobs
