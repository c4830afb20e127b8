// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-knit-field DATA.csv MODEL.json [THINNING]: a homogeneous membrane fitted to the full
// field of a pulled knit, each picture left out in turn and foretold. Without a force only ratios
// of stiffnesses are told: the model fixes that of the weft.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "common/base/text_file.h"
#include "common/model/document.h"
#include "server/estimation/fit.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/bench/knit/field_data.h"

namespace tenter::bench {
namespace {

using namespace estimation;

constexpr int kNone = -1;

/// mm, of the length of what is missed.
Expected<double> error_mm(const model::Model& model, const FieldData& data, int frame) {
  auto evaluator = SequenceEvaluator::make(model, {data.sequence});
  if (!evaluator) return tl::unexpected(evaluator.error());
  Eigen::VectorXd r;
  if (evaluator->evaluate(parameter_values(model), r, nullptr) != mechanics::PathStatus::ok)
    return bad_input(evaluator->failure());
  double squares = 0.0;
  int rows = 0;
  for (std::size_t i = 0; i < evaluator->rows().size(); ++i) {
    const Row& row = evaluator->rows()[i];
    if (row.frame != frame) continue;
    const PointChannel& point = data.sequence.points[static_cast<std::size_t>(row.channel / 3)];
    squares += std::pow(1e3 * point.sigma_m * r[static_cast<Eigen::Index>(i)], 2);
    ++rows;
  }
  return std::sqrt(2.0 * squares / rows);
}

double even_error_mm(const FieldData& data, std::size_t frame) {
  double squares = 0.0;
  int points = 0;
  const Eigen::Matrix3Xd& seen = data.sequence.frames[frame].points_m;
  for (Eigen::Index k = 0; k < seen.cols(); ++k) {
    if (std::isnan(seen(0, k))) continue;
    squares += 1e6 * (seen.col(k) - data.even[frame].col(k)).head<2>().squaredNorm();
    ++points;
  }
  return std::sqrt(squares / points);
}

/// Fitted to all pictures but one.
Expected<model::Model> fitted(model::Model model, const FieldData& data, int left_out) {
  Sequence seen = data.sequence;
  if (left_out != kNone)
    seen.frames[static_cast<std::size_t>(left_out)].points_m.setConstant(
        std::numeric_limits<double>::quiet_NaN());
  auto evaluator = SequenceEvaluator::make(model, {seen});
  if (!evaluator) return tl::unexpected(evaluator.error());
  FitOptions how;
  how.method = FitMethod::bounded_marquardt;
  how.tolerance = 1e-4;
  how.max_iterations = 60;
  const FitResult found = fit(*evaluator, model, how);
  if (!found.usable) return bad_input(found.message + " " + evaluator->failure());
  store(found, model);
  return model;
}

Expected<void> run(const std::string& path, const std::string& model_path, int thinning) {
  const auto text = read_text_file(model_path, model::kMaxDocumentBytes);
  if (!text) return tl::unexpected(text.error());
  const auto start = model::parse_model(*text, model_path);
  if (!start) return tl::unexpected(start.error());
  const auto data = read_field(path, thinning);
  if (!data) return tl::unexpected(data.error());
  const auto all = fitted(*start, *data, kNone);
  if (!all) return tl::unexpected(all.error());
  std::printf("%d nodes, %zu points; held at the top and the bottom\n",
              data->sequence.cloth.mesh.node_count(), data->sequence.points.size());
  for (const model::Term& term : all->terms) {
    std::printf("  %-14s", term.id.c_str());
    for (const model::Parameter& p : term.law.parameters)
      std::printf(" %9.3g%s", p.value, p.fixed ? " (fixed)" : "");
    std::printf("  %s\n", term.law.parameters.front().unit.c_str());
  }
  std::printf(
      "picture  height at rest, px  stretch   missed, mm: even stretch   fitted   left out\n");
  for (std::size_t f = 0; f < data->pictures.size(); ++f) {
    const int frame = static_cast<int>(f);
    const auto seen = error_mm(*all, *data, frame);
    if (!seen) return tl::unexpected(seen.error());
    const auto others = fitted(*start, *data, frame);
    if (!others) return tl::unexpected(others.error());
    const auto foretold = error_mm(*others, *data, frame);
    if (!foretold) return tl::unexpected(foretold.error());
    std::printf("%7d  %18.0f  %7.3f  %24.3f  %7.3f  %9.3f\n", data->pictures[f],
                data->heights_px[f], data->stretches[f], even_error_mm(*data, f), *seen, *foretold);
  }
  return {};
}

}  // namespace
}  // namespace tenter::bench

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) {
    std::fprintf(stderr, "usage: tenter-bench-knit-field DATA.csv MODEL.json [THINNING]\n");
    return 2;
  }
  const int thinning = argc == 4 ? std::max(1, std::atoi(argv[3])) : 3;
  const auto done = tenter::bench::run(argv[1], argv[2], thinning);
  if (done) return 0;
  std::fprintf(stderr, "tenter-bench-knit-field: %s\n", done.error().message.c_str());
  return static_cast<int>(done.error().kind);
}
