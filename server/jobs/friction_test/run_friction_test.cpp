// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/run_friction_test.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/atomic_write.h"
#include "common/report/residual_file.h"
#include "server/diagnosis/diagnose.h"
#include "server/estimation/friction_tests/stretch/hanging_weights.h"
#include "server/jobs/friction_test/friction_document.h"
#include "server/jobs/friction_test/points/weights_of_capture.h"
#include "server/jobs/friction_test/strips/run_strip_test.h"
#include "server/jobs/results/result_document.h"

namespace tenter::jobs {
namespace {

using estimation::FrictionEstimate;
using nlohmann::json;

Expected<void> check_options(const json& options) {
  for (const auto& [key, value] : options.items())
    if (key != "protocol")
      return bad_input("options." + key + ": no option of a fit with a protocol");
  return {};
}

json test_json(const FrictionEstimate& found, const WeightsOfCapture& weights) {
  json part = part_json(found, weights.measure, "1");
  const double rest = weights.rest_length_m;
  part["noise_m"] = rest > 0.0 ? json(found.noise * rest) : json(nullptr);
  return {{"protocol", "hanging-weights"}, {"parts", json::array({part})}};
}

/// What was found takes the place of the fixed values with which the frames were predicted.
void put_estimate(const FrictionEstimate& found, diagnosis::Diagnosis& d) {
  d.extended.model = found.model;
  for (model::Parameter* p : estimation::parameters_of(d.extended.model)) {
    if (p->interval_lo && p->interval_hi) continue;
    p->interval_lo.reset();  // a document has both ends or none
    p->interval_hi.reset();
  }
  d.extended.fit.states = found.fit.states;
  d.extended.fit.iterations = found.fit.iterations;
  d.extended.fit.converged = found.fit.converged;
  d.extended.fit.message = found.fit.message;
  for (diagnosis::Check& check : checks_of(found, "")) d.checklist.push_back(std::move(check));
}

}  // namespace

Expected<void> run_friction_test(const JobInput& input, const json& spec,
                                 std::vector<std::pair<std::string, capture::Capture>> captures,
                                 const std::function<void(const JobProgress&)>& report,
                                 const std::stop_token& stop) {
  const json& protocol = spec["options"]["protocol"];
  if (protocol == "spiral" || protocol == "cantilever")
    return run_strip_test(input, spec, captures, report, stop);
  if (protocol != "hanging-weights")
    return bad_input("options.protocol: must be hanging-weights, spiral or cantilever, not " +
                     protocol.dump());
  if (auto checked = check_options(spec["options"]); !checked) return checked;
  if (captures.size() != 1)
    return bad_input("captures: hanging weights are fitted one capture at a time, " +
                     std::to_string(captures.size()) + " are given");
  const auto weights = weights_of(captures.front().second, captures.front().first);
  if (!weights) return tl::unexpected(weights.error());
  report({"fit", "hanging weights", 0, 0.0, 0.1});
  estimation::FrictionFitOptions options;
  options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  options.fit.on_iteration = [&](int iteration, double cost) {
    report({"fit", "hanging weights", iteration, cost, 0.2});
    return !stop.stop_requested();
  };
  const auto found = fit_hanging_weights(weights->table, weights->measure, options);
  if (stop.stop_requested()) return fail(ErrorKind::cancelled, "cancelled");
  if (!found) return tl::unexpected(found.error());

  diagnosis::Request request;
  request.captures = std::move(captures);
  request.model = found->model;
  request.options.leave_out = "none";
  for (model::Parameter* p : estimation::parameters_of(request.model)) p->fixed = true;
  diagnosis::Control control;
  control.stop = stop;
  control.report = [&](const diagnosis::Progress& p) {
    report({p.stage, p.detail, p.iteration, p.cost, 0.7 + 0.25 * p.fraction});
  };
  auto predicted = diagnosis::fit_only(request, control);
  if (!predicted) return tl::unexpected(predicted.error());
  put_estimate(*found, *predicted);

  report({"write", "", 0, 0.0, 0.98});
  json document = result_document(*predicted, request, "fit");
  document["friction_test"] = test_json(*found, *weights);
  withhold(*found, document["parameters"]);
  const std::string text = document.dump(1) + "\n";
  if (auto written =
          write_atomically((input.staging / "result.json").string(), text.data(), text.size());
      !written)
    return written;
  return report::write_residuals(residual_tables(*predicted),
                                 (input.staging / "residuals.h5").string());
}

}  // namespace tenter::jobs
