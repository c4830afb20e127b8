// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/mechanics/history/friction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/model/catalogue.h"

namespace tenter::mechanics::testing {
namespace {

const double kPi = std::acos(-1.0);

}  // namespace

model::Term term_of(const std::string& id, const std::string& strain, const std::string& law,
                    const std::vector<double>& values) {
  model::Term term;
  term.id = id;
  term.strain.name = strain;
  term.law.name = law;
  term.law.parameters = model::default_parameters(*model::find_law(law), 1);
  EXPECT_EQ(term.law.parameters.size(), values.size());
  for (std::size_t k = 0; k < values.size(); ++k) term.law.parameters[k].value = values[k];
  return term;
}

model::Model rubbing_cloth() {
  model::Model model;
  model.name = "rubbing cloth";
  model.terms = {term_of("weft", "green_u", "linear", {90.0}),
                 term_of("warp", "green_v", "linear", {110.0}),
                 term_of("shear", "green_uv", "linear", {12.0}),
                 term_of("bend_u", "bend_u", "linear", {4e-5}),
                 term_of("bend_v", "bend_v", "linear", {5e-5}),
                 term_of("bend_d", "bend_d", "linear", {4e-5}),
                 term_of("stretch_friction", "green_pair", "dahl", {0.4, 6.0, 5.0, 0.012}),
                 term_of("shear_friction", "green_uv", "dahl", {0.3, 2.0, 3.0, 0.02}),
                 term_of("bend_friction", "bend_u", "dahl", {2e-5, 1e-6, 1e-9, 4.0})};
  return model;
}

model::Model rubbing_solid() {
  model::Model model;
  model.name = "rubbing solid";
  model.terms = {term_of("normal", "solid_green_normal", "linear", {2e4}),
                 term_of("shear", "solid_green_shear", "linear", {8e3}),
                 term_of("friction", "solid_green_normal", "dahl", {150.0, 900.0, 0.0, 0.015}),
                 term_of("shear_friction", "solid_green_xy", "dahl", {90.0, 700.0, 0.0, 0.02})};
  return model;
}

HeldSheet::HeldSheet(int nodes, const model::Model& description)
    : cloth(cloth_of_grid({nodes, nodes, 0.1, 0.1}, Diagonals::alternating).value()),
      model(MeshModel::make(description, cloth).value()),
      parameters(term_parameters(description)) {
  start.x.resize(3 * model.node_count());
  for (int n = 0; n < model.node_count(); ++n) {
    const Eigen::Vector2d at = cloth.mesh.material_m.col(n);
    start.x.segment<3>(3 * static_cast<Eigen::Index>(n)) << at.x(), at.y(), 0.0;
    if (at.y() < 1e-9 || at.y() > 0.1 - 1e-9) boundary.held.push_back(n);
    if (at.y() > 0.1 - 1e-9) upper.push_back(n);
  }
}

void HeldSheet::hold(const Frame& frame, State& state) const {
  for (const int n : upper) {
    const double u = cloth.mesh.material_m(0, n);
    state.x.segment<3>(3 * static_cast<Eigen::Index>(n)) << u + 0.1 * frame.shear,
        0.1 * (1.0 + frame.stretch), 0.1 * frame.arch * std::sin(kPi * u / 0.1);
  }
}

std::vector<HeldSheet::Frame> partial_reversals() {
  return {{0.02, 0.0, 0.05},  {0.05, 0.01, 0.1},   {0.05, 0.05, 0.15},
          {0.06, 0.09, 0.2},  {0.055, 0.05, 0.15}, {0.05, 0.03, 0.1},
          {0.05, 0.07, 0.12}, {0.06, 0.06, 0.16},  {0.06, -0.02, 0.08}};
}

Walk walk(const HeldSheet& sheet, const std::vector<HeldSheet::Frame>& frames,
          const Eigen::VectorXd& parameters, const EquilibriumOptions& options) {
  Walk result;
  auto solver = EquilibriumSolver::make(sheet.model, sheet.boundary).value();
  History history = sheet.model.never_strained();
  State state = sheet.start;
  for (const HeldSheet::Frame& frame : frames) {
    sheet.hold(frame, state);
    EquilibriumOptions how = options;
    how.start_is_near = !result.states.empty();
    auto solved = solver.solve(parameters, {}, state, how, &history);
    EXPECT_TRUE(solved && solved->is_good(how))
        << (solved ? describe(*solved, how) : solved.error().message);
    EXPECT_EQ(sheet.model.end_of_step(state.x, parameters, history, history.state),
              AssemblyStatus::ok);
    result.states.push_back(state);
    result.results.push_back(std::move(*solved));
    result.histories.push_back(history.state);
  }
  return result;
}

}  // namespace tenter::mechanics::testing
