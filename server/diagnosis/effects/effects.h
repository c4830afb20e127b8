// SPDX-License-Identifier: GPL-3.0-or-later
// One function per effect; each has a file of its own here and a row in catalogue.cpp. Helpers that
// several effects share.
#pragma once

#include "server/diagnosis/effect.h"

namespace tenter::diagnosis {

Effect nonlinear_stiffness();
Effect strain_limit();
Effect anisotropy();
Effect poisson_coupling();
Effect cross_modal_stiffening();
Effect specimen_scatter();
Effect internal_friction();
Effect strain_dependent_friction();
Effect viscosity();
Effect plastic_set();
Effect first_cycle_softening();
Effect load_cell_offset();
Effect load_cell_gain();
Effect load_cell_drift();
Effect load_cell_saturation();
Effect cord_friction();
Effect clip_slip();
Effect force_camera_delay();
Effect camera_scale();
// of sheets alone
Effect rest_shape();
Effect heterogeneity();
Effect camera_pose();
Effect occlusion_bias();
Effect wrong_mass();

/// Tightens the bounds of a parameter of the law.
void bound_parameter(model::Law& law, const std::string& name, double lower, double upper);
/// The term's measure looks where the place is (weft, warp, shear, diagonal), in whatever family of
/// strains.
bool same_measure(const model::StrainMeasure& measure, const Place& place);
/// A sensor correction of this type on each channel of force that does not have it yet.
std::vector<Variant> channel_variants(const model::Model& model, const Excitation& excitation,
                                      const std::string& type);
/// Of sheets: the correction on each named force channel of all captures (on all channels where
/// they have no names), unless the model has it.
std::vector<Variant> sheet_channel_variants(const model::Model& model, const Excitation& excitation,
                                            const std::string& type);
/// Of sheets: the correction on all captures together, and on each where there are several.
std::vector<Variant> sheet_capture_variants(const model::Model& model, const Excitation& excitation,
                                            const std::string& type);
/// A law of one strain with an amplitude (zero: off) and a strain at which it sets in.
struct Onset {
  std::string id;         ///< of its terms: "set" gives "set_weft"
  std::string law;        ///< of the law catalogue
  std::string amplitude;  ///< parameter names
  std::string strain;
  std::vector<double> shares;  ///< of the strain reached: the grid of the onset
  double least = 1e-3;         ///< bounds of the onset, of the strain reached
  double most = 1.5;
};
/// Variants of such a law along weft, warp and both.
std::vector<Variant> onset_variants(const model::Model& model, const Excitation& excitation,
                                    const Onset& onset);

}  // namespace tenter::diagnosis
