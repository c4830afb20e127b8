// SPDX-License-Identifier: GPL-3.0-or-later
// Sheets and solids with internal friction, and what is done to them frame by frame.
#pragma once

#include <string>
#include <vector>

#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::mechanics::testing {

/// A term with this law and these values of its parameters.
model::Term term_of(const std::string& id, const std::string& strain, const std::string& law,
                    const std::vector<double>& values);

/// Linear elasticity with friction on both stretches, shear and bending along the weft.
model::Model rubbing_cloth();
/// Linear elasticity of a solid with friction on its normal strains and on one shear.
model::Model rubbing_solid();

/// A square sheet of 0.1 m between two held edges; frames move the upper one.
struct HeldSheet {
  explicit HeldSheet(int nodes, const model::Model& description);
  HeldSheet(const HeldSheet&) = delete;
  HeldSheet& operator=(const HeldSheet&) = delete;

  Cloth cloth;
  MeshModel model;
  Eigen::VectorXd parameters;
  Boundary boundary;
  State start;
  std::vector<int> upper;

  struct Frame {
    double stretch = 0.0;  ///< of the height
    double shear = 0.0;    ///< sideways way of the upper edge by the height
    double arch = 0.0;     ///< of the upper edge out of its plane, by the height
  };
  void hold(const Frame& frame, State& state) const;
};

/// Stretched and arched, then sheared and arched to and fro without coming back to where it was.
std::vector<HeldSheet::Frame> partial_reversals();

/// A whole walk from a sheet that was never strained.
struct Walk {
  std::vector<State> states;
  std::vector<EquilibriumResult> results;
  std::vector<Eigen::VectorXd> histories;  ///< at the end of each frame
};
Walk walk(const HeldSheet& sheet, const std::vector<HeldSheet::Frame>& frames,
          const Eigen::VectorXd& parameters, const EquilibriumOptions& options);

}  // namespace tenter::mechanics::testing
