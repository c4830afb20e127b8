// SPDX-License-Identifier: Apache-2.0
// A cloth model as the material file of ARCSim (Narain et al. 2012, after the fabric measurements
// of Wang, O'Brien and Ramamoorthi 2011), and back.
//
//   {"density": kg/m^2, "stretching": 6 x [c11, c12, c22, c33], "bending": 3 x 5}
//
// What the simulator makes of it (G the Green strain tensor, G12 half of our green_uv):
//
//   membrane  Psi = c11 G11^2 + 2 c12 G11 G22 + c22 G22^2 + 2 c33 G12^2, the c(G) secant
//             stiffnesses, N/m; it doubles what it reads, so c11 is half of our k, and c33 is
//             our k. First row: at rest. Rows 2 to 6: the larger principal stretch at 1 + 1/6,
//             pulled at 0, 22.5, 45, 67.5, 90 degrees from the weft; linear between, constant
//             beyond; negative counts as zero. Under compression: the first row.
//   bending   energy of an edge ke (l theta)^2 / (8 a), a the area of both triangles; ours is
//             k/2 (3 l theta/a)^2 a/3, so ke = 12 k. Rows: edges along the weft (our bend_v),
//             at 45 degrees (bend_d), along the warp (bend_u); columns: our curvature 0, 30,
//             60, 90, 120 1/m.
//
// Both simulators multiply the strain by a secant stiffness, so linear laws go over exactly. A
// spline keeps its values at those samples; between them it becomes straight, and beyond them
// constant. Refused, in one sentence: terms of other strains (springs, soft constraints, fibres,
// solids), laws with a memory, limits, samples over the material, sensor corrections, negative
// stiffness.
//
// Reading back: weft, warp and shear as straight stiffness curves through rest and the sample
// pulled along their own direction (shear: 45 degrees), one coupling, and three bending curves
// through their samples. That is exact for a file that came from such a model; what a fabric's file
// says beyond it is told as a loss.
//
//   auto file = write_arcsim(model, 0.18);          // area density, kg/m^2
//   auto model = read_arcsim(text, "denim.json");
//
// Pure; any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "common/model/export/curves.h"
#include "common/model/model.h"

namespace tenter::model {

/// `area_density_kg_m2` > 0: a model says nothing of mass. The model must be valid.
Expected<Exported> write_arcsim(const Model& model, double area_density_kg_m2);

struct ImportedModel {
  Model model;
  double area_density_kg_m2 = 0.0;
  std::vector<std::string> losses;
};

/// `source_name` is what messages call the text; `name` becomes the model's.
Expected<ImportedModel> read_arcsim(std::string_view text, std::string_view source_name,
                                    const std::string& name);

}  // namespace tenter::model
