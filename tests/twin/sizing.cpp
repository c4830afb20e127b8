// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/sizing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tenter::twin {
namespace {

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

void subtract(std::vector<double>& from, double factor, const std::vector<double>& what) {
  for (std::size_t i = 0; i < from.size(); ++i) from[i] -= factor * what[i];
}

// directions of the baseline's parameters in (c11, c22, c12, c33)
std::vector<Elastic> directions(Baseline baseline) {
  switch (baseline) {
    case Baseline::stvk_orthotropic:
      return {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    case Baseline::stvk_isotropic:  // lambda, mu
      return {{1, 1, 1, 0}, {2, 2, 0, 1}};
    case Baseline::stvk_diagonal:
      return {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}};
  }
  return {};
}

Truth moved(Truth truth, const Elastic& direction, double step) {
  truth.cloth.elastic.c11 += step * direction.c11;
  truth.cloth.elastic.c22 += step * direction.c22;
  truth.cloth.elastic.c12 += step * direction.c12;
  truth.cloth.elastic.c33 += step * direction.c33;
  return truth;
}

/// Columns as products of orthonormal ones and a triangle.
struct Orthonormal {
  std::vector<std::vector<double>> q;
  std::vector<std::vector<double>> r;  ///< r[j]: column j by the q before it, then its own
  std::vector<std::ptrdiff_t> own;     ///< which q column j added; -1: none

  /// Coefficients of the columns in the least squares sense; zero for a column that added nothing.
  std::vector<double> solve(const std::vector<double>& target) const {
    std::vector<double> along(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) along[i] = dot(q[i], target);
    std::vector<double> coefficients(own.size(), 0.0);
    for (std::size_t j = own.size(); j-- > 0;) {
      if (own[j] < 0) continue;
      const auto last = static_cast<std::size_t>(own[j]);
      coefficients[j] = along[last] / r[j][last];
      for (std::size_t i = 0; i <= last; ++i) along[i] -= coefficients[j] * r[j][i];
    }
    return coefficients;
  }
};

// modified Gram-Schmidt; a direction that the suite does not excite drops out
Orthonormal orthonormal(std::vector<std::vector<double>> columns) {
  Orthonormal basis;
  for (std::vector<double>& column : columns) {
    const double before = std::sqrt(dot(column, column));
    std::vector<double> along;
    for (const std::vector<double>& q : basis.q) {
      along.push_back(dot(q, column));
      subtract(column, along.back(), q);
    }
    const double after = std::sqrt(dot(column, column));
    const bool adds = after > 1e-6 * before;
    basis.own.push_back(adds ? static_cast<std::ptrdiff_t>(basis.q.size()) : -1);
    if (adds) {
      along.push_back(after);
      for (double& value : column) value /= after;
      basis.q.push_back(std::move(column));
    }
    basis.r.push_back(std::move(along));
  }
  return basis;
}

}  // namespace

std::string preset_name(Baseline baseline) {
  switch (baseline) {
    case Baseline::stvk_orthotropic:
      return "stvk_orthotropic";
    case Baseline::stvk_isotropic:
      return "stvk_isotropic";
    case Baseline::stvk_diagonal:
      return "stvk_diagonal";
  }
  return "";
}

Baseline baseline_for(const std::vector<std::string>& effect_ids) {
  for (const std::string& id : effect_ids) {
    if (id == "anisotropy") return Baseline::stvk_isotropic;
    if (id == "poisson_coupling") return Baseline::stvk_diagonal;
  }
  return Baseline::stvk_orthotropic;
}

std::vector<double> whitened_readings(const std::vector<PlannedCapture>& plans, const Truth& truth,
                                      const NoiseLevels& noise, std::vector<double>* sigma_N_m) {
  std::vector<double> rows;
  const auto append = [&](const std::vector<double>& column, double sigma, bool is_stress = true) {
    for (const double value : column) rows.push_back(value / sigma);
    if (sigma_N_m) sigma_N_m->insert(sigma_N_m->end(), column.size(), is_stress ? sigma : 0.0);
  };
  for (std::size_t c = 0; c < plans.size(); ++c) {
    Readings readings = measure(plans[c], c, truth.cloth, truth.faults);
    show_in_steps(truth.faults.step_N_m[0], readings.stress_x);
    show_in_steps(truth.faults.step_N_m[1], readings.stress_y);
    append(readings.stress_x, noise.stress_N_m);
    append(readings.stress_y, noise.stress_N_m);
    append(readings.stress_shear, noise.shear_stress_N_m);
    append(readings.stretch_x, noise.observed_stretch, false);
    append(readings.stretch_y, noise.observed_stretch, false);
  }
  return rows;
}

