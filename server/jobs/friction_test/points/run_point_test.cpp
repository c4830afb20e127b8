// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/points/run_point_test.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/atomic_write.h"
#include "common/report/residual_file.h"
#include "server/diagnosis/diagnose.h"
#include "server/estimation/friction_tests/loops/loop_fit.h"
#include "server/estimation/friction_tests/stretch/hanging_weights.h"
#include "server/jobs/friction_test/friction_document.h"
#include "server/jobs/friction_test/points/loops_of_captures.h"
#include "server/jobs/friction_test/points/rate_question.h"
#include "server/jobs/friction_test/points/weights_of_capture.h"
#include "server/jobs/results/json_number.h"
#include "server/jobs/results/result_document.h"

namespace tenter::jobs {
namespace {

using estimation::FrictionEstimate;
using nlohmann::json;
using PointReport = std::function<void(const JobProgress&)>;
using PointCaptures = std::vector<std::pair<std::string, capture::Capture>>;

int all_threads() {
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

/// What was found takes the place of the fixed values with which the frames were predicted.
void put_estimate(const FrictionEstimate& found, diagnosis::Diagnosis& d) {
  d.extended.model = found.model;
  for (model::Parameter* p : estimation::parameters_of(d.extended.model)) {
    if (p->interval_lo && p->interval_hi) continue;
    p->interval_lo.reset();  // a document has both ends or none
    p->interval_hi.reset();
  }
  d.baseline.model = d.extended.model;  // there is one model, and pages draw one
  d.extended.fit.states = found.fit.states;
  d.extended.fit.iterations = found.fit.iterations;
  d.extended.fit.converged = found.fit.converged;
  d.extended.fit.message = found.fit.message;
  for (diagnosis::Check& check : checks_of(found, "")) d.checklist.push_back(std::move(check));
}

/// What only the protocol knows.
struct PointFindings {
  json test;                             ///< friction_test
  json figures = json::array();          ///< beside those of any fit
  std::vector<diagnosis::Check> checks;  ///< beside those of the numbers
  std::vector<report::ResidualTable> tables;
};

/// Every frame predicted with what was found, and the documents of it.
Expected<void> write_point_documents(const JobInput& input, PointCaptures captures,
                                     const FrictionEstimate& found, PointFindings findings,
                                     const PointReport& report, const std::stop_token& stop) {
  diagnosis::Request request;
  request.captures = std::move(captures);
  request.model = found.model;
  request.options.leave_out = "none";
  for (model::Parameter* p : estimation::parameters_of(request.model)) p->fixed = true;
  diagnosis::Control control;
  control.stop = stop;
  control.report = [&](const diagnosis::Progress& p) {
    report({p.stage, p.detail, p.iteration, p.cost, 0.7 + 0.25 * p.fraction});
  };
  auto predicted = diagnosis::fit_only(request, control);
  if (!predicted) return tl::unexpected(predicted.error());
  put_estimate(found, *predicted);
  for (diagnosis::Check& check : findings.checks) predicted->checklist.push_back(std::move(check));

  report({"write", "", 0, 0.0, 0.98});
  json document = result_document(*predicted, request, "fit");
  document["friction_test"] = std::move(findings.test);
  for (json& figure : findings.figures) document["figures"].push_back(std::move(figure));
  withhold(found, document["parameters"]);
  const std::string text = document.dump(1) + "\n";
  if (auto written =
          write_atomically((input.staging / "result.json").string(), text.data(), text.size());
      !written)
    return written;
  std::vector<report::ResidualTable> tables = residual_tables(*predicted);
  for (report::ResidualTable& table : findings.tables) tables.push_back(std::move(table));
  return report::write_residuals(tables, (input.staging / "residuals.h5").string());
}

Expected<void> check_point_options(const json& options, bool has_direction) {
  for (const auto& [key, value] : options.items()) {
    if (key == "protocol") continue;
    if (key != "direction" || !has_direction)
      return bad_input("options." + key + ": no option of a fit with this protocol");
    if (value != "weft" && value != "warp")
      return bad_input("options.direction: must be weft or warp, not " + value.dump());
  }
  return {};
}

/// Lengths against weights, run by run, and those that the model hangs at.
json weights_figure(const std::string& id, const WeightsOfCapture& weights,
                    const FrictionEstimate& found) {
  const bool has_length = weights.rest_length_m > 0.0;
  const double scale = has_length ? 1e3 * weights.rest_length_m : 1.0;
  json series = json::array();
  for (const char* role : {"measured", "baseline"}) {
    int run = -1;
    for (std::size_t i = 0; i < weights.table.readings.size(); ++i) {
      const estimation::WeightReading& reading = weights.table.readings[i];
      if (reading.run != run) {
        run = reading.run;
        series.push_back({{"name", std::string(role) + ", run " + std::to_string(run + 1)},
                          {"role", role},
                          {"x", json::array()},
                          {"y", json::array()}});
      }
      const double missed =
          found.noise * found.fit.residuals[static_cast<Eigen::Index>(i)];  // model - read
      const double shown = reading.length_m + (role[0] == 'm' ? 0.0 : missed);
      series.back()["x"].push_back(number(reading.weight_N));
      series.back()["y"].push_back(number(scale * shown));
    }
  }
  return {{"kind", "weights"},
          {"capture", id},
          {"title", "Length against weight"},
          {"x", {{"name", "weight per width"}, {"unit", "N/m"}}},
          {"y", {{"name", has_length ? "length" : "stretch"}, {"unit", has_length ? "mm" : "1"}}},
          {"series", std::move(series)}};
}

/// The lengths, which are what was fitted; the force is that of any other fit.
report::ResidualTable length_residuals(const std::pair<std::string, capture::Capture>& of,
                                       const WeightsOfCapture& weights,
                                       const FrictionEstimate& found) {
  report::ResidualTable table;
  table.capture_id = of.first;
  table.capture_title = of.second.title;
  table.channel = "hanging_stretch";
  table.unit = "1";
  const auto places = estimation::places_of(weights.table);
  for (std::size_t i = 0; i < weights.table.readings.size(); ++i) {
    const estimation::WeightReading& reading = weights.table.readings[i];
    const double predicted =
        reading.length_m + found.noise * found.fit.residuals[static_cast<Eigen::Index>(i)];
    table.frame.push_back(of.second.frame[i]);
    table.run.push_back(of.second.runs[static_cast<std::size_t>(of.second.run[i])].number);
    table.block.push_back(places[i].branch);
    table.branch.push_back(places[i].sign < 0.0 ? 1 : 0);
    if (!of.second.time_s.empty()) table.time_s.push_back(of.second.time_s[i]);
    table.strain_x.push_back(reading.length_m - 1.0);
    table.strain_y.push_back(std::nan(""));
    table.strain_xy.push_back(std::nan(""));
    table.measured.push_back(reading.length_m);
    table.predicted_baseline.push_back(predicted);
    table.predicted_extended.push_back(predicted);
    table.sigma.push_back(found.noise);
    table.weight.push_back(1.0);
  }
  return table;
}

const char* answer_word(RateAnswer answer) {
  if (answer == RateAnswer::not_asked) return "cannot tell";
  return answer == RateAnswer::friction ? "friction" : "viscosity";
}

json rate_json(const RateQuestion& rate) {
  return {{"answer", answer_word(rate.answer)},
          {"viscosity_share", number(rate.viscosity_share)},
          {"evidence", number(rate.evidence)},
          {"fallen", rate.fallen ? number(*rate.fallen) : json(nullptr)},
          {"hold_s", number(rate.hold_s)},
          {"loss_ratio", rate.loss_ratio ? number(*rate.loss_ratio) : json(nullptr)},
          {"rate_ratio", number(rate.rate_ratio)},
          {"words", rate.words}};
}

json loops_test(const LoopsOfCaptures& loops, const estimation::LoopEstimate& found,
                const RateQuestion& rate) {
  json part = part_json(found.friction, loops.measure, "N/m");
  part["runs"] = loops.runs;
  part["runs_passed_over"] = loops.runs_passed_over;
  part["readings"] = loops.table.readings.size();
  part["noise_is_from_fit"] = found.noise_is_from_fit;
  part["missed_share"] = number(found.missed_share);
  part["lost_share"] = number(found.lost_share);
  part["lost_share_of_model"] = number(found.lost_share_of_model);
  part["rate"] = rate_json(rate);
  return {{"protocol", "loops"}, {"parts", json::array({part})}};
}

}  // namespace

Expected<void> run_hanging_weights(const JobInput& input, const json& spec, PointCaptures captures,
                                   const PointReport& report, const std::stop_token& stop) {
  if (auto ok = check_point_options(spec["options"], false); !ok) return ok;
  if (captures.size() != 1)
    return bad_input("captures: hanging weights are fitted one capture at a time, " +
                     std::to_string(captures.size()) + " are given");
  const auto weights = weights_of(captures.front().second, captures.front().first);
  if (!weights) return tl::unexpected(weights.error());
  report({"fit", "hanging weights", 0, 0.0, 0.1});
  estimation::FrictionFitOptions options;
  options.threads = all_threads();
  options.fit.on_iteration = [&](int iteration, double cost) {
    report({"fit", "hanging weights", iteration, cost, 0.2});
    return !stop.stop_requested();
  };
  const auto found = fit_hanging_weights(weights->table, weights->measure, options);
  if (stop.stop_requested()) return fail(ErrorKind::cancelled, "cancelled");
  if (!found) return tl::unexpected(found.error());
  PointFindings findings;
  json part = part_json(*found, weights->measure, "1");
  const double rest = weights->rest_length_m;
  if (rest > 0.0) {
    part["noise"] = found->noise * rest;
    part["noise_unit"] = "m";
  }
  findings.test = {{"protocol", "hanging-weights"}, {"parts", json::array({part})}};
  findings.figures.push_back(weights_figure(captures.front().first, *weights, *found));
  findings.tables.push_back(length_residuals(captures.front(), *weights, *found));
  return write_point_documents(input, std::move(captures), *found, std::move(findings), report,
                               stop);
}

Expected<void> run_loops(const JobInput& input, const json& spec, const PointCaptures& captures,
                         const PointReport& report, const std::stop_token& stop) {
  if (auto ok = check_point_options(spec["options"], true); !ok) return ok;
  auto loops = loops_of(captures, spec["options"].value("direction", ""));
  if (!loops) return tl::unexpected(loops.error());
  const std::string words = std::to_string(loops->runs) + (loops->runs == 1 ? " run" : " runs");
  estimation::FrictionFitOptions options;
  options.threads = all_threads();
  options.fit.on_iteration = [&](int iteration, double cost) {
    report({"fit", words, iteration, cost, 0.2});
    return !stop.stop_requested();
  };
  const auto found = fit_loops(loops->table, loops->measure, options);
  if (stop.stop_requested()) return fail(ErrorKind::cancelled, "cancelled");
  if (!found) return tl::unexpected(found.error());
  report({"rate", words, 0, 0.0, 0.5});
  diagnosis::Control control;
  control.stop = stop;
  control.threads = all_threads();
  const auto rate = ask_for_rate(loops->captures, found->friction.model, control);
  if (stop.stop_requested()) return fail(ErrorKind::cancelled, "cancelled");
  if (!rate) return tl::unexpected(rate.error());
  if (rate->answer == RateAnswer::viscosity)
    return fail(ErrorKind::refused, "loops: refused as friction: " + rate->words);
  PointFindings findings;
  findings.test = loops_test(*loops, *found, *rate);
  const bool is_open = rate->answer == RateAnswer::not_asked;
  findings.checks.push_back({is_open ? "WARNING" : "OK", "friction or viscosity", rate->words});
  if (loops->runs_passed_over > 0)
    findings.checks.push_back({"OK", "runs passed over",
                               std::to_string(loops->runs_passed_over) +
                                   " in which more than one strain moves, or none"});
  return write_point_documents(input, std::move(loops->captures), found->friction,
                               std::move(findings), report, stop);
}

}  // namespace tenter::jobs
