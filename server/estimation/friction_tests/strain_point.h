// SPDX-License-Identifier: GPL-3.0-or-later
// A model of one strain, led along a path of strains and loads, with exact parameter derivatives.
//
// Question it answers: a specimen was brought to this strain, or a weight was hung on it: what
// stress has it then, or where does it come to rest, and how do both change with every parameter?
//
//   load = sigma(eps, history) w(eps)     sigma: the sum of the model's laws
//   stretch   w = d eps / d lambda = sqrt(1 + 2 eps)    load per width, N/m (thesis 5.5)
//   bending   w = 1, eps = 3 kappa                      torque per width, N (thesis 5.7)
//
// Under a load the strain goes from where it is in the direction that the load asks for,
// one-signed, to the first place of rest: all of a step of Dahl's law, exactly. Where the stress
// falls along the way (a snap: friction that grows faster with the strain than the elastic stress)
// the place of rest lies beyond, and `snapped` says so.
//
// Units: N/m and 1 for stretch, N and 1/m for bending. Parameters flat, in document order. Cost:
// about ten evaluations of the laws per load. A point is immutable, scratch lives in the Walk of
// the caller: any thread, no allocation after the first walk.
//
//   auto point = StrainPoint::make(model);
//   StrainPoint::Walk walk;
//   point->begin(walk);                                        // never strained before
//   if (point->to_load(12.0, parameters, walk) == PathStatus::ok) use(walk.strain,
//   walk.strain_by_p);
#pragma once

#include <memory>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/mechanics/law.h"
#include "server/mechanics/material_point.h"

namespace tenter::estimation {

class StrainPoint {
 public:
  /// All terms on one strain: green_u or green_v; or bend_u or bend_v. bad_input otherwise.
  static Expected<StrainPoint> make(const model::Model& model);

  int parameter_count() const { return parameter_count_; }
  bool is_bending() const { return is_bending_; }

  struct Walk {
    double strain = 0.0;          ///< where it is
    double load = 0.0;            ///< what holds it there
    double tangent = 0.0;         ///< d load / d strain of the step that led there
    int snapped = 0;              ///< steps under a load that passed a fall of the stress
    Eigen::VectorXd strain_by_p;  ///< zero after to_strain
    Eigen::VectorXd load_by_p;    ///< zero after to_load
    std::vector<double> state;
    mechanics::RowMatrix state_by_p, next_state_by_p;
    std::vector<mechanics::LawOutput> laws;
  };
  void begin(Walk& walk) const;
  void to_strain(double strain, const Eigen::VectorXd& parameters, Walk& walk) const;
  [[nodiscard]] mechanics::PathStatus to_load(double load, const Eigen::VectorXd& parameters,
                                              Walk& walk) const;
  /// Load and tangent at a strain, one step on from where the walk is; it stays there. Its
  /// load_by_p (strain held) is filled where asked for.
  void look(double strain, const Eigen::VectorXd& parameters, bool by_p, Walk& walk, double& load,
            double& tangent) const;

 private:
  struct Term {
    std::shared_ptr<const mechanics::Law> law;
    int first_parameter = 0;
    int first_state = 0;
  };
  struct Weight {
    double value, slope;
  };
  Weight weight(double strain) const;
  bool find_rest(double load, const Eigen::VectorXd& parameters, Walk& walk, double& strain) const;
  void settle(double strain, Walk& walk) const;

  std::vector<Term> terms_;
  int parameter_count_ = 0;
  int state_count_ = 0;
  bool is_bending_ = false;
};

}  // namespace tenter::estimation
