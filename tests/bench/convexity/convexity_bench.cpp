// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-convexity [SEEDS]: ways to a convex energy (thesis 4.2.3, 4.3.3), on a knit that is
// slack at first, from noisy loops: cost, what is lost of the fit, what is gained on loops that it
// did not see, and the smallest eigenvalue over the largest.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "common/model/catalogue.h"
#include "server/estimation/convexity/convex_fit.h"
#include "server/estimation/fit.h"
#include "tests/bench/convexity/slsqp_projection.h"
#include "tests/server/estimation/fixtures.h"

namespace tenter::bench {
namespace {

using namespace estimation;

constexpr double kSigma = 1.0;  // N/m

/// The weft's energy by nine control points, with a coupling surface of Gaussians.
model::Model slack_knit() {
  model::Model model = testing::preset_with("stvk_orthotropic", {0.0, 300.0, 30.0, 100.0});
  model::Law& weft = model.terms[0].law;
  weft.name = "hermite_energy";
  weft.range_hi = 0.07;
  weft.parameters = model::default_parameters(*model::find_law(weft.name), 9);
  double slope = 0.0, energy = 0.0;
  for (std::size_t i = 1; i < weft.parameters.size(); ++i) {
    constexpr double kWidth = 0.07 / 8.0;
    slope += 20.0 * std::pow(1.8, static_cast<double>(i)) * kWidth;
    weft.parameters[i].value = energy += slope * kWidth;
  }
  weft.parameters[0].fixed = true;
  model.terms[3].law.parameters[0].fixed = true;  // shear is not in the loops
  return model;
}

/// The same knit of addends that are convex whatever their non-negative coefficients are.
model::Model convex_by_construction() {
  model::Model model = slack_knit();
  model::Law& weft = model.terms[0].law;
  weft.name = "convex_spline";
  weft.parameters = model::default_parameters(*model::find_law(weft.name), 9);
  model::Term& coupling = model.terms[2];
  coupling.strain.name = "green_trace";
  coupling.law.name = "linear";
  coupling.law.parameters = model::default_parameters(*model::find_law("linear"));
  return model;
}

struct Sum {
  double ms = 0.0, evaluations = 0.0, train = 0.0, held_out = 0.0;
  double worst = 1.0;
};

double chi2_per_row(const model::Model& model, const std::shared_ptr<DataSet>& data,
                    const Eigen::VectorXd& p) {
  auto evaluator = Evaluator::make(model, data).value();
  Eigen::VectorXd r;
  if (evaluator.evaluate(p, r, nullptr) != mechanics::PathStatus::ok) return -1.0;
  return r.squaredNorm() / static_cast<double>(r.size());
}

double milliseconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

struct Way {
  std::string name;
  std::function<Eigen::VectorXd(Evaluator&, const model::Model&, const ConvexityConstraints&)> run;
  bool by_construction = false;
  Sum sum;
};

Eigen::VectorXd fitted(Evaluator& evaluator, const model::Model& start) {
  return fit(evaluator, start, {}).parameters;
}

std::vector<Way> ways() {
  const auto afterwards = [](bool with_data) {
    return [with_data](Evaluator& e, const model::Model& m, const ConvexityConstraints& c) {
      const FitResult free = fit(e, m, {});
      Eigen::MatrixXd metric;
      if (with_data) {
        metric = free.jacobian.transpose() * free.jacobian;
        metric.diagonal().array() += 1e-9 * metric.diagonal().maxCoeff();
      }
      return project_onto_convex(c, free.parameters, metric).parameters;
    };
  };
  const auto inside = [](Metric metric) {
    return [metric](Evaluator& e, const model::Model& m, const ConvexityConstraints& c) {
      return fit_convex(e, parameter_values(m), c, {.metric = metric}).parameters;
    };
  };
  const auto plain = [](Evaluator& e, const model::Model& m, const ConvexityConstraints&) {
    return fitted(e, m);
  };
  return {{"free fit (not convex)", plain, false, {}},
          {"then projected, |p|", afterwards(false), false, {}},
          {"then projected, J'J", afterwards(true), false, {}},
          {"each step, |p| (thesis)", inside(Metric::parameters), false, {}},
          {"each step, J'J", inside(Metric::data), false, {}},
          {"convex by construction", plain, true, {}}};
}

void compare_fits(int seeds) {
  const model::Model truth = slack_knit();
  const model::Model convex = convex_by_construction();
  std::vector<Way> list = ways();
  for (int seed = 1; seed <= seeds; ++seed) {
    auto data = testing::data_of({testing::loop_capture({.runs = 1})}, kSigma);
    testing::measure_with(truth, kSigma, static_cast<unsigned>(seed), *data);
    auto unseen = testing::data_of({testing::loop_capture({.runs = 3, .peak = 0.05})}, kSigma);
    testing::measure_with(truth, 0.0, 1, *unseen);
    for (Way& way : list) {
      const model::Model& model = way.by_construction ? convex : truth;
      auto evaluator = Evaluator::make(model, data).value();
      const auto constraints = ConvexityConstraints::make(model).value();
      Eigen::VectorXd p;
      way.sum.ms += milliseconds([&] { p = way.run(evaluator, model, constraints); });
      way.sum.train += chi2_per_row(model, data, p);
      way.sum.held_out += chi2_per_row(model, unseen, p);
      way.sum.worst = std::min(way.sum.worst, constraints.worst(p).relative);
    }
  }
  std::printf("%-26s %10s %16s %20s %14s\n", "way", "ms a fit", "chi2/row, fitted",
              "held out, no noise", "worst eigen");
  for (const Way& way : list)
    std::printf("%-26s %10.2f %16.4f %20.4f %14.1e\n", way.name.c_str(), way.sum.ms / seeds,
                way.sum.train / seeds, way.sum.held_out / seeds, way.sum.worst);
}

void compare_projections(int seeds) {
  const model::Model truth = slack_knit();
  const auto constraints = ConvexityConstraints::make(truth).value();
  double planes_ms = 0.0, slsqp_ms = 0.0, farther = 0.0, nearer = 1e9, slsqp_worst = 0.0,
         rounds = 0.0;
  bool ran = true;
  for (int seed = 1; seed <= seeds; ++seed) {
    auto data = testing::data_of({testing::loop_capture({.runs = 1})}, kSigma);
    testing::measure_with(truth, kSigma, static_cast<unsigned>(seed), *data);
    auto evaluator = Evaluator::make(truth, data).value();
    const Eigen::VectorXd p = fitted(evaluator, truth);
    ConvexProjection planes;
    SlsqpResult slsqp;
    planes_ms += milliseconds([&] { planes = project_onto_convex(constraints, p); });
    slsqp_ms += milliseconds([&] { slsqp = project_by_slsqp(constraints, p); });
    ran = ran && slsqp.ran;
    rounds += planes.rounds;
    const double ratio = (slsqp.parameters - p).norm() / (planes.parameters - p).norm();
    farther = std::max(farther, ratio);
    nearer = std::min(nearer, ratio);
    slsqp_worst = std::min(slsqp_worst, constraints.worst(slsqp.parameters).relative);
  }
  std::printf("\none projection, %d rows and %d matrices: cutting planes %.3f ms (%.1f rounds)",
              constraints.row_count(), constraints.matrix_count(), planes_ms / seeds,
              rounds / seeds);
  if (ran)
    std::printf(
        "; SLSQP %.3f ms, ratio %.1f; its distance over ours %.6f to %.6f, worst "
        "eigenvalue %.1e\n",
        slsqp_ms / seeds, slsqp_ms / planes_ms, nearer, farther, slsqp_worst);
  else
    std::printf("; SLSQP: not built in, or it failed\n");
}

}  // namespace
}  // namespace tenter::bench

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 20;
  std::printf("%d seeds, one thread\n", seeds);
  tenter::bench::compare_fits(seeds);
  tenter::bench::compare_projections(seeds);
  return 0;
}
