// SPDX-License-Identifier: GPL-3.0-or-later
// What would the instruments have shown of what a sheet did? A model's sensor corrections on the
// predictions of a sequence, with exact derivatives, and what two faults of the rig do to the
// sheet.
//
// A channel of force F(t) (N), at frame f and its time t = sum of durations, shows
//
//   T(t)  = F(t) (1 + mu s(t))       cord_friction; s = +1 where the channel's clip last moved
//   along
//                                    it, -1 where it moved back, 0 before it first moved
//   v     = gain T(t - delay) + offset + rate t       T linear between frames
//   shown = v - share max(0, v - cap)                 saturation
//
// A point x shows, with c the middle of what the first frame saw and a the sequence's camera_axis,
//
//   x1 = x + share length a                           occlusion_bias; the share of a point's
//                                                     distance to hidden ones (hidden_points.h)
//   x2 = c + R(turn) (x1 - c) + shift                 camera_pose
//   shown = c + scale (x2 - c)                        camera_scale
//
// A scale about another point is one about c and a shift. Clips keep their measured poses: cameras
// err about points alone. Lengths, areas and torques show what they are.
//
// Two faults change the equilibrium, and with it all channels:
//
//   mass_scale   every node weighs scale times as much (clips do not); several add up
//   clip_slip    from at_frame on (of the sequence, from 0) the nodes of the channel's clip lie
//                length back against the channel's direction; the clip itself stays
//
// A correction's `capture` is a sequence's name, "" all; its `component` a ForceChannel's name, ""
// all forces. The first parameters of a model are its terms'; at_frame has no derivative.
//
//   auto sensors = SequenceSensors::make(model, sequences);
//   sensors->act(sequence, s, f, parameters, loads, poses);           // before a frame is solved
//   sensors->show(sequence, s, f, predicted[s], parameters, shown);   // after all of them are
//
// Immutable after make; const calls may come from any thread, and allocate nothing once `shown` has
// its size. show() costs channels x parameters.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/estimation/instrument/reading.h"
#include "server/estimation/residual_function.h"
#include "server/estimation/sequences/sequence.h"
#include "server/mechanics/equilibrium/sensitivity.h"

namespace tenter::estimation {

/// All channels of a frame, in the order of Observations: one row each.
struct Readings {
  Eigen::VectorXd value;
  RowMatrix by_p;  ///< by all parameters of the model, where wanted
  Shown scratch;
};

class SequenceSensors {
 public:
  SequenceSensors() = default;
  /// bad_input names the correction: one that sheets do not have or whose units are not theirs, a
  /// sequence or channel that is none, a channel where there is none to name, a slip of a free
  /// clip.
  static Expected<SequenceSensors> make(const model::Model& model,
                                        const std::vector<Sequence>& sequences);

  bool is_empty() const { return corrections_.empty(); }
  int parameter_count() const { return parameter_count_; }  ///< of terms and corrections

  /// Flat parameters that move the equilibria of a sequence, rising.
  std::vector<Eigen::Index> felt(std::size_t which) const;
  /// Puts the faults of the rig into what a frame is solved with.
  void act(const Sequence& sequence, std::size_t which, std::size_t frame,
           const Eigen::VectorXd& parameters, mechanics::Loads& loads,
           std::vector<mechanics::Pose>& clips) const;
  /// What one unit of each parameter in `columns`, some of felt(), moves: a column each.
  mechanics::OuterChange outer_change(const Sequence& sequence, std::size_t which,
                                      std::size_t frame, const Eigen::VectorXd& parameters,
                                      const std::vector<Eigen::Index>& columns) const;

  /// `predicted`: of every frame of the sequence, with derivatives by all parameters where
  /// `sensitivities` are wanted.
  void show(const Sequence& sequence, std::size_t which, std::size_t frame,
            const std::vector<Readings>& predicted, const Eigen::VectorXd& parameters,
            bool sensitivities, Readings& shown) const;

 private:
  enum class Type {
    offset,
    gain,
    drift,
    delay,
    cord_friction,
    saturation,
    camera_scale,
    camera_pose,
    occlusion_bias,
    clip_slip,
    mass_scale
  };
  struct Correction {
    Type type = Type::offset;
    int first_parameter = 0;
    std::vector<bool> on;                   ///< [sequence]
    std::vector<std::vector<bool>> forces;  ///< [sequence][force]; of cameras and mass none
  };
  /// What is known of a sequence before anything is predicted.
  struct Known {
    std::vector<double> clock_s;
    std::vector<std::vector<double>> motion;  ///< [force][frame]: s of its cord
    Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
    std::vector<std::vector<double>> from_hidden;  ///< [frame][point], in spacings
  };
  struct At;  ///< a frame of a sequence, with what is asked of it

  static Expected<Correction> bind(const model::SensorCorrection& description,
                                   const std::vector<Sequence>& sequences);
  Known know(const Sequence& sequence) const;

  bool is_slipped(const Correction& c, std::size_t which, std::size_t force, std::size_t frame,
                  const Eigen::VectorXd& parameters) const;
  void hang(const At& at, std::size_t force, int frame, double weight, Shown& shown) const;
  void hang_late(const At& at, std::size_t force, Shown& shown) const;
  void show_force(const At& at, std::size_t force, Shown& shown) const;
  void show_points(const At& at, Readings& shown) const;
  std::vector<Correction> corrections_;
  std::vector<Known> known_;  ///< [sequence]
  int parameter_count_ = 0;
};

/// bad_input where the model has sensor corrections: for what looks at equilibria without them.
Expected<void> without_corrections(const model::Model& model);

}  // namespace tenter::estimation
