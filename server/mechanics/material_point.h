// SPDX-License-Identifier: GPL-3.0-or-later
// A model under homogeneous strain, followed along a measured path, with exact parameter
// derivatives.
//
// Question it answers: given the strain of every frame (some components imposed, some free of
// stress), what nominal stresses (N/m) does the model give, where do the free components go, and
// how do both change with every parameter?
//
//   P_i(q, state, p) = sum over terms  sigma_t . d eps_t / d q_i
//
// Free components solve P_f = 0 frame by frame; their sensitivities follow from the implicit
// function theorem, those of the laws' states are carried forward. Cost: O(frames x terms x
// parameters). Pure: no files, clock, threads; a MaterialPoint is immutable, scratch lives in the
// Workspace of the caller.
//
//   auto point = MaterialPoint::make(model);
//   MaterialPoint::Workspace scratch;
//   PathResponse response;
//   PathStatus status = point->follow(path, parameters, /*sensitivities=*/true, scratch, response);
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/mechanics/homogeneous_strain.h"
#include "server/mechanics/law.h"
#include "server/mechanics/strain_measure.h"

namespace tenter::mechanics {

/// How a frame follows the one before it.
enum class FrameStart {
  next,    ///< the path goes on
  rested,  ///< a new run on the same specimen, unloaded out of sight: only memory is kept
  virgin   ///< a specimen that was never pulled
};

/// The loading of one specimen. All vectors have one entry per frame.
struct StrainPath {
  double axis_angle_rad = 0.0;
  std::array<bool, 3> is_free = {false, false, false};
  std::vector<Eigen::Vector3d> q;  ///< stretch_x, stretch_y, shear_xy; a first guess where free
  std::vector<double> duration_s;  ///< since the frame before; 0 where a run starts
  std::vector<FrameStart> start;
};

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct PathResponse {
  std::vector<Eigen::Vector3d> stress;  ///< N/m; zero on free components
  std::vector<Eigen::Vector3d> q;       ///< with the free components solved
  RowMatrix stress_by_p;                ///< (3 frames) x parameters
  RowMatrix q_by_p;                     ///< (3 frames) x parameters; zero rows where imposed
};

enum class PathStatus {
  ok,
  no_equilibrium,  ///< a free component found no zero of its stress; `PathResponse` is not usable
  not_finite       ///< a strain measure or law left the range of numbers (e.g. a negative area)
};

class MaterialPoint {
 public:
  /// Terms of hinges and of springs over two edges bend a mesh: here they do nothing, and their
  /// parameters keep their places with zero derivatives. bad_input for terms of solids,
  /// supports other than "everywhere" and energy limits.
  static Expected<MaterialPoint> make(const model::Model& model);

  int parameter_count() const { return parameter_count_; }

  struct Workspace {
    std::vector<double> state;
    RowMatrix state_by_p;
    RowMatrix next_state_by_p;
    RowMatrix stress_by_p;
    RowMatrix strain_by_p;
    std::vector<LawOutput> laws;
    std::vector<StrainValue> strains;
    std::vector<Eigen::Matrix<double, kMaxStrains, 3>> strain_by_q;
  };

  [[nodiscard]] PathStatus follow(const StrainPath& path, const Eigen::VectorXd& parameters,
                                  bool sensitivities, Workspace& scratch,
                                  PathResponse& response) const;

  /// d2Psi/dq2 at one state of a model without history (path-dependent terms count as never
  /// strained before).
  Eigen::Matrix3d elastic_hessian(const HomogeneousStrain& kinematics, const Eigen::Vector3d& q,
                                  const Eigen::VectorXd& parameters) const;

 private:
  struct Term {
    StrainMeasure measure;
    std::shared_ptr<const Law> law;
    int first_parameter = 0;
    int first_state = 0;
  };
  struct Balance {
    Eigen::Vector3d stress;   ///< dPsi/dq
    Eigen::Matrix3d tangent;  ///< d2Psi/dq2
    double scale = 0.0;       ///< sum of the magnitudes that were added up
  };

  void begin_run(FrameStart start, Workspace& scratch) const;
  Balance evaluate(const HomogeneousStrain& kinematics, const Eigen::Vector3d& q,
                   const Eigen::VectorXd& parameters, double duration_s, Workspace& scratch) const;
  bool solve_free(const HomogeneousStrain& kinematics, const std::array<bool, 3>& is_free,
                  const Eigen::VectorXd& parameters, double duration_s, Workspace& scratch,
                  Eigen::Vector3d& q, Balance& balance) const;
  void differentiate(const std::array<bool, 3>& is_free, const Balance& balance, Eigen::Index frame,
                     Workspace& scratch, PathResponse& response) const;
  void advance_state(Workspace& scratch) const;

  std::vector<Term> terms_;
  int parameter_count_ = 0;
  int state_count_ = 0;
};

}  // namespace tenter::mechanics
