// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/next/design.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace tenter::diagnosis {
namespace {

constexpr double kTelling = 0.5;  // sigmas, rms over the readings: less tells nothing apart
constexpr double kUsualRate_per_s = 0.01;
constexpr double kHold_s = 300.0;

using Steps = std::vector<ExperimentStep>;

void loop(double low, double high, double rate, Steps& steps) {
  steps.push_back(ramp_to(high, rate));
  steps.push_back(ramp_to(low, rate));
}

/// The family: each a question that some pair of causes answers differently.
std::vector<Experiment> family(int component, double reach, double widest, double fast) {
  const double slow = fast / 10.0;
  std::vector<Experiment> all;
  const auto add = [&](const char* name, Steps steps) {
    all.push_back({name, component, std::move(steps)});
  };
  Steps rates;
  loop(0.0, reach, slow, rates);
  loop(0.0, reach, fast, rates);
  add("two_rates", rates);
  Steps hold = {ramp_to(0.5 * reach, fast), hold_for(kHold_s), ramp_to(0.0, fast)};
  add("hold", hold);
  Steps rates_and_hold = rates;
  rates_and_hold.insert(rates_and_hold.end(), hold.begin(), hold.end());
  add("two_rates_and_hold", std::move(rates_and_hold));
  Steps nested;
  for (const double share : {0.25, 0.5, 0.75, 1.0}) loop(0.0, share * reach, fast, nested);
  add("nested_loops", std::move(nested));
  Steps returning;
  for (const double share : {0.25, 0.5, 1.0}) {
    loop(0.0, share * reach, fast, returning);
    for (int k = 0; k < 2; ++k) loop(0.0, 0.05 * reach, fast, returning);
  }
  add("nested_loops_with_return", std::move(returning));
  Steps repeats;
  for (const double share : {1.0 / 3.0, 2.0 / 3.0, 1.0})
    for (int k = 0; k < 3; ++k) loop(0.0, share * reach, fast, repeats);
  add("repeat_cycles_growing", std::move(repeats));
  Steps offsets;
  for (const double share : {0.25, 0.5, 0.9}) {
    offsets.push_back(ramp_to(share * reach, fast));
    for (int k = 0; k < 2; ++k) loop((share - 0.1) * reach, (share + 0.1) * reach, fast, offsets);
  }
  offsets.push_back(ramp_to(0.0, fast));
  add("nested_loops_at_offsets", std::move(offsets));
  if (widest > reach) {
    Steps wider;
    loop(0.0, widest, slow, wider);
    add("wider_range", std::move(wider));
  }
  return all;
}

/// What every rival says of a plan; nothing where one of them cannot do it.
std::optional<Separation> least_separation(const Experiment& plan, const Mounting& mounting,
                                           const std::vector<const Reference*>& rivals,
                                           const Bench& bench) {
  std::vector<Foretold> foretold;
  for (std::size_t k = 0; k < rivals.size(); ++k) {
    auto one = bench.foretell(plan, mounting, k);
    if (!one) return std::nullopt;
    foretold.push_back(std::move(*one));
  }
  return separation(foretold, rivals);
}

double evidence(const Experiment& plan, const Separation& apart) {
  return apart.chi2 / std::max(1, apart.rows) * static_cast<double>(plan.steps.size());
}

}  // namespace

std::optional<Design> design_next(const std::vector<const Reference*>& rivals, const Bench& bench,
                                  const RigLimits& limits, Question question) {
  const double known = bench.fastest_per_s > 0.0 ? bench.fastest_per_s : kUsualRate_per_s;
  const double fast = limits.fastest_per_s > 0.0 ? limits.fastest_per_s : known;
  std::optional<Design> best;
  int considered = 0;
  for (const Mounting& mounting : bench.mountings) {
    const double travel =
        limits.largest_strain > 0.0 ? limits.largest_strain : kWiderThanCaptured * mounting.reach;
    const double reach = std::min(mounting.reach, travel);
    for (Experiment& plan : family(mounting.component, reach, travel, fast)) {
      if (plan.duration_s() > limits.longest_s || plan.largest_strain() > travel * (1.0 + 1e-9))
        continue;
      if (question == Question::of_rate && !plan.splits_rate()) continue;
      const auto apart = least_separation(plan, mounting, rivals, bench);
      if (!apart || apart->largest_force > bench.strongest) continue;
      ++considered;
      if (apart->of_noise() < kTelling) continue;
      if (best && evidence(plan, *apart) <= evidence(best->plan, best->separation)) continue;
      best = Design{std::move(plan), mounting.mounted_as, *apart, 0};
    }
  }
  if (best) best->considered = considered;
  return best;
}

void describe(const Design& design, NextProtocol& protocol) {
  char apart[32];
  std::snprintf(apart, sizeof apart, "%.2g", design.separation.of_noise());
  protocol.name = design.plan.name;
  protocol.words = "A new specimen, mounted as in \"" + design.mounted_as + "\", " +
                   (design.plan.component == kWayOfClips
                        ? "its clips led along the way that they took there, as listed (0 % is "
                          "where they began)"
                        : "pulled as listed") +
                   ": of " + std::to_string(design.considered) +
                   " pulls within the rig's limits the one that splits them best. What the causes "
                   "foretell differs by " +
                   apart + " times the noise there, after the wrong one has given way.";
  protocol.phases.clear();
  const std::vector<std::string> words = words_of(design.plan);
  for (std::size_t i = 0; i < words.size(); ++i)
    protocol.phases.push_back({design.plan.steps[i].is_hold ? "hold" : "ramp", words[i]});
}

}  // namespace tenter::diagnosis
