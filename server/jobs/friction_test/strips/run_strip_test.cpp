// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/strips/run_strip_test.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/atomic_write.h"
#include "common/model/document.h"
#include "common/report/residual_file.h"
#include "server/jobs/friction_test/friction_document.h"
#include "server/jobs/friction_test/strips/strip_figures.h"
#include "server/jobs/friction_test/strips/strip_part.h"
#include "server/jobs/results/json_number.h"
#include "server/jobs/results/parameters_json.h"

namespace tenter::jobs {
namespace {

using estimation::BendingTests;
using estimation::ProfileSamples;
using estimation::StripTest;
using estimation::TorqueSample;
using nlohmann::json;

struct StripFindings {
  bool are_spirals = true;
  std::vector<StripPart> parts;
  std::vector<diagnosis::Check> checks;
};

Expected<int> samples_asked(const json& options) {
  for (const auto& [key, value] : options.items())
    if (key != "protocol" && key != "samples")
      return bad_input("options." + key + ": no option of a fit of strips");
  if (!options.contains("samples")) return BendingTests{}.samples;
  const json& given = options["samples"];
  if (!given.is_number_integer() || given < 1 || given > 40)
    return bad_input("options.samples: must be a whole number from 1 to 40, not " + given.dump());
  return given.get<int>();
}

std::string counted_words(std::size_t count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::size_t spirals_in(const BendingTests& tests) {
  return static_cast<std::size_t>(
      std::count_if(tests.strips.begin(), tests.strips.end(),
                    [](const StripTest& strip) { return strip.radius_m > 0.0; }));
}

/// What of one sense is fitted; false where there is nothing of it. What is passed over is said.
bool choose_strips(const std::string& sense, BendingTests& tests, StripFindings& findings) {
  const std::size_t spirals = spirals_in(tests);
  const std::size_t cantilevers = tests.strips.size() - spirals;
  if (tests.strips.empty()) return false;
  if (findings.are_spirals) {
    if (spirals > 0) return true;
    findings.checks.push_back({"WARNING", sense + " sense",
                               counted_words(cantilevers, "cantilever") +
                                   " and no spiral: left out, friction shows in spirals"});
    return false;
  }
  std::erase_if(tests.strips, [](const StripTest& strip) { return strip.radius_m > 0.0; });
  if (spirals > 0)
    findings.checks.push_back({"WARNING", sense + " sense",
                               counted_words(spirals, "spiral") +
                                   " passed over: cantilevers alone are looked at (--protocol "
                                   "spiral takes both)"});
  return !tests.strips.empty();
}

json strip_part_json(const StripPart& part, const std::string& measure) {
  json document = part_json(part.found.friction, measure, "m");
  document["sense"] = part.sense;
  const std::size_t spirals = spirals_in(part.tests);
  document["spirals"] = spirals;
  document["cantilevers"] = part.tests.strips.size() - spirals;
  document["samples"] = part.samples.size();
  document["left_out"] = part.found.left_out;
  const estimation::FrictionValues& alone = part.found.cantilever;
  document["cantilever"] =
      alone.k1 > 0.0 ? json{{"k1", alone.k1}, {"k2", alone.k2}} : json(nullptr);
  document["model"] = json::parse(model::write_model(part.found.friction.model));
  return document;
}

json strip_captures_json(const NamedCaptures& captures,
                         const std::vector<report::ResidualTable>& tables,
                         const std::string& unit) {
  json list = json::array();
  for (const auto& [id, capture] : captures) {
    std::size_t samples = 0;
    double missed = 0.0, read = 0.0;
    for (const report::ResidualTable& table : tables) {
      if (table.capture_id != id || table.unit != unit) continue;
      samples += table.size();
      for (std::size_t i = 0; i < table.size(); ++i) {
        missed += std::pow(table.measured[i] - table.predicted_extended[i], 2);
        read += std::pow(table.measured[i], 2);
      }
    }
    const json error = read > 0.0 ? number(std::sqrt(missed / read)) : json(nullptr);
    list.push_back({{"id", id},
                    {"title", capture.title},
                    {"synthetic", capture.provenance.synthetic},
                    {"specimen", capture.specimen.name},
                    {"material", capture.specimen.material},
                    {"licence", capture.provenance.licence},
                    {"source", capture.provenance.source},
                    {"frames", capture.frame_count()},
                    {"samples", samples},
                    {"noise_source", "scatter of the points about a smooth curve"},
                    {"error_before", error},
                    {"error_after", error}});
  }
  return list;
}

/// Shares of what was read: strains under the torques; of cantilevers alone torques at the strains.
struct StripErrors {
  double missed = 0.0;
  double noise = 0.0;
};

StripErrors errors_of(const StripFindings& findings) {
  const std::vector<StripPart>& parts = findings.parts;
  if (!findings.are_spirals) {
    const double read =
        rms_of_samples(parts, [](const SampleOfStrip& s) { return s.read->mean_torque(); });
    const double missed = rms_of_samples(
        parts, [](const SampleOfStrip& s) { return s.read->mean_torque() - s.torque; });
    return {missed / read, std::nan("")};
  }
  const double read = rms_of_samples(parts, [](const SampleOfStrip& s) { return s.read->strain; });
  return {rms_of_samples(parts, [](const SampleOfStrip& s) { return s.read->strain - s.strain; }) /
              read,
          rms_of_samples(parts, [](const SampleOfStrip& s) { return s.read->std_error; }) / read};
}

Expected<void> write_strip_documents(const JobInput& input, StripFindings findings,
                                     const StripsOfCaptures& strips,
                                     const NamedCaptures& captures) {
  const bool are_two = findings.parts.size() > 1;
  json parts = json::array();
  json parameters = json::array();
  json figures = json::array();
  std::vector<report::ResidualTable> tables;
  for (StripPart& part : findings.parts) {
    const std::string name = are_two ? part.sense : "";
    part.found.friction.model.name += "_" + part.sense;
    for (model::Parameter* p : estimation::parameters_of(part.found.friction.model)) {
      if (p->interval_lo && p->interval_hi) continue;
      p->interval_lo.reset();  // a document has both ends or none
      p->interval_hi.reset();
    }
    parts.push_back(strip_part_json(part, strips.measure));
    json own = model_parameters_json(part.found.friction.model, part.found.friction.fit.states);
    withhold(part.found.friction, own);
    for (json& parameter : own) {
      if (are_two)
        parameter["name"] = part.sense + "." + parameter["name"].get_ref<const std::string&>();
      parameters.push_back(std::move(parameter));
    }
    for (json& figure : strip_figures(part, strips, captures)) figures.push_back(std::move(figure));
    for (report::ResidualTable& table : strip_residuals(part, strips, captures))
      tables.push_back(std::move(table));
    for (diagnosis::Check& check : checks_of(part.found.friction, name))
      findings.checks.push_back(std::move(check));
  }
  json checklist = json::array();
  for (const diagnosis::Check& c : findings.checks)
    checklist.push_back({{"level", c.level}, {"what", c.what}, {"why", c.why}});
  const StripErrors errors = errors_of(findings);
  const estimation::FitResult& fit = findings.parts.front().found.friction.fit;
  const json document = {
      {"schema", "tenter.result"},
      {"version", 1},
      {"kind", "fit"},
      {"verdicts", json::array()},
      {"noise_floor", number(errors.noise)},
      {"error_before", number(errors.missed)},
      {"error_after", number(errors.missed)},
      {"baseline_model", parts.front()["model"]},
      {"model", parts.front()["model"]},
      {"captures", strip_captures_json(captures, tables, findings.are_spirals ? "1/m" : "N")},
      {"parameters", parameters},
      {"checklist", checklist},
      {"figures", figures},
      {"friction_test",
       {{"protocol", findings.are_spirals ? "spiral" : "cantilever"}, {"parts", parts}}},
      {"fit",
       {{"cost", number(fit.chi2)},
        {"iterations", fit.iterations},
        {"status", fit.converged ? "converged" : "not converged"},
        {"message", fit.message}}}};
  const std::string text = document.dump(1) + "\n";
  if (auto written =
          write_atomically((input.staging / "result.json").string(), text.data(), text.size());
      !written)
    return written;
  return report::write_residuals(tables, (input.staging / "residuals.h5").string());
}

}  // namespace

Expected<void> run_strip_test(const JobInput& input, const json& spec,
                              const NamedCaptures& captures,
                              const std::function<void(const JobProgress&)>& report,
                              const std::stop_token& stop) {
  StripFindings findings;
  findings.are_spirals = spec["options"]["protocol"] == "spiral";
  const auto samples = samples_asked(spec["options"]);
  if (!samples) return tl::unexpected(samples.error());
  auto strips = strips_of(captures);
  if (!strips) return tl::unexpected(strips.error());
  strips->tests.samples = *samples;
  const auto senses = by_sense(strips->tests);
  for (std::size_t k = 0; k < senses.size(); ++k) {
    StripPart part{k == 0 ? "positive" : "negative", senses[k], {}, {}};
    if (!choose_strips(part.sense, part.tests, findings)) continue;
    const std::string words =
        part.sense + " sense, " + counted_words(part.tests.strips.size(), "strip");
    const double begin = 0.05 + 0.45 * static_cast<double>(k);
    report({"profiles", words, 0, 0.0, begin});
    estimation::FrictionFitOptions options;
    options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    options.fit.on_iteration = [&](int iteration, double cost) {
      report({"fit", words, iteration, cost, begin + 0.1});
      return !stop.stop_requested();
    };
    auto found = findings.are_spirals ? fit_bending(part.tests, strips->measure, options)
                                      : fit_cantilevers(part.tests, strips->measure, options);
    if (stop.stop_requested()) return fail(ErrorKind::cancelled, "cancelled");
    if (!found) return bad_input(part.sense + " sense: " + found.error().message);
    part.found = std::move(*found);
    findings.parts.push_back(std::move(part));
  }
  if (findings.parts.empty())
    return bad_input(findings.are_spirals
                         ? "captures: no strip was rolled around a cylinder (radius): friction "
                           "shows in spirals; --protocol cantilever takes the others"
                         : "captures: every strip was rolled around a cylinder: there is no "
                           "cantilever");
  for (StripPart& part : findings.parts) look_at_samples(part);
  report({"write", "", 0, 0.0, 0.98});
  return write_strip_documents(input, std::move(findings), *strips, captures);
}

}  // namespace tenter::jobs
