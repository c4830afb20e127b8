// SPDX-License-Identifier: GPL-3.0-or-later
// How large is the noise of a sheet's channels? What a capture states may be wrong by a factor.
//
// From the residuals of a fit, in sigmas as stated, for each kind of channel of each sequence (of
// forces, which are few, scatter is that of all sequences together):
//
//   repeats   sequences of one protocol with equal poses: rms of (r_a - r_b) / sqrt 2
//   scatter   what is left of a reading when smooth misfits are taken away (scatter.h): over the
//             frames, or between frames with equal poses; of points, also less what the nearest
//             points have of it in the material
//   stated    where neither can be had, or what scatters is only a bound of the noise, and above
//             what is stated
//
// The stated value stays where what is shown is within a quarter of it, or within two to three of
// its own errors: a handful of forces knows no better. It stays too where neighbouring readings
// differ by less than a tenth of it: they were filtered, and tell nothing of the noise that they
// had.
//
// Where a capture states none a guess stands in, and what is shown takes its place in any case.
//
//   const FieldNoise noise = estimate_field_noise(data, rows, residuals);
//   data = reweighed(data, noise);                                // and fit again
//
// Pure; linear in the rows.
#pragma once

#include <string>
#include <vector>

#include "server/diagnosis/field/data/field_fit.h"
#include "server/diagnosis/field/data/structure.h"
#include "server/estimation/noise.h"
#include "server/estimation/sequences/observations.h"

namespace tenter::diagnosis {

struct FieldNoise {
  struct Kind {
    int sequence = 0;
    estimation::ObservationKind kind = estimation::ObservationKind::position;
    int rows = 0;
    double stated = 0.0;      ///< rms of the channels' sigmas: m or N
    double shown = 0.0;       ///< the same by repeats or scatter; 0: cannot be had
    bool is_bound = false;    ///< the noise is no larger than `shown`, but may be smaller
    double factor = 1.0;      ///< on the sigmas
    bool is_guessed = false;  ///< `stated` is a guess
    double known_of = 0.0;    ///< independent readings that `shown` is worth
    estimation::NoiseSource source = estimation::NoiseSource::declared;
  };
  std::vector<Kind> kinds;  ///< in the order of kind_places()
};

FieldNoise estimate_field_noise(const FieldData& data, const std::vector<estimation::Row>& rows,
                                const Eigen::VectorXd& residuals);

/// What is left is white: it goes on neither from frame to frame nor from point to point, does not
/// stay with the material, and neighbouring frames differ by as much. That is noise which is larger
/// than stated, if not by so much that nobody would have stated it.
bool is_scatter(const Structure& left, const FieldNoise& noise);

/// The sigmas times their factors.
FieldData reweighed(FieldData data, const FieldNoise& noise);

/// One noise after another on the same data: factors multiply, stated values are the first's.
FieldNoise combined(FieldNoise first, const FieldNoise& second);

}  // namespace tenter::diagnosis
