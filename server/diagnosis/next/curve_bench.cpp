// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/next/curve_bench.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>

namespace tenter::diagnosis {
namespace {

Mounting mounting_of(const estimation::Curves& curves, int number) {
  Mounting mounting;
  mounting.mounted_as = curves.title;
  mounting.capture = number;
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
    const auto& path = data.curves[static_cast<std::size_t>(one.capture)].path;
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
  return fastest;
}

double largest_force(const estimation::DataSet& data) {
  double largest = 0.0;
  for (const estimation::Curves& curves : data.curves)
    for (const auto& channel : curves.channels)
      for (const double value : channel.measured)
        if (channel.is_stress && std::isfinite(value)) largest = std::max(largest, std::abs(value));
  return largest;
}

}  // namespace

std::optional<Foretold> foretell(const Experiment& plan, const Reference& at,
                                 const estimation::DataSet& data, int like) {
  const auto which = static_cast<std::size_t>(like);
  auto next = std::make_shared<estimation::DataSet>();
  next->curves.push_back(curves_of(plan, data.curves[which]));
  next->sigma.push_back(data.sigma[which]);
  auto& left_out = next->left_out.emplace_back();
  for (const auto& channel : next->curves.front().channels)
    left_out.emplace_back(channel.measured.size(), false);
  auto evaluator = estimation::Evaluator::make(at.model, next);
  if (!evaluator) return std::nullopt;
  Foretold result;
  estimation::RowMatrix jacobian;
  if (evaluator->evaluate(estimation::parameter_values(at.model), result.whitened, &jacobian) !=
      mechanics::PathStatus::ok)
    return std::nullopt;
  result.jacobian = jacobian(Eigen::all, moving_columns(at));
  const auto& rows = evaluator->rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto& channel = next->curves.front().channels[static_cast<std::size_t>(rows[r].channel)];
    if (channel.is_stress)
      result.largest_force =
          std::max(result.largest_force, std::abs(result.whitened[static_cast<Eigen::Index>(r)]) *
                                             evaluator->sigma(static_cast<int>(r)));
  }
  return result;
}

Bench curve_bench(const std::vector<const Reference*>& rivals, const estimation::DataSet& data,
                  const RigLimits& limits) {
  Bench bench;
  bench.mountings = mountings(data);
  bench.fastest_per_s = fastest_of(data);
  bench.strongest =
      limits.largest_N_m > 0.0 ? limits.largest_N_m : kWiderThanCaptured * largest_force(data);
  bench.foretell = [&](const Experiment& plan, const Mounting& mounting, std::size_t k) {
    return foretell(plan, *rivals[k], data, mounting.capture);
  };
  return bench;
}

}  // namespace tenter::diagnosis
