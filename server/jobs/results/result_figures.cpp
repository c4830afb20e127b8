// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/results/result_figures.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/jobs/results/result_document.h"

namespace tenter::jobs {
namespace {

using diagnosis::Diagnosis;
using estimation::Curves;
using nlohmann::json;
using report::ResidualTable;

constexpr std::size_t kPointsPerBlock = 150;

/// Predictions of one model on every frame, NaN where it could not be evaluated:
/// [curve][channel][frame].
using Predictions = std::vector<std::vector<std::vector<double>>>;

Predictions predict(const model::Model& model, const std::vector<Curves>& curves) {
  Predictions result;
  auto data = std::make_shared<estimation::DataSet>();
  data->curves = curves;
  for (const Curves& c : curves) {
    std::vector<std::vector<double>> channels;
    std::vector<std::vector<bool>> none;
    for (std::size_t k = 0; k < c.channels.size(); ++k) {
      channels.emplace_back(c.frame_count(), std::nan(""));
      none.emplace_back(c.frame_count(), false);
    }
    result.push_back(std::move(channels));
    data->left_out.push_back(std::move(none));
    data->sigma.emplace_back(c.channels.size(), 1.0);
  }
  auto evaluator = estimation::Evaluator::make(model, data);
  Eigen::VectorXd residuals;
  if (!evaluator || evaluator->evaluate(estimation::parameter_values(model), residuals, nullptr) !=
                        mechanics::PathStatus::ok)
    return result;
  const std::vector<double> values = evaluator->predicted(residuals);
  for (std::size_t r = 0; r < values.size(); ++r) {
    const estimation::Row& row = evaluator->rows()[r];
    result[static_cast<std::size_t>(row.curve)][static_cast<std::size_t>(row.channel)]
          [static_cast<std::size_t>(row.frame)] = values[r];
  }
  return result;
}

/// Rows of a table that a figure shows: every block's first and last, and evenly between.
std::vector<std::size_t> shown_rows(const ResidualTable& table, int block) {
  std::vector<std::size_t> rows;
  for (std::size_t r = 0; r < table.size(); ++r)
    if (table.block[r] == block) rows.push_back(r);
  if (rows.size() <= kPointsPerBlock) return rows;
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < kPointsPerBlock; ++k)
    chosen.push_back(rows[k * (rows.size() - 1) / (kPointsPerBlock - 1)]);
  return chosen;
}

/// The strain that moves most over the table.
const std::vector<double>& driver(const ResidualTable& table, std::string& name) {
  const std::vector<double>* all[] = {&table.strain_x, &table.strain_y, &table.strain_xy};
  static constexpr const char* kNames[] = {"strain x", "strain y", "shear xy"};
  int best = 0;
  double most = -1.0;
  for (int i = 0; i < 3; ++i) {
    double lo = 1e300;
    double hi = -1e300;
    for (const double v : *all[i]) {
      if (!std::isfinite(v)) continue;
      lo = std::min(lo, v);
      hi = std::max(hi, v);
    }
    // the component of the channel wins a tie, being the conjugate one
    if (hi - lo > most * (1.0 + 1e-9)) {
      most = hi - lo;
      best = i;
    }
  }
  name = kNames[best];
  return *all[best];
}

struct Axis {
  std::string name;
  std::string unit;
};

json figure(const char* kind, const ResidualTable& table, const std::string& title, const Axis& x,
            const Axis& y, json series) {
  return {{"kind", kind},
          {"capture", table.capture_id},
          {"title", title},
          {"x", {{"name", x.name}, {"unit", x.unit}}},
          {"y", {{"name", y.name}, {"unit", y.unit}}},
          {"series", std::move(series)}};
}

/// One series of a block; points where either coordinate is missing, or that `keep` refuses, are
/// left out.
template <class Y, class Keep>
void add_series(json& list, const ResidualTable& table, int block, const std::vector<double>& x,
                const char* role, const std::vector<std::size_t>& rows, Y&& y, Keep&& keep) {
  json xs = json::array();
  json ys = json::array();
  for (const std::size_t r : rows) {
    const double value = y(r);
    if (!keep(r) || !std::isfinite(x[r]) || !std::isfinite(value)) continue;
    xs.push_back(x[r]);
    ys.push_back(value);
  }
  if (xs.empty()) return;
  static constexpr const char* kBranches[] = {"load", "unload", "hold", "other"};
  const std::string name = std::string(role) + ", run " + std::to_string(table.run[rows.front()]) +
                           " " + kBranches[table.branch[rows.front()]];
  list.push_back({{"name", name},
                  {"role", role},
                  {"block", block},
                  {"branch", kBranches[table.branch[rows.front()]]},
                  {"x", xs},
                  {"y", ys}});
}

int blocks_of(const ResidualTable& table) {
  return table.block.empty() ? 0 : 1 + *std::max_element(table.block.begin(), table.block.end());
}

}  // namespace

