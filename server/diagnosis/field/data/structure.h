// SPDX-License-Identifier: GPL-3.0-or-later
// How much do thousands of residuals of a sheet say, and what do they hang on?
//
// Neighbouring points miss alike, and so do neighbouring frames: of n values so many count,
//
//   n / (tau_s tau_t)     tau_t = 1 + 2 sum_k rho_t(k)          over the frames of a block
//                         tau_s = 1 + sum_d m(d) rho_s(d)       over rings of neighbours, m(d)
//                         points
//                                                               in each
//
// each sum while its terms are positive; correlations are pooled over the channels of one kind of a
// sequence, mean kept in: what keeps its sign everywhere is one piece of evidence.
//
//   const double rows = independent_rows(sequences, all_rows, residuals);
//   for (const Structure& s : structure_of(...)) ... s.neighbours
//
// Pure; cost is linear in frames x points x `kReferences`.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "server/estimation/residual_function.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::diagnosis {

/// The residuals of one kind of one sequence.
struct Structure {
  int sequence = 0;
  estimation::ObservationKind kind = estimation::ObservationKind::position;
  int rows = 0;
  double chi2 = 0.0;
  double independent = 0.0;  ///< of the rows, at least one
  // what white noise has around zero, and one is all of it
  double in_time = 0.0;     ///< correlation of a channel's neighbouring frames
  double neighbours = 0.0;  ///< of nearest points in a frame
  double fixed = 0.0;     ///< share of the power that is the same in all frames: hangs on material
  double at_edges = 0.0;  ///< mean square near free edges over that elsewhere, less one
  double with_place =
      0.0;  ///< share that is linear in the place in space: scale or turn of cameras
};

std::vector<Structure> structure_of(const std::vector<estimation::Sequence>& sequences,
                                    const std::vector<estimation::Row>& rows,
                                    const Eigen::VectorXd& residuals);

/// chi2 over positions and over all else: points are many and would outvote the forces.
struct Misfit {
  std::array<double, 2> chi2 = {0.0, 0.0};
  std::array<double, 2> rows = {0.0, 0.0};
};
Misfit misfit_of(const std::vector<estimation::Sequence>& sequences,
                 const std::vector<estimation::Row>& rows, const Eigen::VectorXd& residuals);

/// Sum of `independent`.
double independent_rows(const std::vector<estimation::Sequence>& sequences,
                        const std::vector<estimation::Row>& rows, const Eigen::VectorXd& residuals);

/// For each row the place of its kind and sequence, from 0: rows of one place are judged together.
std::vector<int> kind_places(const std::vector<estimation::Sequence>& sequences,
                             const std::vector<estimation::Row>& rows);

}  // namespace tenter::diagnosis
