// SPDX-License-Identifier: Apache-2.0
#include "common/effects/effects.h"

namespace tenter::effects {

std::vector<Row> material_rows() {
  return {
      {"nonlinear_stiffness",
       Kind::material,
       "a stiffness that changes with strain, the same on the way up and down",
       "single-valued in strain, the same sign on both branches",
       "a convex spline in the place of a constant stiffness, or beside the other terms",
       {"anisotropy"},
       {"wider_range",
        "A slow ramp to a larger strain in each direction: the curve of force against strain "
        "bends.",
        {{"ramp", "to one and a half times the range, weft"}, {"ramp", "the same, warp"}}}},
      {"anisotropy",
       Kind::material,
       "anisotropy: the stiffness depends on the direction in the cloth",
       "biased in opposite senses along directions that share a parameter; turns with the specimen",
       "a stiffness of its own along one direction",
       {"nonlinear_stiffness", "load_cell_gain"},
       {"remount_90_and_45_degrees",
        "The same pull on the specimen remounted at 90 and at 45 degrees: what turns with the "
        "specimen is the material.",
        {{"remount", "at 90 degrees"},
         {"ramp", "the same pull"},
         {"remount", "at 45 degrees"},
         {"ramp", "the same pull"}}}},
      {"poisson_coupling",
       Kind::material,
       "coupling of the two stretches: a pull along one direction narrows or loads the other",
       "a transverse force or a transverse stretch in stretching, none in pure shear",
       "a product of both strains, or the change of area",
       {"anisotropy", "nonlinear_stiffness"},
       {"biaxial_paths",
        "Biaxial paths with different ratios of the two stretches, both forces measured.",
        {{"ramp", "x alone, y held"}, {"ramp", "x and y together"}, {"ramp", "y alone, x held"}}}},
      {"cross_modal_stiffening",
       Kind::material,
       "cross-modal stiffening: one mode of deformation stiffens another",
       "in one mode, in proportion to its strain and to the square of another's; absent when "
       "either is zero",
       "an addend c/2 eps_1^2 eps_2^2 of two strains",
       {"poisson_coupling", "nonlinear_stiffness"},
       {"biaxial_ladder",
        "Pull one stretch while the other is held at none, at a half and at the whole of its "
        "range: the pull is stiffer at each level.",
        {{"ramp", "x alone, y at rest"},
         {"ramp", "x, with y held at half its range"},
         {"ramp", "x, with y held at its range"}}}},
      {"internal_friction",
       Kind::material,
       "internal friction: the force lags behind every reversal of the strain, at any rate",
       "odd under reversal, smooth over a strain before it slides; its width does not change with "
       "the rate, does not decay in a hold, and remains at zero force",
       "a Dahl element of constant sigma_max beside the elastic terms (thesis 5.2)",
       {"viscosity", "plastic_set", "force_camera_delay", "strain_dependent_friction"},
       {"two_rates_and_hold",
        "Repeat one loop at two rates a decade apart and hold for ten minutes at half the peak: "
        "friction keeps its loop width and its force, viscosity does not.",
        {{"cycle", "one loop at a tenth of the rate"},
         {"cycle", "the same loop at the full rate"},
         {"hold", "hold for 600 s at half the peak, loading"}}}},
      {"strain_dependent_friction",
       Kind::material,
       "friction that grows with strain: loops are wider where the specimen is stretched more",
       "loops whose width grows with the strain about which they run",
       "a Dahl element whose sigma_max grows with strain, linearly or quadratically (thesis 5.2.4)",
       {"internal_friction", "viscosity"},
       {"nested_loops_at_offsets",
        "Small loops of the same amplitude about several offset strains: their width shows how the "
        "friction grows.",
        {{"cycle", "loops of a tenth of the range at a quarter of it"},
         {"cycle", "the same at a half"},
         {"cycle", "the same at the full range"}}}},
      {"viscosity",
       Kind::material,
       "viscosity: the force depends on how fast the strain changes and relaxes in a hold",
       "Maxwell: a width that changes with the rate and decays in a hold with a time constant; "
       "Kelvin-Voigt: a width in proportion to the rate that drops at once in a hold",
       "a Maxwell or a Kelvin-Voigt element beside the elastic terms",
       {"internal_friction", "force_camera_delay", "strain_dependent_friction"},
       {"two_rates_and_hold",
        "Repeat one loop at two rates a decade apart and hold for ten minutes at half the peak: "
        "viscosity changes its loop width with the rate and relaxes in the hold, friction does "
        "neither.",
        {{"cycle", "one loop at a tenth of the rate"},
         {"cycle", "the same loop at the full rate"},
         {"hold", "hold for 600 s at half the peak, loading"}}}},
      {"plastic_set",
       Kind::material,
       "plastic set: each new maximum leaves the specimen longer, and small cycles do not undo it",
       "an offset at the return to zero that grows with new maxima only; reloading is elastic",
       "a rest strain that moves with each new maximum beyond a yield strain",
       {"internal_friction", "first_cycle_softening"},
       {"nested_loops_with_return",
        "Loops to growing maxima with a return to zero and a few small cycles after each: "
        "friction's offset is undone by the small cycles, a set is not.",
        {{"cycle", "to a quarter of the range and back to zero force, three times"},
         {"cycle", "to a half, the same"},
         {"cycle", "to the full range, the same"}}}},
      {"first_cycle_softening",
       Kind::material,
       "first-cycle softening: the first loading to each new strain is stiffer than every later "
       "one",
       "only in the first loading to each new maximum; later cycles agree with each other",
       "a loss of stiffness below the largest strain so far (Mullins)",
       {"plastic_set", "internal_friction"},
       {"repeat_cycles_growing",
        "Three cycles to each of three growing maxima on a new specimen: softening shows between "
        "the first and the second cycle of each, and only there.",
        {{"cycle", "three cycles to a third of the range"},
         {"cycle", "three cycles to two thirds"},
         {"cycle", "three cycles to the full range"}}}},
  };
}

}  // namespace tenter::effects