Ruler::Ruler(const std::vector<PlannedCapture>& plans, const Truth& plain, Baseline baseline,
             const NoiseLevels& noise)
    : plans_(plans),
      noise_(noise),
      plain_cloth_(plain),
      directions_(directions(baseline)),
      plain_(whitened_readings(plans, plain, noise)),
      span_(orthonormal(columns_at(plain)).q) {}

std::vector<std::vector<double>> Ruler::columns_at(const Truth& cloth) const {
  const double step = 1e-3 * plain_cloth_.cloth.elastic.c11;
  std::vector<std::vector<double>> columns;
  for (const Elastic& direction : directions_) {
    std::vector<double> column = whitened_readings(plans_, moved(cloth, direction, step), noise_);
    subtract(column, 1.0, whitened_readings(plans_, moved(cloth, direction, -step), noise_));
    for (double& value : column) value /= 2.0 * step;
    columns.push_back(std::move(column));
  }
  return columns;
}

std::vector<double> Ruler::unabsorbed(const std::vector<double>& readings) const {
  std::vector<double> added = readings;
  subtract(added, 1.0, plain_);
  for (const std::vector<double>& q : span_) subtract(added, dot(q, added), q);
  return added;
}

double Ruler::share_of_force(const Truth& truth) const {
  constexpr int kMostSteps = 10;
  constexpr double kSettled = 1e-8;  // of the misfit
  std::vector<double> sigma_N_m;
  const std::vector<double> readings = whitened_readings(plans_, truth, noise_, &sigma_N_m);
  Truth best = plain_cloth_;
  std::vector<double> left = readings;
  subtract(left, 1.0, plain_);
  for (int k = 0; k < kMostSteps; ++k) {  // Gauss-Newton; nearly linear in so few stiffnesses
    const double before = dot(left, left);
    const Orthonormal basis = orthonormal(columns_at(best));
    const std::vector<double> steps = basis.solve(left);
    Truth next = best;
    for (std::size_t d = 0; d < steps.size(); ++d) next = moved(next, directions_[d], steps[d]);
    std::vector<double> then = readings;
    subtract(then, 1.0, whitened_readings(plans_, next, noise_));
    if (dot(then, then) >= before) break;
    best = next;
    left = std::move(then);
    if (before - dot(left, left) < kSettled * before) break;
  }
  double effect = 0.0;
  double force = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    effect += left[i] * left[i] * sigma_N_m[i] * sigma_N_m[i];
    force += readings[i] * readings[i] * sigma_N_m[i] * sigma_N_m[i];
  }
  return force > 0.0 ? std::sqrt(effect / force) : 0.0;
}

double Ruler::size_of(const Truth& truth) const {
  const std::vector<double> added = unabsorbed(whitened_readings(plans_, truth, noise_));
  return std::sqrt(dot(added, added) / static_cast<double>(added.size()));
}

Sized find_amplitude(double first_guess, double largest, double wanted,
                     const std::function<double(double)>& size_of, double tolerance) {
  constexpr int kMostTrials = 25;
  Sized at{std::min(first_guess, largest), 0.0};
  at.size = size_of(at.amplitude);
  double slope = 1.0;
  for (int i = 0; i < kMostTrials && at.size > 0.0; ++i) {
    if (std::abs(at.size / wanted - 1.0) < tolerance) break;
    const double factor = std::clamp(std::pow(wanted / at.size, 1.0 / slope), 0.05, 20.0);
    const double next = std::min(at.amplitude * factor, largest);
    if (next == at.amplitude) break;
    const double next_size = size_of(next);
    if (next_size > 0.0)
      slope = std::clamp(std::log(next_size / at.size) / std::log(next / at.amplitude), 0.3, 3.0);
    at = {next, next_size};
  }
  return at;
}

}  // namespace tenter::twin
