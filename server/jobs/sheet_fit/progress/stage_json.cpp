// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/progress/stage_json.h"

#include <array>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/model/document.h"
#include "server/jobs/results/json_number.h"

namespace tenter::jobs {
namespace {

using estimation::ParameterState;
using estimation::StageRecord;
using nlohmann::json;

constexpr std::array kStates = {ParameterState::free, ParameterState::fixed,
                                ParameterState::at_bound, ParameterState::zero_gradient,
                                ParameterState::flat};

double number_at(const json& object, const char* key) {
  const json& value = object.at(key);
  return value.is_null() ? std::nan("") : value.get<double>();
}

json to_json(const StageRecord& record) {
  json refinements = json::array();
  for (const auto& r : record.refinements)
    refinements.push_back({r.control_points, number(r.cost), r.kept});
  json dropped = json::array();
  for (const auto& d : record.dropped) dropped.push_back({d.sequence, d.frame, d.reason});
  json not_free = json::array();
  for (const auto& n : record.not_free)
    not_free.push_back({n.parameter, std::string(state_word(n.state))});
  return {{"name", record.name},
          {"message", record.message},
          {"done", record.done},
          {"converged", record.converged},
          {"stopped", record.stopped},
          {"held", record.held},
          {"guessed", record.guessed},
          {"guess_message", record.guess_message},
          {"cost_at_start", number(record.cost_at_start)},
          {"cost_before", number(record.cost_before)},
          {"cost_after", number(record.cost_after)},
          {"rows", record.rows},
          {"iterations", record.iterations},
          {"refinements", refinements},
          {"dropped", dropped},
          {"not_free", not_free}};
}

ParameterState state_of(const std::string& word) {
  for (const ParameterState state : kStates)
    if (word == state_word(state)) return state;
  return ParameterState::free;
}

StageRecord record_of(const json& value) {
  StageRecord record;
  value.at("name").get_to(record.name);
  value.at("message").get_to(record.message);
  value.at("done").get_to(record.done);
  value.at("converged").get_to(record.converged);
  value.at("stopped").get_to(record.stopped);
  record.held = value.value("held", false);
  value.at("guessed").get_to(record.guessed);
  value.at("guess_message").get_to(record.guess_message);
  record.cost_at_start = number_at(value, "cost_at_start");
  record.cost_before = number_at(value, "cost_before");
  record.cost_after = number_at(value, "cost_after");
  value.at("rows").get_to(record.rows);
  value.at("iterations").get_to(record.iterations);
  for (const json& r : value.at("refinements"))
    record.refinements.push_back({r.at(0).get<int>(),
                                  r.at(1).is_null() ? std::nan("") : r.at(1).get<double>(),
                                  r.at(2).get<bool>()});
  for (const json& d : value.at("dropped"))
    record.dropped.push_back(
        {d.at(0).get<std::string>(), d.at(1).get<int>(), d.at(2).get<std::string>()});
  for (const json& n : value.at("not_free"))
    record.not_free.push_back({n.at(0).get<std::string>(), state_of(n.at(1).get<std::string>())});
  return record;
}

}  // namespace

const char* state_word(ParameterState state) {
  switch (state) {
    case ParameterState::free:
      return "free";
    case ParameterState::fixed:
      return "fixed";
    case ParameterState::at_bound:
      return "at_bound";
    case ParameterState::zero_gradient:
      return "zero_gradient";
    case ParameterState::flat:
      return "flat";
  }
  return "";
}

json to_json(const estimation::StagedResult& result) {
  json stages = json::array();
  for (const StageRecord& record : result.stages) stages.push_back(to_json(record));
  return {{"model", json::parse(model::write_model(result.model))},
          {"stages", stages},
          {"stopped", result.stopped}};
}

Expected<estimation::StagedResult> staged_from_json(const json& value) {
  estimation::StagedResult result;
  try {
    auto model = model::parse_model(value.at("model").dump(), "the checkpoint's model");
    if (!model) return tl::unexpected(model.error());
    result.model = std::move(*model);
    for (const json& stage : value.at("stages")) result.stages.push_back(record_of(stage));
    value.at("stopped").get_to(result.stopped);
  } catch (const json::exception& trouble) {
    return bad_input(std::string("the checkpoint is not one: ") + trouble.what());
  }
  return result;
}

json to_json(const std::vector<estimation::StartOutcome>& outcomes) {
  json list = json::array();
  for (const estimation::StartOutcome& outcome : outcomes) {
    const auto& p = outcome.parameters;
    list.push_back({{"start", outcome.start},
                    {"usable", outcome.usable},
                    {"cost", number(outcome.cost)},
                    {"parameters", std::vector<double>(p.data(), p.data() + p.size())},
                    {"iterations", outcome.iterations},
                    {"message", outcome.message}});
  }
  return list;
}

Expected<std::vector<estimation::StartOutcome>> outcomes_from_json(const json& value) {
  std::vector<estimation::StartOutcome> outcomes;
  try {
    for (const json& entry : value) {
      estimation::StartOutcome& outcome = outcomes.emplace_back();
      entry.at("start").get_to(outcome.start);
      entry.at("usable").get_to(outcome.usable);
      const json& cost = entry.at("cost");
      outcome.cost = cost.is_null() ? std::numeric_limits<double>::infinity() : cost.get<double>();
      const auto p = entry.at("parameters").get<std::vector<double>>();
      outcome.parameters =
          Eigen::Map<const Eigen::VectorXd>(p.data(), static_cast<Eigen::Index>(p.size()));
      entry.at("iterations").get_to(outcome.iterations);
      entry.at("message").get_to(outcome.message);
    }
  } catch (const json::exception& trouble) {
    return bad_input(std::string("the checkpoint is not one: ") + trouble.what());
  }
  return outcomes;
}

}  // namespace tenter::jobs
