// SPDX-License-Identifier: GPL-3.0-or-later
// All nodes of the simulated mesh where a frame was measured: what forces are linear at.
//
//   fill    the smoothest change of `state` that follows the measured points:
//             min  sum over points |W x - m|^2  +  alpha sum over hinges |second difference of d|^2
//           x = state + d; clips and held nodes go where the frame has them; alpha falls with sigma
//   settle  the shape at which the model's forces and springs to the measured points balance:
//             min  Pi(x, p) + k/2 sum over points |W x - m|^2
//           Noise in the plane, which a stiff membrane answers with large forces, and nodes
//           between sparse points go where the model wants them; what is soft stays as measured.
//           k = K (0.001 h / sigma)^2, K the mean stiffness of a node, h the mean edge: equal to
//           the mesh's own where noise makes strains of 0.001; without noise points are followed.
//
//   auto shape = MeasuredShape::make(model, sequence);
//   State state = sequence.start;
//   if (shape->fill(frame, state) && shape->settle(frame, parameters, state)) ...
//
// One thread per object. Both return false where a matrix cannot be factored or an energy is not
// finite; `state` is then not to be used.
#pragma once

#include <memory>
#include <vector>

#include "server/estimation/sequences/material_location.h"
#include "server/estimation/sequences/sequence.h"
#include "server/mechanics/conditions/potential.h"
#include "server/mechanics/sparse/factor.h"

namespace tenter::estimation {

class MeasuredShape {
 public:
  /// Model and sequence must outlive it. bad_input as check(sequence).
  static Expected<MeasuredShape> make(const mechanics::MeshModel& model, const Sequence& sequence);

  [[nodiscard]] bool fill(std::size_t frame, mechanics::State& state);
  [[nodiscard]] bool settle(std::size_t frame, const Eigen::VectorXd& parameters,
                            mechanics::State& state, const mechanics::History* history = nullptr);

  /// Unknowns and a factor with their pattern, of the frame's boundary.
  struct Site {
    std::unique_ptr<mechanics::Unknowns> unknowns;
    std::unique_ptr<mechanics::SparseFactor> factor;
  };
  Site& site(std::size_t frame);
  const std::vector<MaterialLocation>& locations() const { return locations_; }
  const mechanics::Boundary& boundary(std::size_t frame) const;
  mechanics::Loads loads(std::size_t frame) const;

 private:
  struct Stencil {
    std::array<int, 4> nodes;
    std::array<double, 4> weight;  ///< zero on every affine function of the material
  };

  MeasuredShape(const mechanics::MeshModel& model, const Sequence& sequence)
      : model_(&model), sequence_(&sequence) {}
  void add_springs(std::size_t frame, double stiffness, const mechanics::State& state,
                   mechanics::PotentialValue& value) const;
  double spring_energy(std::size_t frame, double stiffness, const Eigen::VectorXd& x) const;
  double spring_stiffness(std::size_t frame, const mechanics::PotentialValue& value);
  bool is_measured(std::size_t frame, std::size_t point) const;

  const mechanics::MeshModel* model_;
  const Sequence* sequence_;
  std::vector<MaterialLocation> locations_;
  std::vector<Stencil> stencils_;
  std::vector<Site> sites_;
  double edge_m_ = 0.0;
  double sigma_m_ = 0.0;  ///< root mean square over the points
};

}  // namespace tenter::estimation
