// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/energy_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/server/mechanics/assembly/model_checks.h"
#include "tests/server/mechanics/assembly/solid_bodies.h"
#include "tests/server/mechanics/sparse/count_allocations.h"

namespace tenter::mechanics {
namespace {

Cloth limited_cloth() {
  return cloth_of_grid({6, 5, 0.25, 0.2}, Diagonals::alternating).value();
}

Eigen::VectorXd crumpled(const Cloth& on, unsigned seed) {
  testing::Numbers numbers(seed);
  Eigen::VectorXd x(3 * on.mesh.node_count());
  for (int n = 0; n < on.mesh.node_count(); ++n) {
    x.segment<3>(3 * n) << 1.1 * on.mesh.material_m.col(n), 0.0;
    for (int i = 0; i < 3; ++i) x[3 * n + i] += numbers.between(-0.006, 0.006);
  }
  return x;
}

/// With a maximum for each limit in the middle of what its elements have at x.
template <class Body>
model::Model with_maxima(model::Model description, const Body& body, const Eigen::VectorXd& x) {
  const auto model = MeshModel::make(description, body);
  EXPECT_TRUE(model) << model.error().message;
  Eigen::VectorXd excess;
  EXPECT_EQ(model->limit_excess(x, term_parameters(description), excess), AssemblyStatus::ok);
  for (model::EnergyLimit& limit : description.limits) {
    std::vector<double> densities;
    for (const LimitedElements& part : model->limited())
      if (part.limit == limit.id)
        for (std::size_t k = 0; k < part.element.size(); ++k)
          densities.push_back(excess[part.first + static_cast<int>(k)] + part.energy_max);
    EXPECT_FALSE(densities.empty());
    std::sort(densities.begin(), densities.end());
    limit.energy_max = densities[densities.size() / 2];
    EXPECT_GT(limit.energy_max, 0.0) << limit.id;
  }
  return description;
}

/// Derivatives of the limits' part alone, which the model's own would hide: differences of the
/// sums with and without it. About half of the elements are beyond their limit.
template <class Body>
void check_limits(const model::Model& plain, const Body& body, const Eigen::VectorXd& x,
                  double step) {
  const model::Model description = with_maxima(plain, body, x);
  const auto model = MeshModel::make(description, body);
  ASSERT_TRUE(model);
  const Eigen::VectorXd parameters = term_parameters(description);
  Eigen::VectorXd excess;
  ASSERT_EQ(model->limit_excess(x, parameters, excess), AssemblyStatus::ok);
  ASSERT_EQ(excess.size(), model->limited_count());
  EnergyLimitState limits{Eigen::VectorXd::Zero(excess.size()), 0.0};
  limits.penalty = 3.0 / description.limits.front().energy_max;
  testing::Numbers numbers(5);
  int active = 0, with_multiplier = 0;
  for (Eigen::Index k = 0; k < excess.size(); ++k) {
    if (k % 3 != 0) limits.multiplier[k] = numbers.between(0.0, 1.5);
    double a = limits.multiplier[k] + limits.penalty * excess[k];
    if (std::abs(a) < 0.05) limits.multiplier[k] += 0.1;  // the second derivative jumps at zero
    a = limits.multiplier[k] + limits.penalty * excess[k];
    active += a > 0.0;
    with_multiplier += a <= 0.0 && limits.multiplier[k] > 0.0;
  }
  EXPECT_GT(active, excess.size() / 8);
  EXPECT_LT(active, excess.size() - excess.size() / 8);
  EXPECT_GT(with_multiplier, 0);

  NodeMatrix limited = model->matrix();
  const auto at = [&](const Eigen::VectorXd& y, NodeMatrix* into) {
    Answer with, without;
    EXPECT_EQ(model->evaluate(y, parameters, {&with.energy, &with.gradient, into}, &limits),
              AssemblyStatus::ok);
    NodeMatrix own = model->matrix();
    EXPECT_EQ(
        model->evaluate(y, parameters, {&without.energy, &without.gradient, into ? &own : nullptr}),
        AssemblyStatus::ok);
    if (into)
      for (int b = 0; b < own.block_count(); ++b)
        for (int q = 0; q < 9; ++q) into->block(b)[q] -= own.block(b)[q];
    with.energy -= without.energy;
    with.gradient -= without.gradient;
    return with;
  };
  check_derivatives(at, limited, x, step, 1e-6);

  // what is asked for does not change the answers
  const Answer all = at(x, nullptr);
  double energy = 0.0, own = 0.0;
  ASSERT_EQ(model->evaluate(x, parameters, {&energy, nullptr, nullptr}, &limits),
            AssemblyStatus::ok);
  ASSERT_EQ(model->evaluate(x, parameters, {&own, nullptr, nullptr}), AssemblyStatus::ok);
  EXPECT_EQ(energy - own, all.energy);
  // and is that of the formula, element by element
  double expected = 0.0;
  for (const LimitedElements& part : model->limited()) {
    for (std::size_t k = 0; k < part.element.size(); ++k) {
      const double l = limits.multiplier[part.first + static_cast<int>(k)];
      const double a = std::max(0.0, l + limits.penalty * excess[part.first + static_cast<int>(k)]);
      expected += part.measure[k] / (2.0 * limits.penalty) * (a * a - l * l);
    }
  }
  EXPECT_NE(expected, 0.0);
  EXPECT_NEAR(all.energy, expected, 1e-10 * (std::abs(expected) + std::abs(own)));
}

std::vector<std::string> ids_in(const model::Model& model, model::Domain domain) {
  std::vector<std::string> ids;
  for (const model::Term& term : model.terms)
    if (model::find_strain(term.strain.name)->domain == domain) ids.push_back(term.id);
  return ids;
}

// On cloth: the sum of all membrane terms, and each spring and hinge term alone.
TEST(EnergyLimit, DerivativesOnCloth) {
  const Cloth sheet = limited_cloth();
  const Eigen::VectorXd x = crumpled(sheet, 3);
  int membranes = 0, springs = 0, hinges = 0;
  for (model::Model description : presets_of(Body::cloth)) {
    SCOPED_TRACE(description.name);
    const auto sum = ids_in(description, model::Domain::membrane);
    if (!sum.empty()) {
      description.limits = {limit_of(description, sum)};
      check_limits(description, sheet, x, 1e-5);
      ++membranes;
    }
    for (const model::Domain domain : {model::Domain::edge, model::Domain::hinge}) {
      for (const std::string& id : ids_in(description, domain)) {
        SCOPED_TRACE(id);
        description.limits = {limit_of(description, {id})};
        check_limits(description, sheet, x, 1e-5);
        ++(domain == model::Domain::edge ? springs : hinges);
      }
    }
  }
  EXPECT_GT(membranes, 5);
  EXPECT_GT(springs, 3);
  EXPECT_GT(hinges, 3);
}

// In solids: the total, and an addend together with it.
TEST(EnergyLimit, DerivativesInSolids) {
  for (const SolidBody& body : solid_bodies()) {
    for (model::Model description : presets_of(Body::solid)) {
      SCOPED_TRACE(body.name + ", " + description.name);
      const Eigen::VectorXd x = deformed(body.mesh, 0.1, 4);
      description.limits = {limit_of(description, {}, "total")};
      check_limits(description, body.mesh, x, 1e-3 * kCell);
      description.limits.push_back(limit_of(description, {description.terms.back().id}, "volume"));
      check_limits(description, body.mesh, x, 1e-3 * kCell);
      const auto model = MeshModel::make(description, body.mesh);
      ASSERT_TRUE(model);
      const bool mixed = !body.mesh.tetrahedra.empty() && !body.mesh.hexahedra.empty();
      EXPECT_EQ(model->limited().size(), mixed ? 4U : 2U);
      EXPECT_EQ(model->limited_count(),
                2 * static_cast<int>(body.mesh.tetrahedra.size() + 8 * body.mesh.hexahedra.size()));
    }
  }
}

// Limits see the weight of a support: of two equal samples the sum is the plain material's.
TEST(EnergyLimit, DensitiesCarryTheWeightOfTheirSupport) {
  const SolidBody body = solid_bodies().back();
  const Eigen::VectorXd x = deformed(body.mesh, 0.1, 6);
  model::Model plain = model::preset("solid_neo_hookean").value();
  plain.limits = {limit_of(plain, {"shape"})};
  model::Model split = plain;
  split.fields = {{"body", 3, {0.0, 0.0, 0.0, 0.15, 0.1, 0.08}, 0.06}};
  split.terms.clear();
  for (const model::Term& term : plain.terms)
    for (int sample = 1; sample <= 2; ++sample) {
      split.terms.push_back(term);
      split.terms.back().id += "_" + std::to_string(sample);
      split.terms.back().support = {"rbf", "body", sample};
    }
  split.limits = {limit_of(split, {"shape_1", "shape_2"}), limit_of(split, {"shape_1"}, "part")};
  const auto one = MeshModel::make(plain, body.mesh);
  const auto two = MeshModel::make(split, body.mesh);
  ASSERT_TRUE(one && two);
  Eigen::VectorXd expected, excess;
  ASSERT_EQ(one->limit_excess(x, term_parameters(plain), expected), AssemblyStatus::ok);
  ASSERT_EQ(two->limit_excess(x, term_parameters(split), excess), AssemblyStatus::ok);
  ASSERT_EQ(excess.size(), 2 * expected.size());
  const double scale = expected.cwiseAbs().maxCoeff();
  EXPECT_GT(scale, 100.0);
  EXPECT_LT((excess.head(expected.size()) - expected).cwiseAbs().maxCoeff(), 1e-12 * scale);
  // and alone, less
  EXPECT_LT(excess[expected.size()], expected[0]);
  check_limits(split, body.mesh, x, 1e-3 * kCell);
}

TEST(EnergyLimit, NothingAllocatesAfterTheFirstCall) {
  const SolidBody body = solid_bodies().back();
  model::Model description = model::preset("solid_ogden").value();
  description.limits = {limit_of(description, {})};
  const auto model = MeshModel::make(description, body.mesh);
  ASSERT_TRUE(model);
  const Eigen::VectorXd x = deformed(body.mesh, 0.1, 8), parameters = term_parameters(description);
  const EnergyLimitState limits{Eigen::VectorXd::Ones(model->limited_count()), 1.0};
  NodeMatrix matrix = model->matrix();
  double energy = 0.0;
  Eigen::VectorXd gradient, excess, energies;
  std::vector<TermStrains> strains;
  const auto all_well = [&] {
    return model->evaluate(x, parameters, {&energy, &gradient, &matrix}, &limits) ==
               AssemblyStatus::ok &&
           model->limit_excess(x, parameters, excess) == AssemblyStatus::ok &&
           model->term_energies(x, parameters, energies) == AssemblyStatus::ok &&
           model->term_strains(x, strains) == AssemblyStatus::ok;
  };
  ASSERT_TRUE(all_well());
  const long before = test::allocations();
  EXPECT_GT(before, 0) << "the counter counts";
  const bool well = all_well();
  EXPECT_EQ(test::allocations(), before);
  EXPECT_TRUE(well);
}

TEST(EnergyLimit, WithoutLimitsNothingChanges) {
  const SolidBody body = solid_bodies().front();
  model::Model description = model::preset("solid_stvk").value();
  const auto plain = MeshModel::make(description, body.mesh);
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->limited_count(), 0);
  Eigen::VectorXd excess;
  const Eigen::VectorXd x = deformed(body.mesh, 0.1, 7);
  EXPECT_EQ(plain->limit_excess(x, term_parameters(description), excess), AssemblyStatus::ok);
  EXPECT_EQ(excess.size(), 0);
  const EnergyLimitState none{Eigen::VectorXd(0), 1.0};
  double with = 0.0, without = 0.0;
  EXPECT_EQ(plain->evaluate(x, term_parameters(description), {&with, nullptr, nullptr}, &none),
            AssemblyStatus::ok);
  EXPECT_EQ(plain->evaluate(x, term_parameters(description), {&without, nullptr, nullptr}),
            AssemblyStatus::ok);
  EXPECT_GT(with, 0.0);
  EXPECT_EQ(with, without);
  // inside out, there is no density
  description.limits = {limit_of(description, {})};
  const auto limited = MeshModel::make(description, body.mesh);
  ASSERT_TRUE(limited);
  const Eigen::Matrix3d mirror = Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal();
  EXPECT_EQ(limited->limit_excess(affine(body.mesh, mirror), term_parameters(description), excess),
            AssemblyStatus::inverted);
}

TEST(EnergyLimit, WhatHasNoSumIsRefused) {
  const auto error_of = [](const model::Model& model) {
    const auto made = MeshModel::make(model, limited_cloth());
    return made ? std::string("made") : made.error().message;
  };
  model::Model model = model::preset("cloth_stvk").value();
  model.limits = {limit_of(model, ids_in(model, model::Domain::membrane))};
  EXPECT_EQ(error_of(model), "made");
  model.limits = {limit_of(model, {})};
  EXPECT_EQ(error_of(model),
            "limit \"lock\": its terms act on different elements, so that their energies have no "
            "sum");
  model.limits = {limit_of(model, {"nowhere"})};
  EXPECT_EQ(error_of(model), "limit \"lock\": the model has no term \"nowhere\"");
  model.limits = {limit_of(model, {model.terms[0].id})};
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    model.limits[0].energy_max = bad;
    EXPECT_EQ(error_of(model), "limit \"lock\": its energy_max must be a finite number above 0");
  }
}

}  // namespace
}  // namespace tenter::mechanics
