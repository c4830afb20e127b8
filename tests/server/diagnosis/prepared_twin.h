// SPDX-License-Identifier: GPL-3.0-or-later
// A twin with its baseline fitted: what a screen starts from.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "common/model/presets.h"
#include "server/diagnosis/prepare.h"
#include "tests/twin/generator.h"

namespace tenter::testing {

inline diagnosis::Request request_of(const twin::TwinCase& twin_case) {
  diagnosis::Request request;
  auto twin = twin::make_twin(twin_case);
  EXPECT_TRUE(twin) << (twin ? "" : twin.error().message);
  if (!twin) return request;
  for (std::size_t i = 0; i < twin->captures.size(); ++i)
    request.captures.emplace_back("twin" + std::to_string(i), std::move(twin->captures[i]));
  request.model = *model::preset(twin->baseline_preset);
  return request;
}

inline diagnosis::Prepared prepared_twin(const twin::TwinCase& twin_case, int frames = 20) {
  diagnosis::Request request = request_of(twin_case);
  request.options.max_frames_per_block = frames;
  auto prepared = diagnosis::prepare(request, diagnosis::Control());
  EXPECT_TRUE(prepared) << (prepared ? "" : prepared.error().message);
  return std::move(prepared).value_or(diagnosis::Prepared());
}

/// The fit with other residuals, as if the noise had been this.
inline estimation::FitResult with_residuals(const estimation::FitResult& fit,
                                            const Eigen::VectorXd& residuals) {
  estimation::FitResult result = fit;
  result.residuals = residuals;
  result.chi2 = residuals.squaredNorm();
  return result;
}

inline Eigen::VectorXd white_noise(Eigen::Index rows, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  Eigen::VectorXd noise(rows);
  for (Eigen::Index r = 0; r < rows; ++r) noise[r] = normal(engine);
  return noise;
}

/// The baseline without noise sequences: null twins are white.
inline estimation::Noise white(estimation::Noise noise) {
  noise.sequences.clear();
  return noise;
}

}  // namespace tenter::testing
