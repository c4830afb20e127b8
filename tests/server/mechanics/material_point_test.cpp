// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/material_point.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/law_checks.h"

namespace tenter::mechanics {
namespace {

using testing::Comparison;
using testing::difference;
using testing::law_with;
using testing::Numbers;

constexpr double kPi = std::numbers::pi;

struct Specimen {
  MaterialPoint point;
  Eigen::VectorXd parameters;
};

Specimen specimen_of(const model::Model& model) {
  auto point = MaterialPoint::make(model);
  EXPECT_TRUE(point) << (point ? "" : point.error().message);
  std::vector<double> values;
  for (const model::Term& term : model.terms)
    for (const model::Parameter& parameter : term.law.parameters) values.push_back(parameter.value);
  const auto count = static_cast<Eigen::Index>(values.size());
  return {std::move(*point), Eigen::Map<Eigen::VectorXd>(values.data(), count)};
}

model::Term term(const std::string& measure, model::Law law, double angle_rad = 0.0) {
  model::Term result;
  result.id = measure + "_" + law.name;
  result.strain.name = measure;
  result.strain.angle_rad = angle_rad;
  result.law = std::move(law);
  return result;
}

/// Orthotropic cloth with everything that a path-dependent model may have.
model::Model rich_model() {
  model::Model model;
  model.terms = {
      term("green_u", law_with("linear", {600.0})),
      term("green_v", law_with("hermite_stiffness", {500.0, 700.0, 1100.0}, -0.05, 0.1)),
      term("green_pair", law_with("bilinear", {150.0})),
      term("green_uv", law_with("linear", {100.0})),
      term("green_u", law_with("dahl", {1.0, 15.0, 0.0, 0.01})),
      term("green_v", law_with("dahl", {0.7, 10.0, 40.0, 0.02})),
      term("fibre_pair", law_with("dahl", {0.5, 5.0, 0.0, 0.015}), kPi / 4.0),
      term("green_u", law_with("maxwell", {60.0, 4.0})),
      term("green_v", law_with("kelvin_voigt", {20.0})),
      term("green_u", law_with("plastic_set", {40.0, 0.011})),
  };
  return model;
}

model::Model preset(const std::string& name) {
  auto model = model::preset(name);
  EXPECT_TRUE(model) << name;
  for (model::Term& t : model->terms) {
    if (t.law.parameters.size() < 2) continue;
    t.law.range_lo = -0.1;
    t.law.range_hi = 0.2;
    double value = 150.0;  // an uneven curve
    for (model::Parameter& p : t.law.parameters) p.value = (value += 37.0);
  }
  return *model;
}

StrainPath path_of(std::vector<Eigen::Vector3d> q, double step_s = 0.5) {
  StrainPath path;
  path.duration_s.assign(q.size(), step_s);
  path.start.assign(q.size(), FrameStart::next);
  if (!q.empty()) {
    path.duration_s.front() = 0.0;
    path.start.front() = FrameStart::virgin;
  }
  path.q = std::move(q);
  return path;
}

/// Up and down with uneven steps in all components; the first frame is at rest.
StrainPath wandering_path(unsigned seed, int frames) {
  Numbers numbers(seed);
  std::vector<Eigen::Vector3d> q = {{1.0, 1.0, 0.0}};
  for (int i = 1; i < frames; ++i)
    q.emplace_back(1.0 + 0.05 * std::abs(std::sin(0.31 * i)) + numbers.between(0.0, 0.006),
                   1.0 + 0.04 * std::abs(std::sin(0.23 * i)) + numbers.between(0.0, 0.006),
                   0.03 * std::sin(0.17 * i) + numbers.between(0.0, 0.006));
  return path_of(q);
}

PathResponse response_of(const Specimen& specimen, const StrainPath& path,
                         bool sensitivities = false) {
  MaterialPoint::Workspace scratch;
  PathResponse response;
  EXPECT_EQ(specimen.point.follow(path, specimen.parameters, sensitivities, scratch, response),
            PathStatus::ok);
  return response;
}

Eigen::Vector3d stress_at(const Specimen& specimen, double angle_rad, const Eigen::Vector3d& q) {
  StrainPath path = path_of({q});
  path.axis_angle_rad = angle_rad;
  return response_of(specimen, path).stress.front();
}

// P = F S, S = D : E in material axes; q = (F00, F11, F01).
TEST(MaterialPoint, StVenantKirchhoffIsThatOfTheTextbook) {
  model::Model model = preset("stvk_orthotropic");
  const double c11 = 640.0, c22 = 810.0, c12 = 170.0, c33 = 95.0;
  const std::vector<double> values = {c11, c22, c12, c33};
  ASSERT_EQ(model.terms.size(), values.size());
  // the shipped shear term is k/2 (w_u . w_v)^2: S_uv = k gamma, gamma = 2 E_uv
  for (std::size_t i = 0; i < values.size(); ++i)
    model.terms[i].law.parameters.front().value = values[i];
  const Specimen specimen = specimen_of(model);
  Numbers numbers(1);
  Comparison compared("StVK stress");
  for (int sample = 0; sample < 40; ++sample) {
    const double angle = numbers.between(-3.0, 3.0);
    const Eigen::Vector3d q(numbers.between(0.8, 1.4), numbers.between(0.8, 1.4),
                            numbers.between(-0.4, 0.4));
    Eigen::Matrix2d f;
    f << q[0], q[2], 0.0, q[1];
    const Eigen::Matrix2d axes =
        Eigen::Rotation2Dd(-angle).toRotationMatrix();  // columns: weft, warp
    const Eigen::Matrix2d fm = f * axes;
    const Eigen::Matrix2d e = 0.5 * (fm.transpose() * fm - Eigen::Matrix2d::Identity());
    Eigen::Matrix2d s;
    s(0, 0) = c11 * e(0, 0) + c12 * e(1, 1);
    s(1, 1) = c22 * e(1, 1) + c12 * e(0, 0);
    s(0, 1) = s(1, 0) = c33 * 2.0 * e(0, 1);
    const Eigen::Matrix2d p = fm * s * axes.transpose();
    const Eigen::Vector3d got = stress_at(specimen, angle, q);
    compared.add(got[0], p(0, 0));
    compared.add(got[1], p(1, 1));
    compared.add(got[2], p(0, 1));
  }
  compared.judge(1e-12, 10.0);
}

/// Shipped models that a piece of membrane can follow and that have no memory: all but the solids
/// and the ones with friction.
std::vector<std::string> membrane_presets() {
  std::vector<std::string> names = model::preset_names();
  std::erase_if(names, [](const std::string& name) {
    return name.rfind("solid", 0) == 0 || model::remembers_path(model::preset(name).value());
  });
  EXPECT_EQ(names.size(), 16U);
  return names;
}

TEST(MaterialPoint, ElasticStressHasAPotential) {
  for (const std::string& name : membrane_presets()) {
    const Specimen specimen = specimen_of(preset(name));
    Numbers numbers(2);
    Comparison symmetric(name + ": dP_i/dq_j against dP_j/dq_i");
    for (int sample = 0; sample < 20; ++sample) {
      const double angle = numbers.between(-3.0, 3.0);
      const Eigen::Vector3d q(numbers.between(0.95, 1.2), numbers.between(0.95, 1.2),
                              numbers.between(-0.1, 0.1));
      Eigen::Matrix3d tangent;
      for (int j = 0; j < 3; ++j)
        tangent.col(j) = difference(
            [&](double x) {
              Eigen::Vector3d moved = q;
              moved[j] = x;
              return stress_at(specimen, angle, moved);
            },
            q[j], 2e-5);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < i; ++j) symmetric.add(tangent(i, j), tangent(j, i));
    }
    symmetric.judge(1e-6, 1.0);
  }
}

TEST(MaterialPoint, BendingDoesNothingAndKeepsItsParametersPlaces) {
  for (const char* name : {"cloth_stvk", "cloth_springs", "cloth_soft_spline"}) {
    const model::Model whole = preset(name);
    model::Model flat = whole;
    std::erase_if(flat.terms, [](const model::Term& t) { return t.id.rfind("bend", 0) == 0; });
    ASSERT_EQ(flat.terms.size() + 3, whole.terms.size());
    const Specimen bends = specimen_of(whole);
    const Specimen stays = specimen_of(flat);
    EXPECT_GT(bends.parameters.size(), stays.parameters.size());
    const Eigen::Vector3d stress = stress_at(stays, 0.4, {1.1, 1.05, 0.03});
    EXPECT_GT(stress.norm(), 1.0);
    EXPECT_EQ(stress_at(bends, 0.4, {1.1, 1.05, 0.03}), stress) << name;
  }
}

TEST(MaterialPoint, RefusesSolidsAndPlacesInTheMaterial) {
  const auto solid = MaterialPoint::make(preset("solid_stvk"));
  ASSERT_FALSE(solid);
  EXPECT_NE(solid.error().message.find("strain of solids"), std::string::npos);
  model::Model placed = preset("stvk_orthotropic");
  placed.terms[1].support = {"rbf", "samples", 1};
  const auto field = MaterialPoint::make(placed);
  ASSERT_FALSE(field);
  EXPECT_NE(field.error().message.find("warp"), std::string::npos);
  model::Model limited = model::preset("stvk_orthotropic").value();
  limited.limits = {{"lock", {}, 5.0, "J/m^2"}};
  const auto locked = MaterialPoint::make(limited);
  ASSERT_FALSE(locked);
  EXPECT_EQ(locked.error().message,
            "limit \"lock\": a material point does not enforce energy limits");
}

TEST(MaterialPoint, RestIsFreeOfStress) {
  for (const std::string& name : membrane_presets())
    EXPECT_EQ(stress_at(specimen_of(preset(name)), 0.4, {1.0, 1.0, 0.0}).norm(), 0.0) << name;
  EXPECT_EQ(stress_at(specimen_of(rich_model()), 0.0, {1.0, 1.0, 0.0}).norm(), 0.0);
}

TEST(MaterialPoint, TurningTheSpecimenSwapsWeftAndWarp) {
  const Specimen specimen = specimen_of(preset("stvk_orthotropic_spline"));
  const Eigen::Vector3d q(1.08, 1.03, 0.0);
  const Eigen::Vector3d swapped(1.03, 1.08, 0.0);
  const Eigen::Vector3d plain = stress_at(specimen, 0.0, q);
  const Eigen::Vector3d turned = stress_at(specimen, kPi / 2.0, swapped);
  ASSERT_GT(plain.norm(), 1.0);
  EXPECT_NEAR(turned[0], plain[1], 1e-10);
  EXPECT_NEAR(turned[1], plain[0], 1e-10);
  EXPECT_NEAR((stress_at(specimen, kPi, q) - plain).norm(), 0.0, 1e-10);
}

void expect_free_component_without_stress(const model::Model& model, int free, double angle_rad) {
  const Specimen specimen = specimen_of(model);
  StrainPath path = wandering_path(3, 120);
  path.axis_angle_rad = angle_rad;
  path.is_free[static_cast<std::size_t>(free)] = true;
  for (Eigen::Vector3d& q : path.q) q[free] = free == 2 ? 0.0 : 1.0;
  const PathResponse solved = response_of(specimen, path);
  StrainPath imposed = path;
  imposed.is_free = {false, false, false};
  imposed.q = solved.q;
  const PathResponse again = response_of(specimen, imposed);
  double moved = 0.0;
  for (std::size_t i = 0; i < path.q.size(); ++i) {
    EXPECT_NEAR(again.stress[i][free], 0.0, 1e-7) << "frame " << i;
    for (int k = 0; k < 3; ++k) {
      if (k == free) continue;
      EXPECT_NEAR(again.stress[i][k], solved.stress[i][k], 1e-7) << "frame " << i;
      EXPECT_EQ(solved.q[i][k], path.q[i][k]);
    }
    moved = std::max(moved, std::abs(solved.q[i][free] - path.q[i][free]));
  }
  EXPECT_GT(moved, 1e-3);
}

TEST(MaterialPoint, FreeComponentsAreFreeOfStress) {
  for (int free = 0; free < 3; ++free) {
    expect_free_component_without_stress(preset("stvk_orthotropic"), free, 0.3);
    expect_free_component_without_stress(preset("soft_constraints_spline"), free, 0.7);
    expect_free_component_without_stress(rich_model(), free, 0.3);
  }
}

// Linear elasticity: under a small pull with the transverse direction free, e_y = -(C12/C22) e_x.
TEST(MaterialPoint, ContractsAsPoissonSays) {
  const Specimen specimen = specimen_of(preset("stvk_orthotropic"));  // C22 100, C12 10
  StrainPath path = path_of({{1.0, 1.0, 0.0}, {1.0 + 1e-5, 1.0, 0.0}});
  path.is_free[1] = true;
  EXPECT_NEAR((response_of(specimen, path).q[1][1] - 1.0) / 1e-5, -0.1, 1e-5);
}

/// `idle`: parameters that the path may leave without effect, e.g. of a yield strain that is not
/// reached.
void check_sensitivities(const model::Model& model, std::array<bool, 3> is_free, double angle_rad,
                         unsigned seed, int idle) {
  Specimen specimen = specimen_of(model);
  StrainPath path = wandering_path(seed, 90);
  path.axis_angle_rad = angle_rad;
  path.is_free = is_free;
  path.start[40] = FrameStart::rested;
  path.start[70] = FrameStart::virgin;
  path.duration_s[40] = path.duration_s[70] = 0.0;
  const PathResponse exact = response_of(specimen, path, true);
  const auto frames = static_cast<Eigen::Index>(path.q.size());
  constexpr double kUnitOfZero = 50.0;
  int acting = 0;
  for (int k = 0; k < specimen.point.parameter_count(); ++k) {
    const double unit =
        specimen.parameters[k] != 0.0 ? std::abs(specimen.parameters[k]) : kUnitOfZero;
    const double value = specimen.parameters[k];
    const auto stacked = [&](double x) {
      specimen.parameters[k] = x;
      const PathResponse moved = response_of(specimen, path);
      specimen.parameters[k] = value;
      Eigen::VectorXd all(6 * frames);
      for (Eigen::Index f = 0; f < frames; ++f) {
        all.segment<3>(3 * f) = moved.stress[static_cast<std::size_t>(f)];
        all.segment<3>(3 * (frames + f)) = moved.q[static_cast<std::size_t>(f)];
      }
      return all;
    };
    const Eigen::VectorXd oracle = difference(stacked, value, 3e-4 * unit) * unit;
    Comparison stress("stress by parameter " + std::to_string(k));
    Comparison stretch("free stretch by parameter " + std::to_string(k));
    for (Eigen::Index row = 0; row < 3 * frames; ++row) {
      stress.add(exact.stress_by_p(row, k) * unit, oracle[row]);
      stretch.add(exact.q_by_p(row, k) * unit, oracle[3 * frames + row]);
    }
    // 1e-3 N/m and 1e-6 of stretch: below these the differences are rounding
    if (stress.scale() > 1e-3) ++acting;
    stress.judge(1e-6, stress.scale() > 1e-3 ? 1e-3 : 0.0, 1e-9);
    stretch.judge(1e-6, 0.0, 1e-12);
  }
  EXPECT_GE(acting, specimen.point.parameter_count() - idle);
}

TEST(MaterialPoint, SensitivitiesAreThoseOfTheResponse) {
  check_sensitivities(rich_model(), {false, false, false}, 0.2, 11, 0);
  check_sensitivities(preset("stvk_orthotropic_spline"), {false, false, false}, 0.5, 12, 1);
}

TEST(MaterialPoint, SensitivitiesHoldWithFreeDirectionsAndFriction) {
  check_sensitivities(rich_model(), {false, true, false}, 0.2, 13, 1);
  check_sensitivities(rich_model(), {true, false, false}, 0.2, 14, 4);
  check_sensitivities(rich_model(), {false, true, true}, 0.4, 15, 3);
}

/// Frame 1 pulls, frame 2 is back at rest after `start`.
double stress_after(const model::Model& model, FrameStart start) {
  StrainPath path = path_of({{1.0, 1.0, 0.0}, {1.06, 1.0, 0.0}, {1.0, 1.0, 0.0}});
  path.start[2] = start;
  return response_of(specimen_of(model), path).stress[2][0];
}

TEST(MaterialPoint, ARestedSpecimenKeepsItsMemoryAndAVirginOneDoesNot) {
  model::Model plastic;
  plastic.terms = {term("green_u", law_with("plastic_set", {40.0, 0.01}))};
  model::Model friction;
  friction.terms = {term("green_u", law_with("dahl", {2.0, 0.0, 0.0, 0.01}))};
  EXPECT_LT(stress_after(plastic, FrameStart::next), -1.0);
  EXPECT_EQ(stress_after(plastic, FrameStart::rested), stress_after(plastic, FrameStart::next));
  EXPECT_EQ(stress_after(plastic, FrameStart::virgin), 0.0);
  EXPECT_LT(stress_after(friction, FrameStart::next), -1.0);
  EXPECT_EQ(stress_after(friction, FrameStart::rested), 0.0);
  EXPECT_EQ(stress_after(friction, FrameStart::virgin), 0.0);
}

TEST(MaterialPoint, AWorkspaceRemembersNothing) {
  const Specimen specimen = specimen_of(rich_model());
  const StrainPath path = wandering_path(21, 60);
  const PathResponse fresh = response_of(specimen, path, true);
  MaterialPoint::Workspace scratch;
  PathResponse response;
  ASSERT_EQ(
      specimen.point.follow(wandering_path(22, 80), specimen.parameters, true, scratch, response),
      PathStatus::ok);
  ASSERT_EQ(specimen.point.follow(path, specimen.parameters, true, scratch, response),
            PathStatus::ok);
  EXPECT_EQ(response.stress.size(), fresh.stress.size());
  for (std::size_t i = 0; i < fresh.stress.size(); ++i)
    EXPECT_EQ((response.stress[i] - fresh.stress[i]).norm(), 0.0) << i;
  EXPECT_EQ((response.stress_by_p - fresh.stress_by_p).norm(), 0.0);
}

TEST(MaterialPoint, NumbersOutOfRangeAreAStatus) {
  model::Model model;
  model.terms = {term("green_u", law_with("exponential_fibre", {80.0, 60.0}))};
  const Specimen specimen = specimen_of(model);
  MaterialPoint::Workspace scratch;
  PathResponse response;
  EXPECT_EQ(specimen.point.follow(path_of({{9.0, 1.0, 0.0}}), specimen.parameters, false, scratch,
                                  response),
            PathStatus::not_finite);
}

TEST(MaterialPoint, MisfitsOfMeasureAndLawNameTheTerm) {
  model::Model model;
  model.terms = {term("green_u", law_with("bilinear", {1.0}))};
  const auto point = MaterialPoint::make(model);
  ASSERT_FALSE(point);
  EXPECT_NE(point.error().message.find("green_u_bilinear"), std::string::npos);
}

}  // namespace
}  // namespace tenter::mechanics
