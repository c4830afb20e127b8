// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/requests/requests_json.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/jobs/results/json_number.h"

namespace tenter::jobs {
namespace {

using nlohmann::json;

json starts_json(const StartsFound& starts) {
  json outcomes = json::array();
  for (const estimation::StartOutcome& outcome : starts.outcomes)
    outcomes.push_back({{"start", outcome.start},
                        {"cost", number(outcome.cost)},
                        {"iterations", outcome.iterations},
                        {"message", outcome.message}});
  return {{"count", starts.count},
          {"seed", starts.seed},
          {"widest", starts.widest},
          {"share", starts.share},
          {"frames", starts.frames},
          {"cost_of_fit", number(starts.cost_of_fit)},
          {"in_best_basin", starts.in_best_basin},
          {"is_better", starts.is_better},
          {"outcomes", outcomes}};
}

json convexity_json(const ConvexFound& convex, const SheetFindings& found) {
  return {{"way", convex_word(found.options.convex)},
          {"was_convex", convex.was_convex},
          {"is_convex", convex.is_convex},
          {"least", convex.term.empty() ? json(nullptr)
                                        : json{{"term", convex.term},
                                               {"strain", convex.strain},
                                               {"eigenvalue", number(convex.smallest)}}},
          {"cost_before", number(convex.cost_before)},
          {"cost_after", number(convex.cost_after)},
          {"projections", convex.projections},
          {"iterations", convex.iterations},
          {"message", convex.message}};
}

json samples_json(const SamplesFound& samples) {
  json places = json::array(), steps = json::array();
  const auto& positions = samples.samples.field.positions_m;
  for (std::size_t i = 0; i + 1 < positions.size(); i += 2)
    places.push_back({positions[i], positions[i + 1]});
  for (const estimation::SampleStep& step : samples.fit.steps)
    steps.push_back({{"sample", step.sample + 1},
                     {"kept", step.kept},
                     {"training", number(step.training)},
                     {"held_out_before", number(step.held_out_before)},
                     {"held_out", number(step.held_out)},
                     {"sigmas", number(step.sigmas)},
                     {"rows_left_out", step.rows_left_out}});
  json released = json::array();
  for (const int sample : samples.fit.released) released.push_back(sample + 1);
  return {{"positions_m", places},
          {"width_m", samples.samples.field.width_m},
          {"released", released},
          {"steps", steps},
          {"training_before", number(samples.fit.homogeneous_training)},
          {"training", number(samples.fit.training)},
          {"held_out_before", number(samples.fit.homogeneous_held_out)},
          {"held_out", number(samples.fit.held_out)},
          {"message", samples.message}};
}

json limit_json(const LimitFound& limit) {
  json rounds = json::array();
  for (const estimation::LimitRound& round : limit.fit.rounds)
    rounds.push_back({{"energy_max", number(round.energy_max)}, {"cost", number(round.cost)}});
  return {{"id", limit.id},
          {"unit", "J/m^2"},
          {"given", limit.given},
          {"is_reached", limit.fit.is_reached},
          {"converged", limit.fit.converged},
          {"energy_max", number(limit.fit.energy_max)},
          {"std_error", limit.fit.is_reached ? number(limit.fit.std_error) : json(nullptr)},
          {"at_least", limit.fit.at_least ? number(*limit.fit.at_least) : json(nullptr)},
          {"active_frames", limit.fit.active_frames},
          {"cost", number(limit.fit.cost)},
          {"cost_without", number(limit.fit.cost_without)},
          {"rounds", rounds},
          {"message", limit.message}};
}

/// Null where nothing of the kind was measured.
json size_json(const estimation::GridErrorSize& size) {
  if (size.rows == 0) return nullptr;
  return {{"rms", number(size.rms)},
          {"largest", number(size.largest)},
          {"sigmas", number(size.sigmas)},
          {"rows", size.rows}};
}

json grid_free_json(const GridFreeFound& grid_free, const SheetFindings& found) {
  json captures = json::array();
  for (std::size_t i = 0; i < grid_free.captures.size(); ++i) {
    const GridFreeFound::OfCapture& of = grid_free.captures[i];
    captures.push_back({{"id", found.inputs[i].id},
                        {"title", found.inputs[i].capture.title},
                        {"order", of.order},
                        {"force", size_json(of.force)},
                        {"position", size_json(of.position)},
                        {"frames_without", of.frames_without}});
  }
  return {{"rounds", grid_free.rounds},
          {"settled", grid_free.settled},
          {"change_sigmas", number(grid_free.change_sigmas)},
          {"share_as_sigma", grid_free.share_as_sigma},
          {"captures", captures}};
}

json check(bool is_good, const std::string& what, const std::string& why) {
  return {{"level", is_good ? "OK" : "WARNING"}, {"what", what}, {"why", why}};
}

json starts_check(const StartsFound& starts) {
  char why[200];
  if (starts.is_better)
    std::snprintf(why, sizeof why,
                  "a random start ended at a cost of %.4g, the stages' values at %.4g: the fit was "
                  "taken from there",
                  starts.outcomes.front().cost, starts.cost_of_fit);
  else
    std::snprintf(why, sizeof why, "%d of %zu starts ended within %g %% of the lowest cost",
                  starts.in_best_basin, starts.outcomes.size(), 100.0 * starts.share);
  return check(!starts.is_better, "Random starts", why);
}

json grid_free_check(const GridFreeFound& grid_free) {
  double force_N = 0.0, position_m = 0.0;
  int without = 0;
  for (const GridFreeFound::OfCapture& of : grid_free.captures) {
    force_N = std::max(force_N, of.force.rms);
    position_m = std::max(position_m, of.position.rms);
    without += of.frames_without;
  }
  char why[320];
  std::snprintf(why, sizeof why,
                "estimated from a grid of half the spacing: up to %.2g N of a capture's forces and "
                "%.2g m of its positions (rms); %s after %d rounds%s",
                force_N, position_m, grid_free.settled ? "settled" : "still changing",
                grid_free.rounds,
                without > 0 ? ("; " + std::to_string(without) +
                               " frames have no estimate: their forces were not fitted")
                                  .c_str()
                            : "");
  return check(grid_free.settled && without == 0, "The grid's error was taken off", why);
}

json samples_check(const SamplesFound& samples) {
  if (!samples.message.empty())
    return check(false, "Material samples could not be added", samples.message);
  char why[200];
  if (samples.fit.released.empty())
    std::snprintf(why, sizeof why,
                  "none of %zu that were tried made the held-out captures fit better",
                  samples.fit.steps.size());
  else
    std::snprintf(why, sizeof why,
                  "%zu were kept; the cost of held-out captures went from %.4g to "
                  "%.4g",
                  samples.fit.released.size(), samples.fit.homogeneous_held_out,
                  samples.fit.held_out);
  return check(true, "Material samples", why);
}

}  // namespace

void put_requests(const SheetFindings& found, json& document) {
  const Requested& requested = found.requested;
  document["grid_error"] =
      requested.grid_free ? grid_free_json(*requested.grid_free, found) : json(nullptr);
  document["starts"] = requested.starts ? starts_json(*requested.starts) : json(nullptr);
  document["convexity"] =
      requested.convexity ? convexity_json(*requested.convexity, found) : json(nullptr);
  document["samples"] = requested.samples ? samples_json(*requested.samples) : json(nullptr);
  document["limit"] = requested.limit ? limit_json(*requested.limit) : json(nullptr);
}

void put_request_checks(const SheetFindings& found, json& checklist) {
  const Requested& requested = found.requested;
  if (requested.grid_free) checklist.push_back(grid_free_check(*requested.grid_free));
  if (requested.starts) checklist.push_back(starts_check(*requested.starts));
  if (requested.convexity) {
    const ConvexFound& convex = *requested.convexity;
    checklist.push_back(check(
        convex.is_convex, convex.is_convex ? "The energy is convex" : "The energy is not convex",
        convex.message));
    const bool is_moved = convex.is_convex && found.options.convex != ConvexWay::by_construction &&
                          convex.cost_after != convex.cost_before;
    if (is_moved)
      checklist.push_back(check(false, "Intervals do not know of convexity",
                                "errors are those of the same parameters without its conditions"));
  }
  if (requested.samples) checklist.push_back(samples_check(*requested.samples));
  if (requested.limit)
    checklist.push_back(
        check(requested.limit->fit.is_reached, "Energy limit", requested.limit->message));
}

}  // namespace tenter::jobs