std::vector<ResidualTable> residual_tables(const Diagnosis& d) {
  const Predictions baseline = predict(d.baseline.model, d.curves);
  const Predictions extended = predict(d.extended.model, d.curves);
  std::vector<ResidualTable> tables;
  for (std::size_t i = 0; i < d.curves.size(); ++i) {
    const Curves& curves = d.curves[i];
    for (std::size_t c = 0; c < curves.channels.size(); ++c) {
      ResidualTable table;
      table.capture_id = curves.id;
      table.capture_title = curves.title;
      table.channel = curves.channels[c].name;
      table.unit = curves.channels[c].unit;
      table.measured = curves.channels[c].measured;
      table.predicted_baseline = baseline[i][c];
      table.predicted_extended = extended[i][c];
      table.frame = curves.frame;
      table.block = curves.block_of;
      if (curves.time_base != estimation::TimeBase::none) table.time_s = curves.clock_s;
      for (std::size_t f = 0; f < curves.frame_count(); ++f) {
        const estimation::Block& block =
            curves.blocks[static_cast<std::size_t>(curves.block_of[f])];
        table.run.push_back(curves.runs[static_cast<std::size_t>(block.run)].number);
        table.branch.push_back(static_cast<int>(block.branch));
        table.strain_x.push_back(curves.path.q[f][0] - 1.0);
        table.strain_y.push_back(curves.path.q[f][1] - 1.0);
        table.strain_xy.push_back(curves.path.q[f][2]);
        table.sigma.push_back(d.noise.channels[i][c].sigma);
        table.weight.push_back(std::isfinite(table.measured[f]) ? 1.0 : 0.0);
      }
      for (const estimation::Outlier& o : d.outliers)
        if (o.curve == static_cast<int>(i) && o.channel == static_cast<int>(c))
          table.weight[static_cast<std::size_t>(o.frame)] = 0.0;
      tables.push_back(std::move(table));
    }
  }
  return tables;
}

json figures_json(const Diagnosis& d) {
  json figures = json::array();
  for (const ResidualTable& table : residual_tables(d)) {
    const bool is_stress = table.unit == "N/m";
    std::string x_name;
    const std::vector<double>& x = driver(table, x_name);
    const Axis strain{x_name, "1"};
    json loops = json::array();
    json over_strain = json::array();
    json over_time = json::array();
    const auto any = [](std::size_t) { return true; };
    const auto used = [&](std::size_t r) { return table.weight[r] > 0.0; };
    const auto unused = [&](std::size_t r) { return table.weight[r] == 0.0; };
    for (int block = 0; block < blocks_of(table); ++block) {
      const auto rows = shown_rows(table, block);
      if (rows.empty()) continue;
      const auto measured = [&](std::size_t r) { return table.measured[r]; };
      const auto before = [&](std::size_t r) {
        return table.measured[r] - table.predicted_baseline[r];
      };
      const auto after = [&](std::size_t r) {
        return table.measured[r] - table.predicted_extended[r];
      };
      add_series(loops, table, block, x, "measured", rows, measured, used);
      add_series(
          loops, table, block, x, "baseline", rows,
          [&](std::size_t r) { return table.predicted_baseline[r]; }, any);
      add_series(
          loops, table, block, x, "extended", rows,
          [&](std::size_t r) { return table.predicted_extended[r]; }, any);
      std::vector<std::size_t> out;
      for (std::size_t r = 0; r < table.size(); ++r)
        if (table.block[r] == block && std::isfinite(table.measured[r]) && table.weight[r] == 0.0)
          out.push_back(r);
      if (!out.empty()) add_series(loops, table, block, x, "outlier", out, measured, unused);
      add_series(over_strain, table, block, x, "baseline", rows, before, used);
      add_series(over_strain, table, block, x, "extended", rows, after, used);
      if (table.time_s.empty()) continue;
      add_series(over_time, table, block, table.time_s, "baseline", rows, before, used);
      add_series(over_time, table, block, table.time_s, "extended", rows, after, used);
    }
    const std::string name = table.channel + ", " + table.capture_title;
    figures.push_back(figure(is_stress ? "loop" : "transverse", table, name, strain,
                             {table.channel, table.unit}, loops));
    const double sigma = table.sigma.empty() ? 0.0 : table.sigma.front();
    const Axis residual{"measured - model", table.unit};
    const auto add_residual = [&](const char* kind, const Axis& axis, json series) {
      json drawn = figure(kind, table, "Residual of " + name, axis, residual, std::move(series));
      drawn["band"] = {-sigma, sigma};
      figures.push_back(std::move(drawn));
    };
    add_residual("residual_strain", strain, std::move(over_strain));
    if (!over_time.empty()) add_residual("residual_time", {"time", "s"}, std::move(over_time));
  }
  return figures;
}

}  // namespace tenter::jobs
