// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/next/design.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>

#include "server/diagnosis/next/separation.h"

namespace tenter::diagnosis {
namespace {

constexpr double kTelling = 0.5;  // sigmas, rms over the readings: less tells nothing apart
constexpr double kUsualRate_per_s = 0.01;
constexpr double kHold_s = 300.0;
constexpr double kWider = 1.5;

/// A capture and the component in which it was pulled farthest.
struct Mounting {
  int curve = 0;
  int component = 0;
  double reach = 0.0;
};

Mounting mounting_of(const estimation::Curves& curves, int number) {
  Mounting mounting;
  mounting.curve = number;
  for (int i = 0; i < 3; ++i) {
    if (curves.path.is_free[static_cast<std::size_t>(i)]) continue;
    for (const auto& q : curves.path.q) {
      const double strain = std::abs(q[i] - (i == 2 ? 0.0 : 1.0));
      if (strain <= mounting.reach) continue;
      mounting.reach = strain;
      mounting.component = i;
    }
  }
  return mounting;
}

/// One for each way in which specimens were held and pulled: the farthest.
std::vector<Mounting> mountings(const estimation::DataSet& data) {
  std::vector<Mounting> all;
  for (std::size_t i = 0; i < data.curves.size(); ++i) {
    const Mounting one = mounting_of(data.curves[i], static_cast<int>(i));
    if (one.reach > 0.0) all.push_back(one);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Mounting& a, const Mounting& b) { return a.reach > b.reach; });
  std::set<std::tuple<double, std::array<bool, 3>, int>> taken;
  std::erase_if(all, [&](const Mounting& one) {
    const auto& path = data.curves[static_cast<std::size_t>(one.curve)].path;
    return !taken.insert({path.axis_angle_rad, path.is_free, one.component}).second;
  });
  return all;
}

double fastest_of(const estimation::DataSet& data) {
  double fastest = 0.0;
  for (const estimation::Curves& curves : data.curves) {
    if (curves.time_base == estimation::TimeBase::none) continue;
    for (const estimation::Block& block : curves.blocks) {
      const auto first = static_cast<std::size_t>(block.first);
      const auto last = static_cast<std::size_t>(block.last - 1);
      const double seconds = curves.clock_s[last] - curves.clock_s[first];
      if (seconds > 0.0 && last > first)
        fastest = std::max(
            fastest, (curves.path.q[last] - curves.path.q[first]).cwiseAbs().maxCoeff() / seconds);
    }
  }
  return fastest > 0.0 ? fastest : kUsualRate_per_s;
}

double largest_force(const estimation::DataSet& data) {
  double largest = 0.0;
  for (const estimation::Curves& curves : data.curves)
    for (const auto& channel : curves.channels)
      for (const double value : channel.measured)
        if (channel.is_stress && std::isfinite(value)) largest = std::max(largest, std::abs(value));
  return largest;
}

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

/// Of the pair that is closest.
std::optional<Separation> least_separation(const Experiment& plan,
                                           const std::vector<const Reference*>& rivals,
                                           const estimation::DataSet& data, int like) {
  std::optional<Separation> least;
  for (std::size_t i = 0; i < rivals.size(); ++i) {
    for (std::size_t j = i + 1; j < rivals.size(); ++j) {
      const auto apart = separation(plan, *rivals[i], *rivals[j], data, like);
      if (!apart) return std::nullopt;
      if (!least || apart->chi2 < least->chi2) least = apart;
    }
  }
  return least;
}

double evidence(const Experiment& plan, const Separation& apart) {
  return apart.chi2 / std::max(1, apart.rows) * static_cast<double>(plan.steps.size());
}

}  // namespace

std::optional<Design> design_next(const std::vector<const Reference*>& rivals,
                                  const estimation::DataSet& data, const RigLimits& limits,
                                  Question question) {
  const double fast = limits.fastest_per_s > 0.0 ? limits.fastest_per_s : fastest_of(data);
  const double strongest =
      limits.largest_N_m > 0.0 ? limits.largest_N_m : kWider * largest_force(data);
  std::optional<Design> best;
  int considered = 0;
  for (const Mounting& mounting : mountings(data)) {
    const double travel =
        limits.largest_strain > 0.0 ? limits.largest_strain : kWider * mounting.reach;
    const double reach = std::min(mounting.reach, travel);
    for (Experiment& plan : family(mounting.component, reach, travel, fast)) {
      if (plan.duration_s() > limits.longest_s || plan.largest_strain() > travel * (1.0 + 1e-9))
        continue;
      if (question == Question::of_rate && !plan.splits_rate()) continue;
      const auto apart = least_separation(plan, rivals, data, mounting.curve);
      if (!apart || apart->largest_N_m > strongest) continue;
      ++considered;
      if (apart->of_noise() < kTelling) continue;
      if (best && evidence(plan, *apart) <= evidence(best->plan, best->separation)) continue;
      best = Design{std::move(plan), data.curves[static_cast<std::size_t>(mounting.curve)].title,
                    *apart, 0};
    }
  }
  if (best) best->considered = considered;
  return best;
}

}  // namespace tenter::diagnosis
