// SPDX-License-Identifier: GPL-3.0-or-later
// What would an instrument have shown of what the cloth did? A model's sensor corrections on the
// predictions of a material point, in the order of the instrument, with exact derivatives.
//
// A channel of force shows, of the nominal stress P of its component (N/m),
//
//   T(t) = P(t) (1 + mu s(t))       cord_friction; s = +1 where the component's imposed strain last
//                                   grew, -1 where it last fell, 0 before it first moved
//   v    = gain T(t - delay) + offset + rate (t - t0) + step [frame >= at_frame]
//   shown = v - share max(0, v - cap)                                       saturation
//
// and a channel of stretch, of the free stretch lambda,
//
//   shown = 1 + scale (lambda - 1)   camera_scale: displacements over a rest length known otherwise
//   shown = scale lambda             camera_length: lengths over such a rest length
//
// A chain is made once per model and set of curves. Const calls may come from any thread; they
// allocate nothing once Shown::by_p has its size. O(parameters) a call.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/estimation/curves.h"
#include "server/estimation/instrument/reading.h"
#include "server/mechanics/material_point.h"

namespace tenter::estimation {

class SensorChain {
 public:
  /// `term_parameters`: how many parameters of the model stand before the corrections' own.
  /// bad_input for a correction that the catalogue does not know. The curves are read only here.
  static Expected<SensorChain> make(const model::Model& model, const std::vector<Curves>& curves,
                                    int term_parameters);

  int parameter_count() const { return parameter_count_; }

  /// Reading of force `component` in `frame` of curve number `which`.
  void show_stress(const Curves& curves, int which, const mechanics::PathResponse& response,
                   int component, int frame, const Eigen::VectorXd& parameters, bool sensitivities,
                   Shown& shown) const;
  /// Reading of the free stretch `component`, likewise.
  void show_stretch(const Curves& curves, const mechanics::PathResponse& response, int component,
                    int frame, const Eigen::VectorXd& parameters, bool sensitivities,
                    Shown& shown) const;

 private:
  enum class Type {
    offset,
    gain,
    drift,
    delay,
    clip_slip,
    cord_friction,
    saturation,
    camera_scale,
    camera_length
  };
  struct Correction {
    Type type = Type::offset;
    int first_parameter = 0;
    std::string capture;
    int component = -1;  ///< -1: all

    bool applies(const Curves& curves, int to_component) const {
      return (component < 0 || component == to_component) &&
             (capture.empty() || capture == curves.id);
    }
  };
  struct Frame;  ///< of one reading: what its steps share

  void hang(const Frame& at, int frame, double weight, Shown& shown) const;
  void shift(const Frame& at, Shown& shown) const;
  double added(const Correction& c, const Frame& at, const Eigen::VectorXd& parameters) const;

  std::vector<Correction> corrections_;
  /// [curve][component][frame]: s of the cord; empty without a cord.
  std::vector<std::array<std::vector<double>, 3>> direction_;
  int term_parameters_ = 0;
  int parameter_count_ = 0;
};

}  // namespace tenter::estimation
