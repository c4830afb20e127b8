// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/prepare.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "server/diagnosis/checks/lattice.h"
#include "server/estimation/thinning.h"

namespace tenter::diagnosis {
namespace {

using estimation::Curves;
using estimation::DataSet;

/// Nothing left out; sigma a hundredth of each channel's largest value until the noise is known.
DataSet first_data(const std::vector<Curves>& curves) {
  DataSet data;
  data.curves = curves;
  for (const Curves& c : curves) {
    std::vector<double> sigma;
    std::vector<std::vector<bool>> none;
    for (const auto& channel : c.channels) {
      double largest = 0.0;
      double reference = channel.is_stress || channel.component == 2 ? 0.0 : 1.0;
      for (const double v : channel.measured)
        if (std::isfinite(v)) largest = std::max(largest, std::abs(v - reference));
      sigma.push_back(std::max(0.01 * largest, 1e-9));
      none.emplace_back(c.frame_count(), false);
    }
    data.sigma.push_back(std::move(sigma));
    data.left_out.push_back(std::move(none));
  }
  return data;
}

/// A reading below what its neighbours suggest that no good reading of its component exceeds is at
/// the end of the load cell's range: a flat top, and no misreading.
void keep_flat_tops(const std::vector<Curves>& curves, std::vector<estimation::Outlier>& outliers) {
  constexpr double kNoise = 4.0;  // robust standard deviations between readings of one top
  const auto channel_of = [&](const estimation::Outlier& o) -> const estimation::ObservedChannel& {
    return curves[static_cast<std::size_t>(o.curve)].channels[static_cast<std::size_t>(o.channel)];
  };
  std::map<int, double> top;  // by component, of all that is not set aside
  std::set<std::tuple<int, int, int>> aside;
  for (const estimation::Outlier& o : outliers) aside.insert({o.curve, o.channel, o.frame});
  for (std::size_t i = 0; i < curves.size(); ++i)
    for (std::size_t c = 0; c < curves[i].channels.size(); ++c) {
      const estimation::ObservedChannel& channel = curves[i].channels[c];
      if (!channel.is_stress) continue;
      for (std::size_t f = 0; f < channel.measured.size(); ++f)
        if (std::isfinite(channel.measured[f]) &&
            !aside.contains({static_cast<int>(i), static_cast<int>(c), static_cast<int>(f)})) {
          const auto place = top.emplace(channel.component, channel.measured[f]).first;
          place->second = std::max(place->second, channel.measured[f]);
        }
    }
  std::erase_if(outliers, [&](const estimation::Outlier& o) {
    const estimation::ObservedChannel& channel = channel_of(o);
    const auto highest = top.find(channel.component);
    if (!channel.is_stress || o.deviation >= 0.0 || highest == top.end()) return false;
    const double noise = -o.deviation / o.score;
    return channel.measured[static_cast<std::size_t>(o.frame)] > highest->second - kNoise * noise;
  });
}

/// All stiffnesses times one factor where the forces at the start values miss by more than the
/// forces themselves, else nothing: free directions stay where they are, so that it can be had
/// without a search. A search from there would stop where a free direction comes to no rest.
std::optional<model::Model> with_start_in_reach(model::Model model, const DataPointer& data) {
  estimation::adapt_spline_ranges(model, data->curves);
  auto evaluator = estimation::Evaluator::make(model, data);
  Eigen::VectorXd residuals;
  if (!evaluator || evaluator->evaluate(estimation::parameter_values(model), residuals, nullptr) !=
                        mechanics::PathStatus::ok)
    return std::nullopt;
  const std::vector<double> shown = evaluator->predicted(residuals);
  double across = 0.0, square = 0.0, measured_square = 0.0, missed = 0.0;
  for (std::size_t r = 0; r < shown.size(); ++r) {
    const estimation::Row& row = evaluator->rows()[r];
    const estimation::Curves& curves = data->curves[static_cast<std::size_t>(row.curve)];
    if (!curves.channels[static_cast<std::size_t>(row.channel)].is_stress) continue;
    const double sigma = data->sigma_of(row);
    const double predicted = shown[r] / sigma;
    const double measured = predicted - residuals[static_cast<Eigen::Index>(r)];
    across += predicted * measured;
    square += predicted * predicted;
    measured_square += measured * measured;
    missed += (predicted - measured) * (predicted - measured);
  }
  if (missed <= measured_square || across <= 0.0) return std::nullopt;
  for (model::Parameter* p : estimation::parameters_of(model))
    if (!p->fixed && p->unit.find('N') != std::string::npos)
      p->value = std::clamp(p->value * across / square, p->lower.value_or(-1e300),
                            p->upper.value_or(1e300));
  return model;
}

/// The first fit, from the start values and, where these are out of reach, from nearer ones, too.
Expected<Reference> first_reference(const model::Model& start, const DataPointer& data,
                                    const estimation::FitOptions& options) {
  auto from_start = make_reference(start, data, options);
  const auto nearer = with_start_in_reach(start, data);
  if (!nearer) return from_start;
  auto from_nearer = make_reference(*nearer, data, options);
  const bool is_better =
      from_nearer && (!from_start || from_nearer->fit.chi2 < from_start->fit.chi2);
  return is_better ? from_nearer : from_start;
}

}  // namespace

DataSet thinned(const DataSet& full, int max_frames_per_block) {
  DataSet data;
  data.sigma = full.sigma;
  for (std::size_t i = 0; i < full.curves.size(); ++i) {
    data.curves.push_back(estimation::thin(full.curves[i], max_frames_per_block, full.left_out[i]));
    std::vector<std::vector<bool>> none;
    for (std::size_t c = 0; c < data.curves[i].channels.size(); ++c)
      none.emplace_back(data.curves[i].frame_count(), false);
    data.left_out.push_back(std::move(none));
  }
  return data;
}

std::pair<estimation::Noise, DataPointer> reweigh(const DataPointer& data,
                                                  const std::vector<estimation::Row>& rows,
                                                  const Eigen::VectorXd& residuals) {
  estimation::Noise noise = estimation::estimate_noise(*data, rows, residuals);
  auto weighed = std::make_shared<DataSet>(*data);
  for (std::size_t i = 0; i < weighed->sigma.size(); ++i)
    for (std::size_t c = 0; c < weighed->sigma[i].size(); ++c)
      weighed->sigma[i][c] = noise.channels[i][c].sigma;
  return {std::move(noise), std::move(weighed)};
}

std::optional<Weighed> weigh_without(const DataPointer& data, const estimation::Noise& noise,
                                     const Reference& found) {
  constexpr double kMuch = 0.7;
  Weighed weighed;
  std::tie(weighed.noise, weighed.data) = reweigh(data, data->rows(), found.fit.residuals);
  for (std::size_t i = 0; i < noise.channels.size(); ++i)
    for (std::size_t c = 0; c < noise.channels[i].size(); ++c) {
      const estimation::ChannelNoise& before = noise.channels[i][c];
      if (before.source == estimation::NoiseSource::repeats && before.repeat_sigma > 0.0)
        weighed.quieter = std::min(weighed.quieter,
                                   weighed.noise.channels[i][c].repeat_sigma / before.repeat_sigma);
    }
  if (weighed.quieter >= kMuch) return std::nullopt;
  return weighed;
}

Expected<Reference> make_reference(const model::Model& start, const DataPointer& data,
                                   const estimation::FitOptions& options) {
  Reference reference;
  reference.model = start;
  estimation::adapt_spline_ranges(reference.model, data->curves);
  auto evaluator = estimation::Evaluator::make(reference.model, data);
  if (!evaluator) return tl::unexpected(evaluator.error());
  reference.fit = estimation::fit(*evaluator, reference.model, options);
  if (!reference.fit.usable)
    return bad_input("the model \"" + start.name +
                     "\" cannot be fitted to these captures: " + reference.fit.message);
  estimation::store(reference.fit, reference.model);
  reference.block_chi2 =
      chi2_by_block(evaluator->rows(), reference.fit.residuals, data->block_count());
  return reference;
}

Expected<Prepared> prepare(const Request& request, const Control& control) {
  Prepared prepared;
  for (const auto& [id, capture] : request.captures) {
    auto curves = estimation::make_curves(capture, id);
    if (!curves) return tl::unexpected(curves.error());
    prepared.curves.push_back(std::move(*curves));
  }
  note_resolution(prepared.curves);
  estimation::FitOptions options;
  options.on_iteration = [&](int iteration, double cost) {
    control.report({"baseline", request.model.name, iteration, cost, 0.05});
    return !control.stop.stop_requested();
  };
  DataSet full = first_data(prepared.curves);
  auto coarse =
      std::make_shared<const DataSet>(thinned(full, request.options.max_frames_per_block));
  auto reference = first_reference(request.model, coarse, options);
  if (!reference) return tl::unexpected(reference.error());

  // isolated misreadings on every frame, seen against the first fit
  const auto whole = std::make_shared<const DataSet>(full);
  auto evaluator = estimation::Evaluator::make(reference->model, whole);
  if (!evaluator) return tl::unexpected(evaluator.error());
  Eigen::VectorXd residuals;
  if (evaluator->evaluate(reference->fit.parameters, residuals, nullptr) ==
      mechanics::PathStatus::ok) {
    prepared.outliers = estimation::find_outliers(*whole, evaluator->rows(), residuals, {});
    drop_within_steps(prepared.curves, prepared.outliers);
    keep_flat_tops(prepared.curves, prepared.outliers);
    for (const estimation::Outlier& o : prepared.outliers)
      full.left_out[static_cast<std::size_t>(o.curve)][static_cast<std::size_t>(o.channel)]
                   [static_cast<std::size_t>(o.frame)] = true;
  }
  DataPointer data =
      std::make_shared<const DataSet>(thinned(full, request.options.max_frames_per_block));
  // noise and fit depend on each other's weights: twice is enough
  model::Model model = reference->model;
  for (int pass = 0; pass < 2; ++pass) {
    if (control.stop.stop_requested())
      return fail(ErrorKind::cancelled, "stopped before the baseline was fitted");
    auto at = make_reference(model, data, options);
    if (!at) return tl::unexpected(at.error());
    std::tie(prepared.noise, data) = reweigh(data, data->rows(), at->fit.residuals);
    model = at->model;
  }
  auto baseline = make_reference(model, data, options);
  if (!baseline) return tl::unexpected(baseline.error());
  prepared.baseline = std::move(*baseline);
  prepared.data = std::move(data);
  return prepared;
}

}  // namespace tenter::diagnosis
