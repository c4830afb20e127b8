// SPDX-License-Identifier: Apache-2.0
#include "common/effects/effects.h"

namespace tenter::effects {
namespace {

const Protocol& dead_weights() {
  static const Protocol protocol = {"dead_weights",
                                    "Unmount the specimen, read zero, hang two known weights on "
                                    "the clip, read zero again after ten minutes.",
                                    {{"blank", "no specimen, 60 s"},
                                     {"weight", "two known weights in turn"},
                                     {"blank", "no specimen, 600 s later"}}};
  return protocol;
}

}  // namespace

std::vector<Row> sensor_rows() {
  return {
      {"cord_friction",
       Kind::sensor,
       "friction of a cord over its pulley: the cell shows more than the tension on the way up and "
       "less on the way down",
       "sharp at every reversal, grows with the tension, belongs to one cord",
       "a share of one channel's force with the sign of its last motion",
       {"internal_friction", "strain_dependent_friction", "load_cell_gain"},
       {"blank_run_with_weight",
        "A dead weight in the place of the specimen, hung over the same pulley, moved up and down: "
        "what the cell then shows of a loop is the cord's.",
        {{"weight", "a known weight on the cord"},
         {"cycle", "up and down by the travel of the test"}}}},
      {"load_cell_offset",
       Kind::sensor,
       "a constant error of the load cell",
       "the same in every frame of one channel, also at zero force",
       "a constant on one channel of force",
       {"load_cell_drift", "plastic_set"},
       dead_weights()},
      {"load_cell_gain",
       Kind::sensor,
       "a load cell that shows a multiple of the force",
       "in proportion to the force of one channel, on whatever specimen",
       "a factor on one channel of force",
       {"anisotropy"},
       dead_weights()},
      {"load_cell_drift",
       Kind::sensor,
       "a zero of the load cell that moves with the clock",
       "a function of the wall clock, whatever the specimen does",
       "a rate times the clock on one channel of force",
       {"load_cell_offset", "viscosity", "plastic_set"},
       dead_weights()},
      {"load_cell_saturation",
       Kind::sensor,
       "a load cell at the end of its range: what is above a cap is lost",
       "a flat top at the same force in every run, whatever the strain",
       "a share of what one channel of force shows above a cap is taken off, with the cap on a "
       "grid",
       {"nonlinear_stiffness", "load_cell_gain"},
       {"weights_beyond_the_peak",
        "Hang known weights up to one and a half times the largest force of the test on the clip, "
        "without specimen.",
        {{"blank", "no specimen, 60 s"},
         {"weight", "half, the whole and one and a half times the largest force"}}}},
      {"load_cell_quantisation",
       Kind::sensor,
       "a load cell that shows steps larger than its noise",
       "readings on a lattice, which stick to one value while the force moves",
       "nothing is added: the lattice of the readings is looked for, and its step counted as noise",
       {"load_cell_saturation", "outliers"},
       {"finer_range",
        "Read a weight that is lowered slowly onto the clip, in the finest range of the cell: the "
        "steps are those of the instrument.",
        {{"blank", "no specimen, 60 s"}, {"weight", "lowered slowly onto the clip"}}}},
      {"clip_slip",
       Kind::sensor,
       "a slip in a clip: the force steps within one run and in no other",
       "a step of force at one frame of one run; it does not repeat",
       "a step of one channel of force from one frame of one run on",
       {"outliers", "first_cycle_softening"},
       {"repeat_with_marks",
        "Repeat the run with a mark on the cloth at the edge of each clip: a slip moves the mark.",
        {{"repeat", "the run that stepped"}}}},
      {"force_camera_delay",
       Kind::sensor,
       "a delay between the clocks of force and strain",
       "a loop whose area is in proportion to the rate, which looks viscous, and which one delay "
       "removes",
       "a shift in time between force and strain",
       {"viscosity", "internal_friction"},
       {"hold_and_blank_run",
        "A hold after a fast ramp, and a blank run with a spring of steel in the place of the "
        "specimen: a delay does not relax and stays with the rig.",
        {{"ramp", "as fast as the rig can"},
         {"hold", "60 s"},
         {"blank", "the same with a steel spring"}}}},
      {"camera_scale",
       Kind::sensor,
       "a camera whose scale is off: observed stretches are off by one factor",
       "in proportion to one camera's stretch, or to its length also at rest, whatever the "
       "specimen",
       "a factor on the change of an observed length, or on the length",
       {"poisson_coupling", "anisotropy"},
       {"ruler_in_the_plane",
        "Film a ruler, or a target of known size, in the plane of the specimen.",
        {{"blank", "a target of known size, at two places of the image"}}}},
      {"camera_pose",
       Kind::sensor,
       "cameras that were moved or turned after they were calibrated",
       "of sheets: all points of a capture are off by one turn and one shift",
       "a turn and a shift of what points show",
       {"camera_scale", "heterogeneity"},
       {"marks_in_the_plane",
        "Four marks fixed to the frame beside the specimen, measured by hand: what moves them is "
        "the cameras.",
        {{"blank", "the frame with its marks, no specimen"}}}},
      {"occlusion_bias",
       Kind::sensor,
       "points beside hidden ones that are seen nearer to the cameras than they are",
       "of sheets: only in frames in which a neighbour is missing, along the cameras' axis",
       "a length along the cameras' axis at points beside hidden ones",
       {"heterogeneity", "outliers"},
       {"other_view",
        "The same pull seen from another side: what is hidden moves, what is of the material "
        "stays.",
        {{"ramp", "the same pull, cameras turned by 30 degrees"}}}},
      {"wrong_mass",
       Kind::sensor,
       "a mass of the sheet that was not measured right",
       "of sheets: in proportion to gravity, the same in every frame of a hanging test",
       "a factor on the mass of the sheet",
       {"rest_shape"},
       {"upside_down",
        "The hanging test once more with the specimen turned upside down, and the specimen on a "
        "balance.",
        {{"weight", "the specimen on a balance"}, {"ramp", "hanging, turned upside down"}}}},
      {"outliers",
       Kind::sensor,
       "misread or lost samples",
       "isolated readings far from their neighbours, which do not repeat",
       "nothing is added: readings that stand alone are found against the fit and left out of it",
       {"clip_slip"},
       {"repeat",
        "Repeat the run as it was: a misreading does not come again at the same place.",
        {{"repeat", "the run with the readings that stand alone"}}}},
  };
}

}  // namespace tenter::effects
