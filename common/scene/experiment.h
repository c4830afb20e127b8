// SPDX-License-Identifier: Apache-2.0
// What makes a scene an experiment: what is measured of it, what is drawn, and which other runs of
// the same scene it is compared with.
//
//   "experiment": {
//     "run": "with friction",
//     "measures": [{"id": "bend", "kind": "rms_curvature", "strain": "bend_u", "at": "settle"}],
//     "curves": [{"id": "profile", "kind": "curvature_along", "strain": "bend_u"}],
//     "pictures": [{"title": "at rest", "eye": [0.3, -1, 0.4]}],
//     "variants": [{"name": "without friction", "without_laws": ["dahl"]}]
//   }
//
// Data only; common/experiment works measures and curves out. `at` and `from` name a moment: the
// end of the phase of this name, "start", or, left out, the last frame.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace tenter::scene {

/// A number of every run.
struct Measure {
  std::string id;
  std::string kind;
  std::string words;   ///< of a table's head; left out: the kind's own
  std::string strain;  ///< row of the strain catalogue
  std::string clip;
  std::string at;
  std::string from;
  std::string like;  ///< the moment whose wrinkles are compared with
  double share = 0.0;
  double width_m = 0.02;    ///< of the smoothing that wrinkles are told from (wrinkles.h)
  double bound_m_s = 1e-3;  ///< speed that counts as rest
};

/// One plot, with a line for every run.
struct Curve {
  std::string id;
  std::string kind;
  std::string words;
  std::string strain;
  std::string clip;
  std::string at;
  std::array<double, 3> direction = {1.0, 0.0, 0.0};
};

/// The mesh at one moment of every run.
struct Picture {
  std::string title;
  std::string at;
  std::array<double, 3> eye = {0.3, -1.0, 0.4};  ///< direction to who looks
  std::array<double, 3> up = {0.0, 0.0, 1.0};
};

/// The same scene once more, but for what is named here.
struct Variant {
  std::string name;
  std::vector<std::string> without_laws;  ///< terms of the model with these laws are left out
  double pace = 1.0;                      ///< phases take their duration over this
  std::string patch;                      ///< JSON merge patch (RFC 7386) of the scene; "": none
};

struct Experiment {
  std::string run = "as it is";  ///< what the scene itself is called among the variants
  std::vector<Measure> measures;
  std::vector<Curve> curves;
  std::vector<Picture> pictures;
  std::vector<Variant> variants;
};

/// A kind of measure or curve, and the keys that it takes besides id, kind and words. Those that
/// name a moment, a share or a direction may be left out.
struct Kind {
  std::string_view name;
  std::vector<std::string_view> keys;
  std::string_view words;
};
const std::vector<Kind>& measure_kinds();
const std::vector<Kind>& curve_kinds();

}  // namespace tenter::scene
