// SPDX-License-Identifier: GPL-3.0-or-later
// Same-discretisation twins: what they measure beside closed forms, and that a fit finds what is
// hidden in them.
#include "tests/twin/fabrics/sequences/same_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/model/catalogue.h"
#include "server/estimation/fit.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/mechanics/law.h"
#include "tests/twin/fabrics/sequences/coverage.h"
#include "tests/twin/fabrics/sequences/rig_noise.h"

namespace tenter::twin {
namespace {

using estimation::Sequence;
using estimation::SequenceEvaluator;

constexpr int kCells = 6;  // of the small twins

MeasuredTwin small_twin(const Fabric& fabric, const std::string& protocol, int frames = 6) {
  return same_mesh_twin(fabric,
                        make_protocol(fabric, protocol, {.frames = frames, .cells = kCells}),
                        {.nodes = kCells + 1})
      .value();
}

TEST(FabricModel, HasTheLawsOfTheCurves) {
  for (const std::string& id : fabric_ids()) {
    const Fabric cloth = fabric(id);
    const model::Model model = fabric_model(cloth);
    for (std::size_t m = 0; m < 5; ++m) {
      const auto law = mechanics::make_law(model.terms[m].law, 1).value();
      Eigen::VectorXd parameters(law->parameter_count());
      for (int i = 0; i < law->parameter_count(); ++i)
        parameters[i] = model.terms[m].law.parameters[static_cast<std::size_t>(i)].value;
      const double scale = strain_scale(static_cast<Mode>(m));
      const double end = m < 3 ? 0.7 : 150.0;
      for (double strain = -end; strain <= end; strain += end / 37.0) {
        mechanics::LawOutput out;
        law->clear(out);
        const double eps = scale * strain;
        law->evaluate({.strain = &eps, .parameters = parameters.data()}, out);
        const CurveValue want = cloth.curves[m].at(strain);
        const double size = cloth.curves[m].largest() * end;
        // psi(K) = psi_hinge(3 K) / 3, and the derivatives by K
        EXPECT_NEAR(out.energy / scale, want.energy, 1e-12 * size * end) << id << m << strain;
        EXPECT_NEAR(out.stress[0], want.stress, 1e-12 * size) << id << m << strain;
        EXPECT_NEAR(out.tangent[0][0] * scale, want.tangent, 1e-10 * size) << id << m << strain;
      }
    }
    EXPECT_GT(model.terms[5].law.parameters[0].value, 1e-7) << id;
  }
}

// Between bars nothing but the strain along the pull is large:  F = width sigma(E) (1 + e).
TEST(SameMeshTwin, PulledCanBeReadOffTheCurve) {
  for (const char* id : {"4", "12", "14", "18"}) {
    const Fabric cloth = fabric(id);
    for (const bool along_u : {true, false}) {
      const MeasuredTwin twin = small_twin(cloth, along_u ? "stretch_u" : "stretch_v");
      const double free_m = cloth.side_m * (kCells - 2) / kCells;
      double largest_N = 0.0;
      for (const auto& frame : twin.sequence.frames) {
        const double e = frame.clips[1].position_m.norm() / free_m;
        const double green = e + 0.5 * e * e;
        const double stress =
            cloth.curve(along_u ? Mode::stretch_u : Mode::stretch_v).at(green).stress;
        const double want_N = cloth.side_m * stress * (1.0 + e);
        largest_N = std::max(largest_N, want_N);
        // the sheet's weight pulls at first
        if (e > 0.01) {
          EXPECT_NEAR(frame.forces_N[1], want_N, 0.02 * want_N) << id << along_u << e;
        }
        EXPECT_NEAR(frame.forces_N[0], frame.forces_N[1], 1e-7);  // the other bar bears it
      }
      EXPECT_GT(largest_N, 1.0) << id;
    }
  }
}

// Stiffness over the same share of the range, from forces and poses alone.
TEST(SameMeshTwin, WoolIsTenTimesStifferAlongTheWeft) {
  const Fabric wool = fabric("18");
  const auto secant_at_half = [&](const char* name, double range) {
    const MeasuredTwin twin = small_twin(wool, name, 60);
    const double free_m = wool.side_m * (kCells - 2) / kCells;
    double nearest = 1.0, secant = 0.0;
    for (const auto& frame : twin.sequence.frames) {
      const double e = frame.clips[1].position_m.norm() / free_m;
      const double green = e + 0.5 * e * e;
      if (std::abs(green / range - 0.5) > nearest) continue;
      nearest = std::abs(green / range - 0.5);
      secant = frame.forces_N[1] / (wool.side_m * (1.0 + e) * green);
    }
    EXPECT_LT(nearest, 0.05) << name;
    return secant;
  };
  const double ratio = secant_at_half("stretch_u", 0.05) / secant_at_half("stretch_v", 0.3);
  EXPECT_NEAR(ratio, 10.0, 1.0);
}

/// Constant stiffnesses, of the size of a knit's.
Fabric linear_fabric() {
  Fabric cloth = fabric("12");
  const double k[] = {42.0, 58.0, 19.0, 3e-6, 5e-6, 1.2e-5};
  for (std::size_t m = 0; m < cloth.curves.size(); ++m) cloth.curves[m] = {0.0, 0.0, {k[m]}};
  return cloth;
}

// Thesis 4.2.2: St. Venant-Kirchhoff comes back from its own data.
TEST(SameMeshTwin, GivesItsModelBackFromDataWithoutNoise) {
  const Fabric cloth = linear_fabric();
  const Eigen::VectorXd truth = mechanics::term_parameters(fabric_model(cloth));
  estimation::SequenceOptions how;
  how.threads = 2;
  how.tolerance_N = how.stepping_tolerance_N = 1e-11;
  auto evaluator =
      SequenceEvaluator::make(fabric_model(cloth), fitting_sequences(cloth, 4, kCells), how)
          .value();
  estimation::FitOptions options;
  options.tolerance = 1e-16;
  const auto result = fit(evaluator, poor_start(fabric_model(cloth)), options);
  ASSERT_TRUE(result.usable) << result.message << evaluator.failure();
  for (Eigen::Index p = 0; p < truth.size(); ++p)
    EXPECT_NEAR(result.parameters[p], truth[p], 1e-6 * truth[p]) << p;
}

TEST(RigNoise, CordsHoldBackBetweenPullAndRelease) {
  MeasuredTwin twin = small_twin(fabric("4"), "stretch_u", 30);
  const Sequence before = twin.sequence;
  Random random(1);
  add_rig_noise({.white = false, .cord_loop_N = 0.1}, random, twin.sequence);
  double most = 0.0, least = 0.0;
  for (std::size_t f = 1; f < before.frames.size(); ++f) {
    const double held = twin.sequence.frames[f].forces_N[1] - before.frames[f].forces_N[1];
    const double change = before.frames[f].forces_N[1] - before.frames[f - 1].forces_N[1];
    if (std::abs(change) > 0.1) {
      EXPECT_NEAR(held, change > 0.0 ? 0.05 : -0.05, 1e-12) << f;
    }
    most = std::max(most, held);
    least = std::min(least, held);
  }
  EXPECT_NEAR(most - least, 0.1, 1e-12);
  EXPECT_EQ(twin.sequence.frames[3].points_m, before.frames[3].points_m);
}

}  // namespace
}  // namespace tenter::twin
